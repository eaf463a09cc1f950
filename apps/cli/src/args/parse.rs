//! Values of options.

use conray::Vec3;
use conray_bake::MAX_MAP_SIDE;

pub(super) fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let parse = |side: &str| side.trim().parse().ok().filter(|&n| (1..=65536).contains(&n));
    text.split_once(['x', 'X'])
        .and_then(|(w, h)| Some((parse(w)?, parse(h)?)))
        .ok_or_else(|| "expected WIDTHxHEIGHT, each from 1 to 65536, such as 1280x720".into())
}

pub(super) fn parse_side_or_size(text: &str) -> Result<(u32, u32), String> {
    let side = |text: &str| text.trim().parse().ok().filter(|&n| (1..=MAX_MAP_SIDE).contains(&n));
    let size = match text.split_once(['x', 'X']) {
        Some((width, height)) => side(width).zip(side(height)),
        None => side(text).map(|side| (side, side)),
    };
    size.ok_or_else(|| format!("expected texels from 1 to {MAX_MAP_SIDE}, such as 2048 or 2048x1024"))
}

pub(super) fn parse_point(text: &str) -> Result<Vec3, String> {
    let numbers: Vec<f32> = text.split(',').filter_map(|n| n.trim().parse().ok()).collect();
    match numbers[..] {
        [x, y, z] if text.split(',').count() == 3 && Vec3::new(x, y, z).is_finite() => Ok(Vec3::new(x, y, z)),
        _ => Err("expected three numbers with commas between, such as 1.5,-2,0".into()),
    }
}

pub(super) fn parse_bytes(text: &str) -> Result<u64, String> {
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let unit: u64 = match &text[digits.len()..].to_ascii_uppercase()[..] {
        "" | "B" => 1,
        "K" | "KB" | "KIB" => 1 << 10,
        "M" | "MB" | "MIB" => 1 << 20,
        "G" | "GB" | "GIB" => 1 << 30,
        _ => 0,
    };
    let bytes = digits.parse::<f64>().unwrap_or(f64::NAN) * unit as f64;
    if bytes >= 1.0 { Ok(bytes as u64) } else { Err("expected bytes, such as 800000000, 512M or 2G".into()) }
}

/// Seconds from a number with a unit; without one it means seconds. Whether they make sense is for the settings to say.
pub(super) fn parse_time(text: &str) -> Result<f64, String> {
    let text = text.trim();
    // `ms` ends with the unit of seconds too, so it goes first.
    let units = [("ms", 1e-3), ("s", 1.0), ("m", 60.0)];
    let (number, unit) =
        units.iter().find_map(|(name, unit)| Some((text.strip_suffix(name)?, *unit))).unwrap_or((text, 1.0));
    let seconds = number.trim().parse::<f64>().map(|number| number * unit);
    seconds.map_err(|_| "expected a time, such as 2s, 500ms or 1.5m".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_points_and_bytes() {
        assert_eq!(parse_size("640x480"), Ok((640, 480)));
        assert!(["", "640", "0x1", "1x70000", "axb", "-1x5"].iter().all(|t| parse_size(t).is_err()));
        assert_eq!(parse_side_or_size("2048"), Ok((2048, 2048)));
        assert_eq!(parse_side_or_size("64x16384"), Ok((64, 16384)));
        assert!(["", "0", "100000", "16385x4", "x", "-3"].iter().all(|t| parse_side_or_size(t).is_err()));
        assert_eq!(parse_point("1, -2,3e1"), Ok(Vec3::new(1.0, -2.0, 30.0)));
        assert!(["", "1,2", "1,2,3,4", "1,,3", "a,b,c", "1,2,inf"].iter().all(|t| parse_point(t).is_err()));
        for (text, seconds) in [("2s", 2.0), ("1.5", 1.5), ("500ms", 0.5), ("2m", 120.0), ("-1 s", -1.0)] {
            assert_eq!(parse_time(text), Ok(seconds));
        }
        assert!(["", "s", "abc", "2h", "1s2"].iter().all(|t| parse_time(t).is_err()));
        assert_eq!(parse_bytes("1.5G"), Ok(3 << 29));
        assert!(["", "G", "-1M", "5X", "0", "nan"].iter().all(|t| parse_bytes(t).is_err()));
    }
}

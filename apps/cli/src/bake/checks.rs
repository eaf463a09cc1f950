//! What is refused before any work.

use super::{job, output::Output};
use crate::{args::BakeArgs, failure::Failure};
use conray::{AoSettings, Device, Method, SessionOptions, target::MapSize};
use conray_bake::{MAX_MAP_SIDE, Sheets};

/// Texels of all maps together: more are beyond the numbers that count them, and any memory.
const MAX_TEXELS: u64 = 1 << 30;

/// How the session works: objects that stand apart are estimated on the CPU, since each would need a device.
pub(super) fn device_options(args: &BakeArgs) -> Result<SessionOptions, Failure> {
    let options = args.run.options();
    match options.device {
        _ if !args.scope().self_only => Ok(options),
        Device::Gpu => Err(Failure::Request(
            "--device: objects that stand apart are estimated on the CPU; leave out --self-only and --shared"
                .into(),
        )),
        Device::Auto | Device::Cpu => Ok(SessionOptions { device: Device::Cpu, ..options }),
    }
}

/// Refuses options that were given and would do nothing.
pub(super) fn use_of_options(for_vertices: bool, output: Option<&Output>) -> Result<(), Failure> {
    const OF_MAPS: [&str; 9] =
        ["size", "density", "no-unwrap", "padding", "supersample", "bits", "bent-normals", "shared", "pack"];
    const OF_VERTICES: [&str; 3] = ["attribute", "samples-per-triangle", "smoothness"];
    let given = job::given();
    let first = |options: &[&'static str]| options.iter().copied().find(|option| given.get(option).is_some());
    let refuse = |option: &str, what: &str| Err(Failure::Request(format!("--{option}: {what}")));
    match (for_vertices, output) {
        (true, _) if let Some(option) = first(&OF_MAPS) => refuse(option, "is for maps, not for vertices"),
        (true, Some(Output::Ply | Output::Obj)) if let Some(option) = first(&["attribute"]) => {
            refuse(option, "is for glTF alone")
        }
        (false, _) if let Some(option) = first(&OF_VERTICES) => {
            refuse(option, "is for vertices, not for maps")
        }
        (false, Some(Output::Png | Output::Exr)) if let Some(option) = first(&["pack"]) => {
            refuse(option, "is for glTF alone")
        }
        (false, Some(Output::Exr)) if let Some(option) = first(&["bits"]) => refuse(option, "an EXR has 32"),
        _ => Ok(()),
    }
}

/// Makes the folder of kept work, or refuses one that could not be used, before any work.
pub(super) fn state(args: &BakeArgs, settings: &AoSettings) -> Result<(), Failure> {
    let Some(folder) = &args.state else { return Ok(()) };
    let refuse = |problem: String| Err(Failure::Request(format!("--state {}: {problem}", folder.display())));
    if settings.method != Method::Hybrid {
        return refuse(format!("needs --method hybrid, not {}", settings.method));
    }
    match std::fs::create_dir(folder) {
        Ok(()) => Ok(()),
        Err(_) if folder.is_dir() => Ok(()),
        Err(e) => Err(Failure::Work(format!("{}: cannot be made: {e}", folder.display()))),
    }
}

/// Refuses maps that are too large, each or together.
pub(super) fn size_of_maps(args: &BakeArgs, sheets: &Sheets) -> Result<(), Failure> {
    let (option, count) = (args.extent_option(), sheets.sheets.len());
    let sizes = || sheets.sheets.iter().map(|sheet| (&sheet.name, sheet.size));
    let is_too_large = |size: MapSize| size.width.max(size.height) > MAX_MAP_SIDE;
    if let Some((name, MapSize { width, height })) = sizes().find(|(_, size)| is_too_large(*size)) {
        let what = format!(
            "{option}: the map of {name} would be {width} x {height}, and {MAX_MAP_SIDE} is the most; choose less"
        );
        return Err(Failure::Request(what));
    }
    let texels: u64 = sizes().map(|(_, size)| u64::from(size.width) * u64::from(size.height)).sum();
    if texels > MAX_TEXELS {
        let what = format!("{option}: {count} maps of {texels} texels together are too large; choose less");
        return Err(Failure::Request(what));
    }
    Ok(())
}

//! `conray compare`: how far one image is from another.

use crate::{args::CompareArgs, failure::Failure, report};
use conray::target::{self, ExrImage, PngDepth};
use serde_json::json;
use std::path::Path;

pub(crate) fn run(args: &CompareArgs) -> Result<(), Failure> {
    if let Some(path) = &args.output {
        if path.extension().is_none_or(|e| !e.eq_ignore_ascii_case("png")) {
            return Err(Failure::Request(format!("-o {}: must end in .png", path.display())));
        }
        target::check_writable(path)?;
    }
    let image = target::read_exr_channels(&args.image)?;
    let reference = target::read_exr_channels(&args.reference)?;
    if (image.width, image.height) != (reference.width, reference.height) {
        return Err(Failure::Input(format!(
            "{} is {} x {}, but {} is {} x {}",
            args.image.display(),
            image.width,
            image.height,
            args.reference.display(),
            reference.width,
            reference.height
        )));
    }
    let (found, truth) = (visibility(&image, &args.image)?, visibility(&reference, &args.reference)?);
    // Background does not count: where an image has a coverage, it must be above 0.
    let covered = |image: &ExrImage, i: usize| image.channel("A").is_none_or(|a| a[i] > 0.0);
    let mask: Vec<bool> = (0..found.len()).map(|i| covered(&image, i) && covered(&reference, i)).collect();
    let metrics = target::compare(found, truth, &mask)?;
    if let Some(path) = &args.output {
        let difference: Vec<f32> = found.iter().zip(truth).map(|(a, b)| 10.0 * (a - b).abs()).collect();
        target::write_atomically(path, |w| {
            target::encode_png(w, image.width, image.height, &difference, PngDepth::Eight)
        })?;
    }
    let facts = json!({
        "pixels": metrics.count, "rmse": metrics.rmse, "mae": metrics.mae,
        "bias": metrics.bias, "p95": metrics.p95,
    });
    report::print_lines(&[if args.json {
        facts.to_string()
    } else {
        format!(
            "{} pixels: RMSE {:.5}, mean absolute error {:.5}, bias {:+.5}, 95th percentile {:.5}",
            metrics.count, metrics.rmse, metrics.mae, metrics.bias, metrics.p95
        )
    }]);
    Ok(())
}

/// The grey of an image; every channel of ours holds the visibility.
fn visibility<'a>(image: &'a ExrImage, path: &Path) -> Result<&'a [f32], Failure> {
    ["R", "Y", "visibility"]
        .iter()
        .find_map(|name| image.channel(name))
        .ok_or_else(|| Failure::Input(format!("{}: there is no channel R, Y or visibility", path.display())))
}

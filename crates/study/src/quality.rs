//! How far visibilities are from the truth.

use crate::{Case, StudyError, report::Quality};
use conray::target::{TargetError, compare};
use nv_flip::{DEFAULT_PIXELS_PER_DEGREE, FlipImageRgb8};

/// Judges one visibility a point against the truth, in the case's order.
///
/// RMSE, mean absolute error, bias and percentile are those of [`compare`], of the values as they are. FLIP sees what a
/// grey PNG shows: values held within [0, 1], in 256 steps, with the background white in both; its mean is taken over the
/// pixels that see a surface, so that it does not fall with the share of background.
///
/// # Errors
/// A number of values other than that of the points, or a value that is not finite.
pub fn judge(case: &Case, visibility: &[f32], truth: &[f32]) -> Result<Quality, StudyError> {
    let points = case.points().len();
    for (what, values) in [("visibilities", visibility), ("true visibilities", truth)] {
        if values.len() != points {
            return Err(incomparable(format!("{} {what} for {points} points", values.len())));
        }
        if let Some(index) = values.iter().position(|v| !v.is_finite()) {
            return Err(incomparable(format!("{what}: that of point {index} is {}", values[index])));
        }
    }
    let metrics = compare(visibility, truth, &vec![true; points])?;
    let mean_truth = truth.iter().map(|&v| f64::from(v)).sum::<f64>() / points as f64;
    let size = case.size();
    let map = flip_map(&case.pixels(truth, 1.0), &case.pixels(visibility, 1.0), size);
    let flip = case.points().iter().map(|p| f64::from(map[p.id as usize])).sum::<f64>() / points as f64;
    Ok(Quality {
        rmse: metrics.rmse,
        mae: metrics.mae,
        bias: metrics.bias,
        // Where the truth is closed everywhere there is nothing to relate to.
        relative_bias: if mean_truth > 0.0 { metrics.bias / mean_truth } else { 0.0 },
        p95: metrics.p95,
        flip,
    })
}

/// Root of the mean squared error; 0 of none.
pub fn rmse(visibility: &[f32], truth: &[f32]) -> f64 {
    let squares = visibility.iter().zip(truth).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2));
    (squares.sum::<f64>() / visibility.len().max(1) as f64).sqrt()
}

/// FLIP of each pixel of two grey pictures of that width and height, by the authors' own code.
fn flip_map(reference: &[f32], test: &[f32], (width, height): (u32, u32)) -> Vec<f32> {
    let image = |values: &[f32]| {
        let shades: Vec<u8> = values.iter().flat_map(|&v| [shade(v); 3]).collect();
        FlipImageRgb8::with_data(width, height, &shades)
    };
    nv_flip::flip(image(reference), image(test), DEFAULT_PIXELS_PER_DEGREE).to_vec()
}

/// A visibility as a grey PNG of 8 bits stores it.
fn shade(visibility: f32) -> u8 {
    (visibility.clamp(0.0, 1.0) * 255.0).round() as u8
}

fn incomparable(what: String) -> StudyError {
    TargetError::Incomparable(what).into()
}

#[cfg(test)]
mod tests;

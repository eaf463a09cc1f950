//! Bounds on floating-point rounding.

/// Bound on the relative error of `n` rounded single-precision operations in a row: `n u / (1 - n u)`, `u = 2^-24`.
///
/// Higham, "Accuracy and Stability of Numerical Algorithms", 2002, section 3.1.
pub const fn gamma(n: u32) -> f32 {
    let nu = n as f64 * (f32::EPSILON as f64 / 2.0);
    // Rounded up, so that the single-precision result is still a bound.
    ((nu / (1.0 - nu)) as f32).next_up()
}

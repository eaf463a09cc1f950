//! From the unit square to directions; each sample with its density.

use crate::{Frame, Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

/// Maps the unit square to the unit disc: equal areas stay equal and squares stay nearly square.
///
/// Shirley, Chiu, "A Low Distortion Map Between Disk and Square", 1997.
#[inline]
pub fn concentric_disc(u: Vec2) -> Vec2 {
    let s = 2.0 * u - Vec2::ONE;
    if s == Vec2::ZERO {
        return Vec2::ZERO;
    }
    let (r, phi) = if s.x.abs() > s.y.abs() {
        (s.x, FRAC_PI_4 * (s.y / s.x))
    } else {
        (s.y, FRAC_PI_2 - FRAC_PI_4 * (s.x / s.y))
    };
    let (sin, cos) = phi.sin_cos();
    r * Vec2::new(cos, sin)
}

/// The inverse of [`concentric_disc`].
#[inline]
pub fn square_from_disc(d: Vec2) -> Vec2 {
    let r = d.length();
    let s = if d.x.abs() > d.y.abs() {
        let x = r.copysign(d.x);
        Vec2::new(x, x * (d.y / d.x).atan() / FRAC_PI_4)
    } else if d.y != 0.0 {
        let y = r.copysign(d.y);
        Vec2::new(y * (d.x / d.y).atan() / FRAC_PI_4, y)
    } else {
        Vec2::ZERO
    };
    0.5 * (s + Vec2::ONE)
}

/// Direction about +z with density [`cosine_hemisphere_pdf`] for `u` uniform in the unit square.
///
/// Malley's method: a uniform point of the disc, lifted to the hemisphere.
#[inline]
pub fn cosine_hemisphere(u: Vec2) -> Vec3 {
    let d = concentric_disc(u);
    d.extend((1.0 - d.length_squared()).max(0.0).sqrt())
}

/// Density per solid angle of [`cosine_hemisphere`]: cos / pi above the horizon.
#[inline]
pub fn cosine_hemisphere_pdf(local: Vec3) -> f32 {
    local.z.max(0.0) / PI
}

/// Direction uniform in solid angle within `half_angle_rad` of `axis`; density 1 / (2 pi (1 - cos half_angle)).
#[inline]
pub fn uniform_cone(u: Vec2, axis: Vec3, half_angle_rad: f32) -> Vec3 {
    let z = 1.0 - u.x * (1.0 - half_angle_rad.cos());
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = (TAU * u.y).sin_cos();
    Frame::from_normal(axis).to_world(Vec3::new(r * cos, r * sin, z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Moments, owen_sobol_2d};

    fn draws(n: u32) -> impl Iterator<Item = Vec2> {
        (0..n).map(|i| owen_sobol_2d(i, 7))
    }

    #[test]
    fn cosine_samples_follow_their_density() {
        // Chi-squared over 10 rings of equal probability (sin^2 is uniform) and 8 sectors.
        let (mut counts, n) = ([[0u32; 8]; 10], 80_000);
        for u in draws(n) {
            let d = cosine_hemisphere(u);
            assert!((d.length() - 1.0).abs() < 1e-5 && d.z >= 0.0);
            let ring = ((1.0 - d.z * d.z) * 10.0) as usize;
            let sector = ((d.y.atan2(d.x) / TAU).rem_euclid(1.0) * 8.0) as usize;
            counts[ring.min(9)][sector.min(7)] += 1;
        }
        let expected = f64::from(n) / 80.0;
        let chi2: f64 = counts.iter().flatten().map(|&c| (f64::from(c) - expected).powi(2) / expected).sum();
        // 79 degrees of freedom: 99.9 % quantile is 123; Sobol points are more even than random ones.
        assert!(chi2 < 123.0, "{chi2}");
        assert_eq!(cosine_hemisphere_pdf(Vec3::Z), 1.0 / PI);
        assert_eq!(cosine_hemisphere_pdf(Vec3::NEG_Z), 0.0);
    }

    #[test]
    fn uniform_cone_has_the_mean_cosine_of_its_cap() {
        let (axis, half_angle_rad) = (Vec3::new(0.6, 0.0, 0.8), 0.5f32);
        let cosines: Moments =
            draws(4096).map(|u| f64::from(uniform_cone(u, axis, half_angle_rad).dot(axis))).collect();
        let truth = f64::from((1.0 + half_angle_rad.cos()) / 2.0);
        assert!((cosines.mean - truth).abs() < 1e-4, "{cosines:?} {truth}");
    }

    #[test]
    fn the_disc_map_inverts() {
        for u in draws(1000).chain([Vec2::splat(0.5), Vec2::ZERO, Vec2::ONE]) {
            assert!((square_from_disc(concentric_disc(u)) - u).length() < 1e-5, "{u}");
        }
    }

    #[test]
    fn the_disc_map_is_onto_and_keeps_areas() {
        let inside = draws(65536).filter(|&u| concentric_disc(u).length() < 0.5).count();
        assert!((inside as f64 / 65536.0 - 0.25).abs() < 1e-3);
        assert_eq!(concentric_disc(Vec2::splat(0.5)), Vec2::ZERO);
        assert!((concentric_disc(Vec2::ZERO).length() - 1.0).abs() < 1e-6);
    }
}

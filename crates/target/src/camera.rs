//! A pinhole camera with square pixels.

use crate::TargetError;
use conray_core::{Ray, Vec3, View};
use glam::DVec3;

/// Longest side of an image, in pixels.
pub const MAX_SIDE_PX: u32 = 1 << 16;
/// Most pixels of an image.
pub const MAX_PIXELS: u64 = 1 << 28;

/// Sine of the angle between the line of sight and `up` below which the picture's roll is undefined.
const MIN_UP_SINE: f64 = 1e-6;

/// A perspective camera over a grid of square pixels; row 0 is the top row, column 0 the left one.
///
/// The basis is kept in double precision, so that neighbouring pixels of large images stay apart.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    eye: Vec3,
    /// Unit vectors: to the right of the picture, up in the picture, into the picture.
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    /// Side of a pixel on the plane at unit depth.
    pixel_side: f64,
    width_px: u32,
    height_px: u32,
}

impl Camera {
    /// A camera with the view's vertical field of view over `width` x `height` pixels.
    ///
    /// Refuses ([`TargetError::Settings`]): coordinates that are not finite; `eye` equal to `look_at`; `up` of zero
    /// length or parallel to the line of sight; a field of view outside (0, 180) degrees; sides outside
    /// 1..=[`MAX_SIDE_PX`]; more than [`MAX_PIXELS`] pixels.
    pub fn new(view: &View, width: u32, height: u32) -> Result<Self, TargetError> {
        check_size(width, height)?;
        let fov = view.vertical_fov_deg;
        if !(fov > 0.0 && fov < 180.0) {
            return Err(refuse("fov", format!("{fov} degrees is outside the range of 0 to 180, exclusive")));
        }
        for (setting, v) in [("eye", view.eye), ("look-at", view.look_at), ("up", view.up)] {
            if !v.is_finite() {
                return Err(refuse(setting, format!("{v} is not finite")));
            }
        }
        let sight = view.look_at.as_dvec3() - view.eye.as_dvec3();
        let forward = sight.try_normalize().ok_or_else(|| {
            refuse("look-at", format!("{} is where the eye is: no direction to look in", view.look_at))
        })?;
        let up = view.up.as_dvec3().try_normalize().ok_or_else(|| refuse("up", "has no length".into()))?;
        let across = forward.cross(up);
        if across.length() < MIN_UP_SINE {
            return Err(refuse("up", format!("{} is parallel to the line of sight", view.up)));
        }
        let right = across.normalize();
        let half_height = (0.5 * f64::from(fov).to_radians()).tan();
        Ok(Self {
            eye: view.eye,
            right,
            up: right.cross(forward),
            forward,
            pixel_side: 2.0 * half_height / f64::from(height),
            width_px: width,
            height_px: height,
        })
    }

    /// The ray through the centre of a pixel: from the eye, of unit direction, endless.
    #[inline]
    pub fn ray(&self, px: u32, py: u32) -> Ray {
        let x = (f64::from(px) + 0.5 - 0.5 * f64::from(self.width_px)) * self.pixel_side;
        let y = (0.5 * f64::from(self.height_px) - f64::from(py) - 0.5) * self.pixel_side;
        let direction = (self.forward + x * self.right + y * self.up).normalize().as_vec3();
        Ray { origin: self.eye, direction, t_max: f32::INFINITY }
    }

    /// World size of a pixel's side at the depth of a position, measured across the line of sight; 0 behind the eye.
    #[inline]
    pub fn footprint(&self, position: Vec3) -> f32 {
        let depth = (position.as_dvec3() - self.eye.as_dvec3()).dot(self.forward);
        (depth.max(0.0) * self.pixel_side) as f32
    }

    /// Where rays start.
    pub fn eye(&self) -> Vec3 {
        self.eye
    }

    /// Unit vectors: to the right in the picture, up in it, into it.
    pub fn basis(&self) -> [Vec3; 3] {
        [self.right, self.up, self.forward].map(|axis| axis.as_vec3())
    }

    /// Side of a pixel on the plane at unit depth.
    pub fn pixel_side(&self) -> f32 {
        self.pixel_side as f32
    }

    /// Width of the image in pixels.
    pub fn width(&self) -> u32 {
        self.width_px
    }

    /// Height of the image in pixels.
    pub fn height(&self) -> u32 {
        self.height_px
    }
}

fn refuse(setting: &'static str, problem: String) -> TargetError {
    TargetError::Settings { setting, problem }
}

fn check_size(width: u32, height: u32) -> Result<(), TargetError> {
    let side = 1..=MAX_SIDE_PX;
    if !side.contains(&width) || !side.contains(&height) {
        let problem = format!("{width}x{height}: sides are 1 to {MAX_SIDE_PX} pixels");
        return Err(refuse("size", problem));
    }
    if u64::from(width) * u64::from(height) > MAX_PIXELS {
        let problem = format!("{width}x{height}: an image has at most {MAX_PIXELS} pixels");
        return Err(refuse("size", problem));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn view() -> View {
        View {
            name: "test".into(),
            eye: Vec3::new(1.0, 2.0, 3.0),
            look_at: Vec3::new(1.0, 2.0, -5.0),
            up: Vec3::Y,
            vertical_fov_deg: 60.0,
        }
    }

    fn angle_deg(a: Vec3, b: Vec3) -> f64 {
        let (a, b) = (a.as_dvec3(), b.as_dvec3());
        a.cross(b).length().atan2(a.dot(b)).to_degrees()
    }

    #[test]
    fn the_middle_of_the_picture_is_the_point_looked_at() {
        let v = View { look_at: Vec3::new(-7.0, 4.0, 11.0), ..view() };
        let centre = Camera::new(&v, 641, 359).unwrap().ray(320, 179);
        assert_eq!(centre.origin, v.eye);
        assert!(angle_deg(centre.direction, v.look_at - v.eye) < 1e-4);
        let beside = Camera::new(&v, 641, 359).unwrap().ray(321, 179);
        assert!(angle_deg(beside.direction, v.look_at - v.eye) > 0.1, "the oracle must be able to fail");
    }

    #[test]
    fn corner_pixels_lie_at_the_angles_of_the_field_of_view() {
        // Looking along -z: a corner pixel's centre is half a pixel inside the frustum's edge.
        let (w, h) = (320u32, 180u32);
        let camera = Camera::new(&view(), w, h).unwrap();
        let half = 30f64.to_radians().tan();
        let y = half * (1.0 - 1.0 / f64::from(h));
        let x = half * (f64::from(w) / f64::from(h)) * (1.0 - 1.0 / f64::from(w));
        for (px, py, sx, sy) in [(0, 0, -1.0, 1.0), (w - 1, 0, 1.0, 1.0), (0, h - 1, -1.0, -1.0)] {
            let truth = DVec3::new(sx * x, sy * y, -1.0).normalize();
            let found = camera.ray(px, py).direction.as_dvec3();
            assert!((truth - found).length() < 1e-6, "pixel {px},{py}: {found} is not {truth}");
        }
        // A picture of one pixel's height is looked at through its middle, whatever the field of view.
        let one = Camera::new(&view(), 1, 1).unwrap();
        assert_eq!(one.ray(0, 0).direction, Vec3::NEG_Z);
    }

    #[test]
    fn pixels_are_square() {
        let camera = Camera::new(&view(), 300, 100).unwrap();
        // On the plane at unit depth, steps to the right and down have the same length everywhere.
        let at = |px, py| {
            let d = camera.ray(px, py).direction.as_dvec3();
            d / -d.z
        };
        let side = 2.0 * 30f64.to_radians().tan() / 100.0;
        for (px, py) in [(0, 0), (150, 50), (298, 98)] {
            let (right, down) = (at(px + 1, py) - at(px, py), at(px, py + 1) - at(px, py));
            assert!((right.length() - side).abs() < 1e-6 && (down.length() - side).abs() < 1e-6);
            assert!(right.x > 0.0 && down.y < 0.0, "column 0 is left, row 0 is on top");
        }
    }

    #[test]
    fn up_rolls_the_picture() {
        let upright = Camera::new(&view(), 64, 64).unwrap();
        // A quarter turn: what was to the right is now on top. Only the part across the sight counts.
        let rolled = Camera::new(&View { up: Vec3::new(2.0, 0.0, 9.0), ..view() }, 64, 64).unwrap();
        for (px, py) in [(0, 0), (10, 20), (63, 5)] {
            let (a, b) = (upright.ray(63 - py, px).direction, rolled.ray(px, py).direction);
            assert!((a - b).length() < 1e-6, "{a} {b}");
        }
        assert!((upright.ray(0, 9).direction - rolled.ray(0, 9).direction).length() > 0.1);
    }

    #[test]
    fn footprints_are_the_gap_between_neighbours_at_equal_depth() {
        let camera = Camera::new(&view(), 640, 480).unwrap();
        for depth in [0.01f32, 1.0, 250.0] {
            let hit = |px: u32| {
                let d = camera.ray(px, 100).direction;
                view().eye + d * (depth / -d.z)
            };
            let gap = (hit(601) - hit(600)).length();
            // Positions near 3 carry single-precision errors of some 2e-7.
            assert!((camera.footprint(hit(600)) - gap).abs() < 1e-3 * gap + 1e-6, "depth {depth}");
        }
        assert_eq!(camera.footprint(view().eye + Vec3::Z), 0.0, "behind the eye");
    }

    #[test]
    fn degenerate_views_are_refused_by_the_setting_at_fault() {
        let nan = Vec3::new(0.0, f32::NAN, 0.0);
        let cases = [
            ("look-at", View { look_at: view().eye, ..view() }, 8, 8),
            ("look-at", View { look_at: nan, ..view() }, 8, 8),
            ("eye", View { eye: Vec3::INFINITY, ..view() }, 8, 8),
            ("up", View { up: Vec3::Z, ..view() }, 8, 8),
            ("up", View { up: -7.0 * Vec3::Z, ..view() }, 8, 8),
            ("up", View { up: Vec3::ZERO, ..view() }, 8, 8),
            ("fov", View { vertical_fov_deg: 0.0, ..view() }, 8, 8),
            ("fov", View { vertical_fov_deg: 180.0, ..view() }, 8, 8),
            ("fov", View { vertical_fov_deg: f32::NAN, ..view() }, 8, 8),
            ("size", view(), 0, 8),
            ("size", view(), 8, 0),
            ("size", view(), MAX_SIDE_PX + 1, 1),
            ("size", view(), MAX_SIDE_PX, MAX_SIDE_PX),
        ];
        for (expected, view, w, h) in cases {
            match Camera::new(&view, w, h) {
                Err(TargetError::Settings { setting, .. }) => assert_eq!(setting, expected, "{view:?}"),
                other => panic!("{expected}: {other:?}"),
            }
        }
        assert!(Camera::new(&view(), MAX_SIDE_PX, 4096).is_ok(), "the largest size is allowed");
    }

    proptest! {
        #[test]
        fn any_accepted_view_gives_unit_rays(
            v in prop::array::uniform9(prop::num::f32::ANY), fov in prop::num::f32::ANY, px in 0u32..50, py in 0u32..40,
        ) {
            let view = View {
                name: String::new(),
                eye: Vec3::from_slice(&v[0..3]),
                look_at: Vec3::from_slice(&v[3..6]),
                up: Vec3::from_slice(&v[6..9]),
                vertical_fov_deg: fov.abs() % 200.0,
            };
            if let Ok(camera) = Camera::new(&view, 50, 40) {
                prop_assert!((camera.ray(px, py).direction.length() - 1.0).abs() < 1e-5);
            }
        }
    }
}

//! From where the scene is seen, and how mouse and keys move it: pure functions from a look to the next.

use conray::{Vec3, View};
use serde::{Deserialize, Serialize};

/// A camera as the viewer moves it: the eye, the point that it turns about, and the field of view.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Look {
    /// Position of the camera, in world space.
    pub eye: [f32; 3],
    /// The point in the middle of the picture.
    pub look_at: [f32; 3],
    /// Which way is up in the picture.
    pub up: [f32; 3],
    /// Vertical field of view in degrees, in (0, 180).
    pub vertical_fov_deg: f32,
}

/// The line of sight stays so far from `up`, in radians: nearer, the picture would roll over.
const MIN_POLE_RAD: f32 = 0.02;
/// What one step of the wheel leaves of the distance.
const ZOOM_STEP: f32 = 0.87;

/// Right, up and forward in the picture: unit vectors.
#[derive(Clone, Copy, Debug)]
pub struct Basis {
    /// To the right of the picture.
    pub right: Vec3,
    /// To its top.
    pub up: Vec3,
    /// Into it.
    pub forward: Vec3,
}

impl Look {
    /// That of a named view.
    pub fn of_view(view: &View) -> Self {
        Self {
            eye: view.eye.into(),
            look_at: view.look_at.into(),
            up: view.up.into(),
            vertical_fov_deg: view.vertical_fov_deg,
        }
    }

    /// As a view of that name.
    pub fn view(&self, name: &str) -> View {
        View {
            name: name.into(),
            eye: self.eye.into(),
            look_at: self.look_at.into(),
            up: self.up.into(),
            vertical_fov_deg: self.vertical_fov_deg,
        }
    }

    fn eye(&self) -> Vec3 {
        self.eye.into()
    }

    fn sight(&self) -> Vec3 {
        Vec3::from(self.look_at) - self.eye()
    }

    /// How far the eye is from the point that it turns about.
    pub fn distance(&self) -> f32 {
        self.sight().length()
    }

    /// The picture's axes.
    pub fn basis(&self) -> Basis {
        let forward = self.sight().normalize_or(Vec3::NEG_Z);
        let across = forward.cross(self.up.into());
        let right = across.try_normalize().unwrap_or_else(|| forward.any_orthonormal_vector());
        Basis { right, up: right.cross(forward), forward }
    }

    /// The sight turned about `up` by `yaw` and towards it by `pitch`, in radians, kept off the poles.
    fn turned(&self, yaw: f32, pitch: f32) -> Vec3 {
        let (sight, pole) = (self.sight(), Vec3::from(self.up).normalize_or(Vec3::Y));
        let from_pole = sight.angle_between(pole);
        let pitch = pitch.clamp(
            from_pole - std::f32::consts::PI + MIN_POLE_RAD.min(std::f32::consts::PI - from_pole),
            from_pole - MIN_POLE_RAD.min(from_pole),
        );
        rotated(rotated(sight, self.basis().right, pitch), pole, yaw)
    }

    /// The eye carried about the point looked at.
    #[must_use]
    pub fn orbit(&self, yaw_rad: f32, pitch_rad: f32) -> Self {
        let eye = Vec3::from(self.look_at) - self.turned(yaw_rad, pitch_rad);
        Self { eye: eye.into(), ..*self }
    }

    /// The head turned, the eye where it was.
    #[must_use]
    pub fn turn(&self, yaw_rad: f32, pitch_rad: f32) -> Self {
        Self { look_at: (self.eye() + self.turned(yaw_rad, pitch_rad)).into(), ..*self }
    }

    /// Eye and point moved across the sight, so that what lies at that point's depth follows a pointer that moves by these shares of the picture's
    /// height, to the right and down.
    #[must_use]
    pub fn pan(&self, right: f32, down: f32) -> Self {
        let height = 2.0 * self.distance() * (0.5 * self.vertical_fov_deg.to_radians()).tan();
        let basis = self.basis();
        self.moved((-right * basis.right + down * basis.up) * height)
    }

    /// The eye nearer to the point looked at by steps of the wheel; below 0 farther. It never gets there.
    #[must_use]
    pub fn zoom(&self, steps: f32) -> Self {
        let share = ZOOM_STEP.powf(steps.clamp(-20.0, 20.0));
        let sight = self.sight() * share;
        let near = f32::EPSILON * 64.0 * (self.eye().length() + 1e-20);
        if sight.length() <= near || !sight.is_finite() || sight.length() > 1e30 {
            return *self;
        }
        Self { eye: (Vec3::from(self.look_at) - sight).into(), ..*self }
    }

    /// Eye and point moved along the picture's axes, in world units: right, up, forward.
    #[must_use]
    pub fn fly(&self, [right, up, forward]: [f32; 3]) -> Self {
        let basis = self.basis();
        self.moved(right * basis.right + up * basis.up + forward * basis.forward)
    }

    fn moved(&self, by: Vec3) -> Self {
        let (eye, look_at) = (self.eye() + by, Vec3::from(self.look_at) + by);
        if eye.is_finite() && look_at.is_finite() {
            Self { eye: eye.into(), look_at: look_at.into(), ..*self }
        } else {
            *self
        }
    }

    /// Turned to another point, about which it turns from now on; the eye stays.
    #[must_use]
    pub fn turned_to(&self, point: [f32; 3]) -> Self {
        let next = Self { look_at: point, ..*self };
        let parallel = next.sight().normalize_or_zero().cross(Vec3::from(self.up)).length() < 1e-4;
        if next.distance() > 0.0 && !parallel { next } else { *self }
    }

    /// Where a point is seen in a picture of that size, in pixels from its left top corner; `None` behind the eye.
    pub fn project(&self, point: Vec3, [width, height]: [f32; 2]) -> Option<[f32; 2]> {
        let (basis, to) = (self.basis(), point - self.eye());
        let depth = to.dot(basis.forward);
        if depth <= 1e-6 * self.distance() {
            return None;
        }
        let scale = 0.5 * height / (0.5 * self.vertical_fov_deg.to_radians()).tan() / depth;
        Some([0.5 * width + to.dot(basis.right) * scale, 0.5 * height - to.dot(basis.up) * scale])
    }
}

/// A vector turned about a unit axis (Rodrigues).
fn rotated(v: Vec3, axis: Vec3, angle_rad: f32) -> Vec3 {
    let (sin, cos) = angle_rad.sin_cos();
    v * cos + axis.cross(v) * sin + axis * axis.dot(v) * (1.0 - cos)
}

#[cfg(test)]
mod tests {
    use super::*;
    use conray::target::Camera;

    fn look() -> Look {
        Look { eye: [1.0, 2.0, 6.0], look_at: [1.0, 2.0, 0.0], up: [0.0, 1.0, 0.0], vertical_fov_deg: 50.0 }
    }

    fn near(a: [f32; 3], b: [f32; 3]) -> bool {
        (Vec3::from(a) - Vec3::from(b)).length() < 1e-4
    }

    #[test]
    fn orbits_keep_the_distance_and_come_back() {
        let there = look().orbit(0.7, 0.3);
        assert!((there.distance() - look().distance()).abs() < 1e-4);
        assert_eq!(there.look_at, look().look_at);
        assert!(!near(there.eye, look().eye));
        // A quarter turn about y takes an eye on +z to an eye on +x.
        let quarter = look().orbit(std::f32::consts::FRAC_PI_2, 0.0);
        assert!(near(quarter.eye, [7.0, 2.0, 0.0]), "{quarter:?}");
    }

    #[test]
    fn poles_are_never_reached() {
        for pitch in [-100.0, -1.0, 1.0, 100.0] {
            let mut there = look();
            for _ in 0..10 {
                there = there.orbit(0.0, pitch);
                let angle = Vec3::from(there.up).angle_between(there.sight());
                assert!(angle > 0.01 && angle < std::f32::consts::PI - 0.01, "{pitch}: {angle}");
                assert!(Camera::new(&there.view("v"), 8, 8).is_ok());
            }
        }
    }

    #[test]
    fn a_pan_carries_the_point_with_the_pointer() {
        let moved = look().pan(0.25, -0.1);
        let [x, y] = moved.project(look().look_at.into(), [400.0, 200.0]).unwrap();
        assert!(
            (x - (200.0 + 0.25 * 200.0)).abs() < 0.01 && (y - (100.0 - 0.1 * 200.0)).abs() < 0.01,
            "{x} {y}"
        );
    }

    #[test]
    fn zooms_undo_each_other_and_never_arrive() {
        assert!(near(look().zoom(3.0).zoom(-3.0).eye, look().eye));
        assert!(look().zoom(1.0).distance() < look().distance());
        let mut there = look();
        for _ in 0..1000 {
            there = there.zoom(5.0);
        }
        assert!(there.distance() > 0.0);
    }

    #[test]
    fn flying_and_turning_keep_what_they_should() {
        let there = look().fly([1.0, 2.0, 3.0]);
        assert!(near(there.eye, [2.0, 4.0, 3.0]) && (there.distance() - 6.0).abs() < 1e-4);
        let turned = look().turn(0.4, -0.2);
        assert_eq!(turned.eye, look().eye);
        assert!((turned.distance() - 6.0).abs() < 1e-4 && !near(turned.look_at, look().look_at));
        assert_eq!(look().turned_to([3.0, 1.0, 0.0]).look_at, [3.0, 1.0, 0.0]);
        assert_eq!(look().turned_to(look().eye), look(), "there is no direction to look in");
    }

    #[test]
    fn projection_is_the_inverse_of_the_cameras_rays() {
        let there = look().orbit(0.5, 0.4);
        let camera = Camera::new(&there.view("v"), 320, 180).unwrap();
        for (px, py) in [(0, 0), (160, 90), (319, 20)] {
            let ray = camera.ray(px, py);
            let [x, y] = there.project(ray.origin + 5.0 * ray.direction, [320.0, 180.0]).unwrap();
            assert!((x - px as f32 - 0.5).abs() < 0.01 && (y - py as f32 - 0.5).abs() < 0.01, "{x} {y}");
        }
        assert_eq!(there.project(there.eye() - there.basis().forward, [9.0, 9.0]), None);
    }
}

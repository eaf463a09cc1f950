//! Surface points and the rays that leave them.

use crate::{Vec3, gamma};

/// Where ambient occlusion is asked for. All in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Position on the surface.
    pub position: Vec3,
    /// Unit normal of the triangle, on the side that is asked about.
    pub geometric_normal: Vec3,
    /// Unit normal about which the hemisphere is taken; directions below the geometric surface count as closed.
    pub shading_normal: Vec3,
    /// World size of the pixel or texel that the point stands for; 0 when unknown.
    pub footprint: f32,
    /// Bound on each coordinate's absolute error: the true surface passes within this of `position` on every axis.
    pub position_error: f32,
    /// Key of the point's random numbers: the same id and seed give the same rays, wherever the point stands in a slice.
    pub id: u32,
}

/// A ray or a piece of one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Start, in world space.
    pub origin: Vec3,
    /// Unit direction.
    pub direction: Vec3,
    /// Hits count for `0 < t < t_max`, in world units; may be infinite.
    pub t_max: f32,
}

impl SurfacePoint {
    /// A point known only by position and normal.
    ///
    /// The normal is made a unit vector; its error is taken as that of a point interpolated on a triangle of about
    /// the same coordinates (`gamma(7)`, Pharr, Jakob, Humphreys, "Physically Based Rendering", 4th ed., 2023, 6.8.4).
    pub fn new(position: Vec3, normal: Vec3) -> Self {
        let normal = normal.normalize_or_zero();
        Self {
            position,
            geometric_normal: normal,
            shading_normal: normal,
            footprint: 0.0,
            position_error: gamma(7) * position.abs().max_element(),
            id: 0,
        }
    }

    /// The same point with another key for its random numbers.
    pub fn with_id(self, id: u32) -> Self {
        Self { id, ..self }
    }

    /// False where the point cannot be asked about: NaN, infinite or zero-length members.
    pub fn is_valid(&self) -> bool {
        self.position.is_finite()
            && self.position_error.is_finite()
            && (self.geometric_normal.length_squared() - 1.0).abs() < 1e-3
            && (self.shading_normal.length_squared() - 1.0).abs() < 1e-3
    }

    /// Where rays into the upper side start: just outside the slab in which the true surface may lie.
    ///
    /// The slab about a plane with normal n whose points err by at most e on every axis reaches e (|nx|+|ny|+|nz|)
    /// along n (Pharr, Jakob, Humphreys, 2023, 6.8.4); the result is rounded away from the surface.
    #[inline]
    pub fn ray_origin(&self) -> Vec3 {
        let n = self.geometric_normal;
        let reach = self.position_error * n.abs().element_sum();
        let away = |p: f32, n: f32| {
            let moved = p + reach * n;
            if n > 0.0 {
                moved.next_up()
            } else if n < 0.0 {
                moved.next_down()
            } else {
                moved
            }
        };
        Vec3::new(away(self.position.x, n.x), away(self.position.y, n.y), away(self.position.z, n.z))
    }
}

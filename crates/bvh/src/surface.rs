//! From a hit to a surface point.
//!
//! # How far the point may be from its triangle
//!
//! The corners in the world are exact by definition (see `placement.rs`). The position is their barycentric mean in
//! double precision, rounded once: at most u = 2^-24 of each coordinate. Rays, however, must clear not the point but
//! everything that the triangle test may still take for the triangle (`triangle.rs`):
//!
//! - its single precision edge functions err by as much as moving the corners by 6 u r per coordinate, 6 sqrt(2) u r in
//!   the plane across the ray, with r the triangle's reach from the point;
//! - the normal is a rounded unit vector: a direction with a computed `d . n >= 0` may descend by up to 5 u per unit of
//!   length (2 u from the normal, 3 u from the dot product), 5 sqrt(3) u r over the triangle.
//!
//! Together under 18 u r, so [`position_error`] returns `u |p| + gamma(20) r`, the sum rounded up: some micrometres on
//! a wall of several metres, and nothing that depends on the scene around it.
//!
//! # On which side of other surfaces it is
//!
//! Where two surfaces meet, as a wall meets the floor, a hit on the one may round to the far side of the other: the
//! point then sees the inside of the wall. What lies between the ray's origin and the hit is known to be open, so
//! [`Bvh::surface_point`] draws the position back along the ray by [`DRAWN_BACK`] error bounds, which brings it to the
//! seen side of every surface that is not itself grazed, and adds as much to its error.

use crate::bvh::Bvh;
use crate::placement::{wide_matrix, world_corner};
use crate::query::Hit;
use conray_core::{Affine3A, Geometry, Ray, SurfacePoint, TriangleMesh, Vec3, gamma};
use glam::{DMat3, DVec3};

/// How far surface points are drawn back along their ray, in error bounds of the hit: enough for the bounds of both
/// surfaces that meet and for a wall seen at 60 degrees to its normal.
const DRAWN_BACK: f32 = 4.0;

/// Bound on each coordinate's error for a point computed on a triangle with these world-space corners: use it as
/// [`SurfacePoint::position_error`], and rays from [`SurfacePoint::ray_origin`] do not meet the triangle again.
///
/// `position` must have been rounded to single precision only once, as [`triangle_point`] does.
pub fn position_error(corners: &[Vec3; 3], position: Vec3) -> f32 {
    let [a, b, c] = *corners;
    let reach = (b - a).abs().max((c - b).abs()).max((a - c).abs()).max_element();
    let bound = gamma(1) * position.abs().max_element() + gamma(20) * reach;
    // Room for the roundings of this sum and of the offset itself; the smallest number for triangles near zero.
    (bound * (1.0 + gamma(8))).next_up()
}

/// Point of a triangle with barycentric weights `u` of corner 1 and `v` of corner 2, rounded once.
pub fn triangle_point(corners: &[Vec3; 3], u: f32, v: f32) -> Vec3 {
    let [a, b, c] = corners.map(|p| p.as_dvec3());
    let (u, v) = (f64::from(u), f64::from(v));
    (a * (1.0 - u - v) + b * u + c * v).as_vec3()
}

impl Bvh {
    /// World-space corners of a triangle of an instance, to the bit those that rays are tested against.
    ///
    /// # Panics
    /// Where the instance or the triangle does not exist.
    pub fn world_corners(&self, instance: u32, triangle: u32) -> [Vec3; 3] {
        let placed = &self.geometry.instances()[instance as usize];
        let corners = self.geometry.meshes()[placed.mesh as usize].corners(triangle as usize);
        corners.map(|p| world_corner(&placed.world_from_mesh, p))
    }

    /// The surface point where `ray` met `hit`, seen from the ray's side.
    ///
    /// The position comes from the barycentrics, which is more exact than `origin + t direction`, drawn back along the
    /// ray by a few error bounds so that it is on the seen side of surfaces that meet there. The geometric normal
    /// is that of the world-space corners, turned to face the ray's origin; the shading normal is interpolated from
    /// the vertex normals (by the inverse transpose, right for mirrored placements too), turned to the same side, and
    /// is the geometric normal where the mesh has none or where it points below the surface or has no length.
    /// `footprint` and `id` are 0.
    ///
    /// # Panics
    /// Where the hit's instance or triangle does not exist: hits come from this hierarchy's queries.
    pub fn surface_point(&self, hit: &Hit, ray: &Ray) -> SurfacePoint {
        let corners = self.world_corners(hit.instance, hit.triangle);
        let on_triangle = triangle_point(&corners, hit.u, hit.v);
        let error = position_error(&corners, on_triangle);
        let position =
            (on_triangle.as_dvec3() - f64::from(DRAWN_BACK * error) * ray.direction.as_dvec3()).as_vec3();
        let outward = plane_normal(&corners).unwrap_or(-ray.direction.as_dvec3());
        let towards_ray = if outward.dot(ray.direction.as_dvec3()) > 0.0 { -1.0 } else { 1.0 };
        let geometric = outward * towards_ray;
        let placed = &self.geometry.instances()[hit.instance as usize];
        let mesh = &self.geometry.meshes()[placed.mesh as usize];
        let shading = interpolated_normal(mesh, hit, &placed.world_from_mesh)
            // Vertex normals agree with the winding or, in careless files, oppose it: only the side of the ray counts.
            .map(|n| if n.dot(outward) < 0.0 { n * -towards_ray } else { n * towards_ray })
            .filter(|n| n.dot(geometric) > 0.0)
            .unwrap_or(geometric);
        SurfacePoint {
            position,
            geometric_normal: geometric.as_vec3(),
            shading_normal: shading.as_vec3(),
            footprint: 0.0,
            // The first bound holds at the hit; the rest is the way back, with its rounding inside the room it leaves.
            position_error: ((1.0 + DRAWN_BACK) * error + gamma(1) * position.abs().max_element()).next_up(),
            id: 0,
        }
    }
}

impl Bvh {
    /// The surface point at a place of a triangle of an instance, with weights `u` of corner 1 and `v` of corner 2, on its front side.
    ///
    /// The front is where the corners go round counter-clockwise, the placement's mirroring counted, or where the vertex normals point in
    /// files that make the two disagree. A point on the rim is drawn inwards by a few error bounds, so that it is on the
    /// seen side of a surface that meets the triangle there; the error is the larger for it. `footprint` and `id` are 0. A triangle
    /// without area gives a point that is not valid.
    ///
    /// # Panics
    /// Where the instance or the triangle does not exist.
    pub fn front_point(&self, instance: u32, triangle: u32, [u, v]: [f32; 2]) -> SurfacePoint {
        let corners = self.world_corners(instance, triangle);
        let on_triangle = triangle_point(&corners, u, v);
        let error = position_error(&corners, on_triangle);
        let middle = triangle_point(&corners, 1.0 / 3.0, 1.0 / 3.0);
        let to_middle = (middle - on_triangle).as_dvec3();
        let drawn = f64::from(DRAWN_BACK * error).min(to_middle.length());
        let position = (on_triangle.as_dvec3() + drawn * to_middle.normalize_or_zero()).as_vec3();
        let placed = &self.geometry.instances()[instance as usize];
        let mesh = &self.geometry.meshes()[placed.mesh as usize];
        let mirrored = if wide_matrix(&placed.world_from_mesh).0.determinant() < 0.0 { -1.0 } else { 1.0 };
        let by_winding = mirrored * plane_normal(&corners).unwrap_or(DVec3::ZERO);
        let hit = Hit { instance, triangle, u, v, t: 0.0 };
        // The cofactors carry the sign of the determinant: a mirrored normal comes out turned round.
        let shading =
            interpolated_normal(mesh, &hit, &placed.world_from_mesh).map(|normal| mirrored * normal);
        let geometric = match shading {
            Some(shading) if shading.dot(by_winding) < 0.0 => -by_winding,
            _ => by_winding,
        };
        SurfacePoint {
            position,
            geometric_normal: geometric.as_vec3(),
            shading_normal: shading.filter(|n| n.dot(geometric) > 0.0).unwrap_or(geometric).as_vec3(),
            footprint: 0.0,
            position_error: ((1.0 + DRAWN_BACK) * error + gamma(1) * position.abs().max_element()).next_up(),
            id: 0,
        }
    }
}

impl Bvh {
    /// True where a ray met the back of a triangle: the front is as [`Bvh::front_point`] says.
    ///
    /// # Panics
    /// Where the hit's instance or triangle does not exist: hits come from this hierarchy's queries.
    pub fn is_back(&self, hit: &Hit, ray: &Ray) -> bool {
        is_back(&self.geometry, hit, ray.direction)
    }
}

/// True where a ray in that direction met the back of a triangle.
pub(crate) fn is_back(geometry: &Geometry, hit: &Hit, direction: Vec3) -> bool {
    let placed = &geometry.instances()[hit.instance as usize];
    let mesh = &geometry.meshes()[placed.mesh as usize];
    let corners = mesh.corners(hit.triangle as usize).map(|p| world_corner(&placed.world_from_mesh, p));
    let [a, b, c] = corners.map(|p| p.as_dvec3());
    let by_winding = (b - a).cross(c - a);
    // Of a mirrored placement both turn round: whether they agree stays, and the winding is the one to turn.
    let mirrored = wide_matrix(&placed.world_from_mesh).0.determinant() < 0.0;
    let disagrees = interpolated_normal(mesh, hit, &placed.world_from_mesh)
        .is_some_and(|shading| shading.dot(by_winding) < 0.0);
    (by_winding.dot(direction.as_dvec3()) > 0.0) != (mirrored != disagrees)
}

/// Unit normal of a triangle by the right-hand rule on its corners; `None` where they lie on a line.
fn plane_normal(corners: &[Vec3; 3]) -> Option<DVec3> {
    let [a, b, c] = corners.map(|p| p.as_dvec3());
    (b - a).cross(c - a).try_normalize()
}

/// World-space unit normal from the vertex normals; `None` where there are none or they cancel.
fn interpolated_normal(mesh: &TriangleMesh, hit: &Hit, world_from_mesh: &Affine3A) -> Option<DVec3> {
    if mesh.normals().is_empty() {
        return None;
    }
    let [a, b, c] = mesh.triangles()[hit.triangle as usize].map(|v| mesh.normals()[v as usize].as_dvec3());
    let (u, v) = (f64::from(hit.u), f64::from(hit.v));
    let normal = a * (1.0 - u - v) + b * u + c * v;
    (cofactors(world_from_mesh) * normal).try_normalize()
}

/// The inverse transpose times the determinant: defined for singular transforms as well.
fn cofactors(world_from_mesh: &Affine3A) -> DMat3 {
    let (m, _) = wide_matrix(world_from_mesh);
    DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis))
}

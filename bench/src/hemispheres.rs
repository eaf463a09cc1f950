//! The same hemispheres of rays for every kernel: made once, traced by each in turn, timed apart from their making.

use conray::{AoSettings, Error, Method, Session, SurfacePoint, Vec3, target::Target};
use conray_core::{Frame, cosine_hemisphere, hash_u32, owen_sobol_2d};

use crate::Judged;

/// Points whose rays are made at one go, so that they stay near the caches.
pub const CHUNK: usize = 4096;

/// A scene with the points from which hemispheres are cast.
pub struct Hemispheres {
    /// Name in tables.
    pub name: String,
    /// Built with a BVH.
    pub session: Session,
    /// The points, in the order of image tiles.
    pub points: Vec<SurfacePoint>,
    /// AO distance in world units.
    pub distance: f32,
}

impl Hemispheres {
    /// The points that a square image of that side sees, every surface opaque.
    ///
    /// # Errors
    /// What building says.
    pub fn new(judged: Judged, settings: &AoSettings, side: u32) -> Result<Self, Error> {
        let Judged { name, scene, view } = judged;
        let settings = AoSettings { method: Method::Rays, alpha: conray::Alpha::Opaque, ..settings.clone() };
        let session = Session::build(scene.geometry, &settings)?;
        let points = session.camera(&view, side, side)?.points().to_vec();
        let distance = session.plan().distance;
        Ok(Self { name, session, points, distance })
    }
}

/// Directions of a chunk of points: `rays` for each, above its surface, in a coherent order.
///
/// Owen-scrambled Sobol points, as the product draws them, sorted into the 4 x 4 cells of the square so that sixteen
/// rays in a row look about the same way: the best that a packet tracer can be given.
pub fn directions(points: &[SurfacePoint], rays: u32, out: &mut Vec<Vec3>) {
    out.clear();
    for point in points {
        let frame = Frame::from_normal(point.geometric_normal);
        let start = out.len();
        let seed = hash_u32(point.id);
        let mut squares: Vec<_> = (0..rays).map(|i| owen_sobol_2d(i, seed)).collect();
        let side = f32::from(u8::try_from((rays / 16).clamp(1, 16)).unwrap_or(16)).sqrt().floor();
        squares.sort_by_key(|u| ((u.x * side) as u32, (u.y * side) as u32));
        out.extend(squares.into_iter().map(|u| frame.to_world(cosine_hemisphere(u))));
        // A direction along the surface is not worth a case of its own.
        for direction in &mut out[start..] {
            if direction.dot(point.geometric_normal) <= 0.0 {
                *direction = point.geometric_normal;
            }
        }
    }
}

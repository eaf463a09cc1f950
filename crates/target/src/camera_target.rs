//! What a camera sees, as surface points.

use crate::{Camera, Layers, Target, TargetError, target::check_count};
use conray_core::{Estimate, Layout, Ray, SurfacePoint};
use rayon::prelude::*;

/// Side of the tiles in whose order points are listed, in pixels: neighbours in the list see much the same geometry.
const TILE_PX: u32 = 16;

/// The surface points behind the pixels of an image.
///
/// Points are listed tile by tile (16 x 16 pixels, rows of tiles from the top), row by row within a tile; the `id` of
/// each is its pixel, `y * width + x`. Pixels that see nothing have no point.
#[derive(Clone, Debug)]
pub struct CameraTarget {
    camera: Camera,
    points: Vec<SurfacePoint>,
    unusable_hits: usize,
}

impl CameraTarget {
    /// Asks for the nearest hit through every pixel, in parallel; the result does not depend on the thread count.
    ///
    /// `hit` answers with the surface point on the side that the ray came from, or `None` where it meets nothing; the
    /// point's `id` and `footprint` are set here. A point that is not valid ([`SurfacePoint::is_valid`]) is left out
    /// as if nothing had been met, and counted ([`CameraTarget::unusable_hits`]).
    pub fn trace(camera: Camera, hit: impl Fn(&Ray) -> Option<SurfacePoint> + Sync) -> Self {
        let (width, height) = (camera.width(), camera.height());
        let mut points: Vec<SurfacePoint> = (0..tile_count(width, height))
            .into_par_iter()
            .flat_map_iter(|tile| tile_pixels(width, height, tile))
            .filter_map(|(px, py)| {
                let point = hit(&camera.ray(px, py))?;
                let footprint = camera.footprint(point.position);
                Some(SurfacePoint { id: py * width + px, footprint, ..point })
            })
            .collect();
        let met = points.len();
        points.retain(SurfacePoint::is_valid);
        Self { camera, unusable_hits: met - points.len(), points }
    }

    /// The camera.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// How many hits were left out because they were not valid surface points.
    pub fn unusable_hits(&self) -> usize {
        self.unusable_hits
    }
}

impl Target for CameraTarget {
    type Output = Layers;

    fn points(&self) -> &[SurfacePoint] {
        &self.points
    }

    fn layout(&self) -> Layout {
        Layout::Image { first: 0, width: self.camera.width(), height: self.camera.height() }
    }

    fn resolve(&self, estimates: &[Estimate]) -> Result<Layers, TargetError> {
        check_count(&self.points, estimates)?;
        Ok(Layers::new(self.camera.width(), self.camera.height(), &self.points, estimates))
    }
}

fn tile_count(width: u32, height: u32) -> u32 {
    width.div_ceil(TILE_PX) * height.div_ceil(TILE_PX)
}

/// Pixels (x, y) of one tile, row by row; tiles at the right and the bottom may be cut.
fn tile_pixels(width: u32, height: u32, tile: u32) -> impl Iterator<Item = (u32, u32)> {
    let columns = width.div_ceil(TILE_PX);
    let (left, top) = (tile % columns * TILE_PX, tile / columns * TILE_PX);
    let (right, bottom) = ((left + TILE_PX).min(width), (top + TILE_PX).min(height));
    (top..bottom).flat_map(move |y| (left..right).map(move |x| (x, y)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use conray_core::{Vec3, View};
    use proptest::prelude::*;

    fn camera(width: u32, height: u32) -> Camera {
        let (eye, look_at, up) = (Vec3::new(0.0, 0.0, 4.0), Vec3::ZERO, Vec3::Y);
        let view = View { name: String::new(), eye, look_at, up, vertical_fov_deg: 60.0 };
        Camera::new(&view, width, height).unwrap()
    }

    /// The plane z = 0 within the unit disc.
    fn disc(ray: &Ray) -> Option<SurfacePoint> {
        let p = ray.origin - ray.direction * (ray.origin.z / ray.direction.z);
        (p.truncate().length() < 1.0).then(|| SurfacePoint::new(p, Vec3::Z))
    }

    proptest! {
        #[test]
        fn tiles_cover_every_pixel_once(width in 1u32..70, height in 1u32..70) {
            let mut seen = vec![0u32; (width * height) as usize];
            for tile in 0..tile_count(width, height) {
                for (x, y) in tile_pixels(width, height, tile) {
                    prop_assert!(x < width && y < height);
                    seen[(y * width + x) as usize] += 1;
                }
            }
            prop_assert!(seen.iter().all(|&n| n == 1));
        }
    }

    #[test]
    fn points_carry_their_pixel_and_its_size() {
        let target = CameraTarget::trace(camera(67, 45), disc);
        let truth = target.camera().footprint(Vec3::ZERO);
        assert!((truth - 4.0 * 2.0 * 30f32.to_radians().tan() / 45.0).abs() < 1e-6);
        assert!(!target.points().is_empty());
        for p in target.points() {
            let ray = target.camera().ray(p.id % 67, p.id / 67);
            assert!((disc(&ray).unwrap().position - p.position).length() < 1e-6);
            assert!((p.footprint - truth).abs() < 1e-5, "all hits lie at the same depth");
        }
        // A disc of radius 1 at depth 4 covers pi / footprint^2 pixels, but for its rim of some 2 pi / footprint.
        let expected = std::f32::consts::PI / (truth * truth);
        assert!((target.points().len() as f32 - expected).abs() < 6.3 / truth);
    }

    #[test]
    fn order_does_not_depend_on_threads() {
        let trace = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| CameraTarget::trace(camera(123, 77), disc).points().to_vec())
        };
        assert_eq!(trace(1), trace(4));
    }

    #[test]
    fn invalid_hits_are_left_out_and_counted() {
        let target = CameraTarget::trace(camera(20, 20), |ray| {
            let normal = if ray.direction.x < 0.0 { Vec3::ZERO } else { Vec3::Z };
            Some(SurfacePoint::new(ray.origin + ray.direction, normal))
        });
        assert_eq!((target.points().len(), target.unusable_hits()), (200, 200));
    }

    #[test]
    fn estimates_must_match_the_points() {
        let target = CameraTarget::trace(camera(9, 9), disc);
        let few = vec![Estimate::PENDING; target.points().len() - 1];
        assert!(matches!(target.resolve(&few), Err(TargetError::EstimateCount { .. })));
    }
}

//! The same hemispheres of rays for every kernel: made once, traced by each in turn, timed apart from their making.

use crate::Judged;
use conray::{AoSettings, Error, Method, Session, SurfacePoint, Vec2, Vec3, target::Target};
use conray_core::{Frame, cosine_hemisphere, hash_u32, owen_sobol_2d};
use rayon::prelude::*;

/// Points whose rays are made at one go.
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

/// In which order the rays of a point are handed to a kernel. The set of rays is the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Square cells of sixteen rays each, cell after cell: sixteen in a row look about the same way.
    Cells,
    /// Morton order of the square: any run of neighbours looks about the same way.
    Morton,
    /// By the signs of the direction in world space, then Morton: neighbours enter boxes through the same sides.
    Octants,
}

impl Order {
    /// All orders.
    pub const ALL: [Self; 3] = [Self::Cells, Self::Morton, Self::Octants];

    /// By what the rays of a point are sorted; `rays` is how many there are.
    fn key(self, square: Vec2, direction: Vec3, rays: usize) -> u64 {
        match self {
            Self::Cells => {
                let side = (rays as f32 / 16.0).max(1.0).sqrt().floor();
                ((square.x * side) as u64) << 32 | (square.y * side) as u64
            }
            Self::Morton => u64::from(morton(square)),
            Self::Octants => u64::from(direction.is_negative_bitmask()) << 32 | u64::from(morton(square)),
        }
    }
}

/// Morton code of a point of the unit square, 16 bits an axis.
fn morton(square: Vec2) -> u32 {
    // Each bit moves to twice its place, a half of the word at a time.
    let spread = |v: f32| {
        let mut bits = ((v * 65536.0) as u32).min(0xffff);
        bits = (bits | bits << 8) & 0x00ff_00ff;
        bits = (bits | bits << 4) & 0x0f0f_0f0f;
        bits = (bits | bits << 2) & 0x3333_3333;
        (bits | bits << 1) & 0x5555_5555
    };
    spread(square.x) | spread(square.y) << 1
}

/// Directions of the rays of some points, in the order in which they are drawn.
#[derive(Default)]
pub struct Directions {
    /// Rays of each point.
    pub rays: usize,
    squares: Vec<Vec2>,
    directions: Vec<Vec3>,
}

/// The same directions in an order of a kernel's choice.
pub struct Ordered {
    /// Point by point.
    pub directions: Vec<Vec3>,
    /// For each the place among the rays of its point in which it was drawn.
    pub drawn: Vec<u32>,
}

impl Directions {
    /// Draws `rays` directions above the surface of each point: Owen-scrambled Sobol points, cosine-weighted, as the
    /// product draws them.
    pub fn draw(&mut self, points: &[SurfacePoint], rays: usize) {
        self.rays = rays;
        self.squares.resize(points.len() * rays, Vec2::ZERO);
        self.directions.resize(points.len() * rays, Vec3::ZERO);
        let rows = self.squares.par_chunks_mut(rays).zip(self.directions.par_chunks_mut(rays));
        points.par_iter().zip(rows).for_each(|(point, (squares, directions))| {
            let (frame, seed) = (Frame::from_normal(point.geometric_normal), hash_u32(point.id));
            for (index, (square, direction)) in (0u32..).zip(squares.iter_mut().zip(directions)) {
                *square = owen_sobol_2d(index, seed);
                *direction = frame.to_world(cosine_hemisphere(*square));
                // A direction along the surface is not worth a case of its own.
                if direction.dot(point.geometric_normal) <= 0.0 {
                    *direction = point.geometric_normal;
                }
            }
        });
    }

    /// Sorts the rays of each point.
    pub fn ordered(&self, order: Order) -> Ordered {
        let rays = self.rays;
        let mut drawn: Vec<u32> = vec![0; self.directions.len()];
        drawn.par_chunks_mut(rays).enumerate().for_each(|(point, drawn)| {
            let at = |i: u32| point * rays + i as usize;
            (0u32..).zip(drawn.iter_mut()).for_each(|(i, place)| *place = i);
            drawn.sort_by_cached_key(|&i| order.key(self.squares[at(i)], self.directions[at(i)], rays));
        });
        let place = |(i, &drawn): (usize, &u32)| self.directions[i / rays * rays + drawn as usize];
        let directions = drawn.par_iter().enumerate().map(place).collect();
        Ordered { directions, drawn }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_order_is_a_permutation_of_each_points_rays() {
        let points: Vec<SurfacePoint> =
            (0..5).map(|id| SurfacePoint::new(Vec3::ZERO, Vec3::new(1.0, 2.0, -3.0)).with_id(id)).collect();
        let mut directions = Directions::default();
        directions.draw(&points, 64);
        for order in Order::ALL {
            let ordered = directions.ordered(order);
            for (point, drawn) in ordered.drawn.chunks(64).enumerate() {
                let mut places = drawn.to_vec();
                places.sort_unstable();
                assert!(places.iter().copied().eq(0..64), "{order:?}");
                for (i, &d) in drawn.iter().enumerate() {
                    assert_eq!(
                        ordered.directions[64 * point + i],
                        directions.directions[64 * point + d as usize]
                    );
                }
            }
        }
    }

    #[test]
    fn morton_codes_interleave_bits() {
        let code = |x: u32, y: u32| morton(Vec2::new(x as f32, y as f32) / 65536.0);
        let slowly = |x: u32, y: u32| {
            (0..16).fold(0, |c, i| c | (x >> i & 1) << (2 * i) | (y >> i & 1) << (2 * i + 1))
        };
        for (x, y) in [(0, 0), (1, 0), (0, 1), (0xffff, 0), (0x1234, 0xfedc), (0xffff, 0xffff)] {
            assert_eq!(code(x, y), slowly(x, y), "{x} {y}");
        }
        assert_eq!(morton(Vec2::ONE), !0, "the edge belongs to the last cell");
    }

    #[test]
    fn sixteen_in_a_row_look_the_same_way_in_cells_and_any_as_drawn() {
        let points = [SurfacePoint::new(Vec3::ZERO, Vec3::Z)];
        let mut directions = Directions::default();
        directions.draw(&points, 256);
        let spread = |rays: &[Vec3]| {
            let mean = rays.iter().sum::<Vec3>() / rays.len() as f32;
            rays.iter().map(|d| d.distance_squared(mean)).sum::<f32>()
        };
        let total = |all: &[Vec3]| all.chunks(16).map(spread).sum::<f32>();
        for order in [Order::Cells, Order::Morton] {
            let sorted = total(&directions.ordered(order).directions);
            // Unsorted, sixteen cover the hemisphere: the variance is 1/2 across the normal and 1/18 along it. A sixteenth of
            // the square has 1/32 across it, a little more where cells are bent, and 0.024 along it in the 12 cells at the
            // rim, where the squared cosine is uniform up to 7/16: together 0.09 of the whole.
            assert!(sorted < 0.15 * total(&directions.directions), "{order:?}");
        }
    }
}

//! Which points lie inside other geometry, seen by the back faces about them.

use conray::Session;
use conray_core::{
    Estimate, Frame, Geometry, Layout, Opacity, Ray, SurfacePoint, cosine_hemisphere, owen_sobol_2d,
};
use rayon::prelude::*;

/// Points that see more than this are not asked about: inside a closed thing at most half is open beside its wall, and what is further from it than
/// the AO distance is read together with nothing outside.
const MOST_OPEN: f32 = 0.6;
/// Rays that look for back faces, and how many may meet something else, or nothing, inside: an eighth. A wall without thickness takes half of what the
/// floor at its foot sees, and the inside of a shell that is open somewhere, which is seen from there, shows up to three quarters of back faces.
const RAYS: u32 = 24;
const MOST_OTHERS: u32 = 3;
/// Rays that decide it where all of them meet back faces.
const CLEARLY_IN: u32 = 16;
/// Pixels are asked in lattices of so many pixels, each with the wider one whose pixels are known by then.
const LATTICES: [(u32, Option<u32>); 3] = [(4, None), (2, Some(4)), (1, Some(2))];
/// A pixel whose visibility is less than this share of that of neighbours outside may lie inside though they do not.
const AS_OPEN: f32 = 0.5;
/// Neighbours lie on the same surface if they are no farther than so many texels, and their normals have at least this cosine.
const NEAR: f32 = 4.0;
const LIKE: f32 = 0.9;

/// Tells which points lie inside what occludes in a session. Back faces of materials that are seen from both sides, or through, do not count.
///
/// In an image only one point in sixteen is asked about by rays for sure; others are what their neighbours are where these are of one mind.
pub fn inside(
    session: &Session,
    points: &[SurfacePoint],
    estimates: &[Estimate],
    layout: Layout,
) -> Vec<bool> {
    let solid = solid(session.geometry());
    let by_rays = |index: usize| {
        let (point, estimate) = (&points[index], &estimates[index]);
        let closed = !estimate.is_pending() && estimate.visibility <= MOST_OPEN;
        closed.then(|| is_inside(session, &solid, point))
    };
    let found: Vec<Option<bool>> = session.install(|| match layout {
        Layout::Scattered => (0..points.len()).into_par_iter().with_min_len(64).map(by_rays).collect(),
        Layout::Image { first, width, height } => {
            let grid = Grid::of(points, first, [width, height]);
            let mut found = vec![None; points.len()];
            // From a wide lattice to all pixels: between those of one mind nobody is asked.
            for (step, wider) in LATTICES {
                let at_step = |index: usize, step: u32| {
                    let [x, y] = grid.place(&points[index]);
                    (x % step, y % step) == (0, 0)
                };
                let answer = |index: usize| match at_step(index, step) {
                    true if wider.is_none_or(|wider| !at_step(index, wider)) => {
                        if estimates[index].visibility > MOST_OPEN {
                            return None;
                        }
                        let told =
                            wider.and_then(|_| grid.of_one_mind(points, estimates, index, step, &found));
                        told.or_else(|| by_rays(index))
                    }
                    _ => found[index],
                };
                found = (0..points.len()).into_par_iter().with_min_len(64).map(answer).collect();
            }
            found
        }
    });
    found.into_iter().map(|inside| inside == Some(true)).collect()
}

/// Where points stand in an image.
struct Grid {
    first: u32,
    size: [u32; 2],
    /// Index of the point of each pixel.
    index: Vec<u32>,
}

impl Grid {
    fn of(points: &[SurfacePoint], first: u32, size: [u32; 2]) -> Self {
        let mut index = vec![u32::MAX; size[0] as usize * size[1] as usize];
        for (k, point) in (0..).zip(points) {
            index[(point.id - first) as usize] = k;
        }
        Self { first, size, index }
    }

    fn place(&self, point: &SurfacePoint) -> [u32; 2] {
        let pixel = point.id - self.first;
        [pixel % self.size[0], pixel / self.size[0]]
    }

    /// What the neighbours on the lattice of twice the step say where all do that lie on the same surface, and two at least.
    fn of_one_mind(
        &self,
        points: &[SurfacePoint],
        estimates: &[Estimate],
        index: usize,
        step: u32,
        lattice: &[Option<bool>],
    ) -> Option<bool> {
        let point = &points[index];
        let sides =
            |at: u32| if at.is_multiple_of(2 * step) { [at, u32::MAX] } else { [at - step, at + step] };
        let about = self.place(point).map(sides);
        let (mut said, mut count) = (None, 0);
        for (x, y) in about[0].iter().flat_map(|&x| about[1].iter().map(move |&y| (x, y))) {
            if x >= self.size[0] || y >= self.size[1] {
                continue;
            }
            let near = self.index[y as usize * self.size[0] as usize + x as usize] as usize;
            let Some(other) = points.get(near) else { continue };
            if other.position.distance(point.position) > NEAR * point.footprint
                || other.geometric_normal.dot(point.geometric_normal) < LIKE
            {
                continue;
            }
            if estimates[near].is_pending() {
                continue;
            }
            // One that was not asked is open.
            let inside = lattice[near].unwrap_or(false);
            if !inside && estimates[index].visibility < AS_OPEN * estimates[near].visibility {
                return None;
            }
            if said.is_some_and(|said| said != inside) {
                return None;
            }
            (said, count) = (Some(inside), count + 1);
        }
        said.filter(|_| count >= 2)
    }
}

/// For each mesh whether its back faces are the inside of something.
fn solid(geometry: &Geometry) -> Vec<bool> {
    let is_solid = |mesh: usize| {
        let material = geometry.materials().get(geometry.meshes()[mesh].material as usize);
        let two_sided = material.is_some_and(|material| material.double_sided);
        !two_sided && matches!(geometry.opacity(mesh), Opacity::Constant(opacity) if *opacity >= 0.5)
    };
    (0..geometry.meshes().len()).map(is_solid).collect()
}

fn is_inside(session: &Session, solid: &[bool], point: &SurfacePoint) -> bool {
    let frame = Frame::from_normal(point.geometric_normal);
    let meets_back = |k: u32| {
        let local = cosine_hemisphere(owen_sobol_2d(k, point.id));
        let direction = frame.to_world(local).normalize();
        let ray = Ray { origin: point.ray_origin(), direction, t_max: f32::INFINITY };
        let Some(hit) = session.bvh().nearest(&ray) else { return false };
        let mesh = session.geometry().instances()[hit.instance as usize].mesh;
        solid[mesh as usize] && session.bvh().is_back(&hit, &ray)
    };
    let mut others = 0;
    for k in 0..RAYS {
        others += u32::from(!meets_back(k));
        if others > MOST_OTHERS {
            return false;
        }
        if others == 0 && k + 1 == CLEARLY_IN {
            break;
        }
    }
    true
}

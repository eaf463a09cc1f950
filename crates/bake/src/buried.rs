//! Texels that lie inside other geometry, seen by the back faces about them.
//!
//! A floor goes on under the box that stands on it. Nobody sees it there, but the texels at the box's foot are read together with those beside it, and
//! are dark. What they show is no light that anybody sees: they are to take the values of their neighbours outside.

use conray::Session;
use conray_core::{Estimate, Frame, Geometry, Opacity, Ray, SurfacePoint, cosine_hemisphere, owen_sobol_2d};
use rayon::prelude::*;

/// Points that see more than this are not asked about: inside a closed thing at most half is open beside its wall, and what is further from it than
/// the AO distance is read together with nothing outside.
const MOST_OPEN: f32 = 0.6;
/// Rays of the first look, and of the second where half of those met back faces.
const FIRST: u32 = 8;
const ALL: u32 = 32;
/// Share of all rays that meet back faces from which on a point is inside.
const INSIDE: f32 = 0.5;
/// Where more of a surface than this lies inside, it is not buried: what is about it is turned inside out.
const MOST_BURIED: f32 = 0.5;

/// Tells which points lie inside other geometry. `instances` are those of the points: where most of an instance seems buried, none of its points is.
/// Back faces of materials that are seen from both sides, or through, do not count.
pub fn buried(
    session: &Session,
    points: &[SurfacePoint],
    estimates: &[Estimate],
    instances: &[u32],
) -> Vec<bool> {
    let solid = solid(session.geometry());
    let one = |(point, estimate): (&SurfacePoint, &Estimate)| {
        let closed = !estimate.is_pending() && estimate.visibility <= MOST_OPEN;
        closed && is_inside(session, &solid, point)
    };
    let mut found: Vec<bool> =
        session.install(|| points.par_iter().zip(estimates).with_min_len(64).map(one).collect());
    let mut counts = vec![[0u32; 2]; session.geometry().instances().len()];
    for (&instance, &buried) in instances.iter().zip(&found) {
        let [all, inside] = &mut counts[instance as usize];
        (*all, *inside) = (*all + 1, *inside + u32::from(buried));
    }
    for (&instance, buried) in instances.iter().zip(&mut found) {
        let [all, inside] = counts[instance as usize];
        *buried &= inside as f32 <= MOST_BURIED * all as f32;
    }
    found
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
    let meets_back = |k: &u32| {
        let local = cosine_hemisphere(owen_sobol_2d(*k, point.id));
        let direction = frame.to_world(local).normalize();
        let ray = Ray { origin: point.ray_origin(), direction, t_max: f32::INFINITY };
        let Some(hit) = session.bvh().nearest(&ray) else { return false };
        let mesh = session.geometry().instances()[hit.instance as usize].mesh;
        let front = session.bvh().front_point(hit.instance, hit.triangle, [hit.u, hit.v]);
        solid[mesh as usize] && front.geometric_normal.dot(direction) > 0.0
    };
    let first = (0..FIRST).filter(meets_back).count() as f32;
    first >= INSIDE * FIRST as f32
        && first + (FIRST..ALL).filter(meets_back).count() as f32 >= INSIDE * ALL as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use conray::{AoSettings, Distance};
    use conray_core::{Affine3A, Material, TriangleMesh, Vec3};

    /// A floor 4 x 4, and a closed box of 1 x 1 x 1 on the middle of it.
    fn scene(double_sided: bool, inside_out: bool) -> Session {
        let mut geometry = Geometry::default();
        geometry.add_material(Material::default());
        geometry.add_material(Material { double_sided, ..Material::default() });
        let floor = [(-2.0, -2.0), (-2.0, 2.0), (2.0, 2.0), (2.0, -2.0)].map(|(x, z)| Vec3::new(x, 0.0, z));
        let floor = TriangleMesh::new(floor.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).unwrap();
        let corner = |k: u32| {
            let bit = |axis: u32| f32::from((k >> axis & 1) as u8);
            Vec3::new(bit(0) - 0.5, bit(1), bit(2) - 0.5)
        };
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3]];
        let mut triangles: Vec<[u32; 3]> =
            faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        if inside_out {
            triangles.iter_mut().for_each(|triangle| triangle.swap(0, 1));
        }
        let solid = TriangleMesh::new((0..8).map(corner).collect(), triangles).unwrap().with_material(1);
        for mesh in [floor, solid] {
            let mesh = geometry.add_mesh(mesh).unwrap();
            geometry.add_instance(mesh, Affine3A::IDENTITY).unwrap();
        }
        let settings = AoSettings { rays: Some(16), distance: Distance::Infinite, ..AoSettings::default() };
        Session::build(geometry, &settings).unwrap()
    }

    /// Points of the floor, a row along x: buried where they lie under the box.
    fn along(session: &Session, xs: &[f32]) -> Vec<bool> {
        let points: Vec<SurfacePoint> = (0..)
            .zip(xs)
            .map(|(id, &x)| SurfacePoint::new(Vec3::new(x, 0.0, 0.1), Vec3::Y).with_id(id))
            .collect();
        let estimates = session.estimate(&points).unwrap();
        buried(session, &points, &estimates, &vec![0; xs.len()])
    }

    const XS: [f32; 7] = [-1.5, -0.7, -0.505, -0.495, 0.0, 0.52, 1.0];

    #[test]
    fn the_floor_under_a_box_is_buried_and_that_beside_it_is_not() {
        let expected = [false, false, false, true, true, false, false];
        assert_eq!(along(&scene(false, false), &XS), expected);
    }

    #[test]
    fn back_faces_that_are_meant_to_be_seen_bury_nothing() {
        assert_eq!(along(&scene(true, false), &XS), [false; 7]);
    }

    #[test]
    fn a_surface_that_would_be_buried_as_a_whole_is_not() {
        // A box turned inside out shows its back faces to the whole floor beside it, as far as that is closed.
        let near = [-0.51, -0.505, 0.505, 0.51];
        assert_eq!(along(&scene(false, true), &near), [false; 4]);
        assert_eq!(along(&scene(false, false), &[0.0, 0.1, 0.2, 1.5]), [false; 4]);
    }
}

//! Texels that lie inside other geometry, seen by the back faces about them.
//!
//! A floor goes on under the box that stands on it. Nobody sees it there, but the texels at the box's foot are read together with those beside it, and
//! are dark. What they show is no light that anybody sees: they are to take the values of their neighbours outside.

use conray_core::{Estimate, Geometry};
use conray_target::{AtlasMap, AtlasTarget, Target, TargetError, Texel};
use std::collections::HashMap;

/// Where more of a surface than this lies inside, it is not buried: what is about it is turned inside out.
const MOST_BURIED: f64 = 0.5;

/// Texels that lie inside other geometry, of all portions of some maps.
#[derive(Clone, Debug)]
pub struct Buried {
    /// For each instance how many points it has, and how many of them lie inside.
    counts: Vec<[u64; 2]>,
    /// Texels of which parts lie inside, as they are without these, and an instance that lies inside there.
    texels: Vec<(u32, Texel)>,
}

impl Buried {
    /// None yet.
    pub fn new(geometry: &Geometry) -> Self {
        let counts = vec![[0; 2]; geometry.instances().len()];
        Self { counts, texels: Vec::new() }
    }

    /// Adds those of a portion, of whose points `inside` tells. `instances` are those of the target's surfaces.
    ///
    /// # Errors
    /// Estimates that are not those of the target's points.
    pub fn add(
        &mut self,
        target: &AtlasTarget,
        estimates: &[Estimate],
        inside: &[bool],
        instances: &[u32],
    ) -> Result<(), TargetError> {
        let of_points = target.surfaces().iter().map(|&surface| instances[surface as usize]);
        let mut whose: HashMap<(u32, u32), u32> = HashMap::new();
        for ((instance, &inside), texel) in of_points.zip(inside).zip(target.texels()) {
            let [all, within] = &mut self.counts[instance as usize];
            (*all, *within) = (*all + 1, *within + u64::from(inside));
            if inside {
                whose.entry(texel).or_insert(instance);
            }
        }
        if whose.is_empty() {
            return Ok(());
        }
        let without: Vec<Estimate> = estimates
            .iter()
            .zip(inside)
            .map(|(estimate, &inside)| if inside { Estimate::PENDING } else { *estimate })
            .collect();
        let changed = target.resolve(&without)?.into_iter();
        self.texels.extend(changed.filter_map(|texel| Some((*whose.get(&(texel.map, texel.at))?, texel))));
        Ok(())
    }

    /// Takes from maps what lies inside, so that it is filled from its neighbours; tells how many points do, and the texels as they were. Of an
    /// instance that seems to lie inside for the most part none does.
    pub fn take_from(&self, maps: &mut [AtlasMap]) -> (u64, Vec<Texel>) {
        let is_outside = |[all, within]: &[u64; 2]| *within as f64 > MOST_BURIED * *all as f64;
        let mut taken = Vec::new();
        for (instance, texel) in &self.texels {
            if !is_outside(&self.counts[*instance as usize]) {
                let map = &mut maps[texel.map as usize];
                taken.push(map.texel(texel.map, texel.at));
                map.put(texel);
            }
        }
        let inside = self.counts.iter().filter(|counts| !is_outside(counts));
        (inside.map(|[_, within]| within).sum(), taken)
    }
}

/// Takes back that points lie inside for instances of which most do: what is about these is turned inside out. `instances` are those of the points.
pub(crate) fn mostly_outside(inside: &mut [bool], instances: &[u32]) {
    let most = instances.iter().max().map_or(0, |most| *most as usize + 1);
    let mut counts = vec![[0u64; 2]; most];
    for (&instance, &inside) in instances.iter().zip(&*inside) {
        let [all, within] = &mut counts[instance as usize];
        (*all, *within) = (*all + 1, *within + u64::from(inside));
    }
    for (&instance, inside) in instances.iter().zip(inside) {
        let [all, within] = counts[instance as usize];
        *inside &= within as f64 <= MOST_BURIED * all as f64;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inside;
    use conray::{AoSettings, Distance, Session};
    use conray_core::{Affine3A, Layout, Material, SurfacePoint, TriangleMesh, Vec2, Vec3};
    use conray_target::{Atlas, MapSize, Surface};

    /// A floor 4 x 4, and a closed box of 1 x 1 x 1 on the middle of it.
    fn scene(double_sided: bool, inside_out: bool) -> Session {
        let mut geometry = Geometry::default();
        geometry.add_material(Material::default());
        geometry.add_material(Material { double_sided, ..Material::default() });
        let floor = [(-2.0, -2.0), (-2.0, 2.0), (2.0, 2.0), (2.0, -2.0)].map(|(x, z)| Vec3::new(x, 0.0, z));
        let uvs = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(u, v)| Vec2::new(u, v)).to_vec();
        let floor = TriangleMesh::new(floor.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).unwrap();
        let floor = floor.with_uv_set(uvs).unwrap();
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
        Session::build(geometry, &settings()).unwrap()
    }

    fn settings() -> AoSettings {
        AoSettings { rays: Some(16), distance: Distance::Infinite, ..AoSettings::default() }
    }

    /// How many points of a map of the floor are buried, and which texels of the middle row.
    fn floor(session: &Session) -> (u64, Vec<bool>) {
        let corner = |x: f32, z: f32| Vec2::new((x + 2.0) / 4.0, (z + 2.0) / 4.0);
        let [a, b, c, d] = [(-2.0, -2.0), (-2.0, 2.0), (2.0, 2.0), (2.0, -2.0)].map(|(x, z)| corner(x, z));
        let surfaces = vec![Surface { map: 0, uvs: vec![[a, b, c], [a, c, d]] }];
        let atlas = Atlas { sizes: vec![MapSize { width: 64, height: 64 }], surfaces, supersample: 1 };
        let mut buried = Buried::new(session.geometry());
        let mut maps = atlas.maps();
        for portion in atlas.portions(1000).unwrap() {
            let target = atlas.texels(&portion, |_, triangle, weights| {
                session.bvh().front_point(0, triangle as u32, [weights[1], weights[2]])
            });
            let estimates = session.estimate(target.points()).unwrap();
            target.resolve(&estimates).unwrap().iter().for_each(|texel| maps[0].put(texel));
            let inside = inside(session, target.points(), &estimates, target.layout());
            buried.add(&target, &estimates, &inside, &[0]).unwrap();
        }
        let (count, _) = buried.take_from(&mut maps);
        (count, (0..64).map(|x| maps[0].visibility[33 * 64 + x].is_nan()).collect())
    }

    /// The texels of a row across a floor of 4 units that lie under a box of 1 in the middle.
    fn under(x: usize) -> bool {
        (24..40).contains(&x)
    }

    #[test]
    fn the_floor_under_a_box_is_buried_and_that_beside_it_is_not() {
        let (count, row) = floor(&scene(false, false));
        assert_eq!(row, (0..64).map(under).collect::<Vec<_>>());
        assert_eq!(count, 16 * 16);
    }

    #[test]
    fn back_faces_that_are_meant_to_be_seen_bury_nothing() {
        assert_eq!(floor(&scene(true, false)), (0, vec![false; 64]));
    }

    #[test]
    fn a_surface_that_would_be_buried_as_a_whole_is_not() {
        // A floor of 0.9 units under the box.
        let mut geometry = scene(false, false).geometry().clone();
        let small = geometry.meshes()[0].clone();
        let mesh = geometry.add_mesh(small).unwrap();
        let within = Affine3A::from_scale(Vec3::new(0.2, 1.0, 0.2));
        let instance = geometry.add_instance(mesh, within).unwrap();
        let session = Session::build(geometry, &settings()).unwrap();
        let points: Vec<SurfacePoint> = (0..100)
            .map(|id| SurfacePoint::new(Vec3::new(0.004 * id as f32, 0.0, 0.1), Vec3::Y).with_id(id))
            .collect();
        let estimates = session.estimate(&points).unwrap();
        let found = inside(&session, &points, &estimates, Layout::Scattered);
        assert!(found.iter().all(|inside| *inside), "each by itself lies inside");
        let texel = Texel { visibility: f32::NAN, ..Texel::UNKNOWN };
        let mut counts = vec![[0; 2]; session.geometry().instances().len()];
        counts[instance as usize] = [100, 100];
        let buried = Buried { counts, texels: vec![(instance, texel)] };
        let map = AtlasMap {
            width: 1,
            height: 1,
            visibility: vec![0.25],
            error: vec![0.0],
            bent: vec![Vec3::ZERO],
            is_read: vec![true],
        };
        let mut maps = [map];
        assert_eq!(buried.take_from(&mut maps), (0, Vec::new()));
        assert_eq!(maps[0].visibility, [0.25]);
        let mut some = buried;
        some.counts[instance as usize] = [200, 100];
        let (count, taken) = some.take_from(&mut maps);
        assert_eq!((count, taken[0].visibility), (100, 0.25));
        assert!(maps[0].visibility[0].is_nan());
    }

    #[test]
    fn neighbours_of_one_mind_say_what_rays_would() {
        // The floor seen from above as an image of 81 x 81 points, at a slant, so that the box's sides run across rows.
        let session = scene(false, false);
        let (side, turn) = (81u32, 0.3f32);
        let point = |id: u32| {
            let at = Vec2::new((id % side) as f32, (id / side) as f32) / 40.0 - 1.0;
            let at = Vec2::from_angle(turn).rotate(at);
            let point = SurfacePoint::new(Vec3::new(at.x, 0.0, at.y), Vec3::Y);
            SurfacePoint { footprint: 1.0 / 40.0, ..point }.with_id(id)
        };
        let points: Vec<SurfacePoint> = (0..side * side).map(point).collect();
        let estimates = session.estimate(&points).unwrap();
        let layout = Layout::Image { first: 0, width: side, height: side };
        let (each, some) = (
            inside(&session, &points, &estimates, Layout::Scattered),
            inside(&session, &points, &estimates, layout),
        );
        let within = each.iter().filter(|inside| **inside).count();
        assert!((1400..1700).contains(&within), "{within} of 1600 texels of a box of 1 x 1");
        let differ = each.iter().zip(&some).filter(|(a, b)| a != b).count();
        assert!(differ < 20, "{differ}");
    }
}

//! Which maps a model gets, and which surfaces read them by which UVs.
//!
//! Surfaces of one material share a map where their UVs let them: each triangle within one tile, as textures that repeat are read, and none over
//! another. Where they do not - copies of
//! one mesh, parts that were all laid out over the whole square - each gets a map of its own. Surfaces that no UV set of theirs suits
//! are laid out together anew, or told with the reason.

use crate::{MapExtent, NewUvs, unwrap::unwrapped};
use conray_core::{Geometry, Vec2};
use conray_target::{MapSize, Surface, UvUse};
use rayon::prelude::*;
use std::{
    collections::{BTreeMap, BTreeSet},
    fmt,
};

/// Texels on each side of the raster in which overlaps are sought.
const RASTER: u32 = 1024;
/// Share of the covered area that may be covered twice: less is the rounding of packers.
const MOST_OVERLAP: f64 = 0.01;

/// Surfaces of one material get maps of their own if they are no more than this and new UVs can be had; else they are laid out together.
const MOST_OWN: usize = 4;

/// A map, and what reads it.
#[derive(Clone, Debug, PartialEq)]
pub struct Sheet {
    /// Name of the material, made unique; "material 3" where it has none.
    pub name: String,
    /// The scene's material.
    pub material: u32,
    /// How its surfaces read it.
    pub uvs: Uvs,
    /// The scene's instances that it is baked for.
    pub instances: Vec<u32>,
    /// Instances that read it as well, each as the one of that place in `instances` does, whose mesh it shows.
    pub copies: Vec<(u32, usize)>,
    /// Size of the map.
    pub size: MapSize,
    /// True where triangles stand whole tiles away from the unit square: the map is to be repeated.
    pub repeats: bool,
}

/// By which UVs the surfaces of a map read it.
#[derive(Clone, Debug, PartialEq)]
pub enum Uvs {
    /// A set that they have, by its number.
    Set(usize),
    /// New ones, for each instance, to be written as the set of that number.
    New {
        /// The next free number of all of them.
        set: usize,
        /// In the order of the instances.
        of: Vec<NewUvs>,
    },
}

impl Sheet {
    /// All instances that read the map, each with the place in `instances` whose UVs it has.
    pub fn readers(&self) -> impl Iterator<Item = (u32, usize)> {
        let own = self.instances.iter().enumerate().map(|(k, &instance)| (instance, k));
        own.chain(self.copies.iter().copied())
    }
}

impl Uvs {
    /// The number of the set.
    pub fn set(&self) -> usize {
        match self {
            Self::Set(set) | Self::New { set, .. } => *set,
        }
    }
}

/// Why a UV set cannot be used.
#[derive(Clone, Debug, PartialEq)]
pub enum UvFault {
    /// There is none.
    None,
    /// A triangle reaches over several tiles of its texture.
    Outside {
        /// Which.
        triangle: usize,
    },
    /// Triangles lie over each other.
    Overlap {
        /// Share of the covered area.
        share: f64,
    },
    /// All triangles are points or lines.
    NoArea,
    /// New ones could not be made.
    Unwrap {
        /// Why.
        reason: String,
    },
}

impl fmt::Display for UvFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::None => f.write_str("it has no UVs"),
            Self::Outside { triangle } => {
                write!(f, "triangle {triangle} reaches over several tiles of its texture")
            }
            Self::Overlap { share } => write!(f, "{:.1} % of its UVs lie over each other", 100.0 * share),
            Self::NoArea => f.write_str("its UVs cover nothing"),
            Self::Unwrap { reason } => write!(f, "it cannot be unwrapped: {reason}"),
        }
    }
}

/// An instance that no UV set suits.
#[derive(Clone, Debug, PartialEq)]
pub struct Unmapped {
    /// The scene's instance.
    pub instance: u32,
    /// What is wrong with its first UV set.
    pub fault: UvFault,
}

/// The maps of a model.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sheets {
    /// In the order of the materials, then of the instances.
    pub sheets: Vec<Sheet>,
    /// What got none.
    pub unmapped: Vec<Unmapped>,
}

/// What is done about surfaces that no UV set suits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unwrap {
    /// They get new UVs.
    Yes,
    /// They get no map.
    No,
}

impl Sheets {
    /// Finds maps for instances of a scene, by the UV sets that they have, or by new ones: then rows that are not needed are left out.
    pub fn of(geometry: &Geometry, instances: &[u32], extent: MapExtent, unwrap: Unwrap) -> Self {
        let mut groups: Vec<(u32, Vec<u32>)> = Vec::new();
        for &instance in instances {
            let material = geometry.mesh_of(instance as usize).material;
            match groups.iter_mut().find(|(known, _)| *known == material) {
                Some((_, group)) => group.push(instance),
                None => groups.push((material, vec![instance])),
            }
        }
        groups.sort_by_key(|(material, _)| *material);
        let mut found = Self::default();
        for (material, group) in groups {
            found.add(geometry, material, group, extent, unwrap);
        }
        found
    }

    /// The same where instances that show one mesh of one material share what is baked for the first of them.
    pub fn shared(geometry: &Geometry, instances: &[u32], extent: MapExtent, unwrap: Unwrap) -> Self {
        let mut first: BTreeMap<u32, u32> = BTreeMap::new();
        let of = |instance: u32| geometry.instances()[instance as usize].mesh;
        for &instance in instances {
            first.entry(of(instance)).or_insert(instance);
        }
        let (firsts, copies): (Vec<u32>, Vec<u32>) =
            instances.iter().partition(|&&instance| first[&of(instance)] == instance);
        let mut found = Self::of(geometry, &firsts, extent, unwrap);
        for sheet in &mut found.sheets {
            let place = |copy: u32| {
                Some((copy, sheet.instances.iter().position(|&instance| instance == first[&of(copy)])?))
            };
            sheet.copies = copies.iter().filter_map(|&copy| place(copy)).collect();
        }
        found
    }

    fn add(
        &mut self,
        geometry: &Geometry,
        material: u32,
        group: Vec<u32>,
        extent: MapExtent,
        unwrap: Unwrap,
    ) {
        let known = geometry.materials().get(material as usize).map(|material| material.name.clone());
        let name = known.filter(|name| !name.is_empty()).unwrap_or_else(|| format!("material {material}"));
        let sheet = |name, uv_set, instances: Vec<u32>| {
            let away = |&instance: &u32| tiles(geometry, instance, uv_set).any(|tile| tile != Vec2::ZERO);
            let repeats = instances.iter().any(away);
            let uvs: Vec<(u32, Vec<[Vec2; 3]>)> = instances
                .iter()
                .map(|&instance| (instance, corner_uvs(geometry, instance, uv_set)))
                .collect();
            let size = extent.by(geometry, &uvs);
            Sheet { name, material, uvs: Uvs::Set(uv_set), instances, copies: Vec::new(), size, repeats }
        };
        if let Ok(uv_set) = usable(geometry, &group) {
            self.sheets.push(sheet(name, uv_set, group));
            return;
        }
        let each: Vec<Result<usize, UvFault>> =
            group.par_iter().map(|&instance| usable(geometry, &[instance])).collect();
        let mut lacking: Vec<(u32, UvFault)> = Vec::new();
        let own = each.iter().filter(|found| found.is_ok()).count();
        let too_many = unwrap == Unwrap::Yes && own > MOST_OWN;
        for (&instance, found) in group.iter().zip(each) {
            match found {
                // What is wrong with it is that others lie over it.
                Ok(_) if too_many => lacking.push((instance, UvFault::Overlap { share: 1.0 })),
                Ok(uv_set) => self.sheets.push(sheet(format!("{name}-{instance}"), uv_set, vec![instance])),
                Err(fault) => lacking.push((instance, fault)),
            }
        }
        let unmapped =
            |(instance, fault): &(u32, UvFault)| Unmapped { instance: *instance, fault: fault.clone() };
        if unwrap == Unwrap::No || lacking.is_empty() {
            self.unmapped.extend(lacking.iter().map(unmapped));
            return;
        }
        // Numbers of sets follow each other, so only surfaces with as many sets can read the same new one.
        let sets = |instance: u32| geometry.mesh_of(instance as usize).uv_sets().len();
        let counts: BTreeSet<usize> = lacking.iter().map(|(instance, _)| sets(*instance)).collect();
        for &set in &counts {
            let alike: Vec<u32> = lacking
                .iter()
                .map(|(instance, _)| *instance)
                .filter(|&instance| sets(instance) == set)
                .collect();
            let name = if counts.len() > 1 { format!("{name}-uv{set}") } else { name.clone() };
            match unwrapped(geometry, &alike, extent) {
                Ok((size, of)) => {
                    let uvs = Uvs::New { set, of };
                    let (instances, copies) = (alike, Vec::new());
                    self.sheets.push(Sheet { name, material, uvs, instances, copies, size, repeats: false });
                }
                Err(reason) => {
                    let fault = UvFault::Unwrap { reason };
                    let of = |instance| Unmapped { instance, fault: fault.clone() };
                    self.unmapped.extend(alike.into_iter().map(of));
                }
            }
        }
    }

    /// The surfaces that read the maps, by instances, in the order of the maps. `v_up` where the first row of an image is at v = 1, as in OBJ files.
    pub fn surfaces(&self, geometry: &Geometry, v_up: bool) -> Vec<(u32, Surface)> {
        let of_sheet = |(map, sheet): (usize, &Sheet)| {
            let surface = |(k, &instance): (usize, &u32)| {
                let mut uvs = match &sheet.uvs {
                    Uvs::Set(set) => corner_uvs(geometry, instance, *set),
                    Uvs::New { of, .. } => of[k].corners(),
                };
                if v_up && matches!(sheet.uvs, Uvs::Set(_)) {
                    uvs.iter_mut().flatten().for_each(|uv| uv.y = 1.0 - uv.y);
                }
                (instance, Surface { map, uvs })
            };
            sheet.instances.iter().enumerate().map(surface).collect::<Vec<_>>()
        };
        self.sheets.iter().enumerate().flat_map(of_sheet).collect()
    }
}

/// The tile in which the middle of each triangle lies.
fn tiles(geometry: &Geometry, instance: u32, uv_set: usize) -> impl Iterator<Item = Vec2> {
    let mesh = geometry.mesh_of(instance as usize);
    (0..mesh.triangles().len()).map(move |triangle| {
        let [a, b, c] = mesh.corner_uvs(triangle, uv_set);
        ((a + b + c) / 3.0).floor()
    })
}

/// UVs of the triangles' corners, each triangle moved by whole tiles into the unit square.
fn corner_uvs(geometry: &Geometry, instance: u32, uv_set: usize) -> Vec<[Vec2; 3]> {
    let mesh = geometry.mesh_of(instance as usize);
    let moved = |(triangle, tile): (usize, Vec2)| mesh.corner_uvs(triangle, uv_set).map(|uv| uv - tile);
    tiles(geometry, instance, uv_set).enumerate().map(moved).collect()
}

/// The first UV set by which these instances can read one map; else what is wrong with the first.
fn usable(geometry: &Geometry, instances: &[u32]) -> Result<usize, UvFault> {
    let sets = |&instance: &u32| geometry.mesh_of(instance as usize).uv_sets().len();
    let mut first = Err(UvFault::None);
    for uv_set in 0..instances.iter().map(sets).min().unwrap_or(0) {
        let uvs: Vec<[Vec2; 3]> =
            instances.iter().flat_map(|&instance| corner_uvs(geometry, instance, uv_set)).collect();
        match judged(&UvUse::of(&uvs, RASTER)) {
            Ok(()) => return Ok(uv_set),
            Err(fault) if uv_set == 0 => first = Err(fault),
            Err(_) => {}
        }
    }
    first
}

fn judged(found: &UvUse) -> Result<(), UvFault> {
    match found.outside {
        Some(triangle) => Err(UvFault::Outside { triangle }),
        None if found.area <= 0.0 => Err(UvFault::NoArea),
        None if found.overlap > MOST_OVERLAP * found.area => {
            Err(UvFault::Overlap { share: found.overlap / found.area })
        }
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use conray_core::{Affine3A, Material, TriangleMesh, Vec3};

    /// A triangle with a UV set for each corner list.
    fn mesh(sets: &[[[f32; 2]; 3]], material: u32) -> TriangleMesh {
        let mesh = TriangleMesh::new(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]]).unwrap();
        let set = |set: &[[f32; 2]; 3]| set.map(Vec2::from_array).to_vec();
        sets.iter().fold(mesh, |mesh, uvs| mesh.with_uv_set(set(uvs)).unwrap()).with_material(material)
    }

    const LEFT: [[f32; 2]; 3] = [[0.0, 0.0], [0.5, 0.0], [0.0, 1.0]];
    const RIGHT: [[f32; 2]; 3] = [[0.9, 0.0], [0.9, 0.5], [0.6, 0.1]];
    const OUTSIDE: [[f32; 2]; 3] = [[0.0, 0.0], [2.0, 0.0], [0.0, 1.0]];
    const LINE: [[f32; 2]; 3] = [[0.0, 0.0], [0.5, 0.5], [1.0, 1.0]];
    const SIZE: MapSize = MapSize { width: 64, height: 32 };
    const EXTENT: MapExtent = MapExtent::Size(SIZE);

    fn geometry(meshes: &[(&[[[f32; 2]; 3]], u32)], copies: usize) -> (Geometry, Vec<u32>) {
        let mut geometry = Geometry::default();
        for name in ["wood", ""] {
            geometry.add_material(Material { name: name.into(), ..Material::default() });
        }
        let mut instances = Vec::new();
        for (sets, material) in meshes {
            let mesh = geometry.add_mesh(mesh(sets, *material)).unwrap();
            for _ in 0..copies {
                instances.push(geometry.add_instance(mesh, Affine3A::IDENTITY).unwrap());
            }
        }
        (geometry, instances)
    }

    fn names(sheets: &Sheets) -> Vec<(&str, usize, &[u32])> {
        sheets.sheets.iter().map(|sheet| (&sheet.name[..], sheet.uvs.set(), &sheet.instances[..])).collect()
    }

    #[test]
    fn surfaces_of_a_material_share_a_map_where_their_uvs_let_them() {
        let (geometry, instances) = geometry(&[(&[LEFT], 1), (&[RIGHT], 0), (&[LEFT], 0)], 1);
        let found = Sheets::of(&geometry, &instances, EXTENT, Unwrap::No);
        assert_eq!(names(&found), [("wood", 0, &[1, 2][..]), ("material 1", 0, &[0])]);
        assert!(found.unmapped.is_empty());
        let surfaces = found.surfaces(&geometry, true);
        assert_eq!(
            surfaces.iter().map(|(instance, s)| (*instance, s.map)).collect::<Vec<_>>(),
            [(1, 0), (2, 0), (0, 1)]
        );
        assert_eq!(surfaces[1].1.uvs[0][2], Vec2::new(0.0, 0.0), "rows from the top");
    }

    #[test]
    fn copies_get_maps_of_their_own() {
        let (geometry, instances) = geometry(&[(&[LEFT], 0)], 2);
        let found = Sheets::of(&geometry, &instances, EXTENT, Unwrap::No);
        assert_eq!(names(&found), [("wood-0", 0, &[0][..]), ("wood-1", 0, &[1])]);
        assert_eq!(found.sheets[0].size, SIZE);
    }

    #[test]
    fn many_surfaces_that_do_not_fit_together_are_laid_out_in_one_map() {
        let size = MapExtent::Size(MapSize { width: 64, height: 64 });
        let (geometry, instances) = geometry(&[(&[LEFT], 0)], MOST_OWN + 1);
        let found = Sheets::of(&geometry, &instances, size, Unwrap::Yes);
        assert_eq!(names(&found), [("wood", 1, &[0, 1, 2, 3, 4][..])]);
        assert_eq!(Sheets::of(&geometry, &instances, size, Unwrap::No).sheets.len(), 5);
        assert_eq!(Sheets::of(&geometry, &instances[1..], size, Unwrap::Yes).sheets.len(), 4);
    }

    #[test]
    fn copies_share_a_map_where_that_is_wanted() {
        let (geometry, instances) = geometry(&[(&[LEFT], 0), (&[RIGHT], 0)], 2);
        let found = Sheets::shared(&geometry, &instances, EXTENT, Unwrap::No);
        assert_eq!(names(&found), [("wood", 0, &[0, 2][..])]);
        assert_eq!(found.sheets[0].readers().collect::<Vec<_>>(), [(0, 0), (2, 1), (1, 0), (3, 1)]);
    }

    #[test]
    fn the_first_uv_set_that_suits_is_taken() {
        let (geometry, instances) = geometry(&[(&[OUTSIDE, LEFT], 0), (&[LEFT, RIGHT], 0)], 1);
        assert_eq!(names(&Sheets::of(&geometry, &instances, EXTENT, Unwrap::No)), [("wood", 1, &[0, 1][..])]);
    }

    #[test]
    fn triangles_a_whole_tile_away_are_read_from_a_map_that_repeats() {
        let away = LEFT.map(|[u, v]| [u + 3.0, v - 1.0]);
        let (geometry, instances) = geometry(&[(&[away], 0), (&[RIGHT], 0)], 1);
        let found = Sheets::of(&geometry, &instances, EXTENT, Unwrap::No);
        assert_eq!(names(&found), [("wood", 0, &[0, 1][..])]);
        assert!(found.sheets[0].repeats);
        assert_eq!(found.surfaces(&geometry, false)[0].1.uvs[0], LEFT.map(Vec2::from_array));
    }

    #[test]
    fn what_suits_nothing_is_laid_out_anew_where_that_is_wanted() {
        let (geometry, instances) = geometry(&[(&[OUTSIDE], 0), (&[LINE], 0), (&[], 0), (&[LEFT], 1)], 1);
        let size = MapExtent::Size(MapSize { width: 64, height: 64 });
        let found = Sheets::of(&geometry, &instances, size, Unwrap::Yes);
        assert!(found.unmapped.is_empty());
        let expected = [("wood-uv0", 0, &[2][..]), ("wood-uv1", 1, &[0, 1]), ("material 1", 0, &[3])];
        assert_eq!(names(&found), expected);
        let Uvs::New { of, .. } = &found.sheets[1].uvs else { panic!("new ones") };
        let all: Vec<[Vec2; 3]> = of.iter().flat_map(NewUvs::corners).collect();
        assert_eq!(judged(&UvUse::of(&all, RASTER)), Ok(()));
        assert_eq!(found.surfaces(&geometry, false)[1].1.uvs, of[0].corners());
    }

    #[test]
    fn what_suits_nothing_is_told() {
        let cases: [(&[[[f32; 2]; 3]], &str); 4] = [
            (&[], "it has no UVs"),
            (&[OUTSIDE], "triangle 0 reaches over several tiles of its texture"),
            (&[LINE], "its UVs cover nothing"),
            (&[LINE, OUTSIDE], "its UVs cover nothing"),
        ];
        for (sets, expected) in cases {
            let (geometry, instances) = geometry(&[(sets, 0)], 1);
            let found = Sheets::of(&geometry, &instances, EXTENT, Unwrap::No);
            assert!(found.sheets.is_empty());
            assert_eq!(found.unmapped[0].fault.to_string(), expected);
        }
        assert_eq!(UvFault::Overlap { share: 0.5 }.to_string(), "50.0 % of its UVs lie over each other");
    }
}

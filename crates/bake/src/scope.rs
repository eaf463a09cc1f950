//! Who occludes and who receives: by patterns over names, by objects, with a ground.

use conray_core::{Affine3A, Backs, Bounds, Geometry, GeometryError, Material, TriangleMesh, Vec3};
use conray_scene::Scene;
use std::collections::BTreeMap;
use thiserror::Error;
use wildmatch::WildMatch;

/// The ground lies below the lowest point by this share of the scene's diagonal: what stands on it sees it from above.
const BELOW: f32 = 1e-5;
/// An unlimited ground reaches so many diagonals.
const FAR: f32 = 100.0;

/// Which surfaces of a scene take part, and how.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scope {
    /// Patterns of names of what occludes; none is all. `*` stands for any characters, `?` for one.
    pub occluders: Vec<String>,
    /// Patterns of names of what is baked; none is all.
    pub receivers: Vec<String>,
    /// Each object is occluded by itself alone: a node of a glTF, an object of other files.
    pub self_only: bool,
    /// A ground that occludes and is not baked.
    pub ground: Option<Ground>,
    /// What the backs of surfaces do to rays.
    pub backs: Backs,
}

/// Where the ground is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ground {
    /// Under the lowest point of what takes part.
    Lowest,
    /// At that height, y in world units.
    At(f32),
}

/// Why a scope cannot be had.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ScopeError {
    /// A pattern that nothing matches.
    #[error("--{option} {pattern}: no node, mesh or material has such a name; there are {names}")]
    NoMatch {
        /// The option.
        option: &'static str,
        /// The pattern.
        pattern: String,
        /// Some of the names that there are.
        names: String,
    },
    /// The ground cannot be added.
    #[error("--ground: {0}")]
    Ground(GeometryError),
}

/// What a scope comes to for a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Chosen {
    /// Instances that are baked.
    pub receivers: Vec<u32>,
    /// With [`Scope::self_only`] the instances of each object that has receivers; else none.
    pub objects: Vec<Vec<u32>>,
}

impl Scope {
    /// Chooses receivers and changes the scene's geometry: what does not occlude is hidden, the ground is added. `distance` is the AO distance: the ground
    /// reaches as far about the scene.
    ///
    /// # Errors
    /// A pattern that nothing matches.
    pub fn apply(&self, scene: &mut Scene, distance: f32) -> Result<Chosen, ScopeError> {
        let geometry = &scene.geometry;
        let occludes = matching(geometry, "occluders", &self.occluders)?;
        let receives = matching(geometry, "receivers", &self.receivers)?;
        let receivers: Vec<u32> = (0..receives.len() as u32).filter(|&k| receives[k as usize]).collect();
        let mut objects = Vec::new();
        if self.self_only {
            let mut of: BTreeMap<String, Vec<u32>> = BTreeMap::new();
            for k in 0..receives.len() {
                let object = match scene.origins.get(k) {
                    Some(origin) => format!("{:08} {:08}", origin.node, origin.copy),
                    None => geometry.instances()[k].name.clone(),
                };
                of.entry(object).or_default().push(k as u32);
            }
            objects.extend(of.into_values().filter(|of| of.iter().any(|&k| receives[k as usize])));
        }
        let bounds = taking_part(geometry, |k| occludes[k] || receives[k]);
        scene.geometry.hide(|k| !occludes[k]);
        scene.geometry.set_backs(self.backs);
        if let Some(ground) = self.ground {
            let added =
                add_ground(&mut scene.geometry, bounds, ground, distance).map_err(ScopeError::Ground)?;
            objects.iter_mut().for_each(|object| object.push(added));
        }
        Ok(Chosen { receivers, objects })
    }
}

/// Bounds of the instances that take part.
fn taking_part(geometry: &Geometry, takes_part: impl Fn(usize) -> bool) -> Bounds {
    let instances: Vec<u32> =
        (0..geometry.instances().len()).filter(|&k| takes_part(k)).map(|k| k as u32).collect();
    geometry.only(&instances).bounds()
}

/// Which instances have a name that one of some patterns matches: their own, that of their mesh, or that of its material. No pattern matches all.
fn matching(geometry: &Geometry, option: &'static str, patterns: &[String]) -> Result<Vec<bool>, ScopeError> {
    let names = |k: usize| {
        let mesh = geometry.mesh_of(k);
        let material = geometry.materials().get(mesh.material as usize);
        let material = material.map_or("", |material| &material.name[..]);
        [&geometry.instances()[k].name[..], &mesh.name[..], material]
    };
    let count = geometry.instances().len();
    let mut found = vec![patterns.is_empty(); count];
    for pattern in patterns {
        let matcher = WildMatch::new(pattern);
        let matched: Vec<usize> =
            (0..count).filter(|&k| names(k).iter().any(|name| matcher.matches(name))).collect();
        if matched.is_empty() {
            let mut all: Vec<&str> = (0..count).flat_map(names).filter(|name| !name.is_empty()).collect();
            all.sort_unstable();
            all.dedup();
            return Err(ScopeError::NoMatch { option, pattern: pattern.clone(), names: listed(&all) });
        }
        matched.into_iter().for_each(|k| found[k] = true);
    }
    Ok(found)
}

/// Some names, and how many more there are.
fn listed(names: &[&str]) -> String {
    const MOST: usize = 8;
    let shown = names.iter().take(MOST).copied().collect::<Vec<_>>().join(", ");
    match names.len() {
        0 => "none at all".into(),
        count if count > MOST => format!("{shown} and {} more", count - MOST),
        _ => shown,
    }
}

fn add_ground(
    geometry: &mut Geometry,
    bounds: Bounds,
    ground: Ground,
    distance: f32,
) -> Result<u32, GeometryError> {
    let y = match ground {
        Ground::Lowest => bounds.min.y - BELOW * bounds.diagonal(),
        Ground::At(y) => y,
    };
    let reach = distance.min(FAR * bounds.diagonal());
    let (low, high) = (bounds.min - reach, bounds.max + reach);
    let corners = [(low.x, low.z), (low.x, high.z), (high.x, high.z), (high.x, low.z)];
    let corners = corners.map(|(x, z)| Vec3::new(x, y, z)).to_vec();
    let material = geometry.add_material(Material { name: "ground".into(), ..Material::default() });
    let mesh = TriangleMesh::new(corners, vec![[0, 1, 2], [0, 2, 3]])?.with_material(material);
    let mesh = geometry.add_mesh(mesh)?;
    geometry.add_named_instance(mesh, Affine3A::IDENTITY, "ground".into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use conray_core::Opacity;

    /// Instances `wheel 1`, `wheel 2` of one mesh `tyre`, and `body`, of materials `rubber` and `paint`.
    fn scene() -> Scene {
        let mut scene = Scene::default();
        for name in ["rubber", "paint"] {
            scene.geometry.add_material(Material { name: name.into(), ..Material::default() });
        }
        let mesh = |name: &str, material| {
            let corners = vec![Vec3::ZERO, Vec3::X, Vec3::new(0.0, 1.0, 1.0)];
            TriangleMesh::new(corners, vec![[0, 1, 2]]).unwrap().with_name(name).with_material(material)
        };
        let tyre = scene.geometry.add_mesh(mesh("tyre", 0)).unwrap();
        let body = scene.geometry.add_mesh(mesh("hull", 1)).unwrap();
        for (mesh, name) in [(tyre, "wheel 1"), (tyre, "wheel 2"), (body, "body")] {
            scene.geometry.add_named_instance(mesh, Affine3A::IDENTITY, name.into()).unwrap();
        }
        scene
    }

    fn patterns(all: &[&str]) -> Vec<String> {
        all.iter().map(ToString::to_string).collect()
    }

    /// Which instances occlude.
    fn blocks(geometry: &Geometry) -> Vec<bool> {
        let of = |k: usize| {
            let mesh = geometry.instances()[k].mesh as usize;
            !matches!(geometry.opacity(mesh), Opacity::Constant(opacity) if *opacity == 0.0)
        };
        (0..geometry.instances().len()).map(of).collect()
    }

    #[test]
    fn names_of_nodes_meshes_and_materials_say_who_takes_part() {
        let cases: [(&[&str], &[u32]); 6] = [
            (&[], &[0, 1, 2]),
            (&["wheel*"], &[0, 1]),
            (&["tyre"], &[0, 1]),
            (&["p?int"], &[2]),
            (&["wheel 2", "body"], &[1, 2]),
            (&["*"], &[0, 1, 2]),
        ];
        for (names, expected) in cases {
            let mut found = scene();
            let scope = Scope { receivers: patterns(names), ..Scope::default() };
            assert_eq!(scope.apply(&mut found, 1.0).unwrap().receivers, expected, "{names:?}");
            assert_eq!(blocks(&found.geometry), [true; 3]);
            let scope = Scope { occluders: patterns(names), ..Scope::default() };
            assert_eq!(scope.apply(&mut found, 1.0).unwrap().receivers, [0, 1, 2]);
            let blocking = blocks(&found.geometry);
            assert!((0..3u32).all(|k| blocking[k as usize] == expected.contains(&k)), "{names:?}");
        }
    }

    #[test]
    fn a_pattern_that_matches_nothing_is_told_with_the_names_there_are() {
        let scope = Scope { occluders: patterns(&["wheel*", "Door"]), ..Scope::default() };
        let found = scope.apply(&mut scene(), 1.0).unwrap_err().to_string();
        assert_eq!(
            found,
            "--occluders Door: no node, mesh or material has such a name; there are body, hull, paint, rubber, tyre, wheel 1, wheel 2"
        );
    }

    #[test]
    fn objects_stand_alone_with_the_ground() {
        let scope = Scope {
            self_only: true,
            receivers: patterns(&["wheel*"]),
            ground: Some(Ground::Lowest),
            ..Scope::default()
        };
        let mut found = scene();
        let chosen = scope.apply(&mut found, 0.5).unwrap();
        assert_eq!((chosen.receivers, chosen.objects), (vec![0, 1], vec![vec![0, 3], vec![1, 3]]));
        let ground = found.geometry.only(&[3]).bounds();
        assert!(ground.max.y < 0.0 && ground.max.y > -1e-4);
        assert_eq!((ground.min.x, ground.max.z), (-0.5, 1.5));
        // Its front is above.
        let [a, b, c] = found.geometry.mesh_of(3).corners(0);
        assert!((b - a).cross(c - a).y > 0.0);
    }
}

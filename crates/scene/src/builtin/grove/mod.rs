//! A grove on rolling ground with a path through it: few meshes, many instances.
//!
//! Trees, bushes, grass and stones are stored once per prototype and placed by turn and uniform scale; leaves are masked
//! cards. Flattened it would have more than 20 million triangles, stored it has some hundred thousand.

mod growth;
mod scatter;
mod species;
mod terrain;
mod tree;
mod undergrowth;

use super::assembly::Assembly;
use super::masks;
use super::random::Random;
use crate::Scene;
use conray_core::{Affine3A, Vec3};
use scatter::{Rule, scatter};
use terrain::{height, path_x};

/// A prototype: its meshes, which are always placed together.
struct Prototype {
    name: String,
    meshes: Vec<u32>,
}

/// Scene `grove`.
pub(crate) fn grove() -> Scene {
    let mut assembly = Assembly::new("grove");
    let ground = assembly.opaque("ground");
    assembly.add("ground", terrain::mesh(), ground);

    let mut random = Random::new(77);
    for (prototypes, rule) in [
        (trees(&mut assembly), Rule::TREES),
        (bushes(&mut assembly), Rule::BUSHES),
        (ferns(&mut assembly), Rule::FERNS),
        (stones(&mut assembly), Rule::STONES),
        (grass(&mut assembly), Rule::GRASS),
    ] {
        place(&mut assembly, &prototypes, &rule, &mut random);
    }

    let on_path = |z: f32, above: f32| [path_x(z), height(path_x(z), z) + above, z];
    assembly.view("path", on_path(16.0, 1.7), on_path(2.0, 2.6), 58.0);
    assembly.view("above", [18.0, 15.0, 46.0], [-4.0, 4.0, 10.0], 50.0);
    assembly.finish()
}

/// Places prototypes by turns at the places that a rule finds.
fn place(assembly: &mut Assembly, prototypes: &[Prototype], rule: &Rule, random: &mut Random) {
    for (i, place) in scatter(rule, random).into_iter().enumerate() {
        let prototype = &prototypes[random.index(prototypes.len())];
        let world_from_mesh = Affine3A::from_translation(place.position)
            * Affine3A::from_rotation_y(place.turn_rad)
            * Affine3A::from_scale(Vec3::splat(place.scale));
        for &mesh in &prototype.meshes {
            assembly.place(mesh, world_from_mesh, format!("{} {i}", prototype.name));
        }
    }
}

fn trees(assembly: &mut Assembly) -> Vec<Prototype> {
    let bark = assembly.opaque("bark");
    let leaves = assembly.masked("leaves", masks::leafy_twig());
    let needles = assembly.masked("needles", masks::needles());
    let species = species::Species::all().into_iter();
    species
        .enumerate()
        .map(|(i, species)| {
            let tree = tree::tree(&species, 100 + i as u32);
            let foliage = if species.is_conifer { needles } else { leaves };
            let wood = assembly.store(&format!("{} wood", species.name), tree.wood, bark);
            let crown = assembly.store(&format!("{} leaves", species.name), tree.leaves, foliage);
            Prototype { name: species.name.into(), meshes: vec![wood, crown] }
        })
        .collect()
}

fn bushes(assembly: &mut Assembly) -> Vec<Prototype> {
    let twigs = assembly.opaque("twigs");
    let leaves = assembly.masked("bush leaves", masks::leafy_twig());
    (0..2)
        .map(|i| {
            let bush = undergrowth::bush(200 + i);
            let name = format!("bush {i}");
            let wood = assembly.store(&format!("{name} twigs"), bush.wood, twigs);
            let crown = assembly.store(&format!("{name} leaves"), bush.leaves, leaves);
            Prototype { name, meshes: vec![wood, crown] }
        })
        .collect()
}

fn ferns(assembly: &mut Assembly) -> Vec<Prototype> {
    let material = assembly.masked("fern leaves", masks::fern_frond());
    let mut one = |i: u32| {
        let name = format!("fern {i}");
        let mesh = assembly.store(&name, undergrowth::fern(300 + i), material);
        Prototype { name, meshes: vec![mesh] }
    };
    (0..2).map(&mut one).collect()
}

fn stones(assembly: &mut Assembly) -> Vec<Prototype> {
    let material = assembly.opaque("stone");
    let mut one = |i: u32| {
        let name = format!("stone {i}");
        let mesh = assembly.store(&name, undergrowth::stone(400 + i), material);
        Prototype { name, meshes: vec![mesh] }
    };
    (0..3).map(&mut one).collect()
}

fn grass(assembly: &mut Assembly) -> Vec<Prototype> {
    let material = assembly.masked("grass", masks::grass());
    let mut one = |i: u32| {
        let name = format!("grass {i}");
        let mesh = assembly.store(&name, undergrowth::grass(500 + i), material);
        Prototype { name, meshes: vec![mesh] }
    };
    (0..3).map(&mut one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_grove_is_huge_flattened_and_small_stored() {
        let scene = grove();
        let (flattened, stored) = (scene.geometry.triangle_count(), scene.geometry.stored_triangle_count());
        assert!(flattened >= 20_000_000, "{flattened} triangles");
        assert!((100_000..1_000_000).contains(&stored), "{stored} triangles stored");
        let names: Vec<&str> = scene.views.iter().map(|v| v.name.as_str()).collect();
        assert_eq!(names, ["path", "above"]);
        assert!(scene.views.iter().all(|v| v.eye.y > height(v.eye.x, v.eye.z) + 1.0));
    }
}

//! Bent directions in the tangent space of what reads the maps.

use crate::{Places, frames::Frames};
use conray::Session;
use conray_core::Vec3;
use conray_target::{AtlasMap, AtlasTarget};
use rayon::prelude::*;

/// In which space bent directions are told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BentSpace {
    /// The world's.
    #[default]
    World,
    /// That of the surface: along u, up in the picture, along the normal of the vertices. The tangents are those that the file has, where the map is read by the first UV set; else
    /// those of the map's UVs, by MikkTSpace.
    Tangent,
}

/// Where the texels of maps lie on surfaces.
pub(crate) struct TexelPlaces {
    of_map: Vec<Vec<Option<Place>>>,
}

#[derive(Clone, Copy)]
struct Place {
    surface: u32,
    triangle: u32,
    weights: [f32; 2],
}

impl TexelPlaces {
    /// Those of no texel.
    pub(crate) fn new(maps: &[AtlasMap]) -> Self {
        Self { of_map: maps.iter().map(|map| vec![None; map.visibility.len()]).collect() }
    }

    /// Bytes for each texel.
    pub(crate) const BYTES: u64 = size_of::<Option<Place>>() as u64;

    /// Takes note of the texels of a portion: of several points of one texel the first counts.
    pub(crate) fn note(&mut self, target: &AtlasTarget) {
        for (((map, at), surface), (triangle, weights)) in
            target.texels().zip(target.surfaces()).zip(target.places())
        {
            let place = Place { surface: *surface, triangle: *triangle, weights: *weights };
            self.of_map[map as usize][at as usize].get_or_insert(place);
        }
    }

    /// Turns the directions of maps from the world into tangent space; those of texels that no surface reads are left.
    pub(crate) fn turn(&self, session: &Session, places: &Places, maps: &mut [AtlasMap]) {
        let geometry = session.geometry();
        let frames = |(surface, &instance): (usize, &u32)| {
            let mesh = geometry.mesh_of(instance as usize);
            let given = if places.reads_first_set[surface] { Frames::given(mesh) } else { None };
            given.unwrap_or_else(|| Frames::of(mesh, places.atlas.surfaces[surface].uvs.clone()))
        };
        let frames: Vec<Frames> = places.instances.par_iter().enumerate().map(frames).collect();
        for (map, places_of) in maps.iter_mut().zip(&self.of_map) {
            let turned = |(bent, place): (&mut Vec3, &Option<Place>)| {
                let Some(Place { surface, triangle, weights }) = *place else { return };
                let instance = places.instances[surface as usize];
                let normal = session.bvh().front_point(instance, triangle, weights).shading_normal;
                let world_from_mesh = &geometry.instances()[instance as usize].world_from_mesh;
                let basis = frames[surface as usize].basis(triangle, weights, world_from_mesh, normal);
                // Without a tangent any will do: what counts is how far the direction leans.
                let [tangent, bitangent, normal] = basis.unwrap_or_else(|| {
                    let tangent = normal.any_orthonormal_vector();
                    [tangent, normal.cross(tangent), normal]
                });
                *bent = Vec3::new(bent.dot(tangent), bent.dot(bitangent), bent.dot(normal));
            };
            map.bent.par_iter_mut().zip(places_of).with_min_len(4096).for_each(turned);
        }
    }
}

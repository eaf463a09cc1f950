//! Defects of geometry, counted.

use crate::files::{face_normal, position_key, shown};
use crate::{Scene, Warning, WarningKind};
use conray_core::{Affine3A, TriangleMesh};
use rayon::prelude::*;
use std::hash::{DefaultHasher, Hash, Hasher};

impl Scene {
    /// Counts triangles of zero area, exact duplicates, triangles wound against their vertex normals, and vertices
    /// that no triangle uses. Costs about as much as a sort of the triangles.
    ///
    /// Duplicates have the same three corner positions in any order, bit for bit. They are sought among all meshes
    /// that stand untransformed in the world, as in OBJ files, and else within each mesh. A file loader has run this
    /// already, and its [`warnings`](Scene::warnings) hold the result.
    pub fn inspect(&self) -> Vec<Warning> {
        let meshes = self.geometry.meshes();
        let first = |kind, found: Option<(usize, usize)>, count: u64| {
            let (mesh, index) = found?;
            let what = if kind == WarningKind::UnusedVertices { "vertex" } else { "triangle" };
            let of = if meshes[mesh].name.is_empty() {
                format!("mesh {mesh}")
            } else {
                shown(meshes[mesh].name.as_bytes())
            };
            Some(Warning { kind, count, example: format!("{what} {index} of {of}") })
        };
        let tallies: Vec<Tally> = meshes.par_iter().map(Tally::of).collect();
        let sum = |kind, pick: fn(&Tally) -> Count| {
            let found = tallies.iter().enumerate().find_map(|(m, t)| Some((m, pick(t).first?)));
            first(kind, found, tallies.iter().map(|t| pick(t).count).sum())
        };
        let (duplicates, example) = self.duplicates();
        [
            sum(WarningKind::DegenerateTriangles, |t| t.degenerate),
            first(WarningKind::DuplicateTriangles, example, duplicates),
            sum(WarningKind::FlippedTriangles, |t| t.flipped),
            sum(WarningKind::UnusedVertices, |t| t.unused),
        ]
        .into_iter()
        .flatten()
        .collect()
    }

    /// How many triangles repeat an earlier one, and one of those (mesh, triangle).
    fn duplicates(&self) -> (u64, Option<(usize, usize)>) {
        let meshes = self.geometry.meshes();
        let mut placements = vec![(0u32, false); meshes.len()];
        for instance in self.geometry.instances() {
            let (count, untransformed) = &mut placements[instance.mesh as usize];
            (*count, *untransformed) = (*count + 1, instance.world_from_mesh == Affine3A::IDENTITY);
        }
        let space = |mesh: usize| if placements[mesh] == (1, true) { usize::MAX } else { mesh };
        let keys = |mesh: usize| {
            (0..meshes[mesh].triangles().len())
                .into_par_iter()
                .map(move |t| (key(&meshes[mesh], t, space(mesh)), t))
        };
        let mut all: Vec<u64> =
            (0..meshes.len()).into_par_iter().flat_map(|m| keys(m).map(|(key, _)| key)).collect();
        all.par_sort_unstable();
        let repeats = all.windows(2).filter(|w| w[0] == w[1]).count() as u64;
        let Some(first) = all.windows(2).find(|w| w[0] == w[1]).map(|w| w[0]) else { return (0, None) };
        let mut same = (0..meshes.len()).flat_map(|m| {
            let of_mesh: Vec<usize> = keys(m).filter(|(key, _)| *key == first).map(|(_, t)| t).collect();
            of_mesh.into_iter().map(move |t| (m, t))
        });
        let second = same.nth(1);
        (repeats, second)
    }
}

/// How many, and the first of them.
#[derive(Clone, Copy, Default)]
struct Count {
    count: u64,
    first: Option<usize>,
}

impl Count {
    fn add(&mut self, index: usize) {
        self.count += 1;
        self.first.get_or_insert(index);
    }
}

/// Defects of one mesh.
#[derive(Clone, Copy, Default)]
struct Tally {
    degenerate: Count,
    flipped: Count,
    unused: Count,
}

impl Tally {
    fn of(mesh: &TriangleMesh) -> Self {
        let mut tally = Self::default();
        let mut used = vec![false; mesh.positions().len()];
        for (t, triangle) in mesh.triangles().iter().enumerate() {
            triangle.iter().for_each(|&v| used[v as usize] = true);
            let face = face_normal(mesh.corners(t));
            let vertex_normals = || triangle.iter().map(|&v| mesh.normals()[v as usize]);
            if face.length_squared() == 0.0 {
                tally.degenerate.add(t);
            } else if !mesh.normals().is_empty() && vertex_normals().map(|n| n.dot(face)).sum::<f32>() < 0.0 {
                tally.flipped.add(t);
            }
        }
        used.iter().enumerate().filter(|(_, used)| !**used).for_each(|(v, _)| tally.unused.add(v));
        tally
    }
}

/// 64 bits of a triangle's corner positions in any order; different triangles of one file agree by chance with a
/// probability below one in a thousand even for 100 million of them.
fn key(mesh: &TriangleMesh, triangle: usize, space: usize) -> u64 {
    let mut corners = mesh.corners(triangle).map(position_key);
    corners.sort_unstable();
    let mut hasher = DefaultHasher::new();
    (space, corners).hash(&mut hasher);
    hasher.finish()
}

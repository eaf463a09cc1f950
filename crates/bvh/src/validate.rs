//! Walking all levels and checking what the queries rely on.

use crate::blas::TriangleTree;
use crate::bvh::Bvh;
use crate::lanes::WIDTH;
use crate::placement::world_corner;
use conray_core::{Bounds, Vec3};
use std::collections::BTreeMap;
use thiserror::Error;

/// A broken invariant, in words.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("the hierarchy is broken: {0}")]
pub struct InvalidBvh(String);

impl Bvh {
    /// Walks every tree: boxes lie inside their parents' and around their triangles, every triangle that occludes
    /// is there exactly once, nothing else is, and the stack is deep enough. For tests; takes about as long as building.
    ///
    /// # Errors
    /// The first broken invariant.
    pub fn validate(&self) -> Result<(), InvalidBvh> {
        self.check().map_err(InvalidBvh)
    }

    fn check(&self) -> Result<(), String> {
        let mut found = BTreeMap::<u32, Vec<u32>>::new();
        check_triangles(&self.flat, |id, corners| {
            found.entry(id.instance).or_default().push(id.triangle());
            (self.world_corners(id.instance, id.triangle()) == *corners)
                .then_some(())
                .ok_or(format!("{id:?} lies elsewhere"))
        })?;
        let mut per_tree = Vec::new();
        for tree in &self.trees {
            let mut triangles = Vec::new();
            check_triangles(tree, |id, _| {
                triangles.push(id.triangle());
                Ok(())
            })?;
            per_tree.push(triangles);
        }
        let mut placements = 0;
        self.top.tree.check(|bounds, first, items| {
            for placed in &self.top.placed[first as usize..(first + items) as usize] {
                placements += 1;
                found.entry(placed.instance).or_default().extend(&per_tree[placed.tree as usize]);
                let tree = &self.trees[placed.tree as usize];
                for packet in &tree.packets {
                    for corner in (0..WIDTH).flat_map(|lane| packet.lane(lane)) {
                        check_inside(bounds, world_corner(&placed.world_from_mesh, corner))?;
                    }
                }
            }
            Ok(())
        })?;
        if placements != self.top.placed.len() {
            return Err(format!("{placements} placements are reached of {}", self.top.placed.len()));
        }
        self.check_complete(found)
    }

    /// Exactly the triangles that occlude must have been found.
    fn check_complete(&self, mut found: BTreeMap<u32, Vec<u32>>) -> Result<(), String> {
        for (i, instance) in (0u32..).zip(self.geometry.instances()) {
            let mesh = instance.mesh as usize;
            let mut triangles = found.remove(&i).unwrap_or_default();
            triangles.sort_unstable();
            if triangles.windows(2).any(|w| w[0] == w[1]) {
                return Err(format!("a triangle of instance {i} is there twice"));
            }
            let is_void = match self.geometry.opacity(mesh) {
                conray_core::Opacity::Constant(o) => o.is_nan() || *o <= 0.0,
                conray_core::Opacity::Texture(_) => false,
            };
            if is_void && !triangles.is_empty() {
                return Err(format!("instance {i} occludes nothing, yet is there"));
            }
            for t in 0..self.geometry.meshes()[mesh].triangles().len() as u32 {
                let [a, b, c] = self.world_corners(i, t);
                let expected = !is_void && a != b && b != c && c != a;
                // Placed corners may coincide by rounding only; such a triangle is harmless.
                if expected && triangles.binary_search(&t).is_err() {
                    return Err(format!("triangle {t} of instance {i} is missing"));
                }
            }
        }
        if found.is_empty() { Ok(()) } else { Err(format!("unknown instances: {:?}", found.keys())) }
    }
}

/// Checks a tree and its packets; hands each triangle to `each`.
fn check_triangles(
    tree: &TriangleTree,
    mut each: impl FnMut(crate::packet::TriangleId, &[Vec3; 3]) -> Result<(), String>,
) -> Result<(), String> {
    let mut used = vec![false; tree.packets.len()];
    let mut triangles = 0;
    tree.tree.check(|bounds, first, items| {
        let packet = first as usize;
        if std::mem::replace(used.get_mut(packet).ok_or(format!("packet {packet} does not exist"))?, true) {
            return Err(format!("packet {packet} is in two leaves"));
        }
        for lane in 0..items as usize {
            let corners = tree.packets[packet].lane(lane);
            triangles += 1;
            corners.iter().try_for_each(|&c| check_inside(bounds, c))?;
            each(tree.ids[packet][lane], &corners)?;
        }
        Ok(())
    })?;
    if triangles != tree.triangles || used.contains(&false) {
        return Err(format!("{triangles} triangles are reached of {}", tree.triangles));
    }
    Ok(())
}

fn check_inside(bounds: &Bounds, p: Vec3) -> Result<(), String> {
    if p.cmpge(bounds.min).all() && p.cmple(bounds.max).all() {
        Ok(())
    } else {
        Err(format!("{p} lies outside {bounds:?}"))
    }
}

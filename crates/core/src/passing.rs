//! What rays pass although a file says that it is there: hidden instances, and the backs of surfaces.

use crate::Geometry;
use std::collections::BTreeMap;

impl Geometry {
    /// Makes instances occlude nothing; they stay where they are, and can still be asked about. A mesh that other instances show is stored once more.
    pub fn hide(&mut self, hidden: impl Fn(usize) -> bool) {
        let mut shown = vec![false; self.meshes.len()];
        for (index, instance) in self.instances.iter().enumerate() {
            shown[instance.mesh as usize] |= !hidden(index);
        }
        let mut copies: BTreeMap<u32, u32> = BTreeMap::new();
        for (_, instance) in self.instances.iter_mut().enumerate().filter(|(index, _)| hidden(*index)) {
            instance.mesh = *copies.entry(instance.mesh).or_insert_with_key(|&mesh| {
                if !shown[mesh as usize] {
                    return mesh;
                }
                self.meshes.push(self.meshes[mesh as usize].clone());
                self.meshes.len() as u32 - 1
            });
        }
        self.hidden.extend(copies.into_values());
        self.hidden.sort_unstable();
        self.hidden.dedup();
    }

    /// Lets rays pass the backs of surfaces, except of materials that are seen from both sides.
    pub fn pass_backs(&mut self) {
        self.passes_backs = true;
    }

    /// True where rays pass a mesh from behind.
    pub fn is_one_sided(&self, mesh: usize) -> bool {
        let material = self.materials().get(self.meshes[mesh].material as usize);
        self.passes_backs && !material.is_some_and(|material| material.double_sided)
    }

    /// True of a mesh that occludes nothing whatever its material.
    pub(crate) fn is_hidden(&self, mesh: usize) -> bool {
        self.hidden.binary_search(&(mesh as u32)).is_ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Affine3A, Material, Opacity, TriangleMesh, Vec3};

    /// Two instances of one mesh and one of another.
    fn geometry() -> Geometry {
        let mut geometry = Geometry::default();
        geometry.add_material(Material::default());
        geometry.add_material(Material { double_sided: true, ..Material::default() });
        let mesh = || TriangleMesh::new(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]]).unwrap();
        for (mesh, copies) in [(mesh(), 2), (mesh().with_material(1), 1)] {
            let mesh = geometry.add_mesh(mesh).unwrap();
            (0..copies).for_each(|_| _ = geometry.add_instance(mesh, Affine3A::IDENTITY).unwrap());
        }
        geometry
    }

    fn blocks(geometry: &Geometry) -> Vec<bool> {
        let of = |instance: &crate::Instance| !matches!(geometry.opacity(instance.mesh as usize), Opacity::Constant(opacity) if *opacity == 0.0);
        geometry.instances().iter().map(of).collect()
    }

    #[test]
    fn hidden_instances_occlude_nothing_and_others_of_their_mesh_still_do() {
        let mut found = geometry();
        found.hide(|index| index == 1);
        assert_eq!((blocks(&found), found.meshes().len()), (vec![true, false, true], 3));
        assert_eq!(found.mesh_of(1).triangles(), found.mesh_of(0).triangles());
        found.make_opaque();
        assert_eq!(blocks(&found), [true, false, true], "also where all is opaque");
        let mut found = geometry();
        found.hide(|index| index < 2);
        assert_eq!(
            (blocks(&found), found.meshes().len()),
            (vec![false, false, true], 2),
            "no copy is needed"
        );
        found.hide(|_| false);
        assert_eq!(blocks(&found), [false, false, true], "what was hidden stays so");
    }

    #[test]
    fn only_surfaces_that_are_not_seen_from_both_sides_let_rays_pass_from_behind() {
        let mut found = geometry();
        assert!(!found.is_one_sided(0));
        found.pass_backs();
        assert!(found.is_one_sided(0) && !found.is_one_sided(1));
    }
}

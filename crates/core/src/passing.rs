//! What rays pass although a file says that it is there: hidden instances, and the backs of surfaces.

use crate::{Geometry, Instance};
use std::collections::BTreeMap;

/// What the backs of surfaces do to rays. The front is where corners go round counter-clockwise, or where vertex normals point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Backs {
    /// They are in the way as fronts are.
    #[default]
    Block,
    /// Rays pass them, except of materials that are seen from both sides.
    PassOneSided,
    /// Rays pass them.
    Pass,
}

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

    /// Says what the backs of surfaces do to rays.
    pub fn set_backs(&mut self, backs: Backs) {
        self.backs = backs;
    }

    /// True where rays pass a mesh from behind.
    pub fn is_one_sided(&self, mesh: usize) -> bool {
        let material = || self.materials().get(self.meshes[mesh].material as usize);
        match self.backs {
            Backs::Block => false,
            Backs::PassOneSided => !material().is_some_and(|material| material.double_sided),
            Backs::Pass => true,
        }
    }

    /// The same materials, and of the instances only these, in their order, with their meshes.
    #[must_use]
    pub fn only(&self, instances: &[u32]) -> Self {
        let mut found = Self { materials: self.materials.clone(), backs: self.backs, ..Self::default() };
        let mut meshes: BTreeMap<u32, u32> = BTreeMap::new();
        for &index in instances {
            let instance = self.instances[index as usize].clone();
            let mesh = *meshes.entry(instance.mesh).or_insert_with(|| {
                found.meshes.push(self.meshes[instance.mesh as usize].clone());
                let mesh = found.meshes.len() as u32 - 1;
                if self.is_hidden(instance.mesh as usize) {
                    found.hidden.push(mesh);
                }
                mesh
            });
            found.instances.push(Instance { mesh, ..instance });
        }
        found
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
    fn some_instances_come_with_their_meshes_alone() {
        let mut all = geometry();
        all.hide(|index| index == 1);
        let some = all.only(&[2, 1]);
        assert_eq!((some.instances().len(), some.meshes().len()), (2, 2));
        assert_eq!(some.mesh_of(0).material, 1);
        assert_eq!(blocks(&some), [true, false]);
        assert!(all.only(&[]).instances().is_empty());
    }

    #[test]
    fn only_surfaces_that_are_not_seen_from_both_sides_let_rays_pass_from_behind() {
        let mut found = geometry();
        assert!(!found.is_one_sided(0));
        found.set_backs(Backs::PassOneSided);
        assert!(found.is_one_sided(0) && !found.is_one_sided(1));
        found.set_backs(Backs::Pass);
        assert!(found.is_one_sided(0) && found.is_one_sided(1));
    }
}

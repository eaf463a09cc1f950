//! Places meshes in the world.

use super::data::Data;
use crate::files::error::Fault;
use crate::files::intake::Intake;
use crate::files::limits::Limits;
use conray_core::{Affine3A, Bounds, TriangleMesh};
use std::collections::HashMap;

/// Adds instances and keeps the meshes' bounds.
#[derive(Default)]
pub(super) struct Placer {
    bounds: HashMap<u32, Bounds>,
}

impl Placer {
    /// Adds an instance of a mesh that is in the scene. `title` is its name in the scene, `name` the node's in messages.
    ///
    /// Who traces rays needs the inverse of the placement. Where there is none, because the node flattens the mesh,
    /// the flattened triangles become a mesh of their own.
    pub(super) fn place(
        &mut self,
        mesh: u32,
        world_from_mesh: Affine3A,
        title: &str,
        name: &str,
        data: &Data,
        intake: &mut Intake,
    ) -> Result<(), Fault> {
        let instances = intake.scene.geometry.instances().len() as u64;
        Limits::check("instances", instances + 1, intake.limits.max_instances)?;
        let source = &intake.scene.geometry.meshes()[mesh as usize];
        let bounds = *self.bounds.entry(mesh).or_insert_with(|| source.bounds());
        let world = bounds.transformed(&world_from_mesh);
        if !(world_from_mesh.is_finite() && world.min.is_finite() && world.max.is_finite()) {
            return Err(Fault::element(name, "it stands beyond the range of numbers"));
        }
        let fault = |e: conray_core::GeometryError| Fault::element(name, e.to_string());
        let (mesh, world_from_mesh) = if world_from_mesh.inverse().is_finite() {
            (mesh, world_from_mesh)
        } else {
            let triangles = source.triangles().len();
            data.spend(((triangles + source.positions().len()) as u64).saturating_mul(32))?;
            let flat = flattened(source, &world_from_mesh).map_err(fault)?;
            intake.count_triangles(triangles)?;
            let vertices = intake.scene.sources[mesh as usize].clone();
            intake.scene.sources.push(vertices);
            (intake.scene.geometry.add_mesh(flat).map_err(fault)?, Affine3A::IDENTITY)
        };
        intake.scene.geometry.add_named_instance(mesh, world_from_mesh, title.to_string()).map_err(fault)?;
        Ok(())
    }
}

/// The mesh in world coordinates; its normals have lost their meaning.
fn flattened(
    mesh: &TriangleMesh,
    world_from_mesh: &Affine3A,
) -> Result<TriangleMesh, conray_core::GeometryError> {
    let positions = mesh.positions().iter().map(|&p| world_from_mesh.transform_point3(p)).collect();
    let flat = TriangleMesh::new(positions, mesh.triangles().to_vec())?;
    let flat = mesh.uv_sets().iter().try_fold(flat, |flat, uvs| flat.with_uv_set(uvs.clone()))?;
    Ok(flat.with_name(mesh.name.clone()).with_material(mesh.material))
}

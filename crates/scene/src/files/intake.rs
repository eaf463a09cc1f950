//! A scene while it is being loaded.

use super::error::Fault;
use super::extras::Extras;
use super::limits::Limits;
use super::source::Resolver;
use crate::Scene;
use conray_core::{Affine3A, GeometryError, TriangleMesh};

/// The scene so far, where its other files come from, and what it may still take.
pub(super) struct Intake<'a> {
    /// What has been loaded, and the warnings so far.
    pub scene: Scene,
    /// Finds the files that the scene file names.
    pub resolve: &'a Resolver<'a>,
    /// What may be asked for.
    pub limits: &'a Limits,
    /// What is wanted beside what occludes.
    pub extras: Extras,
    /// What is left of [`Limits::max_texture_pixels`].
    pub pixels_left: u64,
    /// Triangles of all meshes so far.
    triangles: u64,
}

impl<'a> Intake<'a> {
    /// An empty scene.
    pub(super) fn new(name: String, resolve: &'a Resolver<'a>, limits: &'a Limits, extras: Extras) -> Self {
        let scene = Scene { name, ..Scene::default() };
        Self { scene, resolve, limits, extras, pixels_left: limits.max_texture_pixels, triangles: 0 }
    }

    /// Counts triangles against [`Limits::max_triangles`].
    pub(super) fn count_triangles(&mut self, more: usize) -> Result<(), Fault> {
        self.triangles = self.triangles.saturating_add(more as u64);
        Limits::check("triangles", self.triangles, self.limits.max_triangles)
    }

    /// Adds a mesh and places it once.
    pub(super) fn add_mesh(
        &mut self,
        mesh: TriangleMesh,
        world_from_mesh: Affine3A,
        name: String,
    ) -> Result<(), Fault> {
        let fault = |e: GeometryError| Fault::file(e.to_string());
        let index = self.scene.geometry.add_mesh(mesh).map_err(fault)?;
        self.scene.geometry.add_named_instance(index, world_from_mesh, name).map_err(fault)?;
        Ok(())
    }
}

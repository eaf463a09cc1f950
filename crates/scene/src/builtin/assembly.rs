//! Putting parts, materials and views together to a scene.

use super::part::Part;
use crate::Scene;
use conray_core::{
    Affine2, Affine3A, AlphaTexture, Geometry, Material, Opacity, TextureOpacity, Vec3, View, Wrap,
};
use std::sync::Arc;

/// A scene under construction.
///
/// What it is given comes from code alone, so that a part which is no mesh is a mistake in this crate: it panics, and
/// the tests build every scene.
pub(crate) struct Assembly {
    name: &'static str,
    geometry: Geometry,
    views: Vec<View>,
}

impl Assembly {
    /// An empty scene of that name.
    pub(crate) fn new(name: &'static str) -> Self {
        Self { name, geometry: Geometry::default(), views: Vec::new() }
    }

    /// Adds an opaque material.
    pub(crate) fn opaque(&mut self, name: &str) -> u32 {
        self.geometry.add_material(Material { name: name.into(), ..Material::default() })
    }

    /// Adds a double-sided material that blocks where its mask is at least one half.
    pub(crate) fn masked(&mut self, name: &str, mask: AlphaTexture) -> u32 {
        let opacity = Opacity::Texture(TextureOpacity {
            texture: Arc::new(mask),
            uv_set: 0,
            texture_from_uv: Affine2::IDENTITY,
            wrap: [Wrap::Clamp; 2],
            factor: 1.0,
            cutoff: Some(0.5),
        });
        self.geometry.add_material(Material {
            name: name.into(),
            opacity,
            double_sided: true,
            ..Material::default()
        })
    }

    /// Stores a part without placing it.
    pub(crate) fn store(&mut self, name: &str, part: Part, material: u32) -> u32 {
        part.into_mesh(name, material)
            .and_then(|mesh| self.geometry.add_mesh(mesh))
            .expect("the parts of built-in scenes are valid meshes")
    }

    /// Places a stored mesh.
    pub(crate) fn place(&mut self, mesh: u32, world_from_mesh: Affine3A, name: String) {
        self.geometry
            .add_named_instance(mesh, world_from_mesh, name)
            .expect("the placements of built-in scenes are finite");
    }

    /// Stores a part and places it where it is.
    pub(crate) fn add(&mut self, name: &str, part: Part, material: u32) {
        let mesh = self.store(name, part, material);
        self.place(mesh, Affine3A::IDENTITY, name.into());
    }

    /// Adds a view.
    pub(crate) fn view(&mut self, name: &str, eye: [f32; 3], look_at: [f32; 3], vertical_fov_deg: f32) {
        let (eye, look_at) = (Vec3::from_array(eye), Vec3::from_array(look_at));
        self.views.push(View { name: name.into(), eye, look_at, up: Vec3::Y, vertical_fov_deg });
    }

    /// The finished scene.
    pub(crate) fn finish(self) -> Scene {
        Scene { name: self.name.into(), geometry: self.geometry, views: self.views, ..Scene::default() }
    }
}

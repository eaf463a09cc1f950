//! Opacities of materials and their textures.

use bytemuck::{Pod, Zeroable, cast_slice};
use conray_core::{AlphaTexture, Geometry, Opacity, TextureOpacity, Vec2, Wrap};
use std::{collections::HashMap, sync::Arc};

/// Stands for a surface that is opaque.
pub(crate) const NONE: u32 = u32::MAX;

/// Opacity of a material that is not opaque.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct GpuMaterial {
    pub(crate) columns: [f32; 4],
    pub(crate) translation: [f32; 2],
    pub(crate) factor: f32,
    pub(crate) cutoff: f32,
    pub(crate) first: u32,
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) wrap: u32,
}

/// The opacities that a scene's triangles refer to.
pub(super) struct Materials {
    pub(super) list: Vec<GpuMaterial>,
    texels: Vec<u8>,
    /// For each of the scene's materials its place in the list.
    places: Vec<u32>,
}

impl Materials {
    pub(super) fn new(geometry: &Geometry) -> Self {
        let mut all = Self { list: Vec::new(), texels: Vec::new(), places: Vec::new() };
        let mut known: HashMap<*const AlphaTexture, u32> = HashMap::new();
        for material in geometry.materials() {
            let place = match &material.opacity {
                opacity if opacity.is_opaque() => NONE,
                Opacity::Constant(factor) => all.push(GpuMaterial {
                    columns: [0.0; 4],
                    translation: [0.0; 2],
                    factor: *factor,
                    cutoff: -1.0,
                    first: 0,
                    width: 0,
                    height: 0,
                    wrap: 0,
                }),
                Opacity::Texture(texture) => {
                    let first = *known.entry(Arc::as_ptr(&texture.texture)).or_insert_with(|| {
                        let first = all.texels.len() as u32;
                        all.texels.extend_from_slice(texture.texture.texels());
                        first
                    });
                    all.push(textured(texture, first))
                }
            };
            all.places.push(place);
        }
        all
    }

    fn push(&mut self, material: GpuMaterial) -> u32 {
        self.list.push(material);
        self.list.len() as u32 - 1
    }

    /// The place of a mesh's opacity in the list, [`NONE`] where it is opaque.
    pub(super) fn place(&self, material: u32) -> u32 {
        self.places.get(material as usize).copied().unwrap_or(NONE)
    }

    /// Whether UVs are read there.
    pub(super) fn uv_set(geometry: &Geometry, mesh: usize) -> Option<usize> {
        match geometry.opacity(mesh) {
            Opacity::Texture(texture) => Some(texture.uv_set),
            Opacity::Constant(_) => None,
        }
    }

    /// All as words, in the order of shaders/shared/scene.wgsl, with the UVs of triangles.
    pub(super) fn words(&self, uvs: &[Vec2]) -> Vec<u32> {
        let list: &[u32] = cast_slice(&self.list);
        let uv_words: &[u32] = cast_slice(uvs);
        let first_uv = 2 + list.len() as u32;
        let texel = |bytes: &[u8]| {
            let mut whole = [0; 4];
            whole[..bytes.len()].copy_from_slice(bytes);
            u32::from_le_bytes(whole)
        };
        let mut words = vec![first_uv, first_uv + uv_words.len() as u32];
        words.extend_from_slice(list);
        words.extend_from_slice(uv_words);
        words.extend(self.texels.chunks(4).map(texel));
        words
    }
}

fn textured(texture: &TextureOpacity, first: u32) -> GpuMaterial {
    let matrix = texture.texture_from_uv.matrix2;
    let wrap = |wrap: Wrap| match wrap {
        Wrap::Repeat => 0,
        Wrap::Mirror => 1,
        Wrap::Clamp => 2,
    };
    GpuMaterial {
        columns: matrix.to_cols_array(),
        translation: texture.texture_from_uv.translation.to_array(),
        factor: texture.factor,
        cutoff: texture.cutoff.unwrap_or(-1.0),
        first,
        width: texture.texture.width(),
        height: texture.texture.height(),
        wrap: wrap(texture.wrap[0]) | wrap(texture.wrap[1]) << 4,
    }
}

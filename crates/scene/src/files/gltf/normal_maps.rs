//! The normal maps of a glTF's materials: "glTF 2.0 Specification", section 3.9.3.

use super::data::{Data, get};
use super::images::{Found, find};
use super::materials::{placement, wraps};
use super::schema::NormalTextureInfo;
use crate::WarningKind;
use crate::files::error::Fault;
use crate::files::image_normals::read_normals;
use crate::files::intake::Intake;
use conray_core::{NormalMap, NormalTexture};
use std::collections::HashMap;
use std::sync::Arc;

/// Reads normal maps, and each image once.
pub(super) struct NormalMaps<'d> {
    data: &'d Data<'d>,
    images: HashMap<usize, Option<Arc<NormalTexture>>>,
}

impl<'d> NormalMaps<'d> {
    /// A reader that has not read anything.
    pub(super) fn new(data: &'d Data<'d>) -> Self {
        Self { data, images: HashMap::new() }
    }

    /// A normal map; `None`, with a warning, where its image is missing or of a kind that is not read.
    pub(super) fn read(
        &mut self,
        normal: &NormalTextureInfo,
        asker: &str,
        intake: &mut Intake,
    ) -> Result<Option<NormalMap>, Fault> {
        let info = &normal.texture;
        let texture = get(&self.data.root.textures, info.index, "texture", asker)?;
        let wrap = wraps(self.data, texture, info.index)?;
        let (texture_from_uv, uv_set) = placement(info);
        let known = texture.source.and_then(|source| self.images.get(&source).cloned());
        let image = match known {
            Some(known) => known,
            None => {
                let lacks = |what: String| (None, Some(what));
                let (image, lack) = match find(self.data, texture, info.index, intake)? {
                    Found::File { name, bytes } => match read_normals(&name, &bytes, intake)? {
                        Ok(texture) => (Some(Arc::new(texture)), None),
                        Err(kind) => lacks(format!("{name}, which is {kind}")),
                    },
                    Found::OtherFormat(extension) => lacks(format!("one in {extension}")),
                    Found::Missing(example) => lacks(example),
                };
                if let Some(example) = lack {
                    intake.scene.warn(WarningKind::MissingNormalMap, 1, example);
                }
                if let Some(source) = texture.source {
                    self.images.insert(source, image.clone());
                }
                image
            }
        };
        let scale = normal.scale.filter(|scale| scale.is_finite()).unwrap_or(1.0);
        Ok(image.map(|texture| NormalMap { texture, uv_set, texture_from_uv, wrap, scale }))
    }
}

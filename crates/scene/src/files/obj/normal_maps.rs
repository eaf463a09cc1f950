//! The normal maps of an OBJ's materials.
//!
//! MTL has heights alone (`map_Bump`); `norm` is an extension for normals, and many exporters name normal maps under `map_Bump`. An image
//! of heights is grey, one of normals is not.

use super::materials::placement;
use super::mtl::{MtlMaterial, TextureStatement};
use crate::WarningKind;
use crate::files::error::{Fault, shown};
use crate::files::image_normals::{is_grey, read_normals};
use crate::files::intake::Intake;
use conray_core::{NormalMap, NormalTexture};
use std::collections::HashMap;
use std::sync::Arc;

/// Reads normal maps, and each image once.
#[derive(Default)]
pub(super) struct ObjNormalMaps {
    images: HashMap<String, Option<Arc<NormalTexture>>>,
}

impl ObjNormalMaps {
    /// The normals of a material; `None` where it has none, and with a warning where they cannot be read.
    pub(super) fn read(
        &mut self,
        intake: &mut Intake,
        mtl: &MtlMaterial,
    ) -> Result<Option<NormalMap>, Fault> {
        let Some(map) = mtl.normal_map.as_ref().or(mtl.bump_map.as_ref()) else { return Ok(None) };
        let Some(texture) = self.image(intake, map)? else { return Ok(None) };
        if is_grey(&texture) {
            let example = format!("{}, which is of heights", shown(map.file.as_bytes()));
            intake.scene.warn(WarningKind::MissingNormalMap, 1, example);
            return Ok(None);
        }
        let (texture_from_uv, wrap) = placement(map);
        Ok(Some(NormalMap { texture, uv_set: 0, texture_from_uv, wrap, scale: map.multiplier }))
    }

    fn image(
        &mut self,
        intake: &mut Intake,
        map: &TextureStatement,
    ) -> Result<Option<Arc<NormalTexture>>, Fault> {
        if let Some(known) = self.images.get(&map.file) {
            return Ok(known.clone());
        }
        let found = match (intake.resolve)(&map.file) {
            Ok(bytes) => read_normals(&map.file, &bytes, intake)?.map_err(|kind| format!("which is {kind}")),
            Err(error) => Err(error.to_string()),
        };
        let texture = match found {
            Ok(texture) => Some(Arc::new(texture)),
            Err(why) => {
                let example = format!("{}: {why}", shown(map.file.as_bytes()));
                intake.scene.warn(WarningKind::MissingNormalMap, 1, example);
                None
            }
        };
        self.images.insert(map.file.clone(), texture.clone());
        Ok(texture)
    }
}

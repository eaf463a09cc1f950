//! The materials that an OBJ uses, from its MTL files and their textures.

use super::mtl::{MtlMaterial, TextureStatement, parse_mtl};
use super::normal_maps::ObjNormalMaps;
use crate::WarningKind;
use crate::files::error::{Fault, shown};
use crate::files::image_alpha::{Channel, ImageOpacity, read_opacity, simplify};
use crate::files::intake::Intake;
use conray_core::{Affine2, AlphaTexture, Material, Opacity, TextureOpacity, Vec2, Wrap};
use std::collections::HashMap;
use std::sync::Arc;

/// More material files than this in one OBJ are not read.
const MAX_MATERIAL_FILES: usize = 4096;

/// Reads all files that the `mtllib` statements name; the first material of a name counts.
pub(super) fn read_materials(intake: &mut Intake, statements: &[String]) -> HashMap<String, MtlMaterial> {
    let mut materials = HashMap::new();
    let mut seen = std::collections::HashSet::new();
    for statement in statements.iter().filter(|s| seen.insert(s.as_str())).take(MAX_MATERIAL_FILES) {
        for text in read_statement(intake, statement) {
            for material in parse_mtl(&text) {
                materials.entry(material.name.clone()).or_insert(material);
            }
        }
    }
    materials
}

/// A statement names one file, whose name may hold spaces, or several apart by spaces.
fn read_statement(intake: &mut Intake, statement: &str) -> Vec<Vec<u8>> {
    if let Ok(text) = (intake.resolve)(statement) {
        return vec![text];
    }
    let names: Vec<&str> = statement.split_whitespace().collect();
    let mut texts = Vec::new();
    let mut missing = Vec::new();
    for name in &names {
        match (intake.resolve)(name) {
            Ok(text) => texts.push(text),
            Err(_) => missing.push(*name),
        }
    }
    if texts.is_empty() {
        missing = vec![statement];
    }
    let example = shown(missing.first().unwrap_or(&"").as_bytes());
    intake.scene.warn(WarningKind::MissingMaterialFile, missing.len() as u64, example);
    texts
}

/// Makes the scene's materials out of those that MTL files hold, reading each texture once.
#[derive(Default)]
pub(super) struct ObjMaterials {
    textures: HashMap<(String, Channel), Option<Arc<AlphaTexture>>>,
    normals: ObjNormalMaps,
}

impl ObjMaterials {
    /// Opacity = d * map_d, or d times the alpha of map_Kd where there is no map_d. Fractional: MTL knows no cutoff.
    pub(super) fn material(&mut self, intake: &mut Intake, mtl: &MtlMaterial) -> Result<Material, Fault> {
        let map = match (&mtl.opacity_map, &mtl.colour_map) {
            (Some(map), _) => {
                let channel = map.channel.unwrap_or(Channel::AlphaOrRed);
                self.texture(intake, map, channel)?.map(|t| (map, t))
            }
            (None, Some(map)) if may_have_alpha(&map.file) => self
                .texture(intake, map, Channel::Alpha)?
                .filter(|t| is_used(intake, map, t))
                .map(|t| (map, t)),
            _ => None,
        };
        let opacity = match map {
            Some((map, texture)) => textured(map, texture, mtl.opacity),
            None => Opacity::Constant(mtl.opacity),
        };
        // MTL does not say which faces are seen from behind, and viewers show both.
        let normal_map = if intake.extras.normal_maps { self.normals.read(intake, mtl)? } else { None };
        Ok(Material { name: mtl.name.clone(), opacity, double_sided: true, normal_map })
    }

    fn texture(
        &mut self,
        intake: &mut Intake,
        map: &TextureStatement,
        channel: Channel,
    ) -> Result<Option<Arc<AlphaTexture>>, Fault> {
        let key = (map.file.clone(), channel);
        if let Some(known) = self.textures.get(&key) {
            return Ok(known.clone());
        }
        let texture = match (intake.resolve)(&map.file) {
            Err(error) => {
                let example = format!("{}: {error}", shown(map.file.as_bytes()));
                intake.scene.warn(WarningKind::MissingTexture, 1, example);
                None
            }
            Ok(bytes) => {
                match read_opacity(&map.file, &bytes, channel, &mut intake.pixels_left, intake.limits)? {
                    ImageOpacity::Opaque => None,
                    ImageOpacity::Texture(texture) => Some(Arc::new(texture)),
                    ImageOpacity::UnknownKind(kind) => {
                        let example = format!("{}, which is {kind}", shown(map.file.as_bytes()));
                        intake.scene.warn(WarningKind::MissingTexture, 1, example);
                        None
                    }
                }
            }
        };
        self.textures.insert(key, texture.clone());
        Ok(texture)
    }
}

/// Colour maps in JPEG need not be opened.
fn may_have_alpha(file: &str) -> bool {
    let lower = file.to_ascii_lowercase();
    !lower.ends_with(".jpg") && !lower.ends_with(".jpeg")
}

/// Colour maps whose alpha is zero everywhere carry a channel that nobody filled.
fn is_used(intake: &mut Intake, map: &TextureStatement, texture: &AlphaTexture) -> bool {
    let used = texture.texels().iter().any(|&t| t > 0);
    if !used {
        let example = format!("the alpha channel of {}, zero everywhere", shown(map.file.as_bytes()));
        intake.scene.warn(WarningKind::IgnoredFeature, 1, example);
    }
    used
}

fn textured(map: &TextureStatement, texture: Arc<AlphaTexture>, factor: f32) -> Opacity {
    let [base, gain] = map.base_gain;
    let texture = if map.base_gain == [0.0, 1.0] {
        texture
    } else {
        let change = |&t: &u8| ((base + gain * f32::from(t) / 255.0).clamp(0.0, 1.0) * 255.0).round() as u8;
        let texels = texture.texels().iter().map(change).collect();
        AlphaTexture::new(texture.width(), texture.height(), texels).map_or(texture, Arc::new)
    };
    let (texture_from_uv, wrap) = placement(map);
    simplify(TextureOpacity { texture, uv_set: 0, texture_from_uv, wrap, factor, cutoff: None })
}

/// From a mesh's UVs to the texture, and what lies outside of it.
pub(super) fn placement(map: &TextureStatement) -> (Affine2, [Wrap; 2]) {
    // OBJ's v points up, and the first row of the texture is the top of the picture.
    let flip = Affine2::from_scale_angle_translation(Vec2::new(1.0, -1.0), 0.0, Vec2::Y);
    (flip * map.texture_from_uv, [if map.clamp { Wrap::Clamp } else { Wrap::Repeat }; 2])
}

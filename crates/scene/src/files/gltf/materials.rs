//! The materials of a glTF: their opacity, and what else is wanted.

use super::data::{Data, get};
use super::images::{Found, find};
use super::normal_maps::NormalMaps;
use super::schema::{MaterialDef, Texture, TextureInfo};
use crate::WarningKind;
use crate::files::error::{Fault, shown};
use crate::files::image_alpha::{Channel, ImageOpacity, read_opacity, simplify};
use crate::files::intake::Intake;
use conray_core::{Affine2, AlphaTexture, Material, Opacity, TextureOpacity, Vec2, Wrap};
use glam::Mat2;
use std::collections::HashMap;
use std::sync::Arc;

/// Reads materials, and each image once.
pub(super) struct Materials<'d> {
    data: &'d Data<'d>,
    images: HashMap<usize, Option<Arc<AlphaTexture>>>,
    normal_maps: NormalMaps<'d>,
}

impl<'d> Materials<'d> {
    /// A reader that has not read anything.
    pub(super) fn new(data: &'d Data<'d>) -> Self {
        Self { data, images: HashMap::new(), normal_maps: NormalMaps::new(data) }
    }

    /// A material: its opacity, and its normal map where these are wanted.
    pub(super) fn material(
        &mut self,
        index: usize,
        def: &MaterialDef,
        intake: &mut Intake,
    ) -> Result<Material, Fault> {
        let name = format!("material {index}");
        let opacity = self.opacity(&name, def, intake)?;
        let normal_map = match &def.normal_texture {
            Some(info) if intake.extras.normal_maps => self.normal_maps.read(info, &name, intake)?,
            _ => None,
        };
        Ok(Material { name: def.name.clone(), opacity, double_sided: def.double_sided, normal_map })
    }

    /// Opacity by `alphaMode`: "glTF 2.0 Specification", section 3.9.4.
    fn opacity(&mut self, name: &str, def: &MaterialDef, intake: &mut Intake) -> Result<Opacity, Fault> {
        let cutoff = match def.alpha_mode.as_deref() {
            None | Some("OPAQUE") => return Ok(Opacity::default()),
            Some("MASK") => Some(def.alpha_cutoff.unwrap_or(0.5)),
            Some("BLEND") => None,
            Some(mode) => {
                return Err(Fault::element(
                    name,
                    format!("alphaMode `{}` is not known", shown(mode.as_bytes())),
                ));
            }
        };
        let (factor, info) = match &def.extensions.specular_glossiness {
            Some(older) => (older.diffuse_factor, &older.diffuse_texture),
            None => {
                (def.pbr_metallic_roughness.base_color_factor, &def.pbr_metallic_roughness.base_color_texture)
            }
        };
        let factor = factor.map_or(1.0, |[_, _, _, a]| a).clamp(0.0, 1.0);
        let textured = match info {
            Some(info) => self.textured(info, factor, cutoff, name, intake)?,
            None => None,
        };
        let constant = || Opacity::Constant(cutoff.map_or(factor, |cutoff| f32::from(factor >= cutoff)));
        Ok(textured.unwrap_or_else(constant))
    }

    fn textured(
        &mut self,
        info: &TextureInfo,
        factor: f32,
        cutoff: Option<f32>,
        asker: &str,
        intake: &mut Intake,
    ) -> Result<Option<Opacity>, Fault> {
        let texture = get(&self.data.root.textures, info.index, "texture", asker)?;
        let Some(image) = self.image(texture, info.index, intake)? else { return Ok(None) };
        let wrap = wraps(self.data, texture, info.index)?;
        let (texture_from_uv, uv_set) = placement(info);
        Ok(Some(simplify(TextureOpacity { texture: image, uv_set, texture_from_uv, wrap, factor, cutoff })))
    }

    /// The alpha channel of a texture's image; `None` where it is opaque or missing.
    fn image(
        &mut self,
        texture: &Texture,
        index: usize,
        intake: &mut Intake,
    ) -> Result<Option<Arc<AlphaTexture>>, Fault> {
        if let Some(known) = texture.source.and_then(|source| self.images.get(&source)) {
            return Ok(known.clone());
        }
        let opacity = match find(self.data, texture, index, intake)? {
            Found::File { name, bytes } => {
                match read_opacity(&name, &bytes, Channel::Alpha, &mut intake.pixels_left, intake.limits)? {
                    ImageOpacity::Opaque => None,
                    ImageOpacity::Texture(texture) => Some(Arc::new(texture)),
                    ImageOpacity::UnknownKind(kind) => {
                        return Err(Fault::unsupported(format!(
                            "{name} of kind {kind} (which the opacity of a material needs)"
                        )));
                    }
                }
            }
            Found::OtherFormat(extension) => {
                return Err(Fault::unsupported(format!(
                    "{extension} (which the opacity of a material needs)"
                )));
            }
            Found::Missing(example) => {
                intake.scene.warn(WarningKind::MissingTexture, 1, example);
                None
            }
        };
        if let Some(source) = texture.source {
            self.images.insert(source, opacity.clone());
        }
        Ok(opacity)
    }
}

/// What a texture's sampler does outside the unit square.
pub(super) fn wraps(data: &Data, texture: &Texture, index: usize) -> Result<[Wrap; 2], Fault> {
    let Some(sampler) = texture.sampler else { return Ok([Wrap::Repeat; 2]) };
    let sampler = get(&data.root.samplers, sampler, "sampler", &format!("texture {index}"))?;
    Ok([sampler.wrap_s, sampler.wrap_t].map(wrap))
}

fn wrap(code: Option<u32>) -> Wrap {
    match code {
        Some(33071) => Wrap::Clamp,
        Some(33648) => Wrap::Mirror,
        _ => Wrap::Repeat,
    }
}

/// `KHR_texture_transform`: scale first, then the rotation, then the offset; and the UV set that is meant.
///
/// The rotation turns UVs counter-clockwise as one sees them with v pointing down, hence the sign.
pub(super) fn placement(info: &TextureInfo) -> (Affine2, usize) {
    let Some(transform) = &info.extensions.transform else { return (Affine2::IDENTITY, info.tex_coord) };
    let (sin, cos) = transform.rotation.sin_cos();
    let rotation = Mat2::from_cols(Vec2::new(cos, -sin), Vec2::new(sin, cos));
    let scale = Mat2::from_diagonal(Vec2::from_array(transform.scale.unwrap_or([1.0; 2])));
    let offset = Vec2::from_array(transform.offset.unwrap_or_default());
    (Affine2::from_mat2_translation(rotation * scale, offset), transform.tex_coord.unwrap_or(info.tex_coord))
}

#[cfg(test)]
mod tests {
    use super::super::schema::TextureTransform;
    use super::*;

    fn with(transform: TextureTransform) -> Affine2 {
        let mut info = TextureInfo::default();
        info.extensions.transform = Some(transform);
        placement(&info).0
    }

    #[test]
    fn the_extensions_own_example_shows_the_lower_left_quadrant() {
        // "utilizes only the lower left quadrant of the source image, rotated clockwise 90 degrees"
        let m = with(TextureTransform {
            offset: Some([0.0, 1.0]),
            rotation: std::f32::consts::FRAC_PI_2,
            scale: Some([0.5, 0.5]),
            tex_coord: None,
        });
        let corners =
            [(0., 0.), (1., 0.), (0., 1.), (1., 1.)].map(|(u, v)| m.transform_point2(Vec2::new(u, v)));
        // v points down: the lower left quadrant is u in [0, 1/2], v in [1/2, 1].
        let expected = [(0., 1.), (0., 0.5), (0.5, 1.), (0.5, 0.5)];
        for (corner, (u, v)) in corners.iter().zip(expected) {
            assert!((*corner - Vec2::new(u, v)).length() < 1e-6, "{corners:?}");
        }
    }

    #[test]
    fn its_second_example_turns_the_picture_over() {
        let m = with(TextureTransform {
            offset: Some([0.0, 1.0]),
            scale: Some([1.0, -1.0]),
            ..Default::default()
        });
        assert_eq!(m.transform_point2(Vec2::new(0.25, 0.25)), Vec2::new(0.25, 0.75));
    }
}

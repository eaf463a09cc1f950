//! MTL: as much of a material as ambient occlusion needs.
//!
//! After the "MTL material format (Lightwave, OBJ)" specification, Wavefront, 1995, with what exporters made of it.

use crate::files::image_alpha::Channel;
use crate::files::text::{Lines, float, name, word};
use conray_core::{Affine2, Vec2};

/// The opacity and the normals of one material as written.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct MtlMaterial {
    pub name: String,
    /// `d`, else `1 - Tr`, else 1; in [0, 1].
    pub opacity: f32,
    /// `map_d`.
    pub opacity_map: Option<TextureStatement>,
    /// `map_Kd`, whose alpha channel counts where there is no `map_d`.
    pub colour_map: Option<TextureStatement>,
    /// `norm`: normals in tangent space.
    pub normal_map: Option<TextureStatement>,
    /// `map_Bump` or `bump`: heights, or what exporters make of it.
    pub bump_map: Option<TextureStatement>,
}

/// A texture with the options before its name.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct TextureStatement {
    /// The file's name as written, without quotation marks.
    pub file: String,
    /// `-s` and `-o`: from the mesh's UVs to the texture's, both with v upwards.
    pub texture_from_uv: Affine2,
    /// `-clamp on`.
    pub clamp: bool,
    /// `-mm base gain`: an opacity t becomes base + gain t.
    pub base_gain: [f32; 2],
    /// `-imfchan`: which channel is meant.
    pub channel: Option<Channel>,
    /// `-bm`: multiplies how much normals are bent.
    pub multiplier: f32,
}

/// Reads the materials of an MTL file; what is not understood is passed over.
pub(super) fn parse_mtl(text: &[u8]) -> Vec<MtlMaterial> {
    let mut materials: Vec<MtlMaterial> = Vec::new();
    let (mut has_d, mut transparency) = (false, None);
    for (_, line) in Lines::joined(text) {
        let mut rest = &line[..];
        let keyword = word(&mut rest).to_ascii_lowercase();
        if keyword == b"newmtl" {
            let name = name(rest);
            materials.push(MtlMaterial { name, opacity: 1.0, ..MtlMaterial::default() });
            (has_d, transparency) = (false, None);
            continue;
        }
        let Some(material) = materials.last_mut() else { continue };
        match keyword.as_slice() {
            // `d -halo 0.5` fades with the angle; its factor is the opacity at the middle.
            b"d" => {
                if let Some(d) = first_number(rest) {
                    (material.opacity, has_d) = (d.clamp(0.0, 1.0), true);
                }
            }
            b"tr" => transparency = first_number(rest),
            b"map_d" | b"map_opacity" => material.opacity_map = texture_statement(rest),
            b"norm" | b"map_norm" | b"map_kn" => material.normal_map = texture_statement(rest),
            b"map_bump" | b"bump" => material.bump_map = texture_statement(rest),
            b"map_kd" => material.colour_map = texture_statement(rest),
            _ => {}
        }
        // Some exporters write opacity as Tr; where there is a d, it is the one that is right.
        if let (false, Some(transparency)) = (has_d, transparency) {
            material.opacity = (1.0 - transparency).clamp(0.0, 1.0);
        }
    }
    materials
}

fn first_number(mut rest: &[u8]) -> Option<f32> {
    loop {
        let word = word(&mut rest);
        match float(word) {
            Some(number) => return number.is_finite().then_some(number),
            None if word.is_empty() => return None,
            None => {}
        }
    }
}

/// Options, then a name that may hold spaces; `None` without a name.
fn texture_statement(mut rest: &[u8]) -> Option<TextureStatement> {
    let (mut scale, mut offset) = (Vec2::ONE, Vec2::ZERO);
    let mut out = TextureStatement {
        file: String::new(),
        texture_from_uv: Affine2::IDENTITY,
        clamp: false,
        base_gain: [0.0, 1.0],
        channel: None,
        multiplier: 1.0,
    };
    loop {
        let mut ahead = rest;
        match word(&mut ahead).to_ascii_lowercase().as_slice() {
            b"-o" => offset = up_to_three(&mut ahead, 0.0),
            b"-s" => scale = up_to_three(&mut ahead, 1.0),
            b"-t" => {
                up_to_three(&mut ahead, 0.0);
            }
            b"-mm" => out.base_gain = up_to_three(&mut ahead, 1.0).to_array(),
            b"-clamp" => out.clamp = word(&mut ahead).eq_ignore_ascii_case(b"on"),
            b"-imfchan" => {
                out.channel = match word(&mut ahead).to_ascii_lowercase().as_slice() {
                    b"r" => Some(Channel::Colour(0)),
                    b"g" => Some(Channel::Colour(1)),
                    b"b" => Some(Channel::Colour(2)),
                    b"m" => Some(Channel::Alpha),
                    b"l" => Some(Channel::Luminance),
                    _ => None,
                }
            }
            b"-bm" => out.multiplier = float(word(&mut ahead)).filter(|n| n.is_finite()).unwrap_or(1.0),
            b"-blendu" | b"-blendv" | b"-cc" | b"-texres" | b"-boost" | b"-type" => {
                word(&mut ahead);
            }
            _ => break,
        }
        rest = ahead;
    }
    out.file = name(rest);
    out.texture_from_uv = Affine2::from_scale_angle_translation(scale, 0.0, offset);
    (!out.file.is_empty()).then_some(out)
}

/// One to three numbers, of which two count; the missing second is `default`. Never takes the last word of the line.
fn up_to_three(rest: &mut &[u8], default: f32) -> Vec2 {
    let mut numbers = [None; 3];
    for number in &mut numbers {
        let mut ahead = *rest;
        match float(word(&mut ahead)).filter(|n| n.is_finite()) {
            Some(value) if !ahead.trim_ascii().is_empty() => (*number, *rest) = (Some(value), ahead),
            _ => break,
        }
    }
    Vec2::new(numbers[0].unwrap_or(default), numbers[1].unwrap_or(default))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(text: &str) -> MtlMaterial {
        let materials = parse_mtl(format!("newmtl a\n{text}\n").as_bytes());
        assert_eq!(materials.len(), 1);
        materials[0].clone()
    }

    #[test]
    fn opacity_is_d_or_else_what_transparency_leaves() {
        assert_eq!(one("").opacity, 1.0);
        assert_eq!(one("d 0.25").opacity, 0.25);
        assert_eq!(one("Tr 0.25").opacity, 0.75);
        assert_eq!(one("d 0.25\nTr 0.5").opacity, 0.25, "d is the one that is right");
        assert_eq!(one("Tr 1\nd 1").opacity, 1.0);
        assert_eq!(one("d -halo 0.5").opacity, 0.5);
        assert_eq!(one("d 7").opacity, 1.0);
        assert_eq!(one("d nan").opacity, 1.0);
        assert_eq!(one("d").opacity, 1.0);
    }

    #[test]
    fn each_material_starts_afresh() {
        let materials = parse_mtl(b"d 0.1\nnewmtl a b \r\nd 0.5\nnewmtl c\nTr 0.2\n");
        assert_eq!(materials.iter().map(|m| m.name.as_str()).collect::<Vec<_>>(), ["a b", "c"]);
        assert_eq!((materials[0].opacity, materials[1].opacity), (0.5, 0.8));
    }

    #[test]
    fn texture_options_are_told_from_the_name() {
        let map = |text: &str| one(text).opacity_map.unwrap();
        assert_eq!(map("map_d leaf mask.png").file, "leaf mask.png");
        assert_eq!(map("map_d \"leaf mask.png\"").file, "leaf mask.png");
        assert_eq!(map("map_d textures\\Leaf.PNG").file, "textures\\Leaf.PNG");
        assert!(map("map_D -clamp on a.png").clamp);
        assert!(!map("map_d -clamp off a.png").clamp);
        let m = map("map_d -s 2 3 1 -o 0.5 -mm 0.25 0.5 -imfchan m -blendu off -texres 512 4x4 b.png");
        assert_eq!(m.file, "4x4 b.png");
        assert_eq!(m.texture_from_uv.transform_point2(Vec2::ONE), Vec2::new(2.5, 3.0));
        assert_eq!((m.base_gain, m.channel), ([0.25, 0.5], Some(Channel::Alpha)));
        assert_eq!(map("map_d -o 1 2 3").file, "3", "the last word is the name");
        assert_eq!(one("map_d").opacity_map, None);
        assert_eq!(one("map_d -clamp on").opacity_map, None);
        assert_eq!(one("map_Kd a.jpg").colour_map.unwrap().file, "a.jpg");
    }

    #[test]
    fn an_offset_of_one_number_leaves_v_alone() {
        let m = one("map_d -s 4 -o 1 a.png").opacity_map.unwrap();
        assert_eq!(m.texture_from_uv.transform_point2(Vec2::ONE), Vec2::new(5.0, 1.0));
    }
}

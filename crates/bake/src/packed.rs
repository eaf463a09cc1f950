//! Occlusion in the red channel of the image that a material's roughness and metalness stand in, which glTF lets them share.

use crate::{
    AssignError, Buffers, Document, DocumentError, Look, Origins, Sheet, Uvs, assign::primitive,
    write::bytes_of,
};
use conray_target::{AtlasMap, PngDepth, encode_colour_png};
use image::{ImageReader, imageops};
use serde_json::{Map, Value};
use std::{io::Cursor, path::Path};

/// Largest image that is unpacked, in bytes: 16384 x 16384 texels of RGBA.
const MOST_BYTES: u64 = 1 << 30;

/// The image of a material's roughness (green) and metalness (blue) with a map in red, as a PNG of 8 bits, and the number of the texture that it is to replace. The
/// inner error says, for people, why they cannot share an image.
///
/// # Errors
/// A document whose parts are not what they must be.
pub(crate) fn packed(
    document: &Document,
    source: &Path,
    buffers: &Buffers,
    origins: &Origins<'_>,
    sheet: &Sheet,
    map: &AtlasMap,
    look: Look,
) -> Result<Result<(Vec<u8>, usize), String>, AssignError> {
    let Some(material) = material_of(document, origins, sheet)? else {
        return Ok(Err("it has no material".into()));
    };
    let material = document.element("materials", material)?;
    let Some(info) = material.get("pbrMetallicRoughness").and_then(|pbr| pbr.get("metallicRoughnessTexture"))
    else {
        return Ok(Err("it has no texture of roughness and metalness".into()));
    };
    let uv_set = info.get("texCoord").and_then(Value::as_u64).unwrap_or(0);
    if matches!(sheet.uvs, Uvs::New { .. }) || uv_set != sheet.uvs.set() as u64 {
        return Ok(Err("its map is read by other UVs than its roughness".into()));
    }
    if info.get("extensions").is_some_and(|all| all.get("KHR_texture_transform").is_some()) {
        return Ok(Err("its roughness is read by UVs that are transformed".into()));
    }
    let index = |value: Option<&Value>| value.and_then(Value::as_u64).map(|index| index as usize);
    let missing = || DocumentError::Missing("the texture of a material".into());
    let texture = index(info.get("index")).ok_or_else(missing)?;
    let image = index(document.element("textures", texture)?.get("source"));
    let Some(image) = image else { return Ok(Err("its roughness is in a format that is not read".into())) };
    let Some(bytes) = image_bytes(document.element("images", image)?, source, document, buffers) else {
        return Ok(Err("the image of its roughness cannot be read".into()));
    };
    Ok(combined(&bytes, map, look).map(|png| (png, texture)))
}

/// Lets a material read roughness and metalness from a texture.
///
/// # Errors
/// A document whose parts are not what they must be.
pub(crate) fn share(
    document: &mut Document,
    origins: &Origins<'_>,
    sheet: &Sheet,
    texture: usize,
) -> Result<(), AssignError> {
    let Some(material) = material_of(document, origins, sheet)? else { return Ok(()) };
    let pbr = document.element_mut("materials", material)?.get_mut("pbrMetallicRoughness");
    let info = pbr.and_then(|pbr| pbr.get_mut("metallicRoughnessTexture")).and_then(Value::as_object_mut);
    if let Some(info) = info {
        info.insert("index".into(), texture.into());
    }
    Ok(())
}

/// The document's material that the surfaces of a sheet show.
fn material_of(
    document: &Document,
    origins: &Origins<'_>,
    sheet: &Sheet,
) -> Result<Option<usize>, DocumentError> {
    let Some(&instance) = sheet.instances.first() else { return Ok(None) };
    let origin = &origins.instances[instance as usize];
    let primitive = primitive(document, (origin.node, origin.primitive))?;
    Ok(primitive.get("material").and_then(Value::as_u64).map(|material| material as usize))
}

fn image_bytes(
    image: &Map<String, Value>,
    source: &Path,
    document: &Document,
    buffers: &Buffers,
) -> Option<Vec<u8>> {
    match image.get("uri").and_then(Value::as_str) {
        Some(uri) => bytes_of(source, uri),
        None => document.view_bytes(image.get("bufferView")?.as_u64()? as usize, buffers),
    }
}

fn combined(bytes: &[u8], map: &AtlasMap, look: Look) -> Result<Vec<u8>, String> {
    let unreadable = |e: &dyn std::fmt::Display| format!("the image of its roughness cannot be read: {e}");
    let mut reader =
        ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|e| unreadable(&e))?;
    let mut limits = image::Limits::default();
    limits.max_alloc = Some(MOST_BYTES);
    reader.limits(limits);
    let found = reader.decode().map_err(|e| unreadable(&e))?.into_rgb8();
    let (width, height) = (map.width, map.height);
    let found = match found.dimensions() == (width, height) {
        true => found,
        false => imageops::resize(&found, width, height, imageops::FilterType::Triangle),
    };
    let colour = |(texel, &visibility): (&image::Rgb<u8>, &f32)| {
        let [_, green, blue] = texel.0.map(|value| f32::from(value) / 255.0);
        [if visibility.is_nan() { 1.0 } else { look.of(visibility) }, green, blue]
    };
    let values: Vec<[f32; 3]> = found.pixels().zip(&map.visibility).map(colour).collect();
    let mut out = Vec::new();
    encode_colour_png(&mut out, width, height, &values, PngDepth::Eight).map_err(|e| e.to_string())?;
    Ok(out)
}

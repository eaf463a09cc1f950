//! OBJ with MTL to a scene.

mod faces;
mod materials;
mod mtl;
mod normal_maps;
mod parse;

use crate::WarningKind;
use crate::files::error::{Fault, shown};
use crate::files::intake::Intake;
use crate::files::normals::fill_normals;
use crate::files::soup::Part;
use conray_core::{Affine3A, Material};
use materials::{ObjMaterials, read_materials};
use parse::{ObjFile, parse};
use std::collections::HashMap;

/// Loads an OBJ: one mesh for each object and material, named after the object, in the order of their first faces.
///
/// Objects are what `o` names or, in files without any `o`, what `g` names. Only materials that faces use are kept.
pub(super) fn load(text: &[u8], intake: &mut Intake) -> Result<(), Fault> {
    let mut file = parse(text, intake)?;
    if file.soup.triangles.is_empty() {
        return Err(Fault::NoTriangles);
    }
    let (unused, first) = file.soup.unused_positions();
    intake.scene.warn(WarningKind::UnusedVertices, unused, format!("vertex {}", first + 1));
    fill_normals(&mut file.soup);
    let parts = parts(&file, intake)?;
    for part in parts {
        let name = part.name.clone();
        let mesh = file.soup.mesh(part)?;
        intake.add_mesh(mesh, Affine3A::IDENTITY, name)?;
    }
    Ok(())
}

/// Gathers the runs of each (object, material) and adds the materials to the scene.
fn parts(file: &ObjFile, intake: &mut Intake) -> Result<Vec<Part>, Fault> {
    let known = read_materials(intake, &file.material_files);
    let mut reader = ObjMaterials::default();
    let mut material_of: HashMap<u32, u32> = HashMap::new();
    let mut part_of: HashMap<(u32, u32), usize> = HashMap::new();
    let mut parts: Vec<Part> = Vec::new();
    let ends = file.runs.iter().skip(1).map(|run| run.start).chain([file.soup.triangles.len()]);
    for (run, end) in file.runs.iter().zip(ends).filter(|(run, end)| run.start < *end) {
        let material = match material_of.get(&run.material) {
            Some(&material) => material,
            None => {
                let name = file.names.get(run.material);
                let material = match known.get(name) {
                    Some(mtl) => reader.material(intake, mtl)?,
                    None => missing_material(intake, name),
                };
                let index = intake.scene.geometry.add_material(material);
                material_of.insert(run.material, index);
                index
            }
        };
        let object = if file.has_objects { run.object } else { run.group };
        let part = *part_of.entry((object, material)).or_insert_with(|| {
            let name = file.names.get(object).to_string();
            parts.push(Part { name, material, runs: Vec::new() });
            parts.len() - 1
        });
        parts[part].runs.push(run.start..end);
    }
    Ok(parts)
}

/// Faces before any `usemtl` have no material, and that is no defect.
fn missing_material(intake: &mut Intake, name: &str) -> Material {
    if !name.is_empty() {
        intake.scene.warn(WarningKind::MissingMaterial, 1, shown(name.as_bytes()));
    }
    Material { name: name.to_string(), double_sided: true, ..Material::default() }
}

//! glTF 2.0, as JSON or as binary GLB, to a scene.
//!
//! Read: the node tree with instances, all kinds of triangle primitives, sparse and quantised accessors, UV sets,
//! opacity by `alphaMode`, perspective cameras, and the extensions of [`EXTENSIONS`].

mod accessor;
mod cameras;
mod container;
mod data;
mod images;
mod materials;
#[cfg_attr(target_arch = "wasm32", path = "no_meshopt.rs")]
mod meshopt;
mod nodes;
mod normal_maps;
mod place;
mod primitive;
mod schema;
mod uri;

use crate::files::error::{Fault, shown};
use crate::files::intake::Intake;
use crate::{Origin, WarningKind};
use conray_core::Material;
use data::{Data, get};
use materials::Materials;
use place::Placer;
use primitive::read_primitive;
use schema::{Primitive, Root};
use std::collections::HashMap;
pub(super) use uri::percent_decoded;

/// Extensions that a file may require: those that are read, and those that change no geometry and no opacity.
///
/// Images in other formats are refused where an opacity needs one, not here.
const EXTENSIONS: [&str; 13] = [
    "KHR_mesh_quantization",
    "KHR_texture_transform",
    "KHR_node_visibility",
    "KHR_materials_pbrSpecularGlossiness",
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "KHR_meshopt_compression",
    "KHR_texture_basisu",
    "EXT_texture_webp",
    "MSFT_texture_dds",
    "KHR_lights_punctual",
    "EXT_lights_image_based",
    "KHR_animation_pointer",
];

/// Loads a glTF: one mesh for each primitive that the scene uses, one instance for each placement.
///
/// All materials of the document are kept, under their indices there; primitives without one share a further one.
pub(super) fn load(bytes: &[u8], intake: &mut Intake) -> Result<(), Fault> {
    let container = container::open(bytes)?;
    let root = &container.root;
    check_extensions(root)?;
    let data = Data::load(root, container.bin, bytes.len(), intake)?;
    let mut materials = Materials::new(&data);
    for (index, def) in root.materials.iter().enumerate() {
        let material = materials.material(index, def, intake)?;
        intake.scene.geometry.add_material(material);
    }
    let placed = nodes::walk(root, intake.limits)?;
    let mut meshes =
        Meshes { data: &data, of_mesh: HashMap::new(), of_primitive: HashMap::new(), default: None };
    let mut placer = Placer::default();
    for place in &placed {
        let (node, name) = (&root.nodes[place.node], format!("node {}", place.node));
        let Some(mesh) = node.mesh else { continue };
        if node.skin.is_some() {
            intake.scene.warn(WarningKind::IgnoredFeature, 1, format!("the skin of {name}, shown at rest"));
        }
        let parts = meshes.read(mesh, &name, intake)?;
        let title = if node.name.is_empty() { &root.meshes[mesh].name } else { &node.name };
        let relative = match &node.extensions.instancing {
            Some(instancing) => nodes::instances(&data, instancing, &name, intake.limits)?,
            None => vec![conray_core::Affine3A::IDENTITY],
        };
        for (copy, world_from_copy) in (0..).zip(&relative) {
            for part in &parts {
                let world_from_mesh = place.world_from_node * *world_from_copy;
                placer.place(part.mesh, world_from_mesh, title, &name, &data, intake)?;
                let (node, mesh) = (place.node as u32, mesh as u32);
                intake.scene.origins.push(Origin { node, copy, mesh, primitive: part.primitive });
            }
        }
    }
    if intake.scene.geometry.triangle_count() == 0 {
        return Err(Fault::NoTriangles);
    }
    cameras::add(root, &placed, intake)
}

/// Everything under `KHR_materials_` and `KHR_xmp` changes looks and notes only.
fn check_extensions(root: &Root) -> Result<(), Fault> {
    let known = |name: &String| {
        EXTENSIONS.contains(&name.as_str())
            || name.starts_with("KHR_materials_")
            || name.starts_with("KHR_xmp")
    };
    match root.extensions_required.iter().find(|name| !known(name)) {
        Some(unknown) => Err(Fault::unsupported(shown(unknown.as_bytes()))),
        None => Ok(()),
    }
}

/// What makes two primitives the same: attributes that are read, indices, mode, material.
type PrimitiveKey = (Vec<(String, usize)>, Option<usize>, Option<u32>, u32);

/// A primitive that has triangles: its index in its mesh, and the scene's mesh.
#[derive(Clone, Copy)]
struct Part {
    primitive: u32,
    mesh: u32,
}

/// The scene's meshes, each made at its first use.
struct Meshes<'d> {
    data: &'d Data<'d>,
    of_mesh: HashMap<usize, Vec<Part>>,
    of_primitive: HashMap<PrimitiveKey, Option<u32>>,
    /// The material of primitives without one.
    default: Option<u32>,
}

impl Meshes<'_> {
    /// The scene's meshes that make up a mesh of the document.
    fn read(&mut self, index: usize, asker: &str, intake: &mut Intake) -> Result<Vec<Part>, Fault> {
        if let Some(known) = self.of_mesh.get(&index) {
            return Ok(known.clone());
        }
        let mesh = get(&self.data.root.meshes, index, "mesh", asker)?;
        let mut parts = Vec::new();
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let name = format!("mesh {index} primitive {p}");
            let found = self.primitive(primitive, &name, &mesh.name, intake)?;
            parts.extend(found.map(|mesh| Part { primitive: p as u32, mesh }));
        }
        self.of_mesh.insert(index, parts.clone());
        Ok(parts)
    }

    fn primitive(
        &mut self,
        primitive: &Primitive,
        name: &str,
        title: &str,
        intake: &mut Intake,
    ) -> Result<Option<u32>, Fault> {
        let material = match primitive.material {
            Some(material) => {
                get(&self.data.root.materials, material, "material", name)?;
                material as u32
            }
            None => {
                *self.default.get_or_insert_with(|| intake.scene.geometry.add_material(Material::default()))
            }
        };
        let tangents = intake.extras.tangents;
        let is_read = |key: &str| {
            matches!(key, "POSITION" | "NORMAL")
                || key.starts_with("TEXCOORD_")
                || tangents && key == "TANGENT"
        };
        let attributes = primitive
            .attributes
            .iter()
            .filter(|(key, _)| is_read(key))
            .map(|(key, &a)| (key.clone(), a))
            .collect();
        let key = (attributes, primitive.indices, primitive.mode, material);
        if let Some(known) = self.of_primitive.get(&key) {
            return Ok(*known);
        }
        let index = match read_primitive(self.data, name, primitive, intake)? {
            Some((mesh, vertices)) => {
                intake.count_triangles(mesh.triangles().len())?;
                let mesh = mesh.with_name(title).with_material(material);
                intake.scene.sources.push(vertices);
                Some(intake.scene.geometry.add_mesh(mesh).map_err(|e| Fault::element(name, e.to_string()))?)
            }
            None => None,
        };
        self.of_primitive.insert(key, index);
        Ok(index)
    }
}

//! Occlusion textures into a document: whole materials where a map is all of a material's, copies of materials and meshes where not.

use crate::{Buffers, Document, DocumentError, Sheets, Uvs};
use conray_scene::Origin;
use serde_json::{Map, Value, json};
use std::collections::{BTreeMap, BTreeSet};
use thiserror::Error;

/// Why maps cannot be written into a document.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum AssignError {
    /// The document itself.
    #[error(transparent)]
    Document(#[from] DocumentError),
    /// A node places copies of a mesh, and one material cannot show several maps.
    #[error("node {0} places several copies of its mesh, which cannot have maps of their own")]
    Copies(u32),
}

/// A primitive as a node shows it.
pub(crate) type Place = (u32, u32);

/// What writing needs to know of the scene that a document became.
#[derive(Clone, Copy, Debug)]
pub struct Origins<'a> {
    /// Where the instances stand ([`conray_scene::Scene::origins`]).
    pub instances: &'a [Origin],
    /// The vertices that are to be written for each instance's mesh ([`conray_scene::Scene::sources`], by the instances).
    pub vertices: &'a [&'a [u32]],
}

/// Makes a texture for each sheet the occlusion of its surfaces.
///
/// A material that no other surface of the document uses is changed; else a copy of it is made for the sheet's surfaces, and a copy of the mesh
/// for nodes that show it with another map. Surfaces that were laid out anew get vertices of their own, with all that the ones before had and the new UVs.
/// All that is added stands at the ends of the document's lists. `name` is that of a file that a text document gains.
///
/// # Errors
/// A document whose parts are not what they must be, and copies of one node with different maps.
pub fn assign(
    document: &mut Document,
    origins: &Origins<'_>,
    sheets: &Sheets,
    textures: &[usize],
    buffers: &Buffers,
    name: &str,
) -> Result<(), AssignError> {
    let mut wanted: BTreeMap<Place, Value> = BTreeMap::new();
    for (sheet, &texture) in sheets.sheets.iter().zip(textures) {
        let place = |instance: u32| {
            let origin = &origins.instances[instance as usize];
            (origin.node, origin.primitive)
        };
        let places: BTreeSet<Place> = sheet.readers().map(|(instance, _)| place(instance)).collect();
        let copied = places.iter().find(|place| wanted.contains_key(place));
        // Copies that share their map may stand at one node.
        let own: BTreeSet<Place> = sheet.instances.iter().map(|&instance| place(instance)).collect();
        if let Some(&(node, _)) = copied.or_else(|| own.first().filter(|_| own.len() < sheet.instances.len()))
        {
            return Err(AssignError::Copies(node));
        }
        let before = places
            .iter()
            .map(|&place| Ok(primitive(document, place)?.get("material").and_then(index)))
            .collect::<Result<BTreeSet<_>, DocumentError>>()?;
        let shown_by = match before.first().copied().flatten() {
            Some(index) if users(document, index) == places.len() => index,
            Some(index) => {
                let mut copy = document.element("materials", index)?.clone();
                copy.insert("name".into(), sheet.name.clone().into());
                document.push("materials", Value::Object(copy))?
            }
            None => document.push("materials", json!({ "name": sheet.name }))?,
        };
        document.set_occlusion(shown_by, texture, sheet.uvs.set())?;
        let mut made: BTreeMap<usize, Value> = BTreeMap::new();
        for (instance, k) in sheet.readers() {
            if let Some(made) = made.get(&k) {
                wanted.insert(place(instance), made.clone());
                continue;
            }
            let mut changed = primitive(document, place(instance))?.clone();
            changed.insert("material".into(), shown_by.into());
            if let Uvs::New { set, of } = &sheet.uvs {
                let source = origins.vertices[instance as usize];
                let vertices: Vec<u32> =
                    of[k].vertices.iter().map(|&vertex| source[vertex as usize]).collect();
                split(document, &mut changed, &vertices, buffers, name)?;
                let uvs: Vec<[f32; 2]> = of[k].uvs.iter().map(|uv| uv.to_array()).collect();
                let uvs = document.push_floats(&uvs, name)?;
                if let Some(Value::Object(attributes)) = changed.get_mut("attributes") {
                    attributes.insert(format!("TEXCOORD_{set}"), uvs.into());
                }
                let indices = document.push_indices(of[k].triangles.as_flattened(), name)?;
                changed.insert("indices".into(), indices.into());
            }
            made.insert(k, Value::Object(changed.clone()));
            wanted.insert(place(instance), Value::Object(changed));
        }
    }
    show(document, &wanted)
}

/// Gives a primitive these vertices of those that it had, as a list of triangles.
pub(crate) fn split(
    document: &mut Document,
    primitive: &mut Map<String, Value>,
    vertices: &[u32],
    buffers: &Buffers,
    name: &str,
) -> Result<(), DocumentError> {
    primitive.shift_remove("mode");
    decompress(primitive);
    let mut gather = |attributes: &mut Value| {
        for accessor in attributes.as_object_mut().into_iter().flat_map(Map::values_mut) {
            let of = index(accessor)
                .ok_or_else(|| DocumentError::Missing("the accessor of an attribute".into()))?;
            *accessor = document.gather(of, vertices, buffers, name)?.into();
        }
        Ok(())
    };
    let targets = primitive.get_mut("targets").and_then(Value::as_array_mut);
    targets.into_iter().flatten().try_for_each(&mut gather)?;
    primitive.get_mut("attributes").map_or(Ok(()), gather)
}

/// Takes back that a primitive is compressed: what that holds is what was there before.
pub(crate) fn decompress(primitive: &mut Map<String, Value>) {
    if let Some(Value::Object(extensions)) = primitive.get_mut("extensions") {
        extensions.shift_remove("KHR_draco_mesh_compression");
    }
}

/// The primitives of the document, each as every node shows it, that use a material: how many.
fn users(document: &Document, material: usize) -> usize {
    let uses_it = |primitive: &Value| primitive.get("material").and_then(index) == Some(material);
    let in_mesh = |mesh: usize| {
        let primitives =
            document.root().get("meshes").and_then(|meshes| meshes.get(mesh)?.get("primitives")?.as_array());
        primitives.map_or(0, |all| all.iter().filter(|primitive| uses_it(primitive)).count())
    };
    // A mesh that no node shows uses it all the same.
    (0..document.count("meshes")).map(|mesh| in_mesh(mesh) * nodes_of(document, mesh).len().max(1)).sum()
}

/// What an index of the document is.
pub(crate) fn index(value: &Value) -> Option<usize> {
    value.as_u64().and_then(|value| usize::try_from(value).ok())
}

fn mesh_of(document: &Document, node: u32) -> Result<usize, DocumentError> {
    let place = || format!("nodes/{node}/mesh");
    let node = document.element("nodes", node as usize)?;
    node.get("mesh").and_then(index).ok_or_else(|| DocumentError::Missing(place()))
}

fn nodes_of(document: &Document, mesh: usize) -> Vec<u32> {
    let shows = |&node: &u32| mesh_of(document, node).ok() == Some(mesh);
    (0..document.count("nodes") as u32).filter(shows).collect()
}

/// A primitive as it is written.
pub(crate) fn primitive(
    document: &Document,
    (node, primitive): Place,
) -> Result<&Map<String, Value>, DocumentError> {
    let mesh = mesh_of(document, node)?;
    let place = || format!("meshes/{mesh}/primitives/{primitive}");
    let found =
        document.element("meshes", mesh)?.get("primitives").and_then(|all| all.get(primitive as usize));
    found.and_then(Value::as_object).ok_or_else(|| DocumentError::Missing(place()))
}

/// Gives nodes the primitives that are wanted for them; a mesh that several nodes would show differently is copied.
pub(crate) fn show(document: &mut Document, wanted: &BTreeMap<Place, Value>) -> Result<(), AssignError> {
    for mesh in 0..document.count("meshes") {
        // The primitives that change, for each node that shows the mesh.
        let mut by_node: Vec<(u32, Vec<(u32, &Value)>)> = Vec::new();
        for node in nodes_of(document, mesh) {
            let mut changes = Vec::new();
            for (&place, new) in wanted.range((node, 0)..=(node, u32::MAX)) {
                if Some(primitive(document, place)?) != new.as_object() {
                    changes.push((place.1, new));
                }
            }
            by_node.push((node, changes));
        }
        let mut versions: Vec<Vec<(u32, &Value)>> = Vec::new();
        for (_, changes) in &by_node {
            if !versions.contains(changes) {
                versions.push(changes.clone());
            }
        }
        // The mesh itself stays as it was where a node shows it so, else it becomes the first version.
        versions.sort_by_key(|changes| !changes.is_empty());
        let original = document.element("meshes", mesh)?.clone();
        for (version, changes) in versions.iter().enumerate() {
            let shown = match version {
                0 => mesh,
                _ => document.push("meshes", Value::Object(original.clone()))?,
            };
            let changed = document.element_mut("meshes", shown)?;
            for &(primitive, new) in changes {
                if let Some(old) =
                    changed.get_mut("primitives").and_then(|all| all.get_mut(primitive as usize))
                {
                    *old = new.clone();
                }
            }
            for (node, _) in by_node.iter().filter(|(_, of)| version > 0 && of == changes) {
                document.element_mut("nodes", *node as usize)?.insert("mesh".into(), shown.into());
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Sheet;
    use conray_target::MapSize;

    /// Materials `a` and `b`; mesh 0 has a primitive of `a` and one of none, mesh 1 one of `b`; nodes 0 and 1 show mesh 0, node 2 mesh 1.
    const TEXT: &str = r#"{"asset":{"version":"2.0"},
        "materials":[{"name":"a","extras":1},{"name":"b","occlusionTexture":{"index":0,"strength":0.5}}],
        "meshes":[{"primitives":[{"material":0},{}]},{"name":"m","primitives":[{"material":1}]}],
        "nodes":[{"mesh":0},{"mesh":0,"name":"n"},{"mesh":1}]}"#;

    fn origins() -> Vec<Origin> {
        let origin = |node, mesh, primitive| Origin { node, copy: 0, mesh, primitive };
        vec![origin(0, 0, 0), origin(0, 0, 1), origin(1, 0, 0), origin(1, 0, 1), origin(2, 1, 0)]
    }

    fn sheets(of: &[&[u32]]) -> Sheets {
        let sheet = |(k, instances): (usize, &&[u32])| Sheet {
            name: format!("sheet {k}"),
            material: 0,
            uvs: Uvs::Set(k),
            instances: instances.to_vec(),
            copies: Vec::new(),
            size: MapSize { width: 4, height: 4 },
            repeats: false,
        };
        Sheets { sheets: of.iter().enumerate().map(sheet).collect(), unmapped: Vec::new() }
    }

    fn assigned_in(
        document: &mut Document,
        instances: &[Origin],
        sheets: &Sheets,
        textures: &[usize],
    ) -> Result<(), AssignError> {
        let vertices = vec![&[][..]; instances.len()];
        let origins = Origins { instances, vertices: &vertices };
        assign(document, &origins, sheets, textures, &Buffers::default(), "new")
    }

    fn assigned(of: &[&[u32]]) -> Value {
        let mut document = Document::open(TEXT.as_bytes()).unwrap();
        let textures: Vec<usize> = (0..of.len()).map(|k| 10 + k).collect();
        assigned_in(&mut document, &origins(), &sheets(of), &textures).unwrap();
        Value::Object(document.root().clone())
    }

    /// The texture that a node's primitive shows.
    fn shown(root: &Value, node: usize, primitive: usize) -> Option<u64> {
        let mesh = root["nodes"][node]["mesh"].as_u64()? as usize;
        let material = root["meshes"][mesh]["primitives"][primitive]["material"].as_u64()? as usize;
        root["materials"][material]["occlusionTexture"]["index"].as_u64()
    }

    #[test]
    fn a_map_of_all_of_a_material_changes_that_material_alone() {
        let root = assigned(&[&[4]]);
        let before: Value = serde_json::from_str(TEXT).unwrap();
        assert_eq!(shown(&root, 2, 0), Some(10));
        assert_eq!(
            root["materials"][1]["occlusionTexture"]["strength"],
            before["materials"][1]["occlusionTexture"]["strength"]
        );
        assert_eq!((&root["meshes"], &root["nodes"]), (&before["meshes"], &before["nodes"]));
        assert_eq!(root["materials"].as_array().unwrap().len(), 2);
    }

    #[test]
    fn nodes_that_share_a_mesh_get_maps_of_their_own() {
        let root = assigned(&[&[0], &[2], &[1], &[3]]);
        let found = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(node, primitive)| shown(&root, node, primitive));
        assert_eq!(found, [Some(10), Some(11), Some(12), Some(13)]);
        assert_eq!(root["meshes"].as_array().unwrap().len(), 3);
        assert_eq!(root["materials"][0]["occlusionTexture"], Value::Null, "the material as it was stays");
        assert_eq!(
            (&root["materials"][2]["extras"], &root["materials"][2]["name"]),
            (&json!(1), &json!("sheet 0"))
        );
        assert_eq!(root["nodes"][1]["name"], "n");
        assert_eq!(shown(&root, 2, 0), Some(0), "another mesh stays");
    }

    #[test]
    fn a_node_that_gets_no_map_keeps_its_mesh() {
        let root = assigned(&[&[2]]);
        assert_eq!((shown(&root, 1, 0), shown(&root, 0, 0)), (Some(10), None));
        assert_eq!(root["nodes"][0]["mesh"], 0);
        let before: Value = serde_json::from_str(TEXT).unwrap();
        assert_eq!(root["meshes"][0], before["meshes"][0]);
    }

    #[test]
    fn copies_of_one_node_cannot_differ() {
        let mut document = Document::open(TEXT.as_bytes()).unwrap();
        let copy = |copy| Origin { node: 2, copy, mesh: 1, primitive: 0 };
        let found = assigned_in(&mut document, &[copy(0), copy(1)], &sheets(&[&[0], &[1]]), &[0, 1]);
        assert_eq!(found, Err(AssignError::Copies(2)));
        let mut document = Document::open(br#"{"nodes":[{}],"meshes":[]}"#).unwrap();
        let origin = Origin { node: 0, copy: 0, mesh: 0, primitive: 0 };
        let found = assigned_in(&mut document, &[origin], &sheets(&[&[0]]), &[0]).unwrap_err();
        assert_eq!(found.to_string(), "`nodes/0/mesh` does not exist");
    }
}

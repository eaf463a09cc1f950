//! Values of vertices into a document: as colours, or as an attribute of their own.

use super::{
    slots::{SlotSurface, Slots},
    values::VertexValues,
};
use crate::{
    AssignError, Buffers, Document, DocumentError, Origins, WriteError, Written,
    assign::{Place, decompress, index, primitive, show, split},
    write::{buffers_of, write_document},
};
use serde_json::{Map, Value};
use std::{collections::BTreeMap, path::Path};

/// How a model shows values of its vertices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VertexAttribute {
    /// Grey in `COLOR_0`, in place of the colours that are there. Their alpha stays.
    Color,
    /// In `COLOR_0`, times the colours that are there. Their alpha stays.
    MultipliedColor,
    /// `_AO`: one float, for renderers that know what to do with it; colours stay.
    Ao,
}

impl VertexAttribute {
    /// Its name in a document.
    pub fn name(self) -> &'static str {
        match self {
            Self::Color | Self::MultipliedColor => "COLOR_0",
            Self::Ao => "_AO",
        }
    }
}

/// Writes a model whose vertices show values, with the files that it gained and, in another folder, those that it had. Files are whole or not there; the
/// model itself comes last. `source` is the file that the document was read from.
///
/// # Errors
/// What the document or the disc refuses; files that were written before stay.
///
/// # Panics
/// Where the values are not those of the slots, or the origins not those of the document.
pub fn write_vertex_model(
    path: &Path,
    source: &Path,
    mut document: Document,
    origins: &Origins<'_>,
    slots: &Slots,
    values: &VertexValues,
    attribute: VertexAttribute,
) -> Result<Written, WriteError> {
    let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let buffers = buffers_of(&document, source)?;
    assign_vertices(&mut document, origins, slots, values, attribute, &buffers, &format!("{stem}-ao"))?;
    write_document(path, source, &document)
}

/// Gives the vertices of surfaces their values.
///
/// Primitives keep their vertices and their indices where each vertex has one value; else, or where they use less than half of a list of vertices, they
/// get vertices of their own, with all that the ones before had. Nodes that show one mesh get copies of it, for what they show differs. All
/// that is added stands at the ends of the document's lists; `name` is that of a file that a text document gains.
///
/// # Errors
/// A document whose parts are not what they must be, and a node that places several copies of its mesh.
///
/// # Panics
/// Where the values are not those of the slots, or the origins not those of the document.
pub fn assign_vertices(
    document: &mut Document,
    origins: &Origins<'_>,
    slots: &Slots,
    values: &VertexValues,
    attribute: VertexAttribute,
    buffers: &Buffers,
    name: &str,
) -> Result<(), AssignError> {
    let mut wanted: BTreeMap<Place, Value> = BTreeMap::new();
    for surface in slots.surfaces() {
        let origin = &origins.instances[surface.instance as usize];
        let place = (origin.node, origin.primitive);
        let vertices = Vertices::of(surface, origins.vertices[surface.instance as usize], values);
        let changed = vertices.shown_by(document, place, surface, attribute, buffers, name)?;
        if wanted.insert(place, Value::Object(changed)).is_some() {
            return Err(AssignError::Copies(origin.node));
        }
    }
    show(document, &wanted)
}

/// Vertices that are written, and their visibility.
struct Vertices {
    /// By the numbers of the document's accessors.
    vertices: Vec<u32>,
    visibility: Vec<f32>,
}

impl Vertices {
    fn of(surface: &SlotSurface, source: &[u32], values: &VertexValues) -> Self {
        Self {
            vertices: surface.vertices.iter().map(|&vertex| source[vertex as usize]).collect(),
            visibility: surface.slots.iter().map(|&slot| values.visibility[slot as usize]).collect(),
        }
    }

    /// All of a list of vertices; those that no triangle uses are open.
    fn among(self, count: usize) -> Self {
        let mut visibility = vec![1.0; count];
        for (vertex, value) in self.vertices.into_iter().zip(self.visibility) {
            visibility[vertex as usize] = value;
        }
        Self { vertices: (0..count as u32).collect(), visibility }
    }

    /// A primitive that shows them.
    fn shown_by(
        mut self,
        document: &mut Document,
        place: Place,
        surface: &SlotSurface,
        attribute: VertexAttribute,
        buffers: &Buffers,
        name: &str,
    ) -> Result<Map<String, Value>, DocumentError> {
        let mut changed = primitive(document, place)?.clone();
        let missing = |what: &str| DocumentError::Missing(format!("the {what} of a primitive"));
        let accessor = |key: &str| changed.get("attributes")?.get(key).and_then(index);
        let position = accessor("POSITION").ok_or_else(|| missing("POSITION"))?;
        let before = accessor(attribute.name());
        let count = document.element("accessors", position)?.get("count").and_then(index);
        let count = count.ok_or_else(|| missing("POSITION's count"))?;
        let gathers = surface.is_split() || 2 * self.vertices.len() < count;
        if !gathers {
            self = self.among(count);
        }
        let new = match attribute {
            VertexAttribute::Ao => document
                .push_floats(&self.visibility.iter().map(|&value| [value]).collect::<Vec<_>>(), name)?,
            VertexAttribute::Color | VertexAttribute::MultipliedColor => {
                let colours = self.colours(document, before, attribute, buffers)?;
                document.push_colours(&colours, name)?
            }
        };
        if gathers {
            // What is replaced need not be gathered.
            if let Some(Value::Object(attributes)) = changed.get_mut("attributes") {
                attributes.shift_remove(attribute.name());
            }
            split(document, &mut changed, &self.vertices, buffers, name)?;
            let indices = document.push_indices(surface.triangles.as_flattened(), name)?;
            changed.insert("indices".into(), indices.into());
        } else {
            decompress(&mut changed);
        }
        if let Some(Value::Object(attributes)) = changed.get_mut("attributes") {
            attributes.insert(attribute.name().into(), new.into());
        }
        Ok(changed)
    }

    /// Their colours; `before` is the accessor of those that were there.
    fn colours(
        &self,
        document: &Document,
        before: Option<usize>,
        attribute: VertexAttribute,
        buffers: &Buffers,
    ) -> Result<Vec<[f32; 4]>, DocumentError> {
        let before =
            before.map(|accessor| Ok((accessor, document.colours(accessor, buffers)?))).transpose()?;
        let colour = |(&vertex, &value): (&u32, &f32)| {
            let had = match &before {
                None => [1.0; 4],
                Some((accessor, colours)) => colours.get(vertex).ok_or_else(|| {
                    DocumentError::Missing(format!("vertex {vertex} of accessors/{accessor}"))
                })?,
            };
            let [red, green, blue, alpha] = had;
            Ok(match attribute {
                VertexAttribute::MultipliedColor => [value * red, value * green, value * blue, alpha],
                _ => [value, value, value, alpha],
            })
        };
        self.vertices.iter().zip(&self.visibility).map(colour).collect()
    }
}

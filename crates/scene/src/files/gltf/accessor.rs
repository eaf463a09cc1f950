//! Accessors: typed reads of a glTF's data, sparse and quantised ones included.
//!
//! "glTF 2.0 Specification", sections 3.6.2 (accessors) and 3.11 (conversion of normalised integers);
//! `KHR_mesh_quantization` only allows more types where these are used.

use super::data::{Data, View, get};
use super::schema::SparseDef;
use crate::files::error::Fault;

/// Type of one component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn of_code(code: u32) -> Option<Self> {
        Some(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }
}

/// A list of vectors whose every element can be read.
pub(super) struct Accessor<'a> {
    /// Number of elements.
    pub count: usize,
    /// From the first element on; empty where the elements are zero.
    bytes: &'a [u8],
    stride: usize,
    component: Component,
    /// Components of an element.
    width: usize,
    normalized: bool,
    sparse: Option<Sparse<'a>>,
}

/// Elements that differ from the list below them, in ascending order.
struct Sparse<'a> {
    indices: Vec<u32>,
    values: &'a [u8],
}

impl<'a> Accessor<'a> {
    /// Accessor `index`, after every range has been checked; `asker` is who wants it.
    pub(super) fn new(data: &'a Data, index: usize, asker: &str) -> Result<Self, Fault> {
        let def = get(&data.root.accessors, index, "accessor", asker)?;
        let name = format!("accessor {index}");
        let component = Component::of_code(def.component_type).ok_or_else(|| {
            Fault::element(&name, format!("component type {} is not known", def.component_type))
        })?;
        let width = match def.kind.as_str() {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            other => return Err(Fault::element(&name, format!("type `{other}` cannot be used here"))),
        };
        let size = component.bytes() * width;
        let (bytes, stride) = match def.buffer_view {
            Some(view) => {
                let view = data.view(view, &name)?;
                let stride = view.stride.unwrap_or(size);
                (elements(view, def.byte_offset, stride, size, def.count, &name)?, stride)
            }
            None if def.count <= data.total_bytes() => (&[][..], size),
            None => {
                let reason = format!("{} elements without data, in so small a file", def.count);
                return Err(Fault::element(name, reason));
            }
        };
        let sparse = def.sparse.as_ref().map(|s| Sparse::new(data, s, size, def.count, &name)).transpose()?;
        Ok(Self { count: def.count, bytes, stride, component, width, normalized: def.normalized, sparse })
    }

    /// Refuses accessors of another width.
    pub(super) fn with_width(self, width: usize, index: usize, what: &str) -> Result<Self, Fault> {
        if self.width == width {
            return Ok(self);
        }
        let reason = format!("{what} needs {width} components, not {}", self.width);
        Err(Fault::element(format!("accessor {index}"), reason))
    }

    /// Bytes of one component of one element; `None` stands for zero.
    #[inline]
    fn raw(&self, element: usize, component: usize) -> Option<&[u8]> {
        let (size, within) = (self.component.bytes(), self.component.bytes() * component);
        if let Some(sparse) = &self.sparse
            && let Ok(i) = sparse.indices.binary_search(&(element as u32))
        {
            return sparse.values.get(i * size * self.width + within..)?.get(..size);
        }
        self.bytes.get(element * self.stride + within..)?.get(..size)
    }

    /// An element as floats; normalised integers become fractions, others keep their value.
    #[inline]
    pub(super) fn floats<const N: usize>(&self, element: usize) -> [f32; N] {
        let mut out = [0.0; N];
        for (i, value) in out.iter_mut().enumerate().take(self.width) {
            *value = self.raw(element, i).map_or(0.0, |raw| self.float(raw));
        }
        out
    }

    fn float(&self, raw: &[u8]) -> f32 {
        let (value, one) = match (self.component, raw) {
            (Component::I8, &[a]) => (f32::from(a as i8), 127.0),
            (Component::U8, &[a]) => (f32::from(a), 255.0),
            (Component::I16, &[a, b]) => (f32::from(i16::from_le_bytes([a, b])), 32767.0),
            (Component::U16, &[a, b]) => (f32::from(u16::from_le_bytes([a, b])), 65535.0),
            (Component::U32, &[a, b, c, d]) => (u32::from_le_bytes([a, b, c, d]) as f32, u32::MAX as f32),
            (Component::F32, &[a, b, c, d]) => return f32::from_le_bytes([a, b, c, d]),
            _ => return 0.0,
        };
        if self.normalized { (value / one).max(-1.0) } else { value }
    }

    /// An element of one component as an index; `None` where the type is not an unsigned integer.
    #[inline]
    pub(super) fn unsigned(&self, element: usize) -> Option<u32> {
        let Some(raw) = self.raw(element, 0) else { return Some(0) };
        match (self.component, raw) {
            (Component::U8, &[a]) => Some(u32::from(a)),
            (Component::U16, &[a, b]) => Some(u32::from(u16::from_le_bytes([a, b]))),
            (Component::U32, &[a, b, c, d]) => Some(u32::from_le_bytes([a, b, c, d])),
            _ => None,
        }
    }
}

/// The part of a view that `count` elements cover.
fn elements<'a>(
    view: View<'a>,
    offset: usize,
    stride: usize,
    size: usize,
    count: usize,
    name: &str,
) -> Result<&'a [u8], Fault> {
    let Some(last) = count.checked_sub(1) else { return Ok(&[]) };
    let end = last.checked_mul(stride).and_then(|at| at.checked_add(size)?.checked_add(offset));
    match end {
        Some(end) if end <= view.bytes.len() => Ok(&view.bytes[offset..end]),
        _ => {
            let there = view.bytes.len();
            let reason = format!("{count} elements do not fit into its buffer view of {there} bytes");
            Err(Fault::element(name, reason))
        }
    }
}

impl<'a> Sparse<'a> {
    fn new(
        data: &'a Data,
        def: &SparseDef,
        size: usize,
        elements_below: usize,
        name: &str,
    ) -> Result<Self, Fault> {
        let kind = Component::of_code(def.indices.component_type)
            .filter(|c| matches!(c, Component::U8 | Component::U16 | Component::U32))
            .ok_or_else(|| Fault::element(name, "its sparse indices are of an unknown type"))?;
        let raw = elements(
            View { stride: None, ..data.view(def.indices.buffer_view, name)? },
            def.indices.byte_offset,
            kind.bytes(),
            kind.bytes(),
            def.count,
            name,
        )?;
        let index = |raw: &[u8]| raw.iter().rev().fold(0u32, |value, &byte| value << 8 | u32::from(byte));
        let indices: Vec<u32> = raw.chunks_exact(kind.bytes()).map(index).collect();
        if indices.windows(2).any(|w| w[0] >= w[1]) {
            return Err(Fault::element(name, "its sparse indices do not ascend"));
        }
        if let Some(last) = indices.last().filter(|last| **last as usize >= elements_below) {
            let reason = format!("sparse index {last} is out of range (there are {elements_below} elements)");
            return Err(Fault::element(name, reason));
        }
        let view = View { stride: None, ..data.view(def.values.buffer_view, name)? };
        let values = elements(view, def.values.byte_offset, size, size, def.count, name)?;
        Ok(Self { indices, values })
    }
}

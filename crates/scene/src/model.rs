//! A scene and what was found wrong with it.

use conray_core::{Geometry, Vec3, View};
use std::fmt;

/// Geometry with its views and the defects found on the way.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// File stem or name of the built-in.
    pub name: String,
    /// All that occludes, in world units.
    pub geometry: Geometry,
    /// Named views: cameras of the file or of the built-in scene, in order, then those known for the file; may be empty.
    pub views: Vec<View>,
    /// What was mended or ignored; never what made the scene unusable.
    pub warnings: Vec<Warning>,
    /// Where each instance stands in a glTF document, in the order of the instances; empty for other scenes.
    pub origins: Vec<Origin>,
    /// For each mesh of a glTF scene the vertices of the document's accessors that its vertices are, in order; empty for other scenes.
    pub sources: Vec<Vec<u32>>,
}

/// The place in a glTF document that an instance comes from, by indices of the document.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Origin {
    /// The node that places it.
    pub node: u32,
    /// Which of the node's copies it is, where an extension places several; else 0.
    pub copy: u32,
    /// The mesh of the node.
    pub mesh: u32,
    /// The primitive of that mesh.
    pub primitive: u32,
}

/// Something odd that did not stop the work.
#[derive(Clone, Debug, PartialEq)]
pub struct Warning {
    /// What kind of oddity.
    pub kind: WarningKind,
    /// How often it was met.
    pub count: u64,
    /// One instance of it: a name, a line, a path.
    pub example: String,
}

/// Kinds of oddity, each with a fixed message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum WarningKind {
    /// Triangles of zero area: they occlude nothing.
    DegenerateTriangles,
    /// Triangles with the same three corners as another.
    DuplicateTriangles,
    /// A material file that could not be read: all its surfaces are opaque.
    MissingMaterialFile,
    /// A material that a face names but no file defines: opaque.
    MissingMaterial,
    /// A texture that could not be read: its surfaces are opaque.
    MissingTexture,
    /// A normal map that could not be read: normals stay those of the shading.
    MissingNormalMap,
    /// Normals that are zero or not finite: replaced by the triangle's own.
    BadNormals,
    /// Triangles whose winding disagrees with their vertex normals.
    FlippedTriangles,
    /// Vertices that no triangle uses.
    UnusedVertices,
    /// Primitives that have no area (points, lines): ignored.
    IgnoredPrimitives,
    /// Faces with fewer than three different corners: ignored.
    IgnoredFaces,
    /// Something in the file that conray does not read and does not need.
    IgnoredFeature,
}

impl fmt::Display for WarningKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::DegenerateTriangles => "triangles of zero area, which occlude nothing",
            Self::DuplicateTriangles => "duplicate triangles",
            Self::MissingMaterialFile => "material files that could not be read; their surfaces are opaque",
            Self::MissingMaterial => "materials that no file defines; their surfaces are opaque",
            Self::MissingTexture => "textures that could not be read; their surfaces are opaque",
            Self::MissingNormalMap => {
                "normal maps that could not be read; normals stay those of the vertices"
            }
            Self::BadNormals => "normals of no length, replaced by those of the triangles",
            Self::FlippedTriangles => "triangles whose winding disagrees with their normals",
            Self::UnusedVertices => "vertices that no triangle uses",
            Self::IgnoredPrimitives => "points and lines, ignored",
            Self::IgnoredFaces => "faces with fewer than three corners, ignored",
            Self::IgnoredFeature => "features that are not read",
        })
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {} (such as {})", self.count, self.kind, self.example)
    }
}

impl Scene {
    /// Counts one more oddity; the first example is kept.
    pub fn warn(&mut self, kind: WarningKind, count: u64, example: impl Into<String>) {
        if count == 0 {
            return;
        }
        match self.warnings.iter_mut().find(|w| w.kind == kind) {
            Some(warning) => warning.count += count,
            None => self.warnings.push(Warning { kind, count, example: example.into() }),
        }
    }

    /// The view of that name.
    pub fn view(&self, name: &str) -> Option<&View> {
        self.views.iter().find(|view| view.name == name)
    }

    /// The first named view, or one that shows the whole scene from the front, above and to the right.
    pub fn default_view(&self) -> View {
        self.views.first().cloned().unwrap_or_else(|| self.whole_view())
    }

    /// A view of the whole scene from the front, above and to the right.
    pub fn whole_view(&self) -> View {
        let (bounds, vertical_fov_deg) = (self.geometry.bounds(), 40.0f32);
        let centre = bounds.centre();
        // The bounding sphere fits the picture's height.
        let distance = 0.5 * bounds.diagonal() / (0.5 * vertical_fov_deg.to_radians()).sin();
        View {
            name: "whole".into(),
            eye: centre + distance * Vec3::new(0.48, 0.36, 0.8),
            look_at: centre,
            up: Vec3::Y,
            vertical_fov_deg,
        }
    }
}

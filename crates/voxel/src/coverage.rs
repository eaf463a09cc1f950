//! How much of a leaf's three faces a piece of a triangle covers.

use crate::clip::{CellClipper, Polygon};
use conray_core::{Geometry, Opacity, TextureOpacity, Vec2};
use glam::{DVec2, DVec3, IVec3};
use rayon::prelude::*;

/// Most sample points along an edge of a triangle.
const MOST_ROWS: f64 = 4.0;

/// A triangle in leaf units with its opacity.
pub(crate) struct CoverageTriangle<'a> {
    /// The cell that holds all of it, if one does, and its coverage there.
    whole: Option<(IVec3, DVec3)>,
    clipper: CellClipper,
    opacity: PieceOpacity<'a>,
}

enum PieceOpacity<'a> {
    Constant(f64),
    Texture(TexturedTriangle<'a>),
}

struct TexturedTriangle<'a> {
    texture: &'a TextureOpacity,
    uvs: [Vec2; 3],
    corner: DVec3,
    /// `(p - corner) . u_of` is the barycentric weight of corner 1, and so on.
    u_of: DVec3,
    v_of: DVec3,
    /// Texels in a unit of leaf area.
    texels_per_area: f64,
}

impl<'a> CoverageTriangle<'a> {
    /// Triangle `triangle` of mesh `mesh` with its corners in leaf units; cells come in the order of `axes`.
    pub(crate) fn new(
        geometry: &'a Geometry,
        means: &MaskMeans,
        mesh: usize,
        triangle: usize,
        corners: [DVec3; 3],
        axes: [usize; 3],
    ) -> Self {
        let [a, b, c] = corners;
        let (home, last) = (a.min(b).min(c).floor(), a.max(b).max(c).floor());
        let whole = (home == last).then(|| {
            let area = (0.5 * (b - a).cross(c - a)).abs();
            (home.as_ivec3(), area * means.of_triangle(geometry, mesh, triangle))
        });
        let opacity = match geometry.opacity(mesh) {
            Opacity::Texture(texture) if whole.is_none() => {
                let uvs = geometry.meshes()[mesh].corner_uvs(triangle, texture.uv_set);
                PieceOpacity::Texture(TexturedTriangle::new(texture, uvs, corners))
            }
            Opacity::Texture(_) => PieceOpacity::Constant(1.0),
            Opacity::Constant(a) => PieceOpacity::Constant(f64::from(*a).clamp(0.0, 1.0)),
        };
        Self { whole, clipper: CellClipper::new(corners, axes), opacity }
    }

    /// Coverage of the faces across x, y and z of the cell by the triangle's piece inside it, each in [0, sqrt 2].
    #[inline]
    pub(crate) fn in_cell(&mut self, cell: IVec3) -> DVec3 {
        if let Some((home, coverage)) = self.whole {
            return if cell == home { coverage } else { DVec3::ZERO };
        }
        let piece = self.clipper.in_cell(cell);
        let area = piece.area_vector();
        if area == DVec3::ZERO {
            return DVec3::ZERO;
        }
        let opacity = match &self.opacity {
            PieceOpacity::Constant(a) => *a,
            PieceOpacity::Texture(textured) => textured.mean(piece, area.length()),
        };
        area.abs() * opacity
    }
}

impl<'a> TexturedTriangle<'a> {
    fn new(texture: &'a TextureOpacity, uvs: [Vec2; 3], [a, b, c]: [DVec3; 3]) -> Self {
        let (e1, e2) = (b - a, c - a);
        let normal = e1.cross(e2);
        let inverse = 1.0 / normal.length_squared().max(f64::MIN_POSITIVE);
        let (u_of, v_of) = (e2.cross(normal) * inverse, normal.cross(e1) * inverse);
        let texels = texel_area(texture, uvs);
        let texels_per_area = texels / (0.5 * normal.length()).max(f64::MIN_POSITIVE);
        Self { texture, uvs, corner: a, u_of, v_of, texels_per_area }
    }

    fn at(&self, point: DVec3) -> f64 {
        let p = point - self.corner;
        let u = p.dot(self.u_of).clamp(0.0, 1.0);
        let v = p.dot(self.v_of).clamp(0.0, 1.0 - u);
        f64::from(at_weights(self.texture, self.uvs, u as f32, v as f32))
    }

    /// Mean opacity over a piece: about a sample per texel, at most [`MOST_ROWS`] squared per triangle of its fan.
    fn mean(&self, piece: &Polygon, area: f64) -> f64 {
        if area * self.texels_per_area <= 1.0 {
            return self.at(piece.middle());
        }
        let (mut sum, mut weight) = (0.0, 0.0);
        for [a, b, c] in piece.fan() {
            let (e1, e2) = (b - a, c - a);
            let share = 0.5 * e1.cross(e2).length();
            let rows = (share * self.texels_per_area).sqrt().ceil().clamp(1.0, MOST_ROWS);
            sum += share * mean_over_triangle(rows, |s, t| self.at(a + e1 * s + e2 * t));
            weight += share;
        }
        if weight > 0.0 { sum / weight } else { 0.0 }
    }
}

/// Mean of a function of barycentric weights, at the centroids of the small triangles into which lines parallel to the edges
/// cut a triangle.
fn mean_over_triangle(rows: f64, mut at: impl FnMut(f64, f64) -> f64) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    let whole_rows = rows as u32;
    for i in 0..whole_rows {
        for j in 0..whole_rows - i {
            let turned = if i + j + 1 < whole_rows { 2 } else { 1 };
            for third in 1..=turned {
                let third = f64::from(third) / 3.0;
                sum += at((f64::from(i) + third) / rows, (f64::from(j) + third) / rows);
                count += 1.0;
            }
        }
    }
    sum / count
}

/// Mean opacities of the triangles of textured meshes: a triangle that one cell holds is looked up once, however often it
/// is placed.
pub(crate) struct MaskMeans {
    /// By mesh; empty where opacity is constant.
    means: Vec<Vec<f32>>,
}

impl MaskMeans {
    pub(crate) fn new(geometry: &Geometry) -> Self {
        let of_mesh = |mesh: usize| -> Vec<f32> {
            let Opacity::Texture(texture) = geometry.opacity(mesh) else { return Vec::new() };
            let count = geometry.meshes()[mesh].triangles().len();
            let mean = |triangle: usize| {
                let uvs = geometry.meshes()[mesh].corner_uvs(triangle, texture.uv_set);
                let rows = texel_area(texture, uvs).sqrt().ceil().clamp(1.0, MOST_ROWS);
                let at = |u: f64, v: f64| f64::from(at_weights(texture, uvs, u as f32, v as f32));
                mean_over_triangle(rows, at) as f32
            };
            (0..count).into_par_iter().map(mean).collect()
        };
        Self { means: (0..geometry.meshes().len()).map(of_mesh).collect() }
    }

    fn of_triangle(&self, geometry: &Geometry, mesh: usize, triangle: usize) -> f64 {
        match geometry.opacity(mesh) {
            Opacity::Constant(a) => f64::from(*a).clamp(0.0, 1.0),
            Opacity::Texture(_) => f64::from(self.means[mesh][triangle]),
        }
    }

    /// Bytes for a geometry.
    pub(crate) fn bytes_for(geometry: &Geometry) -> u64 {
        let textured = (0..geometry.meshes().len())
            .filter(|&mesh| !matches!(geometry.opacity(mesh), Opacity::Constant(_)));
        textured.map(|mesh| geometry.meshes()[mesh].triangles().len() as u64 * size_of::<f32>() as u64).sum()
    }
}

/// Opacity at barycentric weights `u` of corner 1 and `v` of corner 2.
#[inline]
fn at_weights(texture: &TextureOpacity, [a, b, c]: [Vec2; 3], u: f32, v: f32) -> f32 {
    texture.at(a * (1.0 - u - v) + b * u + c * v)
}

/// Area of a triangle in texels of its opacity's texture.
fn texel_area(texture: &TextureOpacity, uvs: [Vec2; 3]) -> f64 {
    let size = DVec2::new(f64::from(texture.texture.width()), f64::from(texture.texture.height()));
    let [a, b, c] = uvs.map(|uv| texture.texture_from_uv.transform_point2(uv).as_dvec2() * size);
    let texels = 0.5 * (b - a).perp_dot(c - a).abs();
    // Nonsense coordinates count as coarse.
    if texels.is_finite() { texels } else { 0.0 }
}

//! How much of a leaf's three faces a piece of a triangle covers.

use crate::clip::{CellClipper, Polygon};
use conray_core::{Geometry, Opacity};
use glam::{DVec2, DVec3, IVec3};

/// Most sample points along an edge of a piece's triangles.
const MOST_ROWS: f64 = 4.0;

/// A triangle in leaf units with its opacity.
pub(crate) struct CoverageTriangle<'a> {
    clipper: CellClipper,
    opacity: PieceOpacity<'a>,
}

enum PieceOpacity<'a> {
    Constant(f64),
    Texture(TexturedTriangle<'a>),
}

struct TexturedTriangle<'a> {
    geometry: &'a Geometry,
    mesh: usize,
    triangle: usize,
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
        mesh: usize,
        triangle: usize,
        corners: [DVec3; 3],
        axes: [usize; 3],
    ) -> Self {
        let opacity = match geometry.opacity(mesh) {
            Opacity::Constant(a) => PieceOpacity::Constant(f64::from(*a).clamp(0.0, 1.0)),
            Opacity::Texture(_) => {
                PieceOpacity::Texture(TexturedTriangle::new(geometry, mesh, triangle, corners))
            }
        };
        Self { clipper: CellClipper::new(corners, axes), opacity }
    }

    /// Coverage of the faces across x, y and z of the cell by the triangle's piece inside it, each in [0, sqrt 2].
    #[inline]
    pub(crate) fn in_cell(&mut self, cell: IVec3) -> DVec3 {
        let piece = self.clipper.in_cell(cell);
        self.of_piece(&piece)
    }

    fn of_piece(&self, piece: &Polygon) -> DVec3 {
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
    fn new(geometry: &'a Geometry, mesh: usize, triangle: usize, [a, b, c]: [DVec3; 3]) -> Self {
        let (e1, e2) = (b - a, c - a);
        let normal = e1.cross(e2);
        let inverse = 1.0 / normal.length_squared().max(f64::MIN_POSITIVE);
        let (u_of, v_of) = (e2.cross(normal) * inverse, normal.cross(e1) * inverse);
        let texels = texel_area(geometry, mesh, triangle);
        let texels_per_area = texels / (0.5 * normal.length()).max(f64::MIN_POSITIVE);
        Self { geometry, mesh, triangle, corner: a, u_of, v_of, texels_per_area }
    }

    fn at(&self, point: DVec3) -> f64 {
        let p = point - self.corner;
        let u = p.dot(self.u_of).clamp(0.0, 1.0);
        let v = p.dot(self.v_of).clamp(0.0, 1.0 - u);
        f64::from(self.geometry.opacity_at(self.mesh, self.triangle, u as f32, v as f32))
    }

    /// Mean opacity over a piece: about a sample per texel, at most [`MOST_ROWS`] squared per triangle of its fan.
    fn mean(&self, piece: &Polygon, area: f64) -> f64 {
        let rows = (area * self.texels_per_area).sqrt().ceil().clamp(1.0, MOST_ROWS);
        if rows <= 1.0 {
            return self.at(piece.middle());
        }
        let (mut sum, mut weight) = (0.0, 0.0);
        for [a, b, c] in piece.fan() {
            let (e1, e2) = (b - a, c - a);
            let share = e1.cross(e2).length();
            // Centroids of the small triangles into which lines parallel to the edges cut it.
            let rows_u = rows as u32;
            for i in 0..rows_u {
                for j in 0..rows_u - i {
                    let turned = if i + j + 1 < rows_u { 2 } else { 1 };
                    for third in 1..=turned {
                        let third = f64::from(third) / 3.0;
                        let (s, t) = ((f64::from(i) + third) / rows, (f64::from(j) + third) / rows);
                        sum += share * self.at(a + e1 * s + e2 * t);
                        weight += share;
                    }
                }
            }
        }
        if weight > 0.0 { sum / weight } else { 0.0 }
    }
}

/// Area of a triangle in texels of its opacity's texture.
fn texel_area(geometry: &Geometry, mesh: usize, triangle: usize) -> f64 {
    let Opacity::Texture(opacity) = geometry.opacity(mesh) else { return 0.0 };
    let size = DVec2::new(f64::from(opacity.texture.width()), f64::from(opacity.texture.height()));
    let [a, b, c] = geometry.meshes()[mesh]
        .corner_uvs(triangle, opacity.uv_set)
        .map(|uv| opacity.texture_from_uv.transform_point2(uv).as_dvec2() * size);
    let texels = 0.5 * (b - a).perp_dot(c - a).abs();
    // Nonsense coordinates count as coarse.
    if texels.is_finite() { texels } else { 0.0 }
}

//! Seams: edges at which a smooth surface is cut in the map, so that its two sides are read from different texels.

use super::{map::AtlasMap, texels::Surface};
use conray_core::{Vec2, Vec3};
use rayon::prelude::*;
use std::collections::HashMap;

/// Normals on both sides of a seam have at least this cosine; less is a hard edge, at which values may jump.
const SMOOTH_COSINE: f32 = 0.98;
/// UVs that differ by less than this in both directions are the same.
const SAME_UV: f32 = 1e-6;

/// One side of a seam: where it is read, at both ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeamSide {
    /// Which map.
    pub map: usize,
    /// UVs at the ends.
    pub uvs: [Vec2; 2],
}

/// An edge of the surface, and how it is read from its two sides; the ends in the same order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seam {
    /// The sides.
    pub sides: [SeamSide; 2],
}

impl Seam {
    /// Its length in texels, on the side where it is longer.
    pub(super) fn texels(&self, maps: &[AtlasMap]) -> f32 {
        let of = |side: &SeamSide| {
            let map = &maps[side.map];
            ((side.uvs[1] - side.uvs[0]) * Vec2::new(map.width as f32, map.height as f32)).length()
        };
        self.sides.iter().map(of).fold(0.0, f32::max)
    }
}

/// A corner of a triangle in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner {
    /// Position; edges are the same where both ends are, to the bit.
    pub position: Vec3,
    /// Shading normal.
    pub normal: Vec3,
}

/// An edge of a triangle as one side sees it.
#[derive(Clone, Copy)]
struct Edge {
    side: SeamSide,
    normals: [Vec3; 2],
}

/// Ends of an edge, by the bits of their positions, the lesser first.
type Ends = [[u32; 3]; 2];

/// The seams of surfaces, in the order of their triangles. `corners(surface, triangle)` are those of a triangle.
pub fn seams(surfaces: &[Surface], corners: impl Fn(usize, usize) -> [Corner; 3] + Sync) -> Vec<Seam> {
    let edges_of = |(s, surface): (usize, &Surface)| {
        let of_triangle = |(triangle, uvs): (usize, &[Vec2; 3])| {
            let of = corners(s, triangle);
            [0, 1, 2].map(|k| edge(surface.map, [of[k], of[(k + 1) % 3]], [uvs[k], uvs[(k + 1) % 3]]))
        };
        surface.uvs.iter().enumerate().flat_map(of_triangle).collect::<Vec<_>>()
    };
    let edges: Vec<Vec<(Ends, Edge)>> = surfaces.par_iter().enumerate().map(edges_of).collect();
    let mut open: HashMap<Ends, Vec<Edge>> = HashMap::new();
    let mut found = Vec::new();
    for (ends, edge) in edges.into_iter().flatten() {
        let met = open.entry(ends).or_default();
        let meets = |other: &Edge| (0..2).all(|k| other.normals[k].dot(edge.normals[k]) >= SMOOTH_COSINE);
        match met.iter().position(meets) {
            Some(at) => {
                let other = met.swap_remove(at);
                if is_cut(&other.side, &edge.side) {
                    found.push(Seam { sides: [other.side, edge.side] });
                }
            }
            None => met.push(edge),
        }
    }
    found
}

fn edge(map: usize, corners: [Corner; 2], uvs: [Vec2; 2]) -> (Ends, Edge) {
    // Zero is the same with either sign.
    let bits = |corner: Corner| (corner.position + 0.0).to_array().map(f32::to_bits);
    let ([a, b], [u, v], normals) = (corners.map(bits), uvs, corners.map(|corner| corner.normal));
    if a <= b {
        ([a, b], Edge { side: SeamSide { map, uvs: [u, v] }, normals })
    } else {
        ([b, a], Edge { side: SeamSide { map, uvs: [v, u] }, normals: [normals[1], normals[0]] })
    }
}

fn is_cut(a: &SeamSide, b: &SeamSide) -> bool {
    a.map != b.map || (0..2).any(|k| (a.uvs[k] - b.uvs[k]).abs().max_element() > SAME_UV)
}

/// How far the two sides of seams are apart in finished maps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SeamReport {
    /// Places that were compared: along each seam one a texel, both ends among them.
    pub places: u64,
    /// Places at which the sides differ by at most the bound.
    pub within: u64,
    /// Root mean square difference.
    pub rms: f64,
    /// Largest difference.
    pub worst: f32,
}

impl SeamReport {
    /// Compares the visibility on both sides of seams, read as a renderer does.
    pub fn of(seams: &[Seam], maps: &[AtlasMap], bound: f32) -> Self {
        let mut report = Self::default();
        let mut squares = 0.0;
        for seam in seams {
            let steps = seam.texels(maps).max(1.0).ceil();
            for step in 0..=steps as u32 {
                let share = step as f32 / steps;
                let [a, b] = seam.sides.map(|side| maps[side.map].read(side.uvs[0].lerp(side.uvs[1], share)));
                let difference = (a - b).abs();
                report.places += 1;
                report.within += u64::from(difference <= bound);
                squares += f64::from(difference).powi(2);
                report.worst = report.worst.max(difference);
            }
        }
        report.rms = (squares / report.places.max(1) as f64).sqrt();
        report
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two triangles of a square in the plane z = 0, apart in the map, with these normals.
    fn cut(second: Vec3, gap: f32) -> Vec<Seam> {
        let [a, b, c, d] = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| Vec2::new(x, y));
        let uv = |corner: Vec2| 0.4 * corner + 0.05;
        let moved = |corner: Vec2| uv(corner) + gap;
        let surface = Surface { map: 0, uvs: vec![[a, b, c].map(uv), [c, d, a].map(moved)] };
        let places = [[a, b, c], [c, d, a]];
        seams(&[surface], |_, triangle| {
            let normal = if triangle == 0 { Vec3::Z } else { second };
            places[triangle].map(|place| Corner { position: place.extend(0.0), normal })
        })
    }

    #[test]
    fn an_edge_that_is_cut_in_the_map_is_a_seam_unless_it_is_hard() {
        let found = cut(Vec3::Z, 0.5);
        assert_eq!(found.len(), 1);
        let [one, other] = found[0].sides.map(|side| side.uvs);
        assert!((0..2).all(|k| (other[k] - one[k] - 0.5).abs().max_element() < 1e-6), "{one:?} {other:?}");
        assert!(cut(Vec3::Z, 0.0).is_empty(), "whole in the map");
        assert!(cut(Vec3::X, 0.5).is_empty(), "a hard edge");
    }

    #[test]
    fn sides_are_compared_along_the_whole_seam() {
        let mut map = AtlasMap::empty(32, 32);
        for at in 0..32 * 32 {
            // The second side lies half a map to the right and below: it reads 0.03 more.
            map.visibility[at] = if at % 32 + at / 32 > 30 { 0.53 } else { 0.5 };
        }
        let seams = cut(Vec3::Z, 0.5);
        let report = SeamReport::of(&seams, std::slice::from_ref(&map), 0.02);
        assert!(report.places > 15 && report.within < report.places / 2, "{report:?}");
        assert!((report.worst - 0.03).abs() < 1e-6);
        let report = SeamReport::of(&seams, &[map], 0.04);
        assert_eq!(report.within, report.places);
    }
}

//! Meshes of simple shapes.

use super::Random;
use conray_core::{TriangleMesh, Vec3};
use std::collections::HashMap;

pub(crate) fn mesh(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> TriangleMesh {
    TriangleMesh::new(positions, triangles).unwrap()
}

/// A parallelogram from a corner along two edges.
pub(crate) fn quad(corner: Vec3, x: Vec3, y: Vec3) -> TriangleMesh {
    mesh(vec![corner, corner + x, corner + y, corner + x + y], vec![[0, 1, 2], [1, 3, 2]])
}

/// A square of half edge `half` at height `h` over the origin.
pub(crate) fn ceiling(h: f32, half: f32) -> TriangleMesh {
    quad(Vec3::new(-half, -half, h), 2.0 * half * Vec3::X, 2.0 * half * Vec3::Y)
}

/// A disc at height `h`, as a fan of `n` triangles of the same area.
pub(crate) fn disc(h: f32, radius: f32, n: u32) -> TriangleMesh {
    let step = std::f64::consts::TAU / f64::from(n);
    let radius = f64::from(radius) * (step / step.sin()).sqrt();
    let rim = |i: u32| {
        let (sin, cos) = (step * f64::from(i)).sin_cos();
        Vec3::new((radius * cos) as f32, (radius * sin) as f32, h)
    };
    let positions = (0..n).map(rim).chain([Vec3::new(0.0, 0.0, h)]).collect();
    mesh(positions, (0..n).map(|i| [n, i, (i + 1) % n]).collect())
}

/// A closed unit sphere: an icosahedron, split `levels` times.
pub(crate) fn icosphere(levels: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let p = 0.5 * (1.0 + 5f32.sqrt());
    let corners = [(-1.0, p), (1.0, p), (-1.0, -p), (1.0, -p)];
    let mut positions: Vec<Vec3> = corners.iter().map(|&(a, b)| Vec3::new(a, b, 0.0)).collect();
    positions.extend(corners.iter().map(|&(a, b)| Vec3::new(0.0, a, b)));
    positions.extend(corners.iter().map(|&(a, b)| Vec3::new(b, 0.0, a)));
    positions.iter_mut().for_each(|v| *v = v.normalize());
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    // The faces are the triples of mutually nearest corners, wound to face outward.
    let near = |a: Vec3, b: Vec3| a.distance(b) < 1.1;
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                let [a, b, c] = [i, j, k].map(|n| positions[n]);
                if near(a, b) && near(b, c) && near(c, a) {
                    let outward = (b - a).cross(c - a).dot(a) > 0.0;
                    let [i, j, k] = [i, j, k].map(|n| n as u32);
                    triangles.push(if outward { [i, j, k] } else { [i, k, j] });
                }
            }
        }
    }
    assert_eq!(triangles.len(), 20);
    for _ in 0..levels {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32, positions: &mut Vec<Vec3>| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                positions.push((positions[a as usize] + positions[b as usize]).normalize());
                positions.len() as u32 - 1
            })
        };
        let split = |[a, b, c]: [u32; 3]| {
            let (ab, bc, ca) =
                (middle(a, b, &mut positions), middle(b, c, &mut positions), middle(c, a, &mut positions));
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        triangles = triangles.into_iter().flat_map(split).collect();
    }
    (positions, triangles)
}

/// A sphere of some triangles about a centre.
pub(crate) fn sphere(levels: u32, centre: Vec3, radius: f32) -> TriangleMesh {
    let (positions, triangles) = icosphere(levels);
    mesh(positions.into_iter().map(|p| centre + radius * p).collect(), triangles)
}

/// The cube [-1, 1]^3: corners by bits of x, y, z; outward winding.
pub(crate) fn cube() -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let sign = |i: u32, bit: u32| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
    let positions = (0..8).map(|i| Vec3::new(sign(i, 0), sign(i, 1), sign(i, 2))).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    (positions, quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect())
}

/// Random triangles of very different sizes in the cube `centre` +- `scale`; one in eight is degenerate.
pub(crate) fn soup(n: u32, centre: Vec3, scale: f32, random: &mut Random) -> TriangleMesh {
    let mut positions = Vec::new();
    for i in 0..n {
        let at = random.cube();
        let size = 10f32.powf(-2.0 * random.unit());
        let (a, b, mut c) = (at, at + size * random.cube(), at + size * random.cube());
        match i % 16 {
            3 => c = a,
            7 => c = 0.5 * (a + b),
            _ => {}
        }
        positions.extend([a, b, c].map(|p| centre + scale * p));
    }
    mesh(positions, (0..n).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
}

//! What every built-in part must satisfy, for the tests.

use super::faces::{Faces, face_normal};
use super::part::{Part, position_key};
use conray_core::Vec3;
use std::collections::{HashMap, HashSet};

/// Six times the signed volume under each triangle, summed, over six (the divergence theorem).
pub(crate) fn volume(faces: &Faces) -> f32 {
    let six_fold: f64 = faces
        .triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|c| c.position.as_dvec3());
            a.dot(b.cross(c))
        })
        .sum();
    (six_fold / 6.0) as f32
}

/// Number of edges that are not walked exactly as often one way as the other.
pub(crate) fn open_edges(part: &Part) -> usize {
    let mut balance: HashMap<([u32; 3], [u32; 3]), i32> = HashMap::new();
    for t in &part.triangles {
        let p = t.map(|v| position_key(part.positions[v as usize]));
        for k in 0..3 {
            let (a, b) = (p[k], p[(k + 1) % 3]);
            let (key, sign) = if a < b { ((a, b), 1) } else { ((b, a), -1) };
            *balance.entry(key).or_default() += sign;
        }
    }
    balance.values().filter(|&&sum| sum != 0).count()
}

/// Fails unless the part bounds a solid: no open edges.
#[track_caller]
pub(crate) fn assert_closed(part: &Part, what: &str) {
    assert!(!part.triangles.is_empty(), "{what} is empty");
    assert_eq!(open_edges(part), 0, "{what} is not closed");
}

/// What is wrong with a part's triangles: degenerate, doubled, or with normals that are not unit or against the winding.
pub(crate) fn defects(part: &Part) -> Vec<String> {
    let mut found = Vec::new();
    let mut seen = HashSet::new();
    if part.normals.iter().any(|n| (n.length() - 1.0).abs() > 1e-4) {
        found.push("normals that are not unit".into());
    }
    for (i, t) in part.triangles.iter().enumerate() {
        let p = t.map(|v| part.positions[v as usize]);
        let normal = face_normal(p);
        if normal == Vec3::ZERO || slenderness(p) < 1e-5 {
            found.push(format!("triangle {i} is degenerate: {p:?}"));
        } else if t.iter().any(|&v| part.normals[v as usize].dot(normal) <= 0.0) {
            found.push(format!("triangle {i} is wound against its normals: {p:?}"));
        }
        let mut keys = p.map(position_key);
        keys.sort_unstable();
        if !seen.insert(keys) {
            found.push(format!("triangle {i} is a duplicate: {p:?}"));
        }
    }
    found
}

/// Height over the longest edge.
fn slenderness([a, b, c]: [Vec3; 3]) -> f64 {
    let [a, b, c] = [a, b, c].map(|p| p.as_dvec3());
    let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
    (b - a).cross(c - a).length() / longest
}

/// Fails where [`defects`] finds anything.
#[track_caller]
pub(crate) fn assert_sound(part: &Part, what: &str) {
    let found = defects(part);
    assert!(found.is_empty(), "{what}: {} defects, first {}", found.len(), found[0]);
}

mod tests {
    use super::*;
    use crate::builtin::shapes::cuboid;

    #[test]
    fn the_checks_find_what_is_wrong() {
        let whole = cuboid(Vec3::ZERO, Vec3::ONE);
        assert!(defects(&whole.flat()).is_empty());

        let mut holed = whole.clone();
        holed.triangles.pop();
        assert_eq!(open_edges(&holed.flat()), 3);

        let mut doubled = whole.clone();
        doubled.triangles.push(doubled.triangles[0]);
        assert_eq!(defects(&doubled.flat()).len(), 1);

        let mut flattened = whole.flat();
        flattened.positions[0] = flattened.positions[1];
        assert!(!defects(&flattened).is_empty());

        let mut inside_out = whole.flat();
        inside_out.normals.iter_mut().for_each(|n| *n = -*n);
        assert_eq!(defects(&inside_out).len(), 12);

        let mut long = whole.flat();
        long.normals[0] *= 2.0;
        assert_eq!(defects(&long).len(), 1);
        assert!((volume(&whole.flipped()) + 1.0).abs() < 1e-6, "an inside-out cube has negative volume");
    }
}

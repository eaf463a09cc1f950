//! Skins over rings of points, and what follows from them: swept profiles, mitred frames, tubes.

use crate::builtin::faces::{Corner, Faces, corner};
use conray_core::{Affine3A, Mat3A, Vec2, Vec3, Vec3A};
use std::f32::consts::TAU;

/// What becomes of the two ends of a loft.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ends {
    /// Left open: for rings that have shrunk to a point.
    Open,
    /// Closed by fans about the rings' centres, from which every point of the ring must be in sight.
    Capped,
    /// The last ring joins the first.
    Joined,
}

/// The skin over rings with equally many points, each ring closed and right-handed about the direction of the path.
///
/// u runs round the rings, v along the path, both from 0 to 1.
pub(crate) fn loft(rings: &[Vec<Vec3>], ends: Ends) -> Faces {
    let mut faces = Faces::default();
    let (Some(first), Some(last)) = (rings.first(), rings.last()) else { return faces };
    let points = first.len();
    let spans = if ends == Ends::Joined { rings.len() } else { rings.len() - 1 };
    let at = |ring: usize, i: usize| -> Corner {
        let position = rings[ring % rings.len()][i % points];
        corner(position, i as f32 / points as f32, ring as f32 / spans as f32)
    };
    for ring in 0..spans {
        for i in 0..points {
            faces.quad(at(ring, i), at(ring, i + 1), at(ring + 1, i + 1), at(ring + 1, i));
        }
    }
    if ends == Ends::Capped {
        let mut reversed = first.clone();
        reversed.reverse();
        fan(&mut faces, &reversed);
        fan(&mut faces, last);
    }
    faces
}

/// A polygon as a fan about the mean of its points.
fn fan(faces: &mut Faces, ring: &[Vec3]) {
    let centre = ring.iter().sum::<Vec3>() / ring.len() as f32;
    for i in 0..ring.len() {
        let (a, b) = (ring[i], ring[(i + 1) % ring.len()]);
        faces.triangle(corner(centre, 0.5, 0.5), corner(a, 0.0, 0.0), corner(b, 1.0, 0.0));
    }
}

/// The polygon, counter-clockwise.
fn counter_clockwise(profile: &[Vec2]) -> Vec<Vec2> {
    let doubled_area: f32 =
        (0..profile.len()).map(|i| profile[i].perp_dot(profile[(i + 1) % profile.len()])).sum();
    let mut polygon = profile.to_vec();
    if doubled_area < 0.0 {
        polygon.reverse();
    }
    polygon
}

/// A closed profile carried along frames: its x and y lie along each frame's x and y axes, and the path follows their z axes.
pub(crate) fn sweep(frames: &[Affine3A], profile: &[Vec2], ends: Ends) -> Faces {
    let profile = counter_clockwise(profile);
    let ring = |frame: &Affine3A| profile.iter().map(|p| frame.transform_point3(p.extend(0.0))).collect();
    let rings: Vec<Vec<Vec3>> = frames.iter().map(ring).collect();
    loft(&rings, ends)
}

/// A closed profile carried round a horizontal rectangle with mitred corners.
///
/// The rectangle reaches to plus and minus `half` in x and z; a profile point is (distance outside it, height).
pub(crate) fn mitred_ring(half: Vec2, profile: &[Vec2]) -> Faces {
    let profile = counter_clockwise(profile);
    let corners = [Vec2::ONE, Vec2::new(-1.0, 1.0), Vec2::NEG_ONE, Vec2::new(1.0, -1.0)];
    let ring = |sign: &Vec2| {
        profile.iter().map(|p| Vec3::new(sign.x * (half.x + p.x), p.y, sign.y * (half.y + p.x))).collect()
    };
    let rings: Vec<Vec<Vec3>> = corners.iter().map(ring).collect();
    loft(&rings, Ends::Joined)
}

/// A capped tube with `sides` sides through points of given radii (points differ, radii are positive).
///
/// Its frames are carried along without twist: each is the one before, turned by the least rotation.
pub(crate) fn tube(points: &[(Vec3, f32)], sides: usize) -> Faces {
    let circle: Vec<Vec2> = (0..sides).map(|i| Vec2::from_angle(TAU * i as f32 / sides as f32)).collect();
    let direction = |i: usize| {
        let (before, after) = (points[i.saturating_sub(1)].0, points[(i + 1).min(points.len() - 1)].0);
        (after - before).normalize_or(Vec3::Y)
    };
    let mut side = direction(0).any_orthonormal_vector();
    let frames: Vec<Affine3A> = points
        .iter()
        .enumerate()
        .map(|(i, &(centre, radius))| {
            let along = direction(i);
            side =
                side.reject_from_normalized(along).try_normalize().unwrap_or(along.any_orthonormal_vector());
            let axes = Mat3A::from_cols(
                Vec3A::from(radius * side),
                Vec3A::from(radius * along.cross(side)),
                Vec3A::from(along),
            );
            Affine3A { matrix3: axes, translation: centre.into() }
        })
        .collect();
    sweep(&frames, &circle, Ends::Capped)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin::checks::{assert_closed, volume};

    #[test]
    fn a_mitred_ring_is_closed_and_pappus_knows_its_volume() {
        let square = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
        for profile in [square.to_vec(), square.iter().rev().copied().collect()] {
            let ring = mitred_ring(Vec2::new(3.0, 2.0), &profile);
            assert_closed(&ring.flat(), "mitred ring");
            assert!((volume(&ring) - (8.0 * 6.0 - 6.0 * 4.0)).abs() < 1e-3);
        }
    }

    #[test]
    fn tubes_are_closed_whatever_way_they_turn() {
        let bent = [
            (Vec3::ZERO, 1.0),
            (Vec3::Y * 2.0, 1.0),
            (Vec3::new(2.0, 4.0, 0.0), 0.8),
            (Vec3::new(4.0, 4.0, 1.0), 0.2),
        ];
        assert_closed(&tube(&bent, 7).flat(), "bent tube");
        for direction in [Vec3::X, Vec3::NEG_Y, Vec3::new(1.0, -2.0, 0.5)] {
            let straight = tube(&[(Vec3::ZERO, 1.0), (direction, 1.0)], 64);
            let expected = direction.length() * 32.0 * (TAU / 64.0).sin();
            assert!((volume(&straight) - expected).abs() < 1e-3 * expected);
        }
    }
}

//! Polygons to triangles.

use conray_core::{Vec2, Vec3};

/// Concave polygons of more corners than this are fanned like convex ones: ear clipping takes time as the square.
const MAX_CLIPPED_CORNERS: usize = 1024;

/// After this many looks for an ear per corner any corner must do: only contrived polygons need more.
const MAX_LOOKS_PER_CORNER: usize = 16;

/// Cuts a polygon into `n - 2` triangles, given as positions in the list of its corners, in the polygon's sense.
///
/// Convex polygons become a fan about their first corner; concave ones are cut by ear clipping (Meisters, "Polygons
/// Have Ears", 1975) in the plane that shows most of them. Fewer than three corners give nothing.
pub(super) fn triangulate(corners: &[Vec3], mut emit: impl FnMut([usize; 3])) {
    let n = corners.len();
    if n < 3 {
        return;
    }
    if n > 3 && n <= MAX_CLIPPED_CORNERS {
        let flat = flatten(corners);
        if !is_convex(&flat) {
            return clip_ears(&flat, emit);
        }
    }
    for i in 1..n - 1 {
        emit([0, i, i + 1]);
    }
}

/// Drops the axis of the largest component of the area vector, so that the polygon turns counter-clockwise.
fn flatten(corners: &[Vec3]) -> Vec<Vec2> {
    // Newell's area vector, about the first corner so that far origins cost no digits.
    let origin = corners[0];
    let area: Vec3 = (1..corners.len() - 1)
        .map(|i| (corners[i] - origin).cross(corners[i + 1] - origin))
        .fold(Vec3::ZERO, |sum, c| sum + c);
    let size = area.abs();
    let (u, v, sign) = if size.x >= size.y && size.x >= size.z {
        (1, 2, area.x)
    } else if size.y >= size.z {
        (2, 0, area.y)
    } else {
        (0, 1, area.z)
    };
    let (u, v) = if sign >= 0.0 { (u, v) } else { (v, u) };
    corners.iter().map(|&c| Vec2::new((c - origin)[u], (c - origin)[v])).collect()
}

/// Twice the signed area of a triangle.
fn turn(a: Vec2, b: Vec2, c: Vec2) -> f32 {
    (b - a).perp_dot(c - a)
}

fn is_convex(p: &[Vec2]) -> bool {
    let n = p.len();
    (0..n).all(|i| turn(p[i], p[(i + 1) % n], p[(i + 2) % n]) >= 0.0)
}

/// True where `p` lies in or on the triangle, other than at its corners.
fn covers(a: Vec2, b: Vec2, c: Vec2, p: Vec2) -> bool {
    p != a && p != b && p != c && turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0
}

fn clip_ears(p: &[Vec2], mut emit: impl FnMut([usize; 3])) {
    let mut left: Vec<usize> = (0..p.len()).collect();
    let (mut at, mut misses, mut looks) = (0, 0, 0);
    while left.len() > 3 {
        let n = left.len();
        let ear = [left[(at + n - 1) % n], left[at % n], left[(at + 1) % n]];
        let [a, b, c] = ear.map(|i| p[i]);
        looks += 1;
        // Only a corner that turns inwards can lie in an ear. After a whole round without an ear (a polygon that
        // crosses itself, or has no area) any corner must do.
        let is_ear = turn(a, b, c) > 0.0
            && !(0..n).any(|i| {
                let [before, q, after] = [left[(i + n - 1) % n], left[i], left[(i + 1) % n]].map(|i| p[i]);
                turn(before, q, after) <= 0.0 && covers(a, b, c, q)
            });
        if is_ear || misses >= n || looks > MAX_LOOKS_PER_CORNER * p.len() {
            emit(ear);
            left.remove(at % n);
            (at, misses) = (if at % n == 0 { 0 } else { at % n - 1 }, 0);
        } else {
            (at, misses) = ((at + 1) % n, misses + 1);
        }
    }
    emit([left[0], left[1], left[2]]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn cut(corners: &[Vec3]) -> Vec<[usize; 3]> {
        let mut out = Vec::new();
        triangulate(corners, |t| out.push(t));
        out
    }

    /// Sums of signed and of absolute areas in the z plane: equal where no triangle is turned over or overlaps.
    fn areas(corners: &[Vec3], triangles: &[[usize; 3]]) -> (f32, f32) {
        triangles.iter().fold((0.0, 0.0), |(signed, absolute), t| {
            let [a, b, c] = t.map(|i| corners[i].truncate());
            (signed + 0.5 * turn(a, b, c), absolute + 0.5 * turn(a, b, c).abs())
        })
    }

    #[test]
    fn convex_polygons_become_fans() {
        let square = [Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y];
        assert_eq!(cut(&square), [[0, 1, 2], [0, 2, 3]]);
        assert!(cut(&square[..2]).is_empty());
    }

    #[test]
    fn a_concave_corner_gets_no_triangle_outside() {
        // An L whose fan about corner 0 would cover the notch.
        let l: Vec<Vec3> = [(2., 0.), (2., 1.), (1., 1.), (1., 2.), (0., 2.), (0., 0.)]
            .map(|(x, y)| Vec3::new(x, y, 5.0))
            .into();
        let (signed, absolute) = areas(&l, &cut(&l));
        assert_eq!((signed, absolute), (3.0, 3.0));
        let fan: Vec<_> = (1..5).map(|i| [0, i, i + 1]).collect();
        assert!(areas(&l, &fan).1 > 3.0, "the oracle must be able to fail");
        let backwards: Vec<Vec3> = l.iter().rev().copied().collect();
        assert_eq!(areas(&backwards, &cut(&backwards)), (-3.0, 3.0), "the sense of the polygon is kept");
    }

    proptest! {
        #[test]
        fn star_shaped_polygons_keep_their_area(radii in prop::collection::vec(0.1f32..1.0, 4..40)) {
            let n = radii.len();
            let corners: Vec<Vec3> = radii.iter().enumerate().map(|(i, r)| {
                let (sin, cos) = (std::f32::consts::TAU * i as f32 / n as f32).sin_cos();
                Vec3::new(r * cos, r * sin, 0.3)
            }).collect();
            let triangles = cut(&corners);
            prop_assert_eq!(triangles.len(), n - 2);
            let (signed, absolute) = areas(&corners, &triangles);
            prop_assert!((signed - absolute).abs() < 1e-5, "{} {}", signed, absolute);
        }

        #[test]
        fn nonsense_gives_the_usual_number_of_triangles(
            corners in prop::collection::vec(prop::array::uniform3(-1.0f32..1.0), 3..30),
            special in prop::sample::select(vec![0.0, f32::MAX, f32::NAN, 1e-40]),
        ) {
            let mut corners: Vec<Vec3> = corners.into_iter().map(Vec3::from_array).collect();
            corners[1].x = special;
            let triangles = cut(&corners);
            prop_assert_eq!(triangles.len(), corners.len() - 2);
            prop_assert!(triangles.iter().flatten().all(|&i| i < corners.len()));
        }
    }
}

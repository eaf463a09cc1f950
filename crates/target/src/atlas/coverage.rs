//! Which texels of a map a triangle touches, and the place in it that stands for each.
//!
//! A texture is read with bilinear taps: a tap reads the texels whose centres are less than a texel away in both directions. So a
//! triangle needs every texel of which the square of two texels a side about its centre meets the triangle, also where
//! the texel's own square does not.
//!
//! Coordinates are texels: texel (x, y) is the square from (x, y) to (x + 1, y + 1), rows from the top.

use conray_core::Vec2;
use std::ops::Range;

/// Overlaps of less than this, in texels, are rounding.
const LEAST_AREA: f32 = 1e-7;
/// A triangle clipped to a square has at most so many corners.
const CORNERS: usize = 7;

/// A texel that a triangle touches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Touched {
    /// Column and row.
    pub(super) texel: [u32; 2],
    /// Share of the texel's own square that the triangle covers; 0 where only taps reach it.
    pub(super) area: f32,
    /// Weights of the triangle's corners at the place that stands for the texel: its centre where that lies inside, else the middle of what is
    /// covered of it, else the nearest place.
    pub(super) weights: [f32; 3],
    /// From that place to the texel's centre, squared.
    pub(super) off: f32,
}

/// Tells of every texel of some rows of a map of that width that a triangle touches, row by row; taps read texels whose centres are less than
/// `tap` away in both directions.
pub(super) fn touched(
    corners: [Vec2; 3],
    width: u32,
    rows: Range<u32>,
    tap: f32,
    mut tell: impl FnMut(Touched),
) {
    if corners.iter().any(|corner| !corner.is_finite()) {
        return;
    }
    let twice_area = (corners[1] - corners[0]).perp_dot(corners[2] - corners[0]);
    let whole = Polygon::of_triangle(corners);
    for y in reached(whole.range(Axis::Y), rows, tap) {
        let centre = y as f32 + 0.5;
        let Some(band) = whole.clipped(Axis::Y, centre - tap, centre + tap) else { continue };
        let own = whole.clipped(Axis::Y, y as f32, y as f32 + 1.0);
        for x in reached(band.range(Axis::X), 0..width, tap) {
            let centre = Vec2::new(x as f32 + 0.5, centre);
            let inside = own.and_then(|own| own.clipped(Axis::X, x as f32, x as f32 + 1.0));
            let (area, middle) = inside.map_or((0.0, centre), |inside| inside.area_and_middle());
            let area = if area < LEAST_AREA { 0.0 } else { area };
            let wanted = match weights_at(&corners, twice_area, centre) {
                Some(weights) if weights.iter().all(|&weight| weight >= 0.0) => Some(weights),
                _ if area > 0.0 => weights_at(&corners, twice_area, middle).map(within),
                _ => None,
            };
            let weights = wanted.unwrap_or_else(|| nearest(&corners, centre));
            let place = corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2];
            tell(Touched { texel: [x, y], area, weights, off: place.distance_squared(centre) });
        }
    }
}

/// Those of a range of rows or columns whose centres are less than a tap from a range of places.
pub(super) fn reached([low, high]: [f32; 2], within: Range<u32>, tap: f32) -> Range<u32> {
    // Floats become integers by rounding towards zero, and saturate.
    let first = ((low - 0.5 - tap).floor() + 1.0) as u32;
    let end = (high - 0.5 + tap).ceil() as u32;
    first.max(within.start)..end.min(within.end)
}

/// Weights of the corners at a place; `None` for a triangle without area.
fn weights_at(corners: &[Vec2; 3], twice_area: f32, at: Vec2) -> Option<[f32; 3]> {
    let [a, b, c] = corners.map(|corner| corner - at);
    let weights = [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)].map(|part| part / twice_area);
    weights.iter().all(|weight| weight.is_finite()).then_some(weights)
}

/// Weights that rounding left outside, brought back.
fn within(weights: [f32; 3]) -> [f32; 3] {
    let weights = weights.map(|weight| weight.max(0.0));
    let sum = weights.iter().sum::<f32>();
    weights.map(|weight| weight / sum)
}

/// Weights of the place on a triangle's rim that is nearest.
fn nearest(corners: &[Vec2; 3], at: Vec2) -> [f32; 3] {
    let of_edge = |from: usize| {
        let to = (from + 1) % 3;
        let (start, along) = (corners[from], corners[to] - corners[from]);
        let length2 = along.length_squared();
        let share = if length2 > 0.0 { ((at - start).dot(along) / length2).clamp(0.0, 1.0) } else { 0.0 };
        let mut weights = [0.0; 3];
        weights[from] = 1.0 - share;
        weights[to] += share;
        ((start + along * share).distance_squared(at), weights)
    };
    let edges = [0, 1, 2].map(of_edge);
    edges.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).map_or([1.0, 0.0, 0.0], |(_, weights)| weights)
}

#[derive(Clone, Copy)]
enum Axis {
    X,
    Y,
}

impl Axis {
    fn of(self, place: Vec2) -> f32 {
        match self {
            Self::X => place.x,
            Self::Y => place.y,
        }
    }
}

/// A convex polygon of few corners.
#[derive(Clone, Copy)]
struct Polygon {
    corners: [Vec2; CORNERS],
    count: usize,
}

impl Polygon {
    fn of_triangle([a, b, c]: [Vec2; 3]) -> Self {
        Self { corners: [a, b, c, c, c, c, c], count: 3 }
    }

    fn all(&self) -> &[Vec2] {
        &self.corners[..self.count]
    }

    /// Its extent along an axis.
    fn range(&self, axis: Axis) -> [f32; 2] {
        let along = self.all().iter().map(|&corner| axis.of(corner));
        along.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
    }

    /// What of it lies between two places of an axis (Sutherland and Hodgman, "Reentrant Polygon Clipping", 1974).
    fn clipped(&self, axis: Axis, low: f32, high: f32) -> Option<Self> {
        self.cut(|place| axis.of(place) - low).and_then(|above| above.cut(|place| high - axis.of(place)))
    }

    /// What of it lies where a linear function is not negative.
    fn cut(&self, inside: impl Fn(Vec2) -> f32) -> Option<Self> {
        let mut out = Self { corners: [Vec2::ZERO; CORNERS], count: 0 };
        let mut push = |corner| {
            if out.count < CORNERS {
                out.corners[out.count] = corner;
                out.count += 1;
            }
        };
        for (k, &corner) in self.all().iter().enumerate() {
            let before = self.corners[(k + self.count - 1) % self.count];
            let (here, there) = (inside(corner), inside(before));
            if (here >= 0.0) != (there >= 0.0) {
                push(before + (corner - before) * (there / (there - here)));
            }
            if here >= 0.0 {
                push(corner);
            }
        }
        (out.count > 0).then_some(out)
    }

    fn area_and_middle(&self) -> (f32, Vec2) {
        let origin = self.corners[0];
        let (mut twice_area, mut middle) = (0.0, Vec2::ZERO);
        for pair in self.all()[1..].windows(2) {
            let (a, b) = (pair[0] - origin, pair[1] - origin);
            let part = a.perp_dot(b);
            twice_area += part;
            middle += part * (a + b) / 3.0;
        }
        let middle = if twice_area == 0.0 { Vec2::ZERO } else { middle / twice_area };
        (0.5 * twice_area.abs(), origin + middle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::HashMap;

    const SIZE: [u32; 2] = [12, 9];

    fn all(corners: [Vec2; 3]) -> HashMap<[u32; 2], Touched> {
        let mut found = HashMap::new();
        touched(corners, SIZE[0], 0..SIZE[1], 1.0, |touched| {
            assert!(found.insert(touched.texel, touched).is_none(), "{:?} twice", touched.texel);
        });
        found
    }

    fn place(corners: &[Vec2; 3], weights: [f32; 3]) -> Vec2 {
        (0..3).map(|k| corners[k] * weights[k]).sum()
    }

    proptest! {
        #[test]
        fn every_texel_that_a_tap_reads_is_touched(
            corners in prop::array::uniform3((-2.0f32..14.0, -2.0f32..11.0)),
            at in prop::collection::vec((0.0f32..1.0, 0.0f32..1.0), 200),
        ) {
            let corners = corners.map(|(x, y)| Vec2::new(x, y));
            let found = all(corners);
            for (u, v) in at {
                let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
                let tap = corners[0] * (1.0 - u - v) + corners[1] * u + corners[2] * v;
                let first = (tap - 0.5).floor();
                for (dx, dy) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
                    let (x, y) = (first.x + dx, first.y + dy);
                    let inside = x >= 0.0 && y >= 0.0 && x < SIZE[0] as f32 && y < SIZE[1] as f32;
                    // A tap that weighs a texel by nothing does not read it.
                    let weight = (1.0 - (tap.x - x - 0.5).abs()) * (1.0 - (tap.y - y - 0.5).abs());
                    if inside && weight > 1e-4 {
                        prop_assert!(found.contains_key(&[x as u32, y as u32]), "{tap} reads {x} {y}");
                    }
                }
            }
        }

        #[test]
        fn none_is_touched_in_vain_and_each_place_lies_in_the_triangle(
            corners in prop::array::uniform3((-2.0f32..14.0, -2.0f32..11.0)),
        ) {
            let corners = corners.map(|(x, y)| Vec2::new(x, y));
            for touched in all(corners).values() {
                let centre = Vec2::new(touched.texel[0] as f32 + 0.5, touched.texel[1] as f32 + 0.5);
                let weights = touched.weights;
                prop_assert!(weights.iter().all(|&w| (0.0..=1.0).contains(&w)), "{weights:?}");
                prop_assert!((weights.iter().sum::<f32>() - 1.0).abs() < 1e-5);
                let at = place(&corners, weights);
                // The nearest place to a texel that only taps reach is less than the diagonal of a tap away.
                let reach = if touched.area > 0.0 { 0.5 } else { std::f32::consts::SQRT_2 };
                prop_assert!((at - centre).abs().max_element() < reach + 1e-3, "{at} for {centre}");
                prop_assert!((touched.off.sqrt() - at.distance(centre)).abs() < 1e-3);
            }
        }

        #[test]
        fn areas_sum_to_that_of_the_triangle(
            corners in prop::array::uniform3((0.0f32..12.0, 0.0f32..9.0)),
        ) {
            let corners = corners.map(|(x, y)| Vec2::new(x, y));
            let area = 0.5 * (corners[1] - corners[0]).perp_dot(corners[2] - corners[0]).abs();
            let sum = all(corners).values().map(|touched| touched.area).sum::<f32>();
            prop_assert!((sum - area).abs() < 1e-3, "{sum} of {area}");
        }
    }

    #[test]
    fn a_texel_inside_is_asked_about_at_its_centre() {
        let found = all([Vec2::new(1.0, 1.0), Vec2::new(9.0, 1.0), Vec2::new(1.0, 8.0)]);
        let inside = found[&[2, 2]];
        assert!(inside.area == 1.0 && inside.off < 1e-10);
        // The corner at (1, 1): the texel above and to the left is read by taps beside the corner alone.
        let outside = found[&[0, 0]];
        assert_eq!(outside.area, 0.0);
        assert!((outside.weights[0] - 1.0).abs() < 1e-6);
    }

    #[test]
    fn triangles_without_area_are_touched_along_their_line() {
        let found = all([Vec2::new(2.5, 2.5), Vec2::new(6.5, 2.5), Vec2::new(4.5, 2.5)]);
        assert!(found.values().all(|touched| touched.area == 0.0));
        assert!(found.contains_key(&[4, 2]) && !found.contains_key(&[4, 4]));
        let point = all([Vec2::splat(3.5); 3]);
        assert!(point.contains_key(&[3, 3]));
        assert!(all([Vec2::NAN, Vec2::ZERO, Vec2::ONE]).is_empty());
    }
}

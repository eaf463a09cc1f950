//! Solids of revolution and the profiles of turned mouldings.

use super::{Ends, loft};
use crate::builtin::faces::Faces;
use conray_core::{Vec2, Vec3};
use std::f32::consts::{PI, TAU};

/// Points (radius, height) from the bottom of a turned solid to its top.
#[derive(Clone, Debug, Default)]
pub(crate) struct Profile {
    points: Vec<Vec2>,
}

impl Profile {
    /// Starts on the axis at a height, then goes out to a radius.
    pub(crate) fn from_disc(radius: f32, height: f32) -> Self {
        Self { points: vec![Vec2::new(0.0, height), Vec2::new(radius, height)] }
    }

    /// Goes straight to a radius and height.
    pub(crate) fn to(mut self, radius: f32, height: f32) -> Self {
        let point = Vec2::new(radius, height);
        if self.points.last() != Some(&point) {
            self.points.push(point);
        }
        self
    }

    fn last(&self) -> Vec2 {
        self.points.last().copied().unwrap_or(Vec2::ZERO)
    }

    /// A torus: bulges outwards by `depth` on its way straight up to `height`.
    pub(crate) fn torus(self, depth: f32, height: f32, steps: usize) -> Self {
        let (from, radius) = (self.last(), self.last().x);
        (1..=steps).fold(self, |profile, i| {
            let angle = PI * i as f32 / steps as f32;
            let bulge = if i == steps { 0.0 } else { depth * angle.sin() };
            profile.to(radius + bulge, from.y + (height - from.y) * 0.5 * (1.0 - angle.cos()))
        })
    }

    /// A quarter ellipse to a radius and height that leaves upright and arrives level: a bell that opens.
    pub(crate) fn flare(self, radius: f32, height: f32, steps: usize) -> Self {
        let from = self.last();
        (1..=steps).fold(self, |profile, i| {
            let angle = 0.5 * PI * i as f32 / steps as f32;
            let (out, up) = (1.0 - angle.cos(), angle.sin());
            if i == steps {
                profile.to(radius, height)
            } else {
                profile.to(from.x + (radius - from.x) * out, from.y + (height - from.y) * up)
            }
        })
    }

    /// A smooth curve through further points (Catmull and Rom, "A Class of Local Interpolating Splines", 1974).
    pub(crate) fn spline(self, through: &[(f32, f32)], steps: usize) -> Self {
        let mut knots = vec![self.last()];
        knots.extend(through.iter().map(|&(r, y)| Vec2::new(r, y)));
        let last = knots.len() - 1;
        let mut profile = self;
        for i in 0..last {
            let [a, b, c, d] = [i.saturating_sub(1), i, i + 1, (i + 2).min(last)].map(|k| knots[k]);
            for step in 1..=steps {
                let t = step as f32 / steps as f32;
                let cubic = (3.0 * (b - c) + d - a) * t * t * t + (2.0 * a - 5.0 * b + 4.0 * c - d) * t * t;
                let point = if step == steps { c } else { b + 0.5 * ((c - a) * t + cubic) };
                profile = profile.to(point.x.max(1e-3), point.y);
            }
        }
        profile
    }

    /// Goes level to the axis and ends there.
    pub(crate) fn ending_on_axis(self) -> Vec<Vec2> {
        let height = self.last().y;
        self.to(0.0, height).points
    }
}

/// The closed solid that a profile sweeps about the y axis; the profile must start and end on the axis.
pub(crate) fn lathe(profile: &[Vec2], segments: usize) -> Faces {
    let ring = |p: &Vec2| {
        let point = |i: usize| {
            let angle = TAU * i as f32 / segments as f32;
            if p.x == 0.0 { Vec3::Y * p.y } else { Vec3::new(p.x * angle.cos(), p.y, -p.x * angle.sin()) }
        };
        (0..segments).map(point).collect()
    };
    let rings: Vec<Vec<Vec3>> = profile.iter().map(ring).collect();
    loft(&rings, Ends::Open)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin::checks::{assert_closed, volume};

    #[test]
    fn a_turned_cone_and_a_vase_are_closed() {
        let cone = lathe(&Profile::from_disc(1.0, 0.0).to(0.0, 2.0).points, 64);
        assert_closed(&cone.flat(), "cone");
        let base = 32.0 * (TAU / 64.0).sin();
        assert!((volume(&cone) - base * 2.0 / 3.0).abs() < 1e-4);
        let vase = Profile::from_disc(0.4, 0.0).torus(0.1, 0.2, 6).spline(&[(0.8, 1.0), (0.3, 1.6)], 5);
        assert_closed(&lathe(&vase.flare(0.5, 1.8, 4).ending_on_axis(), 12).flat(), "vase");
    }

    #[test]
    fn curves_arrive_where_they_are_sent() {
        let profile =
            Profile::from_disc(0.5, 0.0).torus(0.2, 1.0, 7).flare(0.9, 1.5, 3).spline(&[(0.2, 2.0)], 4);
        for expected in [Vec2::new(0.5, 1.0), Vec2::new(0.9, 1.5), Vec2::new(0.2, 2.0)] {
            assert!(profile.points.iter().any(|p| p.distance(expected) < 1e-6), "{expected} is missed");
        }
        let widest = profile.points.iter().filter(|p| p.y < 1.0).map(|p| p.x).fold(0.0, f32::max);
        assert!(widest > 0.65 && widest <= 0.7 + 1e-6);
    }
}

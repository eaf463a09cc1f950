//! What becomes of the crossings of a ray: each query is a sink that takes them in whatever order they come.
//!
//! The order of the tree must not show in results, so nothing is multiplied as it comes: fractional hits are kept and
//! sorted first. Masks are 0 or 1 and never kept.

use crate::query::Hit;
use crate::surface::is_back;
use conray_core::{Falloff, Geometry, Ray, Vec3};
use std::cmp::Ordering;

/// Takes crossings.
pub(crate) trait Sink {
    /// Crossings beyond this distance are of no interest.
    fn limit(&self) -> f32;
    /// Takes one; returns false where no further one can matter. `opaque` means that no look-up is needed.
    fn take(&mut self, hit: Hit, opaque: bool) -> bool;
}

/// By distance, then instance, then triangle.
fn order(a: &Hit, b: &Hit) -> Ordering {
    a.t.total_cmp(&b.t).then(a.instance.cmp(&b.instance)).then(a.triangle.cmp(&b.triangle))
}

/// Opacity in [0, 1] where a ray in that direction met a surface; `opaque` means that no look-up is needed.
pub(crate) fn opacity(geometry: &Geometry, hit: &Hit, direction: Vec3, opaque: bool) -> f32 {
    if opaque {
        return 1.0;
    }
    let mesh = geometry.instances()[hit.instance as usize].mesh as usize;
    if geometry.is_one_sided(mesh) && is_back(geometry, hit, direction) {
        return 0.0;
    }
    geometry.opacity_at(mesh, hit.triangle as usize, hit.u, hit.v).clamp(0.0, 1.0)
}

/// The first hit of opacity one half or more.
pub(crate) struct Nearest<'a> {
    geometry: &'a Geometry,
    direction: Vec3,
    limit: f32,
    pub(crate) best: Option<Hit>,
}

impl<'a> Nearest<'a> {
    pub(crate) fn new(geometry: &'a Geometry, ray: &Ray) -> Self {
        Self { geometry, direction: ray.direction, limit: ray.t_max, best: None }
    }
}

impl Sink for Nearest<'_> {
    fn limit(&self) -> f32 {
        self.limit
    }

    fn take(&mut self, hit: Hit, opaque: bool) -> bool {
        let nearer = self.best.is_none_or(|best| order(&hit, &best).is_lt());
        if nearer && opacity(self.geometry, &hit, self.direction, opaque) >= 0.5 {
            self.limit = hit.t;
            self.best = Some(hit);
        }
        true
    }
}

/// Transmittance: stops at the first opaque hit.
pub(crate) struct Blocked<'a> {
    geometry: &'a Geometry,
    direction: Vec3,
    limit: f32,
    blocked: bool,
    partial: Vec<(Hit, f32)>,
}

impl<'a> Blocked<'a> {
    pub(crate) fn new(geometry: &'a Geometry, ray: &Ray) -> Self {
        Self { geometry, direction: ray.direction, limit: ray.t_max, blocked: false, partial: Vec::new() }
    }

    pub(crate) fn transmittance(mut self) -> f32 {
        if self.blocked {
            return 0.0;
        }
        self.partial.sort_unstable_by(|a, b| order(&a.0, &b.0));
        self.partial.iter().map(|(_, opacity)| 1.0 - opacity).product()
    }
}

impl Sink for Blocked<'_> {
    fn limit(&self) -> f32 {
        self.limit
    }

    fn take(&mut self, hit: Hit, opaque: bool) -> bool {
        let opacity = opacity(self.geometry, &hit, self.direction, opaque);
        if opacity >= 1.0 {
            self.blocked = true;
        } else if opacity > 0.0 {
            self.partial.push((hit, opacity));
        }
        !self.blocked
    }
}

/// Visibility with falloff: needs the fractional hits up to the first opaque one.
pub(crate) struct Faded<'a> {
    geometry: &'a Geometry,
    direction: Vec3,
    /// `t_max`, then the distance of the first opaque hit so far.
    limit: f32,
    closed: bool,
    partial: Vec<(Hit, f32)>,
}

impl<'a> Faded<'a> {
    pub(crate) fn new(geometry: &'a Geometry, ray: &Ray) -> Self {
        Self { geometry, direction: ray.direction, limit: ray.t_max, closed: false, partial: Vec::new() }
    }

    pub(crate) fn visibility(mut self, falloff: Falloff, distance: f32) -> f32 {
        let weight = |t: f32| falloff.weight(t / distance);
        let closed_at = if self.closed { self.limit } else { f32::INFINITY };
        self.partial.retain(|(hit, _)| hit.t < closed_at);
        self.partial.sort_unstable_by(|a, b| order(&a.0, &b.0));
        let (mut through, mut blocked) = (1.0, 0.0);
        for (hit, opacity) in &self.partial {
            blocked += through * opacity * weight(hit.t);
            through *= 1.0 - opacity;
        }
        if self.closed {
            blocked += through * weight(self.limit);
        }
        (1.0 - blocked).clamp(0.0, 1.0)
    }
}

impl Sink for Faded<'_> {
    fn limit(&self) -> f32 {
        self.limit
    }

    fn take(&mut self, hit: Hit, opaque: bool) -> bool {
        let opacity = opacity(self.geometry, &hit, self.direction, opaque);
        if opacity >= 1.0 {
            (self.limit, self.closed) = (self.limit.min(hit.t), true);
        } else if opacity > 0.0 && hit.t <= self.limit {
            self.partial.push((hit, opacity));
        }
        true
    }
}

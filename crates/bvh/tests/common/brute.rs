//! The oracle: every triangle, in double precision, by another formula.
//!
//! Moeller, Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997. Where a ray passes within `tolerance` of
//! an outline, single precision may not know on which side, and the oracle says so.

use conray_core::{Geometry, Ray, Vec3};

/// What a ray meets, as far as it is beyond doubt.
pub(crate) struct Truth {
    /// Certain hits by increasing distance.
    pub(crate) hits: Vec<TrueHit>,
    /// Distances of the outlines that the ray passes too closely.
    pub(crate) doubtful: Vec<f64>,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct TrueHit {
    pub(crate) t: f64,
    pub(crate) instance: u32,
    pub(crate) triangle: u32,
    pub(crate) u: f64,
    pub(crate) v: f64,
    /// Cosine of the angle between ray and normal, in [0, 1].
    pub(crate) cosine: f64,
}

/// Meets every triangle of every instance.
pub(crate) fn trace(geometry: &Geometry, ray: &Ray, tolerance: f64) -> Truth {
    let mut truth = Truth { hits: Vec::new(), doubtful: Vec::new() };
    let (o, d) = (Wide::from(ray.origin), Wide::from(ray.direction));
    for (instance, placed) in (0..).zip(geometry.instances()) {
        let mesh = &geometry.meshes()[placed.mesh as usize];
        for triangle in 0..mesh.triangles().len() {
            let corners = mesh.corners(triangle).map(|p| placed.world_from_mesh.transform_point3(p));
            let corners = corners.map(|p| Wide::from(p).minus(o));
            let near = |i: usize| near_segment(corners[i], corners[(i + 1) % 3], d, tolerance);
            let t_max = f64::from(ray.t_max);
            if let Some(t) = (0..3).find_map(near) {
                if t > -tolerance && t < t_max + tolerance {
                    truth.doubtful.push(t);
                }
            } else if let Some((t, u, v, cosine)) = moeller_trumbore(&corners, d) {
                let triangle = triangle as u32;
                if t.abs() < tolerance || (t - t_max).abs() < tolerance {
                    truth.doubtful.push(t);
                } else if t > 0.0 && t < t_max {
                    truth.hits.push(TrueHit { t, instance, triangle, u, v, cosine });
                }
            }
        }
    }
    truth.hits.sort_by(|a, b| a.t.total_cmp(&b.t));
    truth
}

/// Distance along the ray from the origin where it comes within the tolerance of a segment.
fn near_segment(p: Wide, q: Wide, d: Wide, tolerance: f64) -> Option<f64> {
    let edge = q.minus(p);
    // Both in the plane across the ray.
    let across = |v: Wide| v.minus(d.times(v.dot(d) / d.dot(d)));
    let (pa, ea) = (across(p), across(edge));
    let length2 = ea.dot(ea);
    let s = if length2 > 0.0 { (-pa.dot(ea) / length2).clamp(0.0, 1.0) } else { 0.0 };
    let nearest = pa.plus(ea.times(s));
    (nearest.dot(nearest) < tolerance * tolerance).then(|| p.plus(edge.times(s)).dot(d))
}

fn moeller_trumbore(corners: &[Wide; 3], d: Wide) -> Option<(f64, f64, f64, f64)> {
    let [a, b, c] = *corners;
    let (e1, e2) = (b.minus(a), c.minus(a));
    let p = d.cross(e2);
    let det = e1.dot(p);
    if det == 0.0 {
        return None;
    }
    let s = a.times(-1.0);
    let u = s.dot(p) / det;
    let q = s.cross(e1);
    let v = d.dot(q) / det;
    let normal = e1.cross(e2);
    let cosine = det.abs() / normal.dot(normal).sqrt();
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then(|| (e2.dot(q) / det, u, v, cosine))
}

/// A vector in double precision, of its own, so that the oracle shares no code with what it judges.
#[derive(Clone, Copy, Debug)]
struct Wide([f64; 3]);

impl From<Vec3> for Wide {
    fn from(v: Vec3) -> Self {
        Self(v.to_array().map(f64::from))
    }
}

impl Wide {
    fn plus(self, o: Self) -> Self {
        Self([self.0[0] + o.0[0], self.0[1] + o.0[1], self.0[2] + o.0[2]])
    }

    fn minus(self, o: Self) -> Self {
        self.plus(o.times(-1.0))
    }

    fn times(self, s: f64) -> Self {
        Self(self.0.map(|x| x * s))
    }

    fn dot(self, o: Self) -> f64 {
        self.0.iter().zip(o.0).map(|(a, b)| a * b).sum()
    }

    fn cross(self, o: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, o.0);
        Self([b * z - c * y, c * x - a * z, a * y - b * x])
    }
}

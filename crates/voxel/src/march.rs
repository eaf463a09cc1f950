//! The march of a cone through the octree.

use crate::Octree;
use conray_core::{Falloff, Vec3};

/// One cone from a surface point, in world space.
#[derive(Clone, Copy, Debug)]
pub struct ConeQuery {
    /// Position on the surface.
    pub apex: Vec3,
    /// Unit axis.
    pub axis: Vec3,
    /// Half of the aperture, in [0, pi/2).
    pub half_angle_rad: f32,
    /// Unit geometric normal of the surface, on the cone's side.
    pub normal: Vec3,
    /// AO distance in world units; infinite reaches to where the cone leaves the octree's cube.
    pub distance: f32,
    /// How an occluder's weight fades with its distance.
    pub falloff: Falloff,
}

/// How a cone is marched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MarchOptions {
    /// Step as a share of the sampled node's edge.
    pub step: f32,
    /// Nodes' edges of height above tangent plane.
    pub lift: f32,
    /// width scale
    pub width: f32,
    /// level limit by height
    pub height: f32,
    /// Model.
    pub model: u32,
    /// Gain.
    pub gain: f32,
    /// Lag in steps.
    pub lag: u32,
}

impl Default for MarchOptions {
    fn default() -> Self {
        Self { step: 0.5, lift: 2.0, width: 1.0, height: 1e9, model: 3, gain: 1.0, lag: 4 }
    }
}

/// What a cone found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConeResult {
    /// Share of the cone that is open, in [0, 1].
    pub visibility: f32,
    /// Accumulated SD.
    pub error: f32,
}

impl Octree {
    /// Marches a cone with the default options.
    pub fn march(&self, query: &ConeQuery) -> ConeResult {
        self.march_with(query, &MarchOptions::default())
    }

    /// Marches.
    pub fn march_with(&self, q: &ConeQuery, o: &MarchOptions) -> ConeResult {
        let vs = self.voxel_size();
        let tan2 = 2.0 * q.half_angle_rad.tan() * o.width;
        let cos = q.normal.dot(q.axis);
        let side = vs * self.resolution() as f32;
        let end = q.distance.min(2.0 * side);
        let (mut t, mut tr, mut occ, mut err) = (0.0f32, 1.0f32, 0.0f32, 0.0f32);
        let mut hist = [1.0f32; 64];
        let mut k = 0usize;
        let d = q.axis;
        while t < end && k < 4000 {
            let w = (t * tan2).min(t * cos.max(0.0) * o.height);
            let level = (w.max(vs) / vs).log2();
            let vl = vs * level.exp2();
            let ds = o.step * vl;
            let m = t + 0.5 * ds;
            let lift = (o.lift * vl - m * cos).max(0.0);
            let p = q.apex + d * m + q.normal * lift;
            let s = self.sample(level, p);
            let used = ds.min(end - t);
            let before = tr;
            match o.model {
                0 => tr *= (1.0 - s.mean.min(0.9999)).powf(o.gain * used / vs),
                1 => tr *= (1.0 - s.mean.min(0.9999)).powf(o.gain * used / vl),
                2 => {
                    let a = self.sample_axes(level, p).dot(d * d);
                    tr *= (1.0 - a.min(0.9999)).powf(o.gain * used / vl)
                }
                3 => {
                    let lagged = if o.lag as usize > k { 1.0 } else { hist[(k - o.lag as usize) % 64] };
                    hist[k % 64] = tr;
                    let lagged = if o.lag == 0 { tr } else { lagged };
                    tr = (tr - o.gain * s.mean * used / vs * lagged).max(0.0);
                }
                _ => {
                    // crossings by direction
                    tr *= (-o.gain * s.mean * used / vs).exp();
                }
            }
            let weight = q.falloff.weight(m / q.distance);
            occ += (before - tr) * weight;
            err += before * s.sd * (used / vl) * weight;
            if tr < 1e-3 {
                occ += tr * weight;
                break;
            }
            t += ds;
            k += 1;
        }
        ConeResult { visibility: (1.0 - occ).clamp(0.0, 1.0), error: err }
    }
}

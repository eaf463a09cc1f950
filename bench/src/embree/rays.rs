//! Rays in the layouts of the C API.

use conray_core::{Ray, Vec3};

/// `RTCRay`: 48 bytes, aligned to 16.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
pub struct Ray1 {
    origin: [f32; 3],
    near: f32,
    direction: [f32; 3],
    time: f32,
    pub(super) far: f32,
    mask: u32,
    id: u32,
    flags: u32,
}

/// `RTCRayHit`: a ray and `RTCHit`, which is padded to 48 bytes.
#[repr(C, align(16))]
pub(super) struct RayHit1 {
    pub(super) ray: Ray1,
    pub(super) normal: [f32; 3],
    pub(super) u: f32,
    pub(super) v: f32,
    pub(super) triangle: u32,
    pub(super) geometry: u32,
    instance: [u32; 2],
    _padding: [u32; 3],
}

/// `RTCRay4`, `RTCRay8` or `RTCRay16`: that many rays, member by member.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Packet<const N: usize> {
    origin: [[f32; N]; 3],
    near: [f32; N],
    direction: [[f32; N]; 3],
    time: [f32; N],
    pub(super) far: [f32; N],
    mask: [u32; N],
    id: [u32; N],
    flags: [u32; N],
}

const _: () = assert!(size_of::<Ray1>() == 48 && size_of::<RayHit1>() == 96);
const _: () = assert!(size_of::<Packet<4>>() == 192 && size_of::<Packet<8>>() == 384);
const _: () = assert!(size_of::<Packet<16>>() == 768);

/// `RTC_INVALID_GEOMETRY_ID`.
pub(super) const NOTHING: u32 = !0;

impl Ray1 {
    /// One ray.
    pub fn new(ray: &Ray) -> Self {
        Self {
            origin: ray.origin.to_array(),
            near: 0.0,
            direction: ray.direction.to_array(),
            time: 0.0,
            far: ray.t_max,
            mask: !0,
            id: 0,
            flags: 0,
        }
    }

    /// False where a trace found something in the way, which Embree says by a far distance of minus infinity.
    pub fn is_open(&self) -> bool {
        self.far >= 0.0
    }
}

impl RayHit1 {
    pub(super) fn new(ray: &Ray) -> Self {
        let (ray, normal) = (Ray1::new(ray), [0.0; 3]);
        let (triangle, geometry, instance) = (NOTHING, NOTHING, [NOTHING; 2]);
        Self { ray, normal, u: 0.0, v: 0.0, triangle, geometry, instance, _padding: [0; 3] }
    }
}

impl<const N: usize> Packet<N> {
    /// `N` rays of one length, from that many origins into that many directions.
    pub fn new(origins: [Vec3; N], directions: [Vec3; N], t_max: f32) -> Self {
        let axes = |v: [Vec3; N]| [0, 1, 2].map(|a| v.map(|v| v[a]));
        Self {
            origin: axes(origins),
            near: [0.0; N],
            direction: axes(directions),
            time: [0.0; N],
            far: [t_max; N],
            mask: [!0; N],
            id: [0; N],
            flags: [0; N],
        }
    }

    /// As [`Ray1::is_open`], ray by ray.
    pub fn open(&self) -> [bool; N] {
        self.far.map(|far| far >= 0.0)
    }
}

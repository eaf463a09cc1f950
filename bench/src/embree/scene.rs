//! A scene of triangles, built at quality high, and the queries on it.

use super::{
    api::{
        Arguments, FLAG_COMPACT, FLAG_ROBUST, FLOAT3, Handle, INDEX, OccludedPacket, QUALITY_HIGH, TRIANGLES,
        UINT3, VERTEX,
    },
    device::Device,
    rays::{NOTHING, Packet, Ray1, RayHit1},
};
use conray_core::{Geometry, Ray, Vec3};
use std::{
    ffi::{c_int, c_void},
    ptr,
    sync::Arc,
    time::Instant,
};

/// What a scene is asked to be beyond the defaults.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SceneFlags {
    /// Tests that miss no ray between neighbours, and cost some speed.
    pub robust: bool,
    /// Less memory, and some speed lost.
    pub compact: bool,
}

/// A scene in Embree.
pub struct Embree {
    device: Arc<Device>,
    handle: Handle,
    build_seconds: f64,
}

/// What a ray meets first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// Distance in lengths of the direction.
    pub t: f32,
    /// Index of the instance in the geometry that the scene was built from.
    pub instance: usize,
    /// Index of the triangle in its mesh.
    pub triangle: usize,
    /// Barycentric weights of the second and the third corner.
    pub barycentric: [f32; 2],
}

// SAFETY: Embree documents that committed scenes may be queried from any number of threads at once; nothing here
// changes them after `Embree::build`.
unsafe impl Send for Embree {}
// SAFETY: as above.
unsafe impl Sync for Embree {}

impl Embree {
    /// Builds a scene of all triangles in world space, every surface opaque, at quality high (spatial splits).
    ///
    /// # Errors
    /// What Embree says.
    pub fn build(device: &Arc<Device>, geometry: &Geometry, flags: SceneFlags) -> Result<Self, String> {
        let api = &device.api;
        // SAFETY: the device lives; handles come from the calls before, in the documented order: scene, settings,
        // geometries attached, commit.
        let mut scene = unsafe {
            let handle = (api.new_scene)(device.handle);
            (api.set_quality)(handle, QUALITY_HIGH);
            let bits =
                if flags.robust { FLAG_ROBUST } else { 0 } | if flags.compact { FLAG_COMPACT } else { 0 };
            (api.set_flags)(handle, bits);
            Self { device: Arc::clone(device), handle, build_seconds: 0.0 }
        };
        for (index, instance) in geometry.instances().iter().enumerate() {
            let mesh = geometry.mesh_of(index);
            let place = |&p: &Vec3| instance.world_from_mesh.transform_point3(p);
            let corners: Vec<Vec3> = mesh.positions().iter().map(place).collect();
            scene.attach(&corners, mesh.triangles())?;
        }
        let start = Instant::now();
        // SAFETY: as above.
        unsafe { (api.commit_scene)(scene.handle) };
        scene.build_seconds = start.elapsed().as_secs_f64();
        device.check()?;
        Ok(scene)
    }

    /// One mesh into the scene; its id is the number of meshes before it.
    fn attach(&self, corners: &[Vec3], triangles: &[[u32; 3]]) -> Result<(), String> {
        let api = &self.device.api;
        // SAFETY: as in `build`; Embree allocates both buffers with the sizes given, and pads them itself.
        unsafe {
            let mesh = (api.new_geometry)(self.device.handle, TRIANGLES);
            let place = (api.new_buffer)(mesh, VERTEX, 0, FLOAT3, 12, corners.len());
            let index = (api.new_buffer)(mesh, INDEX, 0, UINT3, 12, triangles.len());
            if place.is_null() || index.is_null() {
                return Err("Embree gave no memory".into());
            }
            ptr::copy_nonoverlapping(corners.as_ptr().cast::<u8>(), place.cast(), 12 * corners.len());
            ptr::copy_nonoverlapping(triangles.as_ptr().cast::<u8>(), index.cast(), 12 * triangles.len());
            (api.commit_geometry)(mesh);
            (api.attach_geometry)(self.handle, mesh);
            (api.release_geometry)(mesh);
        }
        self.device.check()
    }

    /// Wall-clock seconds of `rtcCommitScene`, which builds; the triangles were in Embree's buffers by then.
    pub fn build_seconds(&self) -> f64 {
        self.build_seconds
    }

    /// What a ray meets first.
    pub fn nearest(&self, ray: &Ray) -> Option<Nearest> {
        let mut hit = RayHit1::new(ray);
        // SAFETY: the scene is committed; the layout is as documented; null stands for the default arguments.
        unsafe { (self.device.api.intersect1)(self.handle, &raw mut hit, ptr::null_mut()) };
        (hit.geometry != NOTHING).then_some(Nearest {
            t: hit.ray.far,
            instance: hit.geometry as usize,
            triangle: hit.triangle as usize,
            barycentric: [hit.u, hit.v],
        })
    }

    /// Traces rays one by one with `rtcOccluded1`; each then knows whether it is open.
    #[inline]
    pub fn occluded1(&self, rays: &mut [Ray1]) {
        for ray in rays {
            // SAFETY: the scene is committed; the ray has the documented layout; null stands for the default
            // arguments.
            unsafe { (self.device.api.occluded1)(self.handle, ray, ptr::null_mut()) };
        }
    }

    /// Traces packets with `rtcOccluded4`, `8` or `16`; each then knows which of its rays are open.
    ///
    /// # Panics
    /// For packets of other sizes.
    #[inline]
    pub fn occluded<const N: usize>(&self, packets: &mut [Packet<N>], coherent: bool) {
        let occluded: OccludedPacket = match N {
            4 => self.device.api.occluded4,
            8 => self.device.api.occluded8,
            16 => self.device.api.occluded16,
            _ => panic!("Embree has no packets of {N} rays"),
        };
        static ALL: Valid = Valid([-1; 16]);
        let mut arguments = Arguments::new(coherent);
        for packet in packets {
            // SAFETY: the scene is committed; mask and packet are aligned to 64 bytes and hold N items or more.
            unsafe {
                occluded(
                    ALL.0.as_ptr(),
                    self.handle,
                    ptr::from_mut(packet).cast::<c_void>(),
                    &raw mut arguments,
                );
            }
        }
    }
}

/// Every ray takes part.
#[repr(C, align(64))]
struct Valid([c_int; 16]);

impl Drop for Embree {
    fn drop(&mut self) {
        // SAFETY: the handle is ours and is not used again; the device outlives it.
        unsafe { (self.device.api.release_scene)(self.handle) };
    }
}

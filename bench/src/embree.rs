//! Embree 4, loaded at run time: the rival of our ray kernels.
//!
//! Declarations after the documented C API ("Intel Embree API Reference", version 4). The library is never linked;
//! `bench/fetch-rivals` fetches it. Everything unsafe about it is in this module.
#![allow(unsafe_code, reason = "a C library is called")]

use conray_core::{Geometry, Ray, Vec3};
use libloading::Library;
use std::{
    ffi::{c_char, c_int, c_uint, c_void},
    path::{Path, PathBuf},
    ptr,
};

/// Four-byte items of a ray in the order of `RTCRay`: origin, near distance, direction, time, far distance, mask, id, flags.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
pub struct Ray1 {
    origin: [f32; 3],
    near: f32,
    direction: [f32; 3],
    time: f32,
    far: f32,
    mask: u32,
    id: u32,
    flags: u32,
}

/// Sixteen rays, member by member: `RTCRay16`.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Ray16 {
    origin: [[f32; 16]; 3],
    near: [f32; 16],
    direction: [[f32; 16]; 3],
    time: [f32; 16],
    far: [f32; 16],
    mask: [u32; 16],
    id: [u32; 16],
    flags: [u32; 16],
}

const _: () = assert!(size_of::<Ray1>() == 48 && size_of::<Ray16>() == 768);

/// `RTCOccludedArguments`.
#[repr(C)]
struct Arguments {
    flags: c_uint,
    feature_mask: c_uint,
    context: *mut c_void,
    filter: *const c_void,
    occluded: *const c_void,
}

type Handle = *mut c_void;

/// The functions that are used.
struct Api {
    new_device: unsafe extern "C" fn(*const c_char) -> Handle,
    device_error: unsafe extern "C" fn(Handle) -> c_int,
    new_scene: unsafe extern "C" fn(Handle) -> Handle,
    set_quality: unsafe extern "C" fn(Handle, c_int),
    set_flags: unsafe extern "C" fn(Handle, c_int),
    new_geometry: unsafe extern "C" fn(Handle, c_int) -> Handle,
    new_buffer: unsafe extern "C" fn(Handle, c_int, c_uint, c_int, usize, usize) -> *mut c_void,
    commit_geometry: unsafe extern "C" fn(Handle),
    attach_geometry: unsafe extern "C" fn(Handle, Handle) -> c_uint,
    release_geometry: unsafe extern "C" fn(Handle),
    commit_scene: unsafe extern "C" fn(Handle),
    release_scene: unsafe extern "C" fn(Handle),
    release_device: unsafe extern "C" fn(Handle),
    occluded1: unsafe extern "C" fn(Handle, *mut Ray1, *mut Arguments),
    occluded16: unsafe extern "C" fn(*const c_int, Handle, *mut Ray16, *mut Arguments),
    /// Keeps the functions there; dropped last.
    _library: Library,
}

/// A scene in Embree.
pub struct Embree {
    api: Api,
    device: Handle,
    scene: Handle,
}

// SAFETY: Embree documents that devices and committed scenes may be used from any number of threads at once; nothing
// here changes them after `Embree::build`.
unsafe impl Send for Embree {}
// SAFETY: as above.
unsafe impl Sync for Embree {}

const QUALITY_HIGH: c_int = 2;
const FLAG_ROBUST: c_int = 1 << 2;
const TRIANGLES: c_int = 0;
const INDEX: c_int = 0;
const VERTEX: c_int = 1;
const UINT3: c_int = 0x5003;
const FLOAT3: c_int = 0x9003;
const COHERENT: c_uint = 1 << 16;

impl Embree {
    /// The library where `bench/fetch-rivals` puts it, or where `CONRAY_EMBREE` says.
    pub fn find() -> Option<PathBuf> {
        if let Some(path) = std::env::var_os("CONRAY_EMBREE") {
            return Some(path.into());
        }
        let named =
            |path: &PathBuf| path.file_name().is_some_and(|n| n.to_string_lossy().starts_with("libembree4"));
        let entries = std::fs::read_dir("target/rivals/embree").ok()?;
        entries.filter_map(|e| Some(e.ok()?.path())).find(named)
    }

    /// Loads the library and builds a scene of all triangles in world space, every surface opaque, quality high.
    ///
    /// # Errors
    /// What cannot be loaded, or what Embree says.
    pub fn build(path: &Path, geometry: &Geometry, robust: bool) -> Result<Self, String> {
        let api = Api::load(path)?;
        // SAFETY: each call follows the documented order (device, scene, geometry, buffers, commit, attach, commit);
        // handles come from the calls before; the buffers are written within the sizes asked for.
        unsafe {
            let device = (api.new_device)(ptr::null());
            if device.is_null() {
                return Err("Embree gave no device".into());
            }
            let scene = (api.new_scene)(device);
            (api.set_quality)(scene, QUALITY_HIGH);
            if robust {
                (api.set_flags)(scene, FLAG_ROBUST);
            }
            let embree = Self { api, device, scene };
            for (index, instance) in geometry.instances().iter().enumerate() {
                let mesh = geometry.mesh_of(index);
                let corners: Vec<Vec3> =
                    mesh.positions().iter().map(|&p| instance.world_from_mesh.transform_point3(p)).collect();
                embree.attach(&corners, mesh.triangles())?;
            }
            (embree.api.commit_scene)(scene);
            embree.check()?;
            Ok(embree)
        }
    }

    /// One mesh into the scene.
    fn attach(&self, corners: &[Vec3], triangles: &[[u32; 3]]) -> Result<(), String> {
        let api = &self.api;
        // SAFETY: as in `build`; Embree allocates both buffers with the sizes given, and pads them itself.
        unsafe {
            let mesh = (api.new_geometry)(self.device, TRIANGLES);
            let place = (api.new_buffer)(mesh, VERTEX, 0, FLOAT3, 12, corners.len());
            let index = (api.new_buffer)(mesh, INDEX, 0, UINT3, 12, triangles.len());
            if place.is_null() || index.is_null() {
                return Err("Embree gave no memory".into());
            }
            ptr::copy_nonoverlapping(corners.as_ptr().cast::<u8>(), place.cast(), 12 * corners.len());
            ptr::copy_nonoverlapping(triangles.as_ptr().cast::<u8>(), index.cast(), 12 * triangles.len());
            (api.commit_geometry)(mesh);
            (api.attach_geometry)(self.scene, mesh);
            (api.release_geometry)(mesh);
        }
        self.check()
    }

    fn check(&self) -> Result<(), String> {
        // SAFETY: the device lives as long as self.
        match unsafe { (self.api.device_error)(self.device) } {
            0 => Ok(()),
            code => Err(format!("Embree reports error {code}")),
        }
    }

    /// True where something is in the way.
    #[inline]
    pub fn occluded1(&self, ray: &mut Ray1) -> bool {
        // SAFETY: the scene is committed; the ray has the documented layout; null stands for the default arguments.
        unsafe { (self.api.occluded1)(self.scene, ray, ptr::null_mut()) };
        ray.far < 0.0
    }

    /// Bit i is set where something is in the way of ray i.
    #[inline]
    pub fn occluded16(&self, rays: &mut Ray16, coherent: bool) -> u16 {
        const ALL: &[c_int; 16] = &Valid([-1; 16]).0;
        let flags = if coherent { COHERENT } else { 0 };
        let mut arguments = Arguments {
            flags,
            feature_mask: !0,
            context: ptr::null_mut(),
            filter: ptr::null(),
            occluded: ptr::null(),
        };
        // SAFETY: as above; the mask is aligned to 64 bytes.
        unsafe { (self.api.occluded16)(ALL.as_ptr(), self.scene, rays, &raw mut arguments) };
        rays.far.iter().enumerate().fold(0, |bits, (i, far)| bits | u16::from(*far < 0.0) << i)
    }
}

#[repr(C, align(64))]
struct Valid([c_int; 16]);

impl Drop for Embree {
    fn drop(&mut self) {
        // SAFETY: both handles are ours and are not used again.
        unsafe {
            (self.api.release_scene)(self.scene);
            (self.api.release_device)(self.device);
        }
    }
}

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
}

impl Ray16 {
    /// Sixteen rays from one origin.
    pub fn new(origin: Vec3, directions: &[Vec3], t_max: f32) -> Self {
        let axis = |a: usize| std::array::from_fn(|i| directions[i][a]);
        Self {
            origin: [0, 1, 2].map(|a| [origin[a]; 16]),
            near: [0.0; 16],
            direction: [0, 1, 2].map(axis),
            time: [0.0; 16],
            far: [t_max; 16],
            mask: [!0; 16],
            id: [0; 16],
            flags: [0; 16],
        }
    }
}

impl Api {
    fn load(path: &Path) -> Result<Self, String> {
        let name = |e: libloading::Error| format!("{}: {e}", path.display());
        // SAFETY: Embree's initialisers have no requirements; the symbols have the types of its documented C API.
        unsafe {
            // Its own copy of TBB lies beside it under a name of its own.
            for entry in path.parent().and_then(|f| std::fs::read_dir(f).ok()).into_iter().flatten().flatten()
            {
                if entry.file_name().to_string_lossy().starts_with("libtbb") {
                    std::mem::forget(Library::new(entry.path()).map_err(name)?);
                }
            }
            let library = Library::new(path).map_err(name)?;
            macro_rules! symbol {
                ($name:literal) => {
                    *library.get($name).map_err(name)?
                };
            }
            Ok(Self {
                new_device: symbol!(b"rtcNewDevice\0"),
                device_error: symbol!(b"rtcGetDeviceError\0"),
                new_scene: symbol!(b"rtcNewScene\0"),
                set_quality: symbol!(b"rtcSetSceneBuildQuality\0"),
                set_flags: symbol!(b"rtcSetSceneFlags\0"),
                new_geometry: symbol!(b"rtcNewGeometry\0"),
                new_buffer: symbol!(b"rtcSetNewGeometryBuffer\0"),
                commit_geometry: symbol!(b"rtcCommitGeometry\0"),
                attach_geometry: symbol!(b"rtcAttachGeometry\0"),
                release_geometry: symbol!(b"rtcReleaseGeometry\0"),
                commit_scene: symbol!(b"rtcCommitScene\0"),
                release_scene: symbol!(b"rtcReleaseScene\0"),
                release_device: symbol!(b"rtcReleaseDevice\0"),
                occluded1: symbol!(b"rtcOccluded1\0"),
                occluded16: symbol!(b"rtcOccluded16\0"),
                _library: library,
            })
        }
    }
}

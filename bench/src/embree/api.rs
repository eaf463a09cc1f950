//! The functions of the C API that are used, with their types and constants.

use super::rays::{Ray1, RayHit1};
use libloading::Library;
use std::{
    ffi::{c_char, c_int, c_uint, c_void},
    path::Path,
    ptr,
};

/// A device, scene or geometry.
pub(super) type Handle = *mut c_void;

/// `rtcOccluded4`, `8` and `16`: which rays take part (-1 or 0 each), scene, rays, arguments.
pub(super) type OccludedPacket = unsafe extern "C" fn(*const c_int, Handle, *mut c_void, *mut Arguments);

pub(super) const QUALITY_HIGH: c_int = 2;
pub(super) const FLAG_COMPACT: c_int = 1 << 1;
pub(super) const FLAG_ROBUST: c_int = 1 << 2;
pub(super) const TRIANGLES: c_int = 0;
pub(super) const INDEX: c_int = 0;
pub(super) const VERTEX: c_int = 1;
pub(super) const UINT3: c_int = 0x5003;
pub(super) const FLOAT3: c_int = 0x9003;
pub(super) const PROPERTY_VERSION: c_int = 0;
const QUERY_COHERENT: c_uint = 1 << 16;

/// `RTCOccludedArguments`.
#[repr(C)]
pub(super) struct Arguments {
    flags: c_uint,
    feature_mask: c_uint,
    context: *mut c_void,
    filter: *const c_void,
    occluded: *const c_void,
}

impl Arguments {
    /// The documented defaults, with or without the hint that neighbouring rays go about the same way.
    pub(super) fn new(coherent: bool) -> Self {
        Self {
            flags: if coherent { QUERY_COHERENT } else { 0 },
            feature_mask: !0,
            context: ptr::null_mut(),
            filter: ptr::null(),
            occluded: ptr::null(),
        }
    }
}

/// The functions that are used.
pub(super) struct Api {
    pub(super) new_device: unsafe extern "C" fn(*const c_char) -> Handle,
    pub(super) device_error: unsafe extern "C" fn(Handle) -> c_int,
    pub(super) device_property: unsafe extern "C" fn(Handle, c_int) -> isize,
    pub(super) release_device: unsafe extern "C" fn(Handle),
    pub(super) new_scene: unsafe extern "C" fn(Handle) -> Handle,
    pub(super) set_quality: unsafe extern "C" fn(Handle, c_int),
    pub(super) set_flags: unsafe extern "C" fn(Handle, c_int),
    pub(super) commit_scene: unsafe extern "C" fn(Handle),
    pub(super) release_scene: unsafe extern "C" fn(Handle),
    pub(super) new_geometry: unsafe extern "C" fn(Handle, c_int) -> Handle,
    pub(super) new_buffer: unsafe extern "C" fn(Handle, c_int, c_uint, c_int, usize, usize) -> *mut c_void,
    pub(super) commit_geometry: unsafe extern "C" fn(Handle),
    pub(super) attach_geometry: unsafe extern "C" fn(Handle, Handle) -> c_uint,
    pub(super) release_geometry: unsafe extern "C" fn(Handle),
    pub(super) intersect1: unsafe extern "C" fn(Handle, *mut RayHit1, *mut c_void),
    pub(super) occluded1: unsafe extern "C" fn(Handle, *mut Ray1, *mut Arguments),
    pub(super) occluded4: OccludedPacket,
    pub(super) occluded8: OccludedPacket,
    pub(super) occluded16: OccludedPacket,
    /// Keeps the functions there; dropped last.
    _library: Library,
}

impl Api {
    /// Loads the library, and before it the copy of TBB that lies beside it under a name of its own.
    pub(super) fn load(path: &Path) -> Result<Self, String> {
        let name = |e: libloading::Error| format!("{}: {e}", path.display());
        let beside = path.parent().and_then(|folder| std::fs::read_dir(folder).ok());
        // SAFETY: the initialisers of both libraries have no requirements; the symbols have the types of the
        // documented C API.
        unsafe {
            for entry in beside.into_iter().flatten().flatten() {
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
                device_property: symbol!(b"rtcGetDeviceProperty\0"),
                release_device: symbol!(b"rtcReleaseDevice\0"),
                new_scene: symbol!(b"rtcNewScene\0"),
                set_quality: symbol!(b"rtcSetSceneBuildQuality\0"),
                set_flags: symbol!(b"rtcSetSceneFlags\0"),
                commit_scene: symbol!(b"rtcCommitScene\0"),
                release_scene: symbol!(b"rtcReleaseScene\0"),
                new_geometry: symbol!(b"rtcNewGeometry\0"),
                new_buffer: symbol!(b"rtcSetNewGeometryBuffer\0"),
                commit_geometry: symbol!(b"rtcCommitGeometry\0"),
                attach_geometry: symbol!(b"rtcAttachGeometry\0"),
                release_geometry: symbol!(b"rtcReleaseGeometry\0"),
                intersect1: symbol!(b"rtcIntersect1\0"),
                occluded1: symbol!(b"rtcOccluded1\0"),
                occluded4: symbol!(b"rtcOccluded4\0"),
                occluded8: symbol!(b"rtcOccluded8\0"),
                occluded16: symbol!(b"rtcOccluded16\0"),
                _library: library,
            })
        }
    }
}

//! A device: the loaded library with one configuration of it.

use super::api::{Api, Handle, PROPERTY_VERSION};
use std::{ffi::CString, path::PathBuf, sync::Arc};

/// Embree with its threads and settings; scenes are built on it.
pub struct Device {
    pub(super) api: Api,
    pub(super) handle: Handle,
}

// SAFETY: Embree documents that devices may be used from any number of threads at once.
unsafe impl Send for Device {}
// SAFETY: as above.
unsafe impl Sync for Device {}

impl Device {
    /// The library where `bench/fetch-rivals` puts it, or where `CONRAY_EMBREE` says.
    pub fn find() -> Option<PathBuf> {
        if let Some(path) = std::env::var_os("CONRAY_EMBREE") {
            return Some(path.into());
        }
        let named =
            |path: &PathBuf| path.file_name().is_some_and(|n| n.to_string_lossy().starts_with("libembree4"));
        // From the root of the repository, and from the crate, where its tests run.
        ["target", "../target"].iter().find_map(|target| {
            let entries = std::fs::read_dir(format!("{target}/rivals/embree")).ok()?;
            entries.filter_map(|e| Some(e.ok()?.path())).find(named)
        })
    }

    /// Loads the library and makes a device.
    ///
    /// `config` is a configuration as `rtcNewDevice` documents it, such as `max_isa=avx2` or `hugepages=1`; empty for
    /// the defaults: all threads and the widest instructions that the processor has.
    ///
    /// # Errors
    /// Where there is no library, what cannot be loaded, or what Embree says.
    pub fn new(config: &str) -> Result<Arc<Self>, String> {
        let path = Self::find().ok_or("Embree is not there: run bench/fetch-rivals embree")?;
        let api = Api::load(&path)?;
        let text = CString::new(config).map_err(|e| format!("Embree's configuration: {e}"))?;
        // SAFETY: the text ends with a zero and lives through the call.
        let handle = unsafe { (api.new_device)(text.as_ptr()) };
        if handle.is_null() {
            return Err(format!("Embree gave no device for the configuration \"{config}\""));
        }
        Ok(Arc::new(Self { api, handle }))
    }

    /// Version as a number: 40400 is 4.4.0.
    pub fn version(&self) -> isize {
        // SAFETY: the device lives as long as self.
        unsafe { (self.api.device_property)(self.handle, PROPERTY_VERSION) }
    }

    /// The error since the last call, if there was one.
    pub(super) fn check(&self) -> Result<(), String> {
        // SAFETY: the device lives as long as self.
        match unsafe { (self.api.device_error)(self.handle) } {
            0 => Ok(()),
            code => Err(format!("Embree reports error {code}")),
        }
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: the handle is ours and is not used again; scenes keep the device alive.
        unsafe { (self.api.release_device)(self.handle) };
    }
}

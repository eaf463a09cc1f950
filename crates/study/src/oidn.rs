//! Intel Open Image Denoise 2, opened when the program runs.
//!
//! Afra, "Intel Open Image Denoise", 2019 and later, a neural network for images of path tracers. Declared here from
//! its documented C interface: nothing of it is needed to build conray, and without it one contender stays out.
//! Everything unsafe of this crate is in this file, behind safe functions.
#![allow(unsafe_code, reason = "functions of a C library are called, and only here")]

mod look_up;
#[cfg(test)]
mod tests;

use libloading::Library;
use std::{
    cell::Cell,
    ffi::{CStr, c_char, c_int, c_void},
    path::Path,
    ptr,
    sync::OnceLock,
};

/// A device, filter or image of the library.
type Handle = *mut c_void;

/// The library's number for its device on the CPU.
const CPU: c_int = 1;

/// The functions of the library that are called, by their C names.
pub(crate) struct Api {
    new_device: unsafe extern "C" fn(c_int) -> Handle,
    set_device_int: unsafe extern "C" fn(Handle, *const c_char, c_int),
    set_device_bool: unsafe extern "C" fn(Handle, *const c_char, bool),
    get_device_int: unsafe extern "C" fn(Handle, *const c_char) -> c_int,
    commit_device: unsafe extern "C" fn(Handle),
    get_device_error: unsafe extern "C" fn(Handle, *mut *const c_char) -> c_int,
    release_device: unsafe extern "C" fn(Handle),
    new_filter: unsafe extern "C" fn(Handle, *const c_char) -> Handle,
    set_shared_filter_image:
        unsafe extern "C" fn(Handle, *const c_char, Handle, c_int, usize, usize, usize, usize, usize),
    set_filter_bool: unsafe extern "C" fn(Handle, *const c_char, bool),
    commit_filter: unsafe extern "C" fn(Handle),
    execute_filter: unsafe extern "C" fn(Handle),
    release_filter: unsafe extern "C" fn(Handle),
    /// Kept open for as long as its functions are known.
    _library: Library,
}

impl Api {
    /// The library as found on first use, or in one sentence why there is none.
    pub(crate) fn get() -> Result<&'static Self, &'static str> {
        static FOUND: OnceLock<Result<Api, String>> = OnceLock::new();
        FOUND.get_or_init(look_up::look_up).as_ref().map_err(String::as_str)
    }

    /// Opens one file. `Ok(None)` where there is no such library.
    fn open(file: &Path) -> Result<Option<Self>, String> {
        // SAFETY: opening runs the initialisers of the library, which a person has installed or named as this one; what
        // they do is as trustworthy as that.
        let library = match unsafe { Library::new(file) } {
            Ok(library) => library,
            // Names are left to the loader: that it does not know one is no problem yet.
            Err(error) if file.exists() => return Err(format!("{}: {error}", file.display())),
            Err(_) => return Ok(None),
        };
        let lacks = |name: &str| format!("{}: lacks {name}; version 2 is needed", file.display());
        macro_rules! function {
            ($name:literal) => {{
                // SAFETY: the types of `Api` are those of the functions of that name in the C header of version 2.
                *unsafe { library.get($name) }.map_err(|_| lacks($name))?
            }};
        }
        let api = Self {
            new_device: function!("oidnNewDevice"),
            set_device_int: function!("oidnSetDeviceInt"),
            set_device_bool: function!("oidnSetDeviceBool"),
            get_device_int: function!("oidnGetDeviceInt"),
            commit_device: function!("oidnCommitDevice"),
            get_device_error: function!("oidnGetDeviceError"),
            release_device: function!("oidnReleaseDevice"),
            new_filter: function!("oidnNewFilter"),
            set_shared_filter_image: function!("oidnSetSharedFilterImage"),
            set_filter_bool: function!("oidnSetFilterBool"),
            commit_filter: function!("oidnCommitFilter"),
            execute_filter: function!("oidnExecuteFilter"),
            release_filter: function!("oidnReleaseFilter"),
            _library: library,
        };
        match api.version()? {
            2 => Ok(Some(api)),
            other => Err(format!("{}: is version {other}; version 2 is needed", file.display())),
        }
    }

    /// Major version, as a device tells.
    fn version(&self) -> Result<c_int, String> {
        let device = self.device()?;
        // SAFETY: the device is one of this library and is released once; the name is a C string.
        unsafe {
            let version = (self.get_device_int)(device, c"versionMajor".as_ptr());
            (self.release_device)(device);
            Ok(version)
        }
    }

    fn device(&self) -> Result<Handle, String> {
        // SAFETY: takes a number and gives a handle, null where there is no such device.
        let device = unsafe { (self.new_device)(CPU) };
        if device.is_null() { Err(self.error(device).unwrap_or_default()) } else { Ok(device) }
    }

    /// What went wrong since the last call, if anything did. A null device asks about the thread.
    fn error(&self, device: Handle) -> Option<String> {
        let mut message = ptr::null();
        // SAFETY: the device is null or live, and the message outlives this function: it is kept until the next error.
        unsafe {
            let code = (self.get_device_error)(device, &raw mut message);
            let told = !message.is_null();
            (code != 0 || device.is_null()).then(|| match told {
                true => CStr::from_ptr(message).to_string_lossy().into_owned(),
                false => format!("error {code}"),
            })
        }
    }
}

/// A filter made ready for images of one size.
pub(crate) struct Denoiser {
    api: &'static Api,
    device: Handle,
    filter: Handle,
    size: (usize, usize),
    /// Buffers that the filter knows by address, never resized. Cells, because the library writes behind Rust's back.
    noisy: Vec<Cell<f32>>,
    denoised: Vec<Cell<f32>>,
    _guides: [Vec<Cell<f32>>; 2],
}

// SAFETY: the library's functions may be called from any thread; the handles and buffers belong to this value alone.
unsafe impl Send for Denoiser {}

impl Denoiser {
    /// For linear grey images of that width and height, on that many threads.
    ///
    /// `normals` are three numbers a pixel without noise, all 0 in the background; the library then takes an albedo as
    /// well, which is 1 here.
    pub(crate) fn new(
        api: &'static Api,
        size: (usize, usize),
        threads: usize,
        normals: Option<&[f32]>,
    ) -> Result<Self, String> {
        let pixels = size.0 * size.1;
        let cells = |values: &[f32]| values.iter().map(|&v| Cell::new(v)).collect::<Vec<_>>();
        let guides = match normals {
            Some(normals) if normals.len() == 3 * pixels => [cells(&vec![1.0; 3 * pixels]), cells(normals)],
            Some(normals) => return Err(format!("{} numbers in normals for {pixels} pixels", normals.len())),
            None => [Vec::new(), Vec::new()],
        };
        let (noisy, denoised) = (cells(&vec![0.0; pixels]), cells(&vec![0.0; pixels]));
        let device = api.device()?;
        // From here on dropping releases what there is.
        let mut new = Self { api, device, filter: ptr::null_mut(), size, noisy, denoised, _guides: guides };
        let threads = c_int::try_from(threads).unwrap_or(0);
        // SAFETY: the device is live and not yet committed; names are C strings.
        new.filter = unsafe {
            (api.set_device_int)(device, c"numThreads".as_ptr(), threads);
            // Pinned threads would stand in the way of whatever else runs.
            (api.set_device_bool)(device, c"setAffinity".as_ptr(), false);
            (api.commit_device)(device);
            (api.new_filter)(device, c"RT".as_ptr())
        };
        new.check()?;
        new.set_image(c"color", &new.noisy);
        new.set_image(c"output", &new.denoised);
        if normals.is_some() {
            new.set_image(c"albedo", &new._guides[0]);
            new.set_image(c"normal", &new._guides[1]);
        }
        // SAFETY: the filter is live, as checked; names are C strings.
        unsafe {
            // Visibility is linear: taken as a displayed image it would be brightened.
            (api.set_filter_bool)(new.filter, c"hdr".as_ptr(), true);
            (api.set_filter_bool)(new.filter, c"cleanAux".as_ptr(), normals.is_some());
            (api.commit_filter)(new.filter);
        }
        new.check()?;
        Ok(new)
    }

    /// Denoises one image, row by row from the top.
    pub(crate) fn denoise(&self, image: &[f32]) -> Result<Vec<f32>, String> {
        if image.len() != self.noisy.len() {
            return Err(format!("an image of {} pixels for {}", image.len(), self.noisy.len()));
        }
        self.noisy.iter().zip(image).for_each(|(cell, &value)| cell.set(value));
        // SAFETY: the filter is live and its buffers are those of this value, in place; the call returns when done, and
        // this value is not shared between threads, so that nobody else touches the buffers meanwhile.
        unsafe { (self.api.execute_filter)(self.filter) };
        self.check()?;
        Ok(self.denoised.iter().map(Cell::get).collect())
    }

    /// Tells the filter of an image of 1 or 3 numbers a pixel.
    fn set_image(&self, name: &CStr, cells: &[Cell<f32>]) {
        let (width, height) = self.size;
        // The library numbers formats by their count of floats.
        let format = if cells.len() == width * height { 1 } else { 3 };
        // SAFETY: the filter is live; the buffer has that many pixels and is as long-lived as the filter; its cells may
        // be written through a shared pointer. Offset and strides of 0 mean densely packed.
        unsafe {
            let data = cells.as_ptr().cast_mut().cast();
            (self.api.set_shared_filter_image)(
                self.filter,
                name.as_ptr(),
                data,
                format,
                width,
                height,
                0,
                0,
                0,
            );
        }
    }

    fn check(&self) -> Result<(), String> {
        self.api.error(self.device).map_or(Ok(()), Err)
    }
}

impl Drop for Denoiser {
    fn drop(&mut self) {
        // SAFETY: both are handles of this value, released once, the filter before its buffers go.
        unsafe {
            if !self.filter.is_null() {
                (self.api.release_filter)(self.filter);
            }
            (self.api.release_device)(self.device);
        }
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Open Image Denoise 2 through its C interface, loaded at run time: the declarations that are needed, and one safe function.
//! Source: the public header of Open Image Denoise 2.3 (oidn.h), from which names, numbers and types are restated. Nothing
//! else in this crate is `unsafe`.
//! Invariants: the library reports version 2 before a filter is made; all images have their declared sizes.
//! Tests: `oidn::tests`, with a library of our own that has the same functions, and the real one where `OIDN_LIB` names it.

use std::ffi::{CStr, c_char, c_int, c_void};
use std::path::Path;
use std::ptr::null;

use crate::noisy::Triple;

type Handle = *mut c_void;

const DEVICE_CPU: c_int = 1;
const FORMAT_FLOAT3: c_int = 3;

/// The functions of the library. It stays loaded until the program ends.
pub(crate) struct Library {
    new_device: unsafe extern "C" fn(c_int) -> Handle,
    release_device: unsafe extern "C" fn(Handle),
    set_device_int: unsafe extern "C" fn(Handle, *const c_char, c_int),
    get_device_int: unsafe extern "C" fn(Handle, *const c_char) -> c_int,
    device_error: unsafe extern "C" fn(Handle, *mut *const c_char) -> c_int,
    commit_device: unsafe extern "C" fn(Handle),
    new_filter: unsafe extern "C" fn(Handle, *const c_char) -> Handle,
    release_filter: unsafe extern "C" fn(Handle),
    share_image:
        unsafe extern "C" fn(Handle, *const c_char, *mut c_void, c_int, usize, usize, usize, usize, usize),
    set_filter_bool: unsafe extern "C" fn(Handle, *const c_char, bool),
    commit_filter: unsafe extern "C" fn(Handle),
    execute_filter: unsafe extern "C" fn(Handle),
}

impl Library {
    /// Loads the file, which must have all functions that are called here; a bare name is searched by the
    /// system's loader.
    #[cfg(any(unix, windows))]
    pub(crate) fn open(file: &Path) -> Result<Self, String> {
        // SAFETY: loading runs the library's own start code, as the caller requested.
        let library = unsafe { libloading::Library::new(file) };
        let library =
            std::mem::ManuallyDrop::new(library.map_err(|error| error.to_string().replace('\n', " "))?);
        let missing = |name: &CStr| {
            let (file, name) = (file.display(), name.to_string_lossy());
            format!("{file} is not Open Image Denoise 2: it lacks {name}")
        };
        macro_rules! function {
            ($name:literal) => {
                // SAFETY: the symbol has the type of the field that it goes to according to the library's header.
                // Its version is queried next; a library with all these names is trusted that far.
                *unsafe { library.get($name.to_bytes_with_nul()) }.map_err(|_| missing($name))?
            };
        }
        Ok(Self {
            new_device: function!(c"oidnNewDevice"),
            release_device: function!(c"oidnReleaseDevice"),
            set_device_int: function!(c"oidnSetDeviceInt"),
            get_device_int: function!(c"oidnGetDeviceInt"),
            device_error: function!(c"oidnGetDeviceError"),
            commit_device: function!(c"oidnCommitDevice"),
            new_filter: function!(c"oidnNewFilter"),
            release_filter: function!(c"oidnReleaseFilter"),
            share_image: function!(c"oidnSetSharedFilterImage"),
            set_filter_bool: function!(c"oidnSetFilterBool"),
            commit_filter: function!(c"oidnCommitFilter"),
            execute_filter: function!(c"oidnExecuteFilter"),
        })
    }

    /// Loads the file.
    #[cfg(not(any(unix, windows)))]
    pub(crate) fn open(_: &Path) -> Result<Self, String> {
        Err("this system has no shared libraries".into())
    }
}

/// Pictures of one size, row by row.
pub(crate) struct Images<'a> {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) color: &'a [Triple],
    pub(crate) albedo: &'a [Triple],
    pub(crate) normal: &'a [Triple],
}

/// A device on the CPU.
pub(crate) struct Device<'a> {
    library: &'a Library,
    raw: Handle,
}

impl<'a> Device<'a> {
    /// Opens a device of this many threads, and checks that it is of version 2.
    pub(crate) fn open(library: &'a Library, threads: usize) -> Result<Self, String> {
        // SAFETY: the number is that of the CPU.
        let raw = unsafe { (library.new_device)(DEVICE_CPU) };
        let device = Self { library, raw };
        if raw.is_null() {
            device.check()?;
            return Err("it opens no device on this CPU".into());
        }
        let version = device.version();
        if !(20_000..30_000).contains(&version) {
            return Err(format!("its version is {version}, and 2 (20000 to 29999) is needed"));
        }
        let threads = c_int::try_from(threads).unwrap_or(0);
        // SAFETY: the device is open; names end with a zero.
        unsafe {
            (library.set_device_int)(raw, c"numThreads".as_ptr(), threads);
            (library.set_device_int)(raw, c"setAffinity".as_ptr(), 0);
            (library.commit_device)(raw);
        }
        device.check()?;
        Ok(device)
    }

    /// 20303 for 2.3.3.
    pub(crate) fn version(&self) -> c_int {
        // SAFETY: the device is open; the name ends with a zero.
        unsafe { (self.library.get_device_int)(self.raw, c"version".as_ptr()) }
    }

    fn check(&self) -> Result<(), String> {
        let mut text: *const c_char = null();
        // SAFETY: the device is open or null, which queries the thread's last error; `text` takes a pointer.
        let code = unsafe { (self.library.device_error)(self.raw, &raw mut text) };
        if code == 0 {
            return Ok(());
        }
        // SAFETY: the text is null, or ends with a zero and lives until the next call.
        let reason = unsafe { text.as_ref().map(|text| CStr::from_ptr(text)) };
        let reason =
            reason.map_or_else(|| format!("error {code}"), |text| text.to_string_lossy().into_owned());
        Err(reason.replace('\n', " "))
    }

    /// The filter for ray-traced pictures, in linear light without an upper bound.
    pub(crate) fn filter(&self, images: &Images) -> Result<Vec<Triple>, String> {
        let (width, height) = (images.width, images.height);
        for image in [images.color, images.albedo, images.normal] {
            assert_eq!(image.len(), width * height, "an image has as many values as pixels");
        }
        let mut output = vec![[0.0; 3]; width * height];
        let library = self.library;
        // SAFETY: the device is open and the name ends with a zero.
        let filter = unsafe { (library.new_filter)(self.raw, c"RT".as_ptr()) };
        if filter.is_null() {
            self.check()?;
            return Err("it has no filter 'RT'".into());
        }
        // SAFETY: all images are of width x height three floats without gaps, as asserted, and outlive the filter.
        // The library writes only to the output.
        unsafe {
            let share = |name: &CStr, data: *mut c_void| {
                (library.share_image)(filter, name.as_ptr(), data, FORMAT_FLOAT3, width, height, 0, 0, 0);
            };
            share(c"color", images.color.as_ptr().cast_mut().cast());
            share(c"albedo", images.albedo.as_ptr().cast_mut().cast());
            share(c"normal", images.normal.as_ptr().cast_mut().cast());
            share(c"output", output.as_mut_ptr().cast());
            (library.set_filter_bool)(filter, c"hdr".as_ptr(), true);
            (library.commit_filter)(filter);
            (library.execute_filter)(filter);
            (library.release_filter)(filter);
        }
        self.check()?;
        Ok(output)
    }
}

impl Drop for Device<'_> {
    fn drop(&mut self) {
        if !self.raw.is_null() {
            // SAFETY: the device is open; its filters are gone.
            unsafe { (self.library.release_device)(self.raw) };
        }
    }
}

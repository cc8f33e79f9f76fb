// SPDX-License-Identifier: GPL-3.0-or-later
//! `rtcNewDevice` and its kin: devices, their properties, errors and monitors. Source: Embree's manual.
//! Tests: `tests/c/embree.c`.

use std::ffi::{CStr, c_char, c_uint, c_void};
use std::ptr::null_mut;
use std::sync::{Arc, PoisonError};

use crate::device::{Device, Problem, report_without_device, take_error, with_last_message};
use crate::ffi_abi::Code;
use crate::ffi_callbacks::{Callback, ErrorFunction, MemoryFunction};
use crate::ffi_handle::{Handle, guarded, lend, release, retain, shared, with_device};

/// The version of Embree whose calls these are.
const VERSION: [isize; 3] = [4, 4, 0];

/// Opens a device. See Embree's manual.
///
/// # Safety
/// `settings` is null or a text that ends with a zero.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcNewDevice(settings: *const c_char) -> Handle {
    // SAFETY: passed on.
    let settings = (!settings.is_null()).then(|| unsafe { CStr::from_ptr(settings) });
    let settings = settings.map(CStr::to_string_lossy).unwrap_or_default();
    let device = guarded(|| Device::new(&settings).map_err(|problem| report_without_device(&problem)).ok());
    device.map_or(null_mut(), |device| lend(Arc::new(device)))
}

/// Counts a device once more.
///
/// # Safety
/// A device or null.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcRetainDevice(device: Handle) {
    // SAFETY: passed on.
    unsafe { retain::<Device>(device) }
}

/// Counts a device once less.
///
/// # Safety
/// A device or null.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcReleaseDevice(device: Handle) {
    // SAFETY: passed on.
    unsafe { release::<Device>(device) }
}

/// A property by its number; 0 for unsupported features.
///
/// # Safety
/// A device.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcGetDeviceProperty(device: Handle, property: c_uint) -> isize {
    let property_of = |device: &Arc<Device>| {
        Ok(match property {
            0 => 10_000 * VERSION[0] + 100 * VERSION[1] + VERSION[2],
            1 => VERSION[0],
            2 => VERSION[1],
            3 => VERSION[2],
            // Packets of 4, 8 and 16 keep their size and order in callbacks, on all machines.
            32..=34 => 1,
            // Masks, filters, rays that are unsound; triangles, quads, subdivision surfaces, curves, user geometry, points.
            64 | 66 | 67 | 96..=101 => 1,
            // Without back faces: of curves, of spheres.
            62 => isize::from(device.culls_curves),
            63 => isize::from(device.culls_spheres),
            // Without back faces of triangles; compact polygons.
            65 | 68 => 0,
            // Threads of our own; commits may be joined; several scenes at once; processors, not SYCL.
            128 => 0,
            129 | 130 | 140 => 1,
            141 => 0,
            // Properties that Embree's own tests may read.
            1_000_000.. => 0,
            _ => return Err(Problem::argument(format!("unknown property {property}"))),
        })
    };
    // SAFETY: passed on.
    unsafe { with_device(device, property_of) }
}

/// Embree's own tests may set properties; there are none here.
///
/// # Safety
/// A device.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcSetDeviceProperty(device: Handle, property: c_uint, _value: isize) {
    // Numbers from a million on are Embree's own, of its tests.
    let refused = |_: &Arc<Device>| match property {
        1_000_000.. => Ok(()),
        _ => Err(Problem::argument(format!("property {property} cannot be set"))),
    };
    // SAFETY: passed on.
    unsafe { with_device(device, refused) }
}

/// The first error of this thread since the last query; for a null device that of calls without one.
///
/// # Safety
/// A device or null.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcGetDeviceError(device: Handle) -> c_uint {
    // SAFETY: passed on.
    let device = unsafe { shared::<Device>(device) };
    guarded(|| take_error(device.as_deref()) as c_uint)
}

/// The last message of this thread; it is there until the next error.
///
/// # Safety
/// A device or null.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcGetDeviceLastErrorMessage(device: Handle) -> *const c_char {
    // SAFETY: passed on.
    let device = unsafe { shared::<Device>(device) };
    let message = guarded(|| {
        let start = |message: Option<&CStr>| message.map_or(c"".as_ptr(), CStr::as_ptr);
        Some(with_last_message(device.as_deref(), start))
    });
    message.unwrap_or(c"".as_ptr())
}

/// The name of an error.
#[unsafe(no_mangle)]
pub(crate) extern "C-unwind" fn rtcGetErrorString(code: c_uint) -> *const c_char {
    let name = match code {
        0 => c"RTC_ERROR_NONE",
        1 => c"RTC_ERROR_UNKNOWN",
        2 => c"RTC_ERROR_INVALID_ARGUMENT",
        3 => c"RTC_ERROR_INVALID_OPERATION",
        4 => c"RTC_ERROR_OUT_OF_MEMORY",
        5 => c"RTC_ERROR_UNSUPPORTED_CPU",
        6 => c"RTC_ERROR_CANCELLED",
        7 => c"RTC_ERROR_LEVEL_ZERO_RAYTRACING_SUPPORT_MISSING",
        _ => c"Invalid error code",
    };
    name.as_ptr()
}

/// Sets the function that errors are reported to.
///
/// # Safety
/// A device, and a function that may be called with the pointer.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcSetDeviceErrorFunction(
    device: Handle,
    function: Option<ErrorFunction>,
    user: *mut c_void,
) {
    // SAFETY: passed on.
    let callback = unsafe { Callback::new(function, user) };
    // SAFETY: passed on.
    unsafe {
        with_device(device, |device| {
            *device.on_error.lock().unwrap_or_else(PoisonError::into_inner) = callback;
            Ok(())
        });
    }
}

/// Sets the function that memory is reported to.
///
/// # Safety
/// A device, and a function that may be called with the pointer.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcSetDeviceMemoryMonitorFunction(
    device: Handle,
    function: Option<MemoryFunction>,
    user: *mut c_void,
) {
    // SAFETY: passed on.
    let callback = unsafe { Callback::new(function, user) };
    // SAFETY: passed on.
    unsafe {
        with_device(device, |device| {
            *device.monitor.lock().unwrap_or_else(PoisonError::into_inner) = callback;
            Ok(())
        });
    }
}

/// Reports an unsupported call: sets the error of a device, or that of calls without one.
pub(crate) fn absent(name: &str, device: Option<&Device>) {
    let message = format!("{name}: unsupported by libgnurt; see docs/reference/c-rays.md");
    let problem = Problem { code: Code::InvalidOperation, message };
    match device {
        Some(device) => device.report(&problem),
        None => report_without_device(&problem),
    }
}

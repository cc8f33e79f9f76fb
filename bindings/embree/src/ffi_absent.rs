// SPDX-License-Identifier: GPL-3.0-or-later
//! Embree's calls without an implementation here: those of SYCL. They
//! exist, so that programs can be linked and loaded; each reports an error and does nothing else.
//! Source: the names of Embree 4.4's headers. Tests: `tests/c/embree.c`.

use std::ffi::{c_char, c_int, c_void};

use crate::device::Device;
use crate::ffi_device::absent;
use crate::ffi_handle::{Handle, shared};

/// There is no SYCL here: false.
///
/// # Safety
/// Any pointer.
#[unsafe(no_mangle)]
pub(crate) extern "C-unwind" fn rtcIsSYCLDeviceSupported(_device: *const c_void) -> bool {
    false
}

/// No SYCL device is chosen.
///
/// # Safety
/// Any pointer.
#[unsafe(no_mangle)]
pub(crate) extern "C-unwind" fn rtcSYCLDeviceSelector(_device: *const c_void) -> c_int {
    -1
}

/// Not here.
///
/// # Safety
/// Any pointers.
#[unsafe(no_mangle)]
pub(crate) extern "C-unwind" fn rtcNewSYCLDeviceInternal(
    _context: *const c_void,
    _settings: *const c_char,
) -> Handle {
    absent("rtcNewSYCLDevice", None);
    std::ptr::null_mut()
}

/// Nothing to set.
///
/// # Safety
/// A device.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcSetDeviceSYCLDevice(device: Handle, _sycl: *const c_void) {
    // SAFETY: passed on.
    absent("rtcSetDeviceSYCLDevice", unsafe { shared::<Device>(device) }.as_deref());
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Handles: pointers to counted values, lent to the program. Reference counts follow Embree's manual.
//! Invariant: a handle is an `Arc` converted to a pointer; a program must not use one after its last release,
//! by Embree's rules. No panic gets past [`guarded`]. Tests: `tests/c/embree.c`.

use std::ffi::c_void;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use crate::device::{Device, Problem, report_without_device};
use crate::ffi_abi::Code;
use crate::objects::{Buffer, Geometry, Scene};

/// The program's form of a handle.
pub(crate) type Handle = *mut c_void;

/// The type of a handle's target.
pub(crate) trait Object: Sized {
    /// For messages.
    const NAME: &'static str;
    /// Where its errors go.
    fn device(&self) -> &Arc<Device>;
}

impl Object for Scene {
    const NAME: &'static str = "scene";
    fn device(&self) -> &Arc<Device> {
        &self.device
    }
}

impl Object for Geometry {
    const NAME: &'static str = "geometry";
    fn device(&self) -> &Arc<Device> {
        &self.device
    }
}

impl Object for Buffer {
    const NAME: &'static str = "buffer";
    fn device(&self) -> &Arc<Device> {
        &self.device
    }
}

/// A new handle; the program counts one.
pub(crate) fn lend<T>(object: Arc<T>) -> Handle {
    Arc::into_raw(object).cast_mut().cast()
}

/// Counts one more.
///
/// # Safety
/// The handle was made by [`lend`] for a `T`, and is counted at least once.
pub(crate) unsafe fn retain<T>(handle: Handle) {
    if !handle.is_null() {
        // SAFETY: the caller vouches for the handle.
        unsafe { Arc::increment_strong_count(handle.cast::<T>()) };
    }
}

/// Counts one less.
///
/// # Safety
/// As [`retain`]; this count was the program's.
pub(crate) unsafe fn release<T>(handle: Handle) {
    if !handle.is_null() {
        // SAFETY: the caller vouches for the handle.
        guarded(|| unsafe { Arc::decrement_strong_count(handle.cast::<T>()) });
    }
}

/// The value behind a handle, counted by us.
///
/// # Safety
/// As [`retain`].
pub(crate) unsafe fn shared<T>(handle: Handle) -> Option<Arc<T>> {
    if handle.is_null() {
        return None;
    }
    // SAFETY: the caller vouches for the handle; the count that is taken here goes with the `Arc`.
    unsafe {
        Arc::increment_strong_count(handle.cast::<T>());
        Some(Arc::from_raw(handle.cast::<T>()))
    }
}

/// Runs the body of a call, and reports its error: the result then is the type's default.
///
/// # Safety
/// As [`retain`], if the handle is not null.
pub(crate) unsafe fn with<T: Object, R: Default>(
    handle: Handle,
    call: impl FnOnce(&Arc<T>) -> Result<R, Problem>,
) -> R {
    // SAFETY: passed on.
    let Some(object) = (unsafe { shared::<T>(handle) }) else {
        report_without_device(&Problem::argument(format!("the {} is a null pointer", T::NAME)));
        return R::default();
    };
    let device = Arc::clone(object.device());
    report(&device, || call(&object))
}

/// Runs the body of a device's call.
///
/// # Safety
/// As [`with`].
pub(crate) unsafe fn with_device<R: Default>(
    handle: Handle,
    call: impl FnOnce(&Arc<Device>) -> Result<R, Problem>,
) -> R {
    // SAFETY: passed on.
    match unsafe { shared::<Device>(handle) } {
        Some(device) => report(&device, || call(&device)),
        None => {
            report_without_device(&Problem::argument("the device is a null pointer"));
            R::default()
        }
    }
}

fn report<R: Default>(device: &Device, call: impl FnOnce() -> Result<R, Problem>) -> R {
    let answer = catch_unwind(AssertUnwindSafe(call)).unwrap_or_else(|_| Err(unforeseen()));
    answer.unwrap_or_else(|problem| {
        device.report(&problem);
        R::default()
    })
}

pub(crate) fn not_committed() -> Problem {
    Problem::operation("the scene is not committed: call rtcCommitScene first")
}

fn unforeseen() -> Problem {
    Problem { code: Code::Unknown, message: "an error in libgnurt; the call had no effect".into() }
}

/// Runs a call that has no handle; a panic is reported, and the answer is the type's default.
#[inline(always)]
pub(crate) fn guarded<R: Default>(call: impl FnOnce() -> R) -> R {
    catch_unwind(AssertUnwindSafe(call)).unwrap_or_else(|_| {
        panicked();
        R::default()
    })
}

#[cold]
fn panicked() {
    report_without_device(&unforeseen());
}

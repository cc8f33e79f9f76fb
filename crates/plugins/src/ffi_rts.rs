// SPDX-License-Identifier: GPL-3.0-or-later
//! The structures of `openrt/rts.h`, member for member, and reading those that came from a plugin.
//! Invariant: layouts are those of C; members that a plugin's `struct_size` leaves out read as zero.
//! Tests: `tests::layouts`; bindings/openrt/tests/plugins.rs (a C plugin prints the same numbers).

use std::ffi::{CStr, c_char, c_int, c_void};
use std::mem::offset_of;

/// Version of the interface: major << 16 | minor.
pub(crate) const RTS_ABI: u32 = 0x0001_0001;

/// `RTSvec`.
#[repr(C)]
#[derive(Clone, Copy)]
pub(crate) struct Vec3In {
    pub(crate) x: *const f32,
    pub(crate) y: *const f32,
    pub(crate) z: *const f32,
}

/// `RTSvecm`.
#[repr(C)]
#[derive(Clone, Copy)]
pub(crate) struct Vec3Out {
    pub(crate) x: *mut f32,
    pub(crate) y: *mut f32,
    pub(crate) z: *mut f32,
}

/// `RTSparam`.
#[repr(C)]
#[derive(Clone, Copy)]
pub(crate) struct Param {
    pub(crate) name: *const c_char,
    pub(crate) kind: u32,
    pub(crate) count: u32,
    pub(crate) rate: u32,
    pub(crate) offset: u32,
}

/// `RTSrays`.
#[repr(C)]
#[derive(Clone, Copy)]
pub(crate) struct Rays {
    pub(crate) struct_size: u32,
    pub(crate) n: u32,
    pub(crate) org: Vec3In,
    pub(crate) dir: Vec3In,
    pub(crate) tmin: *const f32,
    pub(crate) tmax: *const f32,
    pub(crate) parent: *const u32,
    pub(crate) weight: *const f32,
}

/// `RTShits`.
#[repr(C)]
pub(crate) struct Hits {
    pub(crate) struct_size: u32,
    pub(crate) n: u32,
    pub(crate) shader: *const c_void,
    pub(crate) p: Vec3In,
    pub(crate) ng: Vec3In,
    pub(crate) ns: Vec3In,
    pub(crate) ray_dir: Vec3In,
    pub(crate) t: *const f32,
    pub(crate) b1: *const f32,
    pub(crate) b2: *const f32,
    pub(crate) color: Vec3In,
    pub(crate) texcoord: Vec3In,
    pub(crate) alpha: *const f32,
    pub(crate) object: *const u32,
    pub(crate) instance: *const u32,
    pub(crate) triangle: *const u32,
    pub(crate) depth: *const u32,
    pub(crate) back: *const u8,
}

/// `RTSctx`: plugins only hand it back.
#[repr(C)]
pub(crate) struct Ctx {
    _opaque: [u8; 0],
}

/// `RTShost`.
#[repr(C)]
pub(crate) struct Host {
    pub(crate) struct_size: u32,
    pub(crate) abi: u32,
    pub(crate) param: unsafe extern "C" fn(*mut Ctx, *const Hits, u32, *mut f32),
    pub(crate) light_count: unsafe extern "C" fn(*mut Ctx) -> u32,
    pub(crate) illuminate:
        unsafe extern "C" fn(*mut Ctx, u32, u32, Vec3In, Vec3Out, *mut f32, Vec3Out, *mut u8),
    pub(crate) occluded: unsafe extern "C" fn(*mut Ctx, *const Rays, Vec3Out),
    pub(crate) trace: unsafe extern "C" fn(*mut Ctx, *const Rays, Vec3Out),
    pub(crate) texture: unsafe extern "C" fn(*mut Ctx, u32, u32, *const f32, *const f32, Vec3Out, *mut f32),
    pub(crate) scratch: unsafe extern "C" fn(*mut Ctx, usize) -> *mut c_void,
    pub(crate) log: unsafe extern "C" fn(*mut Ctx, c_int, *const c_char),
}

/// `init` and `fini` of a class.
pub(crate) type BlockFn = unsafe extern "C-unwind" fn(*mut c_void);
/// `prepare` of a class.
pub(crate) type PrepareFn = unsafe extern "C-unwind" fn(*const Host, *mut c_void) -> c_int;
/// `shade` and `transmit` of a class.
pub(crate) type ShadeFn = unsafe extern "C-unwind" fn(*const Host, *mut Ctx, *const Hits, Vec3Out);
/// `miss` of a class.
pub(crate) type MissFn =
    unsafe extern "C-unwind" fn(*const Host, *mut Ctx, *const c_void, *const Rays, Vec3Out);
/// `illuminate` of a class.
pub(crate) type IlluminateFn = unsafe extern "C-unwind" fn(
    *const Host,
    *mut Ctx,
    *const c_void,
    u32,
    Vec3In,
    Vec3Out,
    *mut f32,
    Vec3Out,
    *mut u8,
);
/// `camera` of a class.
pub(crate) type CameraFn = unsafe extern "C-unwind" fn(
    *const Host,
    *mut Ctx,
    *const c_void,
    u32,
    *const f32,
    *const f32,
    Vec3Out,
    Vec3Out,
);

/// `camera_lens` of a class.
pub(crate) type LensFn = unsafe extern "C-unwind" fn(
    *const Host,
    *mut Ctx,
    *const c_void,
    u32,
    *const f32,
    *const f32,
    *const f32,
    *const f32,
    *const f32,
    Vec3Out,
    Vec3Out,
);

/// `RTSclass`.
#[repr(C)]
#[derive(Clone, Copy)]
pub(crate) struct Class {
    pub(crate) struct_size: u32,
    pub(crate) kind: u32,
    pub(crate) flags: u32,
    pub(crate) name: *const c_char,
    pub(crate) shader_size: u32,
    pub(crate) shader_align: u32,
    pub(crate) triangle_size: u32,
    pub(crate) vertex_size: u32,
    pub(crate) param_count: u32,
    pub(crate) params: *const Param,
    pub(crate) init: Option<BlockFn>,
    pub(crate) fini: Option<BlockFn>,
    pub(crate) prepare: Option<PrepareFn>,
    pub(crate) shade: Option<ShadeFn>,
    pub(crate) transmit: Option<ShadeFn>,
    pub(crate) miss: Option<MissFn>,
    pub(crate) illuminate: Option<IlluminateFn>,
    pub(crate) camera: Option<CameraFn>,
    pub(crate) camera_lens: Option<LensFn>,
}

impl Class {
    /// Bytes that a class must have: all up to its parameters.
    pub(crate) const LEAST: usize = offset_of!(Self, init);
}

/// `RTSmodule`.
#[repr(C)]
#[derive(Clone, Copy)]
pub(crate) struct Module {
    pub(crate) struct_size: u32,
    pub(crate) abi: u32,
    pub(crate) class_count: u32,
    pub(crate) classes: *const *const Class,
}

/// `rts_module`.
pub(crate) type ModuleFn = unsafe extern "C-unwind" fn(u32) -> *const Module;

/// A structure that begins with its size and may be all zeros.
///
/// # Safety
/// The first member is the `u32` `struct_size`, and zero bytes are a value of the type.
pub(crate) unsafe trait Sized32: Copy {}
// SAFETY: it begins with its size; numbers, null pointers and missing functions are zeros.
unsafe impl Sized32 for Class {}
// SAFETY: as above.
unsafe impl Sized32 for Module {}
// SAFETY: as above.
unsafe impl Sized32 for Rays {}

/// A copy of `source`: its stated number of bytes, zeros for missing ones.
///
/// # Safety
/// `source` points to the number of readable bytes that its first four state, at least four.
pub(crate) unsafe fn read_sized<T: Sized32>(source: *const T) -> T {
    // SAFETY: the caller vouches for four bytes.
    let stated = unsafe { source.cast::<u32>().read_unaligned() } as usize;
    let mut copy = std::mem::MaybeUninit::<T>::zeroed();
    let bytes = stated.min(size_of::<T>());
    // SAFETY: `bytes` is within the caller's guarantee, and within the copy.
    unsafe { source.cast::<u8>().copy_to_nonoverlapping(copy.as_mut_ptr().cast::<u8>(), bytes) };
    // SAFETY: zeros are a value by the trait's contract, and the plugin's bytes are members of the same layout.
    unsafe { copy.assume_init() }
}

/// The text at `pointer`, or `None` if it is null.
///
/// # Safety
/// A pointer that is not null points to a text that ends with a zero byte and does not change while the result lives.
pub(crate) unsafe fn text<'a>(pointer: *const c_char) -> Option<&'a CStr> {
    // SAFETY: the caller vouches for the text.
    (!pointer.is_null()).then(|| unsafe { CStr::from_ptr(pointer) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(target_pointer_width = "64")]
    fn layouts() {
        let sizes = [
            size_of::<Vec3In>(),
            size_of::<Param>(),
            size_of::<Rays>(),
            size_of::<Hits>(),
            size_of::<Host>(),
            size_of::<Class>(),
            size_of::<Module>(),
        ];
        // tests/plugins/layout.c has the same numbers.
        assert_eq!(sizes, [24, 24, 88, 232, 72, 128, 24], "sizes on 64-bit machines");
        assert_eq!(Class::LEAST, 56, "up to the parameters");
    }

    #[test]
    fn members_beyond_the_size_are_not_read() {
        let module = Module { struct_size: 8, abi: 7, class_count: 9, classes: std::ptr::null() };
        // SAFETY: it has more bytes than it states.
        let read_back = unsafe { read_sized(&raw const module) };
        assert_eq!((read_back.abi, read_back.class_count), (7, 0), "the count lies beyond");
    }
}

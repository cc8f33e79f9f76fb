// SPDX-License-Identifier: GPL-3.0-or-later
//! `rtcNewBuffer`, `rtcSetSharedGeometryBuffer` and their kin: arrays of geometries.
//! Source: Embree's manual. Tests: `tests/c/embree.c`.

use std::ffi::{c_uint, c_void};
use std::ptr::null_mut;
use std::sync::Arc;

use gnurt_accel::{CurveBasis, CurveForm};

use crate::device::{Device, Problem};
use crate::ffi_abi::{Code, buffer, format};
use crate::ffi_handle::{Handle, lend, release, retain, shared, with, with_device};
use crate::ffi_memory::{Block, Pointer, View};
use crate::objects::{Array, Buffer, Geometry, Kind};
use crate::transform;

pub(crate) fn no_array(of: u32, slot: u32) -> Problem {
    Problem::argument(format!("buffer of type {of} missing in slot {slot}"))
}

fn out_of_memory(bytes: usize) -> Problem {
    Problem { code: Code::OutOfMemory, message: format!("out of memory for {bytes} bytes") }
}

/// A buffer of ours. See Embree's manual, here and below.
///
/// # Safety
/// A device.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcNewBuffer(device: Handle, bytes: usize) -> Handle {
    let new = |device: &Arc<Device>| {
        let block = Arc::new(Block::new(bytes).ok_or_else(|| out_of_memory(bytes))?);
        let start = Pointer(block.start());
        Ok(Some(Arc::new(Buffer { device: Arc::clone(device), block: Some(block), start, bytes })))
    };
    // SAFETY: passed on.
    unsafe { with_device(device, new) }.map_or(null_mut(), lend)
}

/// A buffer of the program's.
///
/// # Safety
/// A device, and bytes that stay in place while the buffer is used.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcNewSharedBuffer(
    device: Handle,
    start: *mut c_void,
    bytes: usize,
) -> Handle {
    let new = |device: &Arc<Device>| {
        let (device, start) = (Arc::clone(device), Pointer(start));
        Ok(Some(Arc::new(Buffer { device, block: None, start, bytes })))
    };
    // SAFETY: passed on.
    unsafe { with_device(device, new) }.map_or(null_mut(), lend)
}

/// There is one memory here.
///
/// # Safety
/// As [`rtcNewBuffer`].
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcNewBufferHostDevice(device: Handle, bytes: usize) -> Handle {
    // SAFETY: passed on.
    unsafe { rtcNewBuffer(device, bytes) }
}

/// There is one memory here.
///
/// # Safety
/// As [`rtcNewSharedBuffer`].
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcNewSharedBufferHostDevice(
    device: Handle,
    start: *mut c_void,
    bytes: usize,
) -> Handle {
    // SAFETY: passed on.
    unsafe { rtcNewSharedBuffer(device, start, bytes) }
}

/// There is nothing to copy.
///
/// # Safety
/// A buffer.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcCommitBuffer(buffer: Handle) {
    // SAFETY: passed on.
    unsafe { with::<Buffer, ()>(buffer, |_| Ok(())) }
}

/// Where a buffer is.
///
/// # Safety
/// A buffer.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcGetBufferData(buffer: Handle) -> *mut c_void {
    // SAFETY: passed on.
    let start = unsafe { with::<Buffer, _>(buffer, |buffer| Ok(buffer.start)) };
    start.0
}

/// The same.
///
/// # Safety
/// A buffer.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcGetBufferDataDevice(buffer: Handle) -> *mut c_void {
    // SAFETY: passed on.
    unsafe { rtcGetBufferData(buffer) }
}

/// Counts a buffer once more.
///
/// # Safety
/// A buffer or null.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcRetainBuffer(buffer: Handle) {
    // SAFETY: passed on.
    unsafe { retain::<Buffer>(buffer) }
}

/// Counts a buffer once less.
///
/// # Safety
/// A buffer or null.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcReleaseBuffer(buffer: Handle) {
    // SAFETY: passed on.
    unsafe { release::<Buffer>(buffer) }
}

/// Bytes of a row of this format; `None` for a format that is not one for this kind and type.
fn width(kind: Kind, of: u32, format: u32) -> Option<usize> {
    let fits = match (kind, of) {
        (Kind::Triangles, buffer::INDEX) => format == format::UINT3,
        (Kind::Quads, buffer::INDEX) => format == format::UINT4,
        (Kind::Triangles | Kind::Quads | Kind::Grids | Kind::Subdivision, buffer::VERTEX) => {
            format == format::FLOAT3
        }
        (Kind::Grids, buffer::GRID) => format == format::GRID,
        (Kind::Subdivision, buffer::EDGE_CREASE_INDEX) => format == format::UINT2,
        (Kind::Subdivision, buffer::INDEX | buffer::FACE | buffer::HOLE | buffer::VERTEX_CREASE_INDEX) => {
            format == format::UINT
        }
        (Kind::Subdivision, buffer::LEVEL | buffer::EDGE_CREASE_WEIGHT | buffer::VERTEX_CREASE_WEIGHT) => {
            format == format::FLOAT
        }
        (Kind::Spheres | Kind::Discs(_) | Kind::Curves(..) | Kind::Cones, buffer::VERTEX)
        | (Kind::Curves(CurveBasis::Hermite, _), buffer::TANGENT) => format == format::FLOAT4,
        (Kind::Discs(true) | Kind::Curves(_, CurveForm::Oriented), buffer::NORMAL)
        | (Kind::Curves(CurveBasis::Hermite, CurveForm::Oriented), buffer::NORMAL_DERIVATIVE) => {
            format == format::FLOAT3
        }
        (Kind::Curves(..) | Kind::Cones, buffer::FLAGS) => format == format::UCHAR,
        (Kind::User | Kind::Instance | Kind::Instances, buffer::VERTEX_ATTRIBUTE) => false,
        (_, buffer::VERTEX_ATTRIBUTE) => (format::FLOAT..=format::FLOAT16).contains(&format),
        (Kind::Curves(..) | Kind::Cones | Kind::Instances, buffer::INDEX) => format == format::UINT,
        (Kind::Instances, buffer::TRANSFORM) => transform::size(format).is_some(),
        _ => false,
    };
    let numbers = match format {
        _ if transform::size(format).is_some() => transform::size(format)?,
        // Two numbers and two half ones.
        format::GRID => 3,
        _ => (format & 0xff) as usize,
    };
    fits.then_some(if format == format::UCHAR { 1 } else { 4 * numbers })
}

/// Whether slots of a type are time steps.
pub(crate) fn is_by_step(of: u32) -> bool {
    matches!(
        of,
        buffer::VERTEX | buffer::NORMAL | buffer::TANGENT | buffer::NORMAL_DERIVATIVE | buffer::TRANSFORM
    )
}

/// A new array of a geometry.
struct Given {
    of: c_uint,
    slot: c_uint,
    format: c_uint,
    stride: usize,
    count: usize,
}

impl Given {
    fn width(&self, geometry: &Geometry) -> Result<usize, Problem> {
        let Self { of, slot, format, stride, .. } = *self;
        let width = width(geometry.kind, of, format).ok_or_else(|| {
            Problem::operation(format!(
                "invalid buffer of type {of} and format {format:#x} for {:?}",
                geometry.kind
            ))
        })?;
        let slots = match of {
            buffer::VERTEX_ATTRIBUTE => geometry.settings().attributes,
            buffer::INDEX => geometry.settings().topologies.len() as u32,
            _ if is_by_step(of) => geometry.settings().steps,
            _ => 1,
        };
        if slot >= slots {
            let why = "as rtcSetGeometryTimeStepCount, rtcSetGeometryVertexAttributeCount and rtcSetGeometryTopologyCount say";
            return Err(Problem::operation(format!(
                "slot {slot} of buffers of type {of}: there are {slots} ({why})"
            )));
        }
        // Rows may overlap, as with Embree.
        if !stride.is_multiple_of(4) && width != 1 {
            return Err(Problem::operation(format!(
                "a stride of {stride} bytes: a multiple of 4 is expected"
            )));
        }
        Ok(width)
    }

    /// # Safety
    /// As [`View::new`] for the rows at `start`.
    unsafe fn set(
        &self,
        geometry: &Geometry,
        start: *const c_void,
        keep: Option<Arc<Block>>,
    ) -> Result<(), Problem> {
        let width = self.width(geometry)?;
        if !(start as usize).is_multiple_of(4) && width != 1 {
            return Err(Problem::operation("the buffer does not start at a multiple of 4 bytes"));
        }
        if start.is_null() && self.count > 0 {
            return Err(Problem::argument("the buffer is a null pointer"));
        }
        // SAFETY: passed on.
        let view = unsafe { View::new(start, self.stride, self.count, width, keep) };
        let array = Array { view, format: self.format };
        let mut settings = geometry.edit();
        settings.arrays.insert((self.of, self.slot), array);
        settings.modified();
        Ok(())
    }
}

/// Gives a geometry an array of the program's.
///
/// # Safety
/// A geometry, and rows that stay in place while the geometry is used.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcSetSharedGeometryBuffer(
    geometry: Handle,
    of: c_uint,
    slot: c_uint,
    format: c_uint,
    start: *const c_void,
    offset: usize,
    stride: usize,
    count: usize,
) {
    let given = Given { of, slot, format, stride, count };
    let set = |geometry: &Arc<Geometry>| {
        // Empty vectors of C++ have no address.
        if start.is_null() && count > 0 {
            return Err(Problem::argument("the buffer is a null pointer"));
        }
        // SAFETY: passed on.
        unsafe { given.set(geometry, start.wrapping_byte_add(offset), None) }
    };
    // SAFETY: passed on.
    unsafe { with::<Geometry, _>(geometry, set) }
}

/// The same; there is one memory here.
///
/// # Safety
/// As [`rtcSetSharedGeometryBuffer`].
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcSetSharedGeometryBufferHostDevice(
    geometry: Handle,
    of: c_uint,
    slot: c_uint,
    format: c_uint,
    start: *const c_void,
    _device: *const c_void,
    offset: usize,
    stride: usize,
    count: usize,
) {
    // SAFETY: passed on.
    unsafe { rtcSetSharedGeometryBuffer(geometry, of, slot, format, start, offset, stride, count) }
}

/// Gives a geometry a part of a buffer.
///
/// # Safety
/// A geometry and a buffer.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcSetGeometryBuffer(
    geometry: Handle,
    of: c_uint,
    slot: c_uint,
    format: c_uint,
    buffer: Handle,
    offset: usize,
    stride: usize,
    count: usize,
) {
    // SAFETY: passed on.
    let buffer = unsafe { shared::<Buffer>(buffer) };
    let given = Given { of, slot, format, stride, count };
    let set = |geometry: &Arc<Geometry>| {
        let buffer = buffer.ok_or_else(|| Problem::argument("the buffer is a null pointer"))?;
        if !Arc::ptr_eq(&buffer.device, &geometry.device) {
            return Err(Problem::argument("buffer and geometry are of two devices"));
        }
        let width = given.width(geometry)?;
        let last = count.checked_sub(1).map_or(Some(0), |last| last.checked_mul(stride));
        let end = last.and_then(|last| last.checked_add(if count > 0 { width } else { 0 }));
        if end.and_then(|end| end.checked_add(offset)).is_none_or(|end| end > buffer.bytes) {
            let bytes = buffer.bytes;
            return Err(Problem::argument(format!("{count} rows do not fit in the buffer's {bytes} bytes")));
        }
        // SAFETY: the rows are in the buffer, whose memory is ours, or that of a program that vouched for it.
        unsafe { given.set(geometry, buffer.start.0.wrapping_byte_add(offset), buffer.block.clone()) }
    };
    // SAFETY: passed on.
    unsafe { with::<Geometry, _>(geometry, set) }
}

/// Gives a geometry an array of ours, and returns its address.
///
/// # Safety
/// A geometry.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcSetNewGeometryBuffer(
    geometry: Handle,
    of: c_uint,
    slot: c_uint,
    format: c_uint,
    stride: usize,
    count: usize,
) -> *mut c_void {
    let given = Given { of, slot, format, stride, count };
    let set = |geometry: &Arc<Geometry>| {
        let width = given.width(geometry)?;
        let bytes =
            stride.checked_mul(count).and_then(|bytes| bytes.checked_add(width.saturating_sub(stride)));
        let bytes = bytes.ok_or_else(|| out_of_memory(usize::MAX))?;
        let block = Arc::new(Block::new(bytes).ok_or_else(|| out_of_memory(bytes))?);
        let start = block.start();
        // SAFETY: the block has this many rows, the last one whole, and 16 bytes more.
        unsafe { given.set(geometry, start, Some(block)) }?;
        Ok(Pointer(start))
    };
    // SAFETY: passed on.
    unsafe { with::<Geometry, _>(geometry, set) }.0
}

/// The same; there is one memory here.
///
/// # Safety
/// A geometry, and room for two pointers, or null.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcSetNewGeometryBufferHostDevice(
    geometry: Handle,
    of: c_uint,
    slot: c_uint,
    format: c_uint,
    stride: usize,
    count: usize,
    host: *mut *mut c_void,
    device: *mut *mut c_void,
) {
    // SAFETY: passed on.
    unsafe {
        let start = rtcSetNewGeometryBuffer(geometry, of, slot, format, stride, count);
        for pointer in [host, device].into_iter().filter(|pointer| !pointer.is_null()) {
            *pointer = start;
        }
    }
}

/// Where an array of a geometry is.
///
/// # Safety
/// A geometry.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcGetGeometryBufferData(
    geometry: Handle,
    of: c_uint,
    slot: c_uint,
) -> *mut c_void {
    let get = |geometry: &Arc<Geometry>| {
        let settings = geometry.settings();
        let array = settings.arrays.get(&(of, slot));
        let array = array.ok_or_else(|| no_array(of, slot))?;
        Ok(Pointer(array.view.start()))
    };
    // SAFETY: passed on.
    unsafe { with::<Geometry, _>(geometry, get) }.0
}

/// The same.
///
/// # Safety
/// A geometry.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcGetGeometryBufferDataDevice(
    geometry: Handle,
    of: c_uint,
    slot: c_uint,
) -> *mut c_void {
    // SAFETY: passed on.
    unsafe { rtcGetGeometryBufferData(geometry, of, slot) }
}

/// An array was written: the geometry is to be committed.
///
/// # Safety
/// A geometry.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcUpdateGeometryBuffer(geometry: Handle, of: c_uint, slot: c_uint) {
    let check = |geometry: &Arc<Geometry>| {
        let mut settings = geometry.edit();
        if !settings.arrays.contains_key(&(of, slot)) {
            return Err(no_array(of, slot));
        }
        settings.modified();
        Ok(())
    };
    // SAFETY: passed on.
    unsafe { with::<Geometry, _>(geometry, check) }
}

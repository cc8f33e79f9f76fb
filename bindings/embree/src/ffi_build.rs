// SPDX-License-Identifier: GPL-3.0-or-later
//! `rtcBuildBVH` and its kin: hierarchies of the program's own. Source: Embree's manual.
//! Invariant: an allocator is used by the thread that builds, during a build. Tests: `tests/c/build.c`.

use std::ffi::{c_uint, c_void};
use std::ptr::null_mut;
use std::sync::{Arc, Mutex, PoisonError};

use crate::builder::{Around, Limits, Primitive, Program, Stop, build};
use crate::device::{Device, Problem};
use crate::ffi_abi::{Bounds, Code};
use crate::ffi_catch::{self, Thrown};
use crate::ffi_handle::{Handle, Object, lend, release, retain, with, with_device};
use crate::ffi_memory::{Block, Pointer};

/// The target of `RTCBVH`.
#[derive(Debug)]
pub(crate) struct Bvh {
    device: Arc<Device>,
    /// What the last build has given the program.
    memory: Mutex<Vec<Block>>,
}

impl Object for Bvh {
    const NAME: &'static str = "BVH";
    fn device(&self) -> &Arc<Device> {
        &self.device
    }
}

/// The target of `RTCThreadLocalAllocator`.
struct Allocator {
    blocks: Vec<Block>,
    /// Free bytes of the last block.
    free: std::ops::Range<usize>,
}

impl Allocator {
    /// Bytes of a block, unless the program wants more at once.
    const BLOCK: usize = 1 << 16;

    fn take(&mut self, bytes: usize, align: usize) -> Option<*mut c_void> {
        let mut start = self.free.start.checked_next_multiple_of(align)?;
        if start.checked_add(bytes).is_none_or(|end| end > self.free.end) {
            let size = bytes.checked_add(align)?.max(Self::BLOCK);
            let block = Block::new(size)?;
            let first = block.start().addr();
            self.blocks.push(block);
            self.free = first..first + size;
            start = first.checked_next_multiple_of(align)?;
        }
        self.free.start = start + bytes;
        let block = self.blocks.last()?.start();
        Some(block.wrapping_byte_add(start - block.addr()))
    }
}

type CreateNode = unsafe extern "C-unwind" fn(*mut Allocator, c_uint, *mut c_void) -> *mut c_void;
type SetChildren = unsafe extern "C-unwind" fn(*mut c_void, *mut *mut c_void, c_uint, *mut c_void);
type SetBounds = unsafe extern "C-unwind" fn(*mut c_void, *mut *const Bounds, c_uint, *mut c_void);
type CreateLeaf =
    unsafe extern "C-unwind" fn(*mut Allocator, *const Primitive, usize, *mut c_void) -> *mut c_void;
type Progress = unsafe extern "C-unwind" fn(*mut c_void, f64) -> bool;

/// `RTCBuildArguments`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub(crate) struct BuildArguments {
    bytes: usize,
    quality: c_uint,
    flags: c_uint,
    branching: c_uint,
    depth: c_uint,
    block: c_uint,
    leaf: [c_uint; 2],
    traversal: f32,
    intersection: f32,
    bvh: Handle,
    primitives: *mut Primitive,
    count: usize,
    capacity: usize,
    create_node: Option<CreateNode>,
    set_children: Option<SetChildren>,
    set_bounds: Option<SetBounds>,
    create_leaf: Option<CreateLeaf>,
    /// Not called: no primitive is split.
    split: *const c_void,
    progress: Option<Progress>,
    user: *mut c_void,
}

/// The program's functions.
struct Functions {
    create_node: CreateNode,
    set_children: SetChildren,
    set_bounds: SetBounds,
    create_leaf: CreateLeaf,
    progress: Option<Progress>,
    user: *mut c_void,
    allocator: *mut Allocator,
}

impl Program for Functions {
    type Node = *mut c_void;

    fn node(&mut self, children: usize) -> Result<Self::Node, Thrown> {
        // SAFETY: the program gave the function to be called like this, here and below.
        ffi_catch::call(|| unsafe { (self.create_node)(self.allocator, children as c_uint, self.user) })
    }

    fn set_bounds(&mut self, node: Self::Node, bounds: &[Around]) -> Result<(), Thrown> {
        let bounds: Vec<Bounds> = bounds
            .iter()
            .map(|&Around { lower, upper }| Bounds { lower, align0: 0.0, upper, align1: 0.0 })
            .collect();
        let mut pointers: Vec<*const Bounds> = bounds.iter().map(|bounds| &raw const *bounds).collect();
        let count = pointers.len() as c_uint;
        // SAFETY: as above; the boxes live during the call.
        ffi_catch::call(|| unsafe { (self.set_bounds)(node, pointers.as_mut_ptr(), count, self.user) })
    }

    fn set_children(&mut self, node: Self::Node, children: &[Self::Node]) -> Result<(), Thrown> {
        let mut children = children.to_vec();
        let count = children.len() as c_uint;
        // SAFETY: as above.
        ffi_catch::call(|| unsafe { (self.set_children)(node, children.as_mut_ptr(), count, self.user) })
    }

    fn leaf(&mut self, primitives: &[Primitive]) -> Result<Self::Node, Thrown> {
        let (start, count) = (primitives.as_ptr(), primitives.len());
        // SAFETY: as above.
        ffi_catch::call(|| unsafe { (self.create_leaf)(self.allocator, start, count, self.user) })
    }

    fn goes_on(&mut self, done: f64) -> Result<bool, Thrown> {
        // SAFETY: as above.
        let goes_on = |progress: Progress| ffi_catch::call(|| unsafe { progress(self.user, done) });
        self.progress.map_or(Ok(true), goes_on)
    }
}

/// Limits that can be kept.
fn limits(arguments: &BuildArguments) -> Result<Limits, Problem> {
    let &BuildArguments { branching, depth, block, leaf: [least, most], traversal, intersection, .. } =
        arguments;
    if !(2..=16).contains(&branching) {
        return Err(Problem::argument(format!("maxBranchingFactor is {branching}: valid are 2 to 16")));
    }
    if !(1..=32).contains(&most) || least > most {
        let message = format!("leaves of {least} to {most} primitives: valid are 1 to 32");
        return Err(Problem::argument(message));
    }
    let depth = (depth as usize).clamp(1, 64);
    let block = block.max(1) as usize;
    let leaf = [least as usize, most as usize];
    Ok(Limits { branching: branching as usize, depth, block, leaf, traversal, intersection })
}

/// A new BVH. See Embree's manual, here and below.
///
/// # Safety
/// A device.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcNewBVH(device: Handle) -> Handle {
    let new = |device: &Arc<Device>| {
        Ok(Some(Arc::new(Bvh { device: Arc::clone(device), memory: Mutex::default() })))
    };
    // SAFETY: passed on.
    unsafe { with_device(device, new) }.map_or(null_mut(), lend)
}

/// Counts a BVH once more.
///
/// # Safety
/// A BVH or null.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcRetainBVH(bvh: Handle) {
    // SAFETY: passed on.
    unsafe { retain::<Bvh>(bvh) }
}

/// Counts a BVH once less.
///
/// # Safety
/// A BVH or null.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcReleaseBVH(bvh: Handle) {
    // SAFETY: passed on.
    unsafe { release::<Bvh>(bvh) }
}

/// Memory that goes with the BVH, or with its next build; null where there is none.
///
/// # Safety
/// The allocator that a function of the program was called with, until that returns.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcThreadLocalAlloc(
    allocator: *mut c_void,
    bytes: usize,
    align: usize,
) -> *mut c_void {
    if allocator.is_null() || !align.is_power_of_two() {
        return null_mut();
    }
    // SAFETY: passed on: it is one of ours, and nothing else uses it meanwhile.
    unsafe { (*allocator.cast::<Allocator>()).take(bytes, align) }.unwrap_or(null_mut())
}

/// Builds a hierarchy over boxes, whose nodes the program makes; returns its root, or null.
///
/// # Safety
/// Arguments as Embree's headers say; functions may be called as its manual says.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcBuildBVH(arguments: *const BuildArguments) -> *mut c_void {
    if arguments.is_null() {
        return null_mut();
    }
    // SAFETY: passed on.
    let arguments = unsafe { &*arguments };
    let run = |bvh: &Arc<Bvh>| {
        if arguments.bytes < size_of::<BuildArguments>() {
            return Err(Problem::argument("byteSize is not that of the arguments"));
        }
        let limits = limits(arguments)?;
        let BuildArguments { create_node, set_children, set_bounds, create_leaf, .. } = *arguments;
        let (Some(create_node), Some(set_children), Some(set_bounds), Some(create_leaf)) =
            (create_node, set_children, set_bounds, create_leaf)
        else {
            return Err(Problem::argument(
                "createNode, setNodeChildren, setNodeBounds or createLeaf is null",
            ));
        };
        if arguments.count == 0 {
            return Ok(Pointer(null_mut()));
        }
        if arguments.primitives.is_null() || !arguments.primitives.is_aligned() {
            return Err(Problem::argument("primitives are not at a multiple of 32 bytes"));
        }
        // SAFETY: passed on: as many primitives, which are the builder's meanwhile.
        let primitives = unsafe { std::slice::from_raw_parts_mut(arguments.primitives, arguments.count) };
        bvh.memory.lock().unwrap_or_else(PoisonError::into_inner).clear();
        let mut allocator = Allocator { blocks: Vec::new(), free: 0..0 };
        let &BuildArguments { progress, user, .. } = arguments;
        let allocator_start = &raw mut allocator;
        let mut functions = Functions {
            create_node,
            set_children,
            set_bounds,
            create_leaf,
            progress,
            user,
            allocator: allocator_start,
        };
        let root = build(primitives, &limits, &mut functions);
        // SAFETY: the program does not use it any more.
        let blocks = unsafe { std::mem::take(&mut (*allocator_start).blocks) };
        *bvh.memory.lock().unwrap_or_else(PoisonError::into_inner) = blocks;
        root.map(Pointer).map_err(|stop| match stop {
            Stop::Thrown(thrown) => thrown.into(),
            Stop::Cancelled => {
                Problem { code: Code::Cancelled, message: "the program has cancelled the build".into() }
            }
            Stop::TooDeep => Problem::argument(format!(
                "{} primitives do not fit in {} levels of leaves of {}",
                arguments.count, limits.depth, limits.leaf[1]
            )),
        })
    };
    // SAFETY: passed on.
    unsafe { with::<Bvh, _>(arguments.bvh, run) }.0
}

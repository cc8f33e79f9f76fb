// SPDX-License-Identifier: GPL-3.0-or-later
//! Arrays for plugins: aligned, a whole number of vectors, from memory that each thread owns.
//! Invariant: an array begins at a multiple of 64 bytes and has memory for its lanes, rounded up to a
//! multiple of 16, as in openrt/rts.h. Tests: `tests`; bindings/openrt/tests/plugins.rs (a plugin that checks
//! its pointers).

use std::cell::RefCell;

use gnurt::shading::{LightBatch, RayRequest, Vec3s};

use crate::ffi_rts::{Vec3In, Vec3Out};

/// Lanes of one vector of the widest kind.
const WIDTH: usize = 16;

/// As many lanes, aligned.
#[repr(C, align(64))]
#[derive(Clone, Copy)]
pub(crate) struct Line([f32; WIDTH]);

/// Memory for the arrays of one call and for its queries of the renderer.
#[derive(Default)]
pub(crate) struct Buffers {
    lines: Vec<Line>,
    /// Light from lights.
    pub(crate) light: LightBatch,
    /// Rays that a plugin traces.
    pub(crate) request: RayRequest,
    /// The results.
    pub(crate) answer: Vec3s,
    /// For the plugin.
    pub(crate) scratch: Scratch,
}

thread_local! {
    /// Buffers without users in this thread. Their number is the greatest nesting of calls so far.
    static FREE: RefCell<Vec<Buffers>> = const { RefCell::new(Vec::new()) };
}

impl Buffers {
    /// An unused buffer; to be given back.
    pub(crate) fn take() -> Self {
        FREE.with(|free| free.borrow_mut().pop()).unwrap_or_default()
    }

    /// For the next call of this thread.
    pub(crate) fn give_back(mut self) {
        self.scratch.reset();
        FREE.with(|free| free.borrow_mut().push(self));
    }

    /// `count` arrays of `lanes` lanes each. Earlier arrays become invalid.
    pub(crate) fn arrays(&mut self, lanes: usize, count: usize) -> Lanes {
        let lines = lanes.div_ceil(WIDTH);
        if self.lines.len() < lines * count {
            self.lines.resize(lines * count, Line([0.0; WIDTH]));
        }
        Lanes { next: self.lines.as_mut_ptr().cast(), stride: lines * WIDTH, left: count, lanes }
    }
}

/// Arrays that have not been handed out yet.
pub(crate) struct Lanes {
    next: *mut f32,
    /// Floats of each.
    stride: usize,
    left: usize,
    lanes: usize,
}

impl Lanes {
    /// The next array, its content arbitrary.
    fn array(&mut self) -> *mut f32 {
        assert!(self.left > 0, "more arrays than were asked for");
        let array = self.next;
        self.left -= 1;
        // SAFETY: `left` arrays of `stride` floats follow each other in memory.
        self.next = unsafe { array.add(self.stride) };
        array
    }

    /// An array with these values.
    pub(crate) fn floats(&mut self, values: &[f32]) -> *const f32 {
        assert!(values.len() <= self.stride, "one value per lane");
        let array = self.array();
        // SAFETY: there is room for `stride` floats, and the values are not in there.
        unsafe { values.as_ptr().copy_to_nonoverlapping(array, values.len()) };
        array
    }

    /// An array with the values of some function of the lane.
    pub(crate) fn floats_by(&mut self, value: impl Fn(usize) -> f32) -> *const f32 {
        let array = self.array();
        for i in 0..self.lanes {
            // SAFETY: `lanes` is at most `stride`.
            unsafe { array.add(i).write(value(i)) };
        }
        array
    }

    /// An array of integers, one per lane.
    pub(crate) fn integers(&mut self, values: impl Iterator<Item = u32>) -> *const u32 {
        let array = self.array().cast::<u32>();
        // SAFETY: an array has `stride` floats, at least `lanes`, all of them written; integers are as large as floats.
        let lanes = unsafe { std::slice::from_raw_parts_mut(array, self.lanes) };
        lanes.iter_mut().zip(values).for_each(|(lane, value)| *lane = value);
        array
    }

    /// An array of bytes, one per lane.
    pub(crate) fn bytes(&mut self, values: impl Iterator<Item = u8>) -> *mut u8 {
        let array = self.array().cast::<u8>();
        // SAFETY: an array has four times as many bytes as floats, all of them written.
        let lanes = unsafe { std::slice::from_raw_parts_mut(array, self.lanes) };
        lanes.iter_mut().zip(values).for_each(|(lane, value)| *lane = value);
        array
    }

    /// Three arrays with these values.
    pub(crate) fn vectors(&mut self, v: &Vec3s) -> Vec3In {
        Vec3In { x: self.floats(&v.x), y: self.floats(&v.y), z: self.floats(&v.z) }
    }

    /// An array of lanes marked as unwritten.
    pub(crate) fn unwritten(&mut self) -> *mut f32 {
        let array = self.array();
        for i in 0..self.stride {
            // SAFETY: the array has `stride` floats.
            unsafe { array.add(i).write(f32::NAN) };
        }
        array
    }

    /// Three of them.
    pub(crate) fn unwritten_vectors(&mut self) -> Vec3Out {
        Vec3Out { x: self.unwritten(), y: self.unwritten(), z: self.unwritten() }
    }

    /// The contents of a plugin's output array of this.
    ///
    /// # Safety
    /// The array belongs to this and is not written while the result lives.
    pub(crate) unsafe fn written<'a>(&self, array: *mut f32) -> &'a [f32] {
        // SAFETY: arrays have at least `lanes` floats, all of them written.
        unsafe { std::slice::from_raw_parts(array, self.lanes) }
    }
}

/// Memory for a plugin's own use, until its callback returns.
#[derive(Default)]
pub(crate) struct Scratch {
    blocks: Vec<Vec<Line>>,
    /// Blocks that the present call has; the others are from earlier ones.
    used: usize,
}

impl Scratch {
    /// Memory of this many bytes at a multiple of 64; null if there is none.
    pub(crate) fn bytes(&mut self, bytes: usize) -> *mut u8 {
        let lines = bytes.div_ceil(size_of::<Line>()).max(1);
        if self.used == self.blocks.len() {
            self.blocks.push(Vec::new());
        }
        let block = &mut self.blocks[self.used];
        if block.len() < lines {
            if block.try_reserve_exact(lines - block.len()).is_err() {
                return std::ptr::null_mut();
            }
            block.resize(lines, Line([0.0; WIDTH]));
        }
        self.used += 1;
        block.as_mut_ptr().cast()
    }

    /// The call is over; large blocks are freed, so that one call does not keep memory for ever.
    fn reset(&mut self) {
        const MOST: usize = 1 << 14;
        self.used = 0;
        self.blocks.retain(|block| block.len() <= MOST);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_are_aligned_and_padded() {
        let mut buffers = Buffers::take();
        for lanes in [1, 15, 16, 17, 256] {
            let mut arrays = buffers.arrays(lanes, 3);
            let first = arrays.floats(&vec![1.0; lanes]);
            let second = arrays.unwritten();
            assert_eq!((first.addr() % 64, second.addr() % 64), (0, 0), "{lanes} lanes begin on a line");
            assert!(
                second.addr() - first.addr() >= lanes.next_multiple_of(16) * 4,
                "{lanes} lanes have room"
            );
            // SAFETY: it belongs to these arrays, and is not written.
            let unwritten = unsafe { arrays.written(second) };
            assert!(
                unwritten.len() == lanes && unwritten.iter().all(|x| x.is_nan()),
                "nobody has written it"
            );
        }
        buffers.give_back();
        let mut scratch = Scratch::default();
        let pointers = [scratch.bytes(0), scratch.bytes(100), scratch.bytes(64)];
        assert!(pointers.iter().all(|p| !p.is_null() && p.addr() % 64 == 0), "aligned: {pointers:?}");
        assert!(scratch.bytes(usize::MAX / 2).is_null(), "no such memory");
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! A stack of fixed size whose memory is not cleared first: a traversal touches a few entries of many.
//! Source: original. Clearing 4 KiB for each ray would cost as much as a short ray does.
//! Invariant: the first `len` entries have been written. Proof: `tests::first_in_last_out`.

use std::mem::MaybeUninit;

/// Up to `N` values, last in first out.
#[derive(Debug)]
pub struct Stack<T: Copy, const N: usize> {
    entries: [MaybeUninit<T>; N],
    len: usize,
}

impl<T: Copy, const N: usize> Stack<T, N> {
    /// An empty one.
    #[inline(always)]
    #[must_use]
    pub const fn new() -> Self {
        Self { entries: [const { MaybeUninit::uninit() }; N], len: 0 }
    }

    /// Puts a value on top. Panics where there is no room.
    #[inline(always)]
    pub fn push(&mut self, value: T) {
        self.entries[self.len] = MaybeUninit::new(value);
        self.len += 1;
    }

    /// Takes the value on top.
    #[inline(always)]
    pub fn pop(&mut self) -> Option<T> {
        self.len = self.len.checked_sub(1)?;
        // SAFETY: `push` is all that raises `len`, and it has written the entry below the new one.
        Some(unsafe { self.entries[self.len].assume_init() })
    }

    /// How many values there are.
    #[inline(always)]
    #[must_use]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there is none.
    #[inline(always)]
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Forgets all values.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.len = 0;
    }

    /// The upmost `count` values, lowest first, to be put in order.
    #[inline(always)]
    pub fn top(&mut self, count: usize) -> &mut [T] {
        let written = &mut self.entries[..self.len];
        let from = written.len() - count;
        // SAFETY: all entries below `len` have been written, and `MaybeUninit<T>` has the layout of `T`.
        unsafe { &mut *(std::ptr::from_mut(&mut written[from..]) as *mut [T]) }
    }
}

impl<T: Copy, const N: usize> Default for Stack<T, N> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_in_last_out() {
        let mut stack = Stack::<u64, 4>::new();
        assert!(stack.pop().is_none() && stack.is_empty(), "nothing is in");
        [1, 5, 3].into_iter().for_each(|value| stack.push(value));
        assert_eq!(stack.len(), 3, "three are in");
        stack.top(2).sort_unstable();
        assert_eq!([stack.pop(), stack.pop(), stack.pop(), stack.pop()], [Some(5), Some(3), Some(1), None]);
    }

    #[test]
    #[should_panic(expected = "index out of bounds")]
    fn a_full_stack_panics() {
        let mut stack = Stack::<u8, 1>::new();
        stack.push(1);
        stack.push(2);
    }
}

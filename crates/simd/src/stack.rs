// SPDX-License-Identifier: GPL-3.0-or-later
//! A stack of fixed size whose memory is not cleared first: a traversal touches a few entries of many.
//! Clearing 4 KiB for each ray would cost as much as a short ray does. The length is kept apart from the
//! memory, so that a walk has it in a register.
//! Invariant: the first `len` entries have been written. Tests: `tests::first_in_last_out`, and the example of
//! [`StackBuffer::resume`] that does not compile.

use std::marker::PhantomData;
use std::mem::MaybeUninit;

/// Memory for up to `N` values, and how many of them there are.
#[derive(Debug)]
pub struct StackBuffer<T: Copy, const N: usize> {
    entries: [MaybeUninit<T>; N],
    len: usize,
}

/// Values, last in first out, in a [`StackBuffer`].
///
/// `'buffer` is no span of time but the mark of a room: [`StackBuffer::resume`] gives each stack one that no other has, so that none
/// can be put in the place of another.
#[derive(Debug)]
pub struct Stack<'a, 'buffer, T: Copy> {
    entries: &'a mut [MaybeUninit<T>],
    len: usize,
    buffer: Mark<'buffer>,
}

/// A lifetime that passes for no other one, neither longer nor shorter.
type Mark<'buffer> = PhantomData<fn(&'buffer ()) -> &'buffer ()>;

impl<T: Copy, const N: usize> StackBuffer<T, N> {
    /// Without values.
    #[inline(always)]
    #[must_use]
    pub const fn new() -> Self {
        Self { entries: [const { MaybeUninit::uninit() }; N], len: 0 }
    }

    /// An empty stack in this memory.
    #[inline(always)]
    pub fn stack(&mut self) -> Stack<'_, 'static, T> {
        Stack { entries: &mut self.entries, len: 0, buffer: PhantomData }
    }

    /// Goes on with the stack that was left here.
    ///
    /// That is the one that it is about afterwards: no other can be put in its place, whose entries would be in another room.
    ///
    /// ```compile_fail,E0521
    /// use gnurt_simd::StackBuffer;
    ///
    /// let mut buffer = StackBuffer::<u64, 4>::new();
    /// buffer.resume(|stack| {
    ///     let mut other = Box::leak(Box::new(StackBuffer::<u64, 4>::new())).stack();
    ///     other.push(1);
    ///     *stack = other;
    /// });
    /// // Nothing was ever written here.
    /// println!("{:?}", buffer.resume(|stack| stack.pop()));
    /// ```
    ///
    /// Nor can the stacks of two rooms be exchanged:
    ///
    /// ```compile_fail,E0521
    /// use gnurt_simd::StackBuffer;
    ///
    /// let (mut a, mut b) = (StackBuffer::<u64, 4>::new(), StackBuffer::<u64, 4>::new());
    /// a.resume(|a| b.resume(|b| std::mem::swap(a, b)));
    /// ```
    #[inline(always)]
    pub fn resume<R>(&mut self, work: impl for<'buffer> FnOnce(&mut Stack<'_, 'buffer, T>) -> R) -> R {
        let mut stack = Stack { entries: &mut self.entries, len: self.len, buffer: PhantomData };
        let result = work(&mut stack);
        self.len = stack.len;
        result
    }

    /// How many values were left here.
    #[inline(always)]
    #[must_use]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether none was left here.
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
}

impl<T: Copy> Stack<'_, '_, T> {
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
        // SAFETY: `push` is all that raises `len`, and it has written the entry below the new one; a room's `len` is that of
        // the stack that was in it last, in whose place no closure can put another: `Mark`.
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

    /// The upmost `count` values, lowest first, to be put in order.
    #[inline(always)]
    pub fn top(&mut self, count: usize) -> &mut [T] {
        let written = &mut self.entries[..self.len];
        let from = written.len() - count;
        // SAFETY: all entries below `len` have been written, and `MaybeUninit<T>` has the layout of `T`.
        unsafe { &mut *(std::ptr::from_mut(&mut written[from..]) as *mut [T]) }
    }
}

impl<T: Copy, const N: usize> Default for StackBuffer<T, N> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_in_last_out() {
        let mut buffer = StackBuffer::<u64, 4>::new();
        let mut stack = buffer.stack();
        assert!(stack.pop().is_none() && stack.is_empty(), "nothing is in");
        [1, 5, 3].into_iter().for_each(|value| stack.push(value));
        assert_eq!(stack.len(), 3, "three are in");
        stack.top(2).sort_unstable();
        assert_eq!([stack.pop(), stack.pop(), stack.pop(), stack.pop()], [Some(5), Some(3), Some(1), None]);
    }

    #[test]
    fn what_is_left_is_found_again() {
        let mut buffer = StackBuffer::<u32, 4>::new();
        buffer.resume(|stack| [7, 8].into_iter().for_each(|value| stack.push(value)));
        assert_eq!((buffer.len(), buffer.resume(|stack| stack.pop())), (2, Some(8)), "two were left");
        assert_eq!(buffer.len(), 1, "one is left");
        buffer.clear();
        assert_eq!(buffer.resume(|stack| stack.pop()), None, "nothing is left");
    }

    #[test]
    #[should_panic(expected = "index out of bounds")]
    fn a_full_stack_panics() {
        let mut buffer = StackBuffer::<u8, 1>::new();
        let mut stack = buffer.stack();
        stack.push(1);
        stack.push(2);
    }
}

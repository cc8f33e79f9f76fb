// SPDX-License-Identifier: GPL-3.0-or-later
//! Memory of Python's arrays as slices: the only unsafe code of this crate.
//! Source: PEP 3118. Invariant: a slice lives no longer than the buffer that it is of, which keeps the array's memory in place.
//! As with every extension that releases the interpreter's lock, a program that writes to an array during a
//! query of another thread gets results for any of the numbers. Tests: `tests/test_arrays.py`.

use std::slice;

use pyo3::buffer::{Element, PyBuffer};
use pyo3::prelude::*;

/// Numbers of one type: rows with a number of elements, one row some elements behind the other.
pub(crate) struct Rows<T: Element> {
    buffer: PyBuffer<T>,
    count: usize,
    width: usize,
    step: usize,
}

impl<T: Element> Rows<T> {
    /// Those of an array of one or two dimensions whose rows are without gaps. `None` if they have some, or overlap.
    pub(crate) fn new(array: &Bound<'_, PyAny>) -> PyResult<Option<Self>> {
        let buffer = PyBuffer::<T>::get(array)?;
        let size = buffer.item_size();
        let (count, width, step) = match (buffer.shape(), buffer.strides()) {
            (&[count], _) if buffer.is_c_contiguous() => (count, 1, 1),
            (&[count, width], _) if buffer.is_c_contiguous() => (count, width, width),
            (&[count, width], &[row, element]) => {
                let fits = element == size as isize && row > 0 && (row as usize).is_multiple_of(size);
                if !fits || (row as usize / size) < width {
                    return Ok(None);
                }
                (count, width, row as usize / size)
            }
            _ => return Ok(None),
        };
        Ok(Some(Self { buffer, count, width, step }))
    }

    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// Elements of a row.
    pub(crate) fn width(&self) -> usize {
        self.width
    }

    /// Elements from one row to the next.
    pub(crate) fn step(&self) -> usize {
        self.step
    }

    fn len(&self) -> usize {
        if self.count * self.width == 0 { 0 } else { (self.count - 1) * self.step + self.width }
    }

    /// All of it, gaps included.
    pub(crate) fn all(&self) -> &[T] {
        let len = self.len();
        if len == 0 {
            return &[];
        }
        // SAFETY: the buffer, which outlives the slice, holds memory of this shape and step; `get` has checked that it is
        // aligned and of this type; `len` ends with the last row.
        unsafe { slice::from_raw_parts(self.buffer.buf_ptr().cast::<T>(), len) }
    }

    /// All of it, for writing. Only for a new array without gaps and without other references.
    pub(crate) fn all_mut(&mut self) -> &mut [T] {
        let len = self.len();
        if len == 0 || self.buffer.readonly() {
            return &mut [];
        }
        // SAFETY: as above; and it is written through `&mut self`, before anybody else has seen the array.
        unsafe { slice::from_raw_parts_mut(self.buffer.buf_ptr().cast::<T>(), len) }
    }
}

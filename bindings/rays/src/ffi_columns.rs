// SPDX-License-Identifier: GPL-3.0-or-later
//! Arrays of `gnurt/rays.h`: input rows, and output positions. See include/gnurt/rays.h.
//! Invariant: the maker of one guarantees the memory. Tests: `tests/c/rays.c`.

use std::ffi::c_void;

use gnurt_accel::Aabb;

use crate::ffi_memory::View;

/// `gnurt_array`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Array {
    pub(crate) data: *const c_void,
    pub(crate) count: usize,
    stride: usize,
    of: u32,
}

/// `enum gnurt_type`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Type {
    F32,
    F64,
    U32,
    U64,
}

impl Array {
    pub(crate) const EMPTY: Self = Self { data: std::ptr::null(), count: 0, stride: 0, of: 0 };
}

/// Rows that are read.
#[derive(Clone, Debug)]
pub(crate) struct Rows {
    view: View,
    of: Type,
    width: usize,
}

/// The elements of rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Access {
    Floats,
    Indices,
}

impl Rows {
    /// Rows of `width` numbers each; `what` names them in messages.
    ///
    /// # Safety
    /// The rows are readable for as long as this or a copy is used.
    pub(crate) unsafe fn new(
        array: &Array,
        width: usize,
        access: Access,
        what: &str,
    ) -> Result<Self, String> {
        let of = match (array.of, access) {
            (0, Access::Floats) => Type::F32,
            (1, Access::Floats) => Type::F64,
            (2, Access::Indices) => Type::U32,
            (3, Access::Indices) => Type::U64,
            (other, Access::Floats) => {
                return Err(format!("{what}: type {other}; GNURT_F32 or GNURT_F64 is expected"));
            }
            (other, Access::Indices) => {
                return Err(format!("{what}: type {other}; GNURT_U32 or GNURT_U64 is expected"));
            }
        };
        let bytes = width * if matches!(of, Type::F32 | Type::U32) { 4 } else { 8 };
        if array.data.is_null() && array.count > 0 {
            return Err(format!("{what}: {} rows at a null pointer", array.count));
        }
        let stride = if array.stride == 0 { bytes } else { array.stride };
        // SAFETY: passed on.
        let view = unsafe { View::new(array.data, stride, array.count, bytes, None) };
        Ok(Self { view, of, width })
    }

    pub(crate) fn len(&self) -> usize {
        self.view.len()
    }

    pub(crate) fn is_double(&self) -> bool {
        self.of == Type::F64
    }

    /// Row `i` of floats; of one row only that one. Zeros behind the end.
    #[inline]
    pub(crate) fn numbers<const N: usize>(&self, i: usize) -> [f64; N] {
        let i = if self.view.len() == 1 { 0 } else { i };
        match self.of {
            Type::F32 => self.view.get::<f32, N>(i).unwrap_or([0.0; N]).map(f64::from),
            Type::F64 => self.view.get::<f64, N>(i).unwrap_or([0.0; N]),
            Type::U32 | Type::U64 => [0.0; N],
        }
    }

    /// A row of one number that is a mask.
    pub(crate) fn mask(&self, i: usize) -> u32 {
        let i = if self.view.len() == 1 { 0 } else { i };
        match self.of {
            Type::U64 => self.view.get::<u64, 1>(i).unwrap_or_default()[0] as u32,
            _ => self.view.get::<u32, 1>(i).unwrap_or_default()[0],
        }
    }

    /// All rows, rounded to floats.
    pub(crate) fn floats<const N: usize>(&self) -> Vec<[f32; N]> {
        debug_assert_eq!(self.width, N, "rows are read as wide as they are");
        match self.of {
            Type::F32 => self.view.rows::<f32, N>().into_owned(),
            _ => (0..self.len())
                .map_while(|i| self.view.get::<f64, N>(i))
                .map(|row| row.map(|x| x as f32))
                .collect(),
        }
    }

    /// All rows as they are, or converted from floats.
    pub(crate) fn doubles<const N: usize>(&self) -> Vec<[f64; N]> {
        match self.of {
            Type::F64 => self.view.rows::<f64, N>().into_owned(),
            _ => (0..self.len()).map(|i| self.numbers(i)).collect(),
        }
    }

    /// All rows of indices; those beyond 32 bits are of no vertex.
    pub(crate) fn u32_rows<const N: usize>(&self) -> Vec<[u32; N]> {
        match self.of {
            Type::U32 => self.view.rows::<u32, N>().into_owned(),
            _ => {
                let to_u32 = |i: u64| u32::try_from(i).unwrap_or(u32::MAX);
                (0..self.len()).map_while(|i| self.view.get::<u64, N>(i)).map(|row| row.map(to_u32)).collect()
            }
        }
    }
}

/// Rows of a geometry: the program's until the first commit, then a copy, for the program need not keep them any longer.
#[derive(Clone, Debug)]
pub(crate) enum Column<T> {
    Given(Rows),
    Owned(Vec<T>),
}

impl<T> Column<T> {
    pub(crate) fn len(&self) -> usize {
        match self {
            Self::Given(rows) => rows.len(),
            Self::Owned(rows) => rows.len(),
        }
    }

    /// The copy; nothing before [`keep`](Self::keep).
    pub(crate) fn retained(&self) -> &[T] {
        match self {
            Self::Given(_) => &[],
            Self::Owned(rows) => rows,
        }
    }

    /// Copies the program's rows, if that was not done.
    pub(crate) fn keep(&mut self, copy: impl FnOnce(&Rows) -> Vec<T>) {
        if let Self::Given(rows) = self {
            *self = Self::Owned(copy(rows));
        }
    }
}

/// `gnurt_hits`, and `gnurt_hits64`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Places<T> {
    stride: usize,
    t: *mut T,
    u: *mut T,
    v: *mut T,
    prim_id: *mut u32,
    geom_id: *mut u32,
    inst_id: *mut u32,
    normal: *mut T,
}

/// Where hits are written, in which precision.
#[derive(Clone, Copy, Debug)]
pub(crate) enum HitArrays {
    Single(Places<f32>),
    Double(Places<f64>),
}

/// The output for a hit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Written {
    pub(crate) t: f64,
    pub(crate) u: f64,
    pub(crate) v: f64,
    pub(crate) prim_id: u32,
    pub(crate) geom_id: u32,
    pub(crate) inst_id: u32,
    pub(crate) normal: [f64; 3],
}

impl Written {
    pub(crate) const MISS: Self = Self {
        t: f64::INFINITY,
        u: 0.0,
        v: 0.0,
        prim_id: u32::MAX,
        geom_id: u32::MAX,
        inst_id: u32::MAX,
        normal: [0.0; 3],
    };
}

impl HitArrays {
    pub(crate) fn needs_normals(&self) -> bool {
        match self {
            Self::Single(places) => !places.normal.is_null(),
            Self::Double(places) => !places.normal.is_null(),
        }
    }

    /// Writes element `i`.
    ///
    /// # Safety
    /// There is such an element in each array that is not null.
    pub(crate) unsafe fn set(&self, i: usize, hit: &Written) {
        // SAFETY: passed on.
        unsafe {
            match self {
                Self::Single(places) => places.set(i, hit, |x| x as f32),
                Self::Double(places) => places.set(i, hit, |x| x),
            }
        }
    }
}

impl<T> Places<T> {
    /// Writes element `i`.
    ///
    /// # Safety
    /// There is such an element in each array that is not null.
    unsafe fn set(&self, i: usize, hit: &Written, number: impl Fn(f64) -> T) {
        /// # Safety
        /// There is such an element, or the pointer is null.
        unsafe fn put<T>(start: *mut T, stride: usize, i: usize, value: T) {
            let stride = if stride == 0 { size_of::<T>() } else { stride };
            if !start.is_null() {
                // SAFETY: the caller vouches for the place.
                unsafe { start.wrapping_byte_add(i * stride).write_unaligned(value) }
            }
        }
        let Self { stride, .. } = *self;
        // SAFETY: passed on.
        unsafe {
            put(self.t, stride, i, number(hit.t));
            put(self.u, stride, i, number(hit.u));
            put(self.v, stride, i, number(hit.v));
            put(self.prim_id, stride, i, hit.prim_id);
            put(self.geom_id, stride, i, hit.geom_id);
            put(self.inst_id, stride, i, hit.inst_id);
            put(self.normal.cast::<[T; 3]>(), stride, i, hit.normal.map(number));
        }
    }
}

/// A box of six floats.
pub(crate) fn aabb(values: [f32; 6]) -> Aabb {
    let [a, b, c, d, e, f] = values;
    Aabb { min: [a, b, c], max: [d, e, f] }
}

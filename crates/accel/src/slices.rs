// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays in other programs' arrays, of floats or doubles, with gaps between them; and arrays for their hits.
//! Rays are copied a few thousand at a time, by the thread that traces them; nothing else is copied. Space
//! and units: as of a [`Ray`]. Invariant: all parts of some rays are of one length; other input is rejected
//! at construction. Tests: `tests/surfaces/slices.rs`.

use std::fmt;
use std::ops::Range;

use crate::{HitBatch, Ray, RayBatch};

/// Borrowed numbers.
#[derive(Clone, Copy, Debug)]
pub enum Floats<'a> {
    /// Single precision.
    F32(&'a [f32]),
    /// Double precision.
    F64(&'a [f64]),
}

impl<'a> From<&'a [f32]> for Floats<'a> {
    fn from(values: &'a [f32]) -> Self {
        Self::F32(values)
    }
}

impl<'a> From<&'a [f64]> for Floats<'a> {
    fn from(values: &'a [f64]) -> Self {
        Self::F64(values)
    }
}

impl Floats<'_> {
    fn len(&self) -> usize {
        match self {
            Self::F32(values) => values.len(),
            Self::F64(values) => values.len(),
        }
    }

    #[inline]
    fn get(&self, i: usize) -> f64 {
        match self {
            Self::F32(values) => f64::from(values[i]),
            Self::F64(values) => values[i],
        }
    }
}

/// Arrays that do not fit each other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SliceError {
    what: &'static str,
    found: usize,
    expected: usize,
}

impl fmt::Display for SliceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { what, found, expected } = self;
        write!(f, "{what}: {found} values where there are {expected} rays")
    }
}

impl std::error::Error for SliceError {}

pub(crate) fn fits(what: &'static str, found: usize, expected: usize) -> Result<(), SliceError> {
    if found == expected { Ok(()) } else { Err(SliceError { what, found, expected }) }
}

/// One number for each ray, or one for all of them.
#[derive(Clone, Copy, Debug)]
pub struct Column<'a> {
    values: Floats<'a>,
    first: usize,
    step: usize,
    len: Option<usize>,
}

impl<'a> Column<'a> {
    /// All numbers of an array, one for each ray.
    #[must_use]
    pub fn new(values: impl Into<Floats<'a>>) -> Self {
        Self::strided(values, 0, 1)
    }

    /// Those at `first`, `first + step` and so on; `step > 0`.
    #[must_use]
    pub fn strided(values: impl Into<Floats<'a>>, first: usize, step: usize) -> Self {
        let (values, step) = (values.into(), step.max(1));
        let len = values.len().saturating_sub(first).div_ceil(step);
        Self { values, first, step, len: Some(len) }
    }

    /// The number at `first`, for all rays. Panics where there is none.
    #[must_use]
    pub fn same(values: impl Into<Floats<'a>>, first: usize) -> Self {
        let values = values.into();
        assert!(first < values.len(), "number {first} of {}", values.len());
        Self { values, first, step: 0, len: None }
    }

    #[inline]
    fn get(&self, i: usize) -> f64 {
        self.values.get(self.first + i * self.step)
    }

    /// Appends some of them, rounded.
    fn copy(&self, range: Range<usize>, into: &mut Vec<f32>) {
        let (first, step, count) = (self.first + range.start * self.step, self.step, range.len());
        match self.values {
            _ if step == 0 => into.resize(into.len() + count, self.get(0) as f32),
            Floats::F32(values) => {
                into.extend(values[first..].iter().step_by(step).take(count));
            }
            Floats::F64(values) => {
                into.extend(values[first..].iter().step_by(step).take(count).map(|&x| x as f32));
            }
        }
    }
}

/// A point or direction for each ray, or one for all of them.
#[derive(Clone, Copy, Debug)]
pub struct Vectors<'a> {
    columns: [Column<'a>; 3],
    len: Option<usize>,
}

impl<'a> Vectors<'a> {
    /// Three numbers in a row for each ray, the first at `first`, the next `step` behind it, and so on: `rows(&array, 0, 6)` and
    /// `rows(&array, 3, 6)` are the two halves of rows of six. Excess elements at the end are ignored.
    #[must_use]
    pub fn rows(values: impl Into<Floats<'a>>, first: usize, step: usize) -> Self {
        let (values, step) = (values.into(), step.max(1));
        // The last one is whole.
        let len = values.len().saturating_sub(first.saturating_add(2)).div_ceil(step);
        let column = |k: usize| Column { values, first: first + k, step, len: Some(len) };
        Self { columns: [column(0), column(1), column(2)], len: Some(len) }
    }

    /// Their x, y and z.
    ///
    /// # Errors
    /// [`SliceError`] where there are not equally many of each.
    pub fn columns(x: Column<'a>, y: Column<'a>, z: Column<'a>) -> Result<Self, SliceError> {
        let len = x.len.or(y.len).or(z.len);
        for (column, what) in [(&x, "x coordinates"), (&y, "y coordinates"), (&z, "z coordinates")] {
            if let (Some(found), Some(len)) = (column.len, len) {
                fits(what, found, len)?;
            }
        }
        Ok(Self { columns: [x, y, z], len })
    }

    /// The same for all rays.
    #[must_use]
    pub fn same(values: &'a [f32; 3]) -> Self {
        let column = |k: usize| Column::same(&values[..], k);
        Self { columns: [column(0), column(1), column(2)], len: None }
    }

    /// How many there are; `None` where it is the same for any number of rays.
    #[must_use]
    pub fn count(&self) -> Option<usize> {
        self.len
    }

    #[inline]
    fn get(&self, i: usize) -> [f64; 3] {
        [self.columns[0].get(i), self.columns[1].get(i), self.columns[2].get(i)]
    }
}

impl<'a> From<&'a [[f32; 3]]> for Vectors<'a> {
    fn from(values: &'a [[f32; 3]]) -> Self {
        Self::rows(values.as_flattened(), 0, 3)
    }
}

impl<'a> From<&'a [[f64; 3]]> for Vectors<'a> {
    fn from(values: &'a [[f64; 3]]) -> Self {
        Self::rows(values.as_flattened(), 0, 3)
    }
}

/// Rays in borrowed arrays. Numbers of double precision are rounded to floats, except for origins, which
/// scenes use unrounded, as those of a [`Ray64`](crate::Ray64).
#[derive(Clone, Copy, Debug)]
pub struct RaySlices<'a> {
    org: Vectors<'a>,
    dir: Vectors<'a>,
    t_near: Option<Column<'a>>,
    t_far: Option<Column<'a>>,
    mask: Option<&'a [u32]>,
    time: Option<Column<'a>>,
    len: usize,
}

impl<'a> RaySlices<'a> {
    /// Rays over `[0, inf]` that see everything.
    ///
    /// # Errors
    /// [`SliceError`] where there are not as many directions as origins, or only one of each for any number of rays.
    pub fn new(org: impl Into<Vectors<'a>>, dir: impl Into<Vectors<'a>>) -> Result<Self, SliceError> {
        let (org, dir) = (org.into(), dir.into());
        let len = org.len.or(dir.len).unwrap_or(1);
        fits("directions", dir.len.unwrap_or(len), len)?;
        Ok(Self { org, dir, t_near: None, t_far: None, mask: None, time: None, len })
    }

    /// The same rays with near ends.
    ///
    /// # Errors
    /// [`SliceError`] if their number is not that of the rays.
    pub fn with_t_near(self, t_near: Column<'a>) -> Result<Self, SliceError> {
        fits("near ends", t_near.len.unwrap_or(self.len), self.len)?;
        Ok(Self { t_near: Some(t_near), ..self })
    }

    /// The same rays with far ends.
    ///
    /// # Errors
    /// [`SliceError`] if their number is not that of the rays.
    pub fn with_t_far(self, t_far: Column<'a>) -> Result<Self, SliceError> {
        fits("far ends", t_far.len.unwrap_or(self.len), self.len)?;
        Ok(Self { t_far: Some(t_far), ..self })
    }

    /// The same rays with masks.
    ///
    /// # Errors
    /// [`SliceError`] if their number is not that of the rays.
    pub fn with_masks(self, mask: &'a [u32]) -> Result<Self, SliceError> {
        fits("masks", mask.len(), self.len)?;
        Ok(Self { mask: Some(mask), ..self })
    }

    /// The same rays with times; see [`Ray::time`].
    ///
    /// # Errors
    /// [`SliceError`] if their number is not that of the rays.
    pub fn with_times(self, time: Column<'a>) -> Result<Self, SliceError> {
        fits("moments", time.len.unwrap_or(self.len), self.len)?;
        Ok(Self { time: Some(time), ..self })
    }

    /// Number of rays.
    #[must_use]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Appends some rays, in single precision.
    pub(crate) fn copy(&self, range: Range<usize>, rays: &mut RayBatch) {
        let Self { org, dir, t_near, t_far, mask, time, .. } = self;
        let end = rays.len() + range.len();
        for k in 0..3 {
            org.columns[k].copy(range.clone(), &mut rays.org[k]);
            dir.columns[k].copy(range.clone(), &mut rays.dir[k]);
        }
        let ends = [(t_near, 0.0, &mut rays.t_near), (t_far, f32::INFINITY, &mut rays.t_far)];
        for (column, default, into) in ends {
            match column {
                Some(column) => column.copy(range.clone(), into),
                None => into.resize(end, default),
            }
        }
        if let Some(mask) = mask {
            rays.mask.extend_from_slice(&mask[range.clone()]);
        }
        if let Some(time) = time {
            time.copy(range, &mut rays.time);
        }
    }

    /// Whether origins are in double precision, and so may be no floats.
    pub(crate) fn has_doubles(&self) -> bool {
        self.org.columns.iter().any(|column| matches!(column.values, Floats::F64(_)))
    }

    /// Ray `i` in single precision, and its origin where that is no float. Panics if `i >= len()`.
    #[must_use]
    pub fn get(&self, i: usize) -> (Ray, Option<[f64; 3]>) {
        let precise = self.org.get(i);
        let org = precise.map(|x| x as f32);
        let is_float = (0..3).all(|k| f64::from(org[k]) == precise[k] || precise[k].is_nan());
        let ray = Ray {
            org,
            t_near: self.t_near.map_or(0.0, |t| t.get(i) as f32),
            dir: self.dir.get(i).map(|x| x as f32),
            t_far: self.t_far.map_or(f32::INFINITY, |t| t.get(i) as f32),
            mask: self.mask.map_or(u32::MAX, |mask| mask[i]),
            time: self.time.map_or(0.0, |time| time.get(i) as f32),
        };
        (ray, (!is_float).then_some(precise))
    }
}

/// The output of hits: borrowed arrays of the requested fields, one value for each ray.
#[derive(Debug, Default)]
pub struct HitSlices<'a> {
    /// Ray parameters; infinite where a ray missed.
    pub t: Option<&'a mut [f32]>,
    /// First parameters on the primitives; 0 where a ray missed.
    pub u: Option<&'a mut [f32]>,
    /// Second parameters, one for each ray.
    pub v: Option<&'a mut [f32]>,
    /// Primitives; [`INVALID_ID`](crate::INVALID_ID) where a ray missed.
    pub prim_id: Option<&'a mut [u32]>,
    /// Geometries, one for each ray.
    pub geom_id: Option<&'a mut [u32]>,
    /// Instances, one for each ray.
    pub inst_id: Option<&'a mut [u32]>,
    /// Indices among all objects, one for each ray.
    pub leaf_id: Option<&'a mut [u32]>,
    /// Unit normals as [`ObjectTree::normal_at`](crate::ObjectTree::normal_at) gives them; zeros where there is none.
    pub normal: Option<&'a mut [[f32; 3]]>,
}

impl HitSlices<'_> {
    pub(crate) fn check(&self, rays: usize) -> Result<(), SliceError> {
        let floats = [(&self.t, "t"), (&self.u, "u"), (&self.v, "v")];
        let ids = [
            (&self.prim_id, "prim_id"),
            (&self.geom_id, "geom_id"),
            (&self.inst_id, "inst_id"),
            (&self.leaf_id, "leaf_id"),
        ];
        for (array, what) in floats {
            array.as_ref().map_or(Ok(()), |array| fits(what, array.len(), rays))?;
        }
        for (array, what) in ids {
            array.as_ref().map_or(Ok(()), |array| fits(what, array.len(), rays))?;
        }
        self.normal.as_ref().map_or(Ok(()), |array| fits("normals", array.len(), rays))
    }

    /// In parts for this many rays each.
    pub(crate) fn parts(&mut self, size: usize) -> Vec<(Range<usize>, HitSlices<'_>)> {
        fn split<'b, T>(array: &mut Option<&'b mut [T]>, at: usize) -> Option<&'b mut [T]> {
            let (first, rest) = array.take()?.split_at_mut(at);
            *array = Some(rest);
            Some(first)
        }
        let mut rest = HitSlices {
            t: self.t.as_deref_mut(),
            u: self.u.as_deref_mut(),
            v: self.v.as_deref_mut(),
            prim_id: self.prim_id.as_deref_mut(),
            geom_id: self.geom_id.as_deref_mut(),
            inst_id: self.inst_id.as_deref_mut(),
            leaf_id: self.leaf_id.as_deref_mut(),
            normal: self.normal.as_deref_mut(),
        };
        let mut parts = Vec::new();
        let mut start = 0;
        while let Some(left) = rest.any_len().filter(|&left| left > 0) {
            let count = left.min(size);
            let part = HitSlices {
                t: split(&mut rest.t, count),
                u: split(&mut rest.u, count),
                v: split(&mut rest.v, count),
                prim_id: split(&mut rest.prim_id, count),
                geom_id: split(&mut rest.geom_id, count),
                inst_id: split(&mut rest.inst_id, count),
                leaf_id: split(&mut rest.leaf_id, count),
                normal: split(&mut rest.normal, count),
            };
            parts.push((start..start + count, part));
            start += count;
        }
        parts
    }

    fn any_len(&self) -> Option<usize> {
        let floats = [&self.t, &self.u, &self.v].into_iter().flatten().map(|array| array.len());
        let ids = [&self.prim_id, &self.geom_id, &self.inst_id, &self.leaf_id];
        let ids = ids.into_iter().flatten().map(|array| array.len());
        floats.chain(ids).chain(self.normal.iter().map(|array| array.len())).next()
    }

    /// Writes all hits of these rays, but no normals.
    pub(crate) fn copy(&mut self, hits: &HitBatch) {
        fn put<T: Copy>(array: &mut Option<&mut [T]>, values: &[T]) {
            if let Some(array) = array {
                array.copy_from_slice(values);
            }
        }
        let HitBatch { t, u, v, prim_id, geom_id, inst_id, leaf_id } = hits;
        put(&mut self.t, t);
        put(&mut self.u, u);
        put(&mut self.v, v);
        put(&mut self.prim_id, prim_id);
        put(&mut self.geom_id, geom_id);
        put(&mut self.inst_id, inst_id);
        put(&mut self.leaf_id, leaf_id);
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays in arrays. Invariant: one origin or one direction goes with any number of the other.
//! Tests: `tests/test_rays.py::test_one_goes_with_many`, `tests/test_arrays.py`.

use std::ops::Range;

use gnurt_accel::doubles::DoubleRay;
use gnurt_accel::{Coherence, Column, Ray64, RaySlices, Vectors};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

use crate::arrays::Numbers;

/// Rays that are traced between two checks for Ctrl-C.
const BLOCK: usize = 1 << 19;

/// Pairs of neighbours that are compared to decide whether rays are coherent.
const SAMPLES: usize = 64;
/// Square of the cosine of the angle between neighbours of similar direction: 3 degrees.
const ALIKE: f32 = 0.997;

/// A number for all rays, or one for each.
enum Ends {
    Same([f64; 1]),
    Each(Numbers),
}

impl Ends {
    fn new(name: &str, value: Option<&Bound<'_, PyAny>>, default: f64, count: usize) -> PyResult<Self> {
        let Some(value) = value else { return Ok(Self::Same([default])) };
        if let Ok(number) = value.extract::<f64>() {
            return Ok(Self::Same([number]));
        }
        let numbers = Numbers::new(name, value, None).map_err(|error| {
            PyTypeError::new_err(format!("{}; or one number for all rays", error.value(value.py())))
        })?;
        match numbers.count() {
            n if n == count => Ok(Self::Each(numbers)),
            n => Err(PyValueError::new_err(format!(
                "{name}: expected {count} numbers, one for each ray, not {n}"
            ))),
        }
    }

    /// That of one ray.
    fn at(&self, i: usize) -> f64 {
        match self {
            Self::Same([number]) => *number,
            Self::Each(numbers) => numbers.row(i)[0],
        }
    }

    fn column(&self, range: &Range<usize>) -> Column<'_> {
        match self {
            Self::Same(number) => Column::same(&number[..], 0),
            Self::Each(numbers) => Column::new(numbers.rows(range.start, range.end)),
        }
    }
}

/// Borrowed rays.
pub(crate) struct Rays {
    origins: Numbers,
    directions: Numbers,
    t_near: Ends,
    t_far: Ends,
    count: usize,
}

impl Rays {
    pub(crate) fn new(
        origins: &Bound<'_, PyAny>,
        directions: &Bound<'_, PyAny>,
        t_near: Option<&Bound<'_, PyAny>>,
        t_far: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let origins = Numbers::new("origins", origins, Some(3))?;
        let directions = Numbers::new("directions", directions, Some(3))?;
        let count = match (origins.count(), directions.count()) {
            (a, b) if a == b || b == 1 => a,
            (1, b) => b,
            (a, b) => {
                return Err(PyValueError::new_err(format!(
                    "directions: expected shape ({a}, 3) as of origins, or (1, 3), not ({b}, 3)"
                )));
            }
        };
        let t_near = Ends::new("t_near", t_near, 0.0, count)?;
        let t_far = Ends::new("t_far", t_far, f64::INFINITY, count)?;
        Ok(Self { origins, directions, t_near, t_far, count })
    }

    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// Ranges of rays that are traced in one go.
    pub(crate) fn blocks(&self) -> impl Iterator<Item = Range<usize>> + use<> {
        let count = self.count;
        (0..count).step_by(BLOCK).map(move |first| first..(first + BLOCK).min(count))
    }

    /// The vectors of some of the rays, or the one for all of them.
    fn vectors<'a>(&self, numbers: &'a Numbers, range: &Range<usize>) -> Vectors<'a> {
        if numbers.count() != 1 || self.count == 1 {
            return Vectors::rows(numbers.rows(range.start, range.end), 0, numbers.step());
        }
        let one = numbers.rows(0, 1);
        let column = |k| Column::same(one, k);
        Vectors::columns(column(0), column(1), column(2)).expect("one of each")
    }

    /// Some of the rays.
    pub(crate) fn slices(&self, range: &Range<usize>) -> PyResult<RaySlices<'_>> {
        let slices =
            RaySlices::new(self.vectors(&self.origins, range), self.vectors(&self.directions, range))
                .and_then(|rays| rays.with_t_near(self.t_near.column(range)))
                .and_then(|rays| rays.with_t_far(self.t_far.column(range)));
        slices.map_err(|error| PyValueError::new_err(error.to_string()))
    }

    /// Whether neighbours have similar directions: judged by a few of them, for results do not depend on it.
    pub(crate) fn coherence(&self, slices: &RaySlices) -> Coherence {
        let pairs = slices.len().saturating_sub(1).min(SAMPLES);
        if pairs < SAMPLES {
            return Coherence::Incoherent;
        }
        let alike = |i: usize| {
            let (a, b) = (slices.get(i).0, slices.get(i + 1).0);
            let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
            let along = dot(a.dir, b.dir);
            along > 0.0 && along * along > ALIKE * dot(a.dir, a.dir) * dot(b.dir, b.dir)
        };
        let step = (slices.len() - 1) / pairs;
        let count = (0..pairs).filter(|i| alike(i * step)).count();
        if 4 * count >= 3 * pairs { Coherence::Coherent } else { Coherence::Incoherent }
    }

    /// Some of the rays in double precision.
    pub(crate) fn doubles(&self, range: &Range<usize>) -> Vec<DoubleRay> {
        let vector = |numbers: &Numbers, i: usize| numbers.row(if numbers.count() == 1 { 0 } else { i });
        let ray = |i| DoubleRay {
            org: vector(&self.origins, i),
            dir: vector(&self.directions, i),
            t_near: self.t_near.at(i),
            t_far: self.t_far.at(i),
            mask: u32::MAX,
        };
        range.clone().map(ray).collect()
    }

    /// Some of the rays for queries one by one.
    pub(crate) fn list(&self, range: &Range<usize>) -> PyResult<Vec<Ray64>> {
        let slices = self.slices(range)?;
        let ray = |i| {
            let (ray, origin) = slices.get(i);
            let org = origin.unwrap_or_else(|| ray.org.map(f64::from));
            Ray64 { org, t_near: ray.t_near, dir: ray.dir, t_far: ray.t_far, mask: ray.mask, time: ray.time }
        };
        Ok((0..slices.len()).map(ray).collect())
    }
}

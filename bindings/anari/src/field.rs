// SPDX-License-Identifier: GPL-3.0-or-later
//! Spatial fields: values at the points of a regular grid, and between them.
//! Source: ANARI 1.1, KHR_SPATIAL_FIELD_STRUCTURED_REGULAR: the first point is the origin; KHR_SPATIAL_FIELD_NANOVDB. Cubic interpolation
//! is Catmull's and Rom's. Space: object. Tests: tests/volumes.rs.

use crate::ffi_array::Array;
use crate::nanovdb;
use crate::object::{Object, Snapshot};
use crate::types;

/// A field.
pub(crate) struct Field {
    /// Points along each axis, at least 1.
    pub(crate) dims: [usize; 3],
    pub(crate) origin: [f32; 3],
    /// From point to point, greater than 0.
    pub(crate) spacing: [f32; 3],
    values: Vec<f32>,
    filter: Filter,
}

/// How values between points follow from theirs.
#[derive(Clone, Copy, PartialEq)]
enum Filter {
    Nearest,
    Linear,
    Cubic,
}

impl Filter {
    fn of(now: &Snapshot) -> Self {
        match now.text("filter") {
            Some("nearest") => Self::Nearest,
            Some("cubic") => Self::Cubic,
            _ => Self::Linear,
        }
    }
}

/// Weights of the points from one below a cell to one above it.
fn cubic(x: f32) -> [f32; 4] {
    let (xx, xxx) = (x * x, x * x * x);
    [-xxx + 2.0 * xx - x, 3.0 * xxx - 5.0 * xx + 2.0, -3.0 * xxx + 4.0 * xx + x, xxx - xx].map(|w| w / 2.0)
}

impl Field {
    /// The field of an object; an error in words where it has no values.
    pub(crate) fn new(object: &Object) -> Result<Self, String> {
        let now = object.committed();
        match object.subtype.as_str() {
            "structuredRegular" => Self::regular(&now),
            "nanovdb" => Self::sparse(&now),
            other => Err(format!("subtype '{other}': unsupported; allowed: structuredRegular, nanovdb")),
        }
    }

    /// That of a grid of NanoVDB.
    fn sparse(now: &Snapshot) -> Result<Self, String> {
        let array = now.object("data", types::ARRAY1D).and_then(|array| Array::of(array));
        let array = array.ok_or("parameter 'data': missing, the field has no values")?;
        let grid = array.with_bytes(nanovdb::dense).map_err(|fault| format!("parameter 'data': {fault}"))?;
        let nanovdb::Dense { dims, origin, spacing, values } = grid;
        Ok(Self { dims, origin, spacing, values, filter: Filter::of(now) })
    }

    fn regular(now: &Snapshot) -> Result<Self, String> {
        let array = now.object("data", types::ARRAY3D).and_then(|array| Array::of(array));
        let array = array.ok_or("parameter 'data': missing, the field has no values")?;
        let element = types::name(array.element);
        let values =
            array.colors().ok_or_else(|| format!("parameter 'data': elements of type {element}: invalid"))?;
        let (dims, spacing) = (array.dims.map(|n| n as usize), now.vec3("spacing").unwrap_or([1.0; 3]));
        if values.is_empty() {
            return Err("parameter 'data': no values".into());
        }
        if !spacing.iter().all(|&step| step > 0.0 && step.is_finite()) {
            return Err(format!("parameter 'spacing': {spacing:?}: out of range; all must be above 0"));
        }
        Ok(Self {
            dims,
            origin: now.vec3("origin").unwrap_or([0.0; 3]),
            spacing,
            values: values.into_iter().map(|value| value[0]).collect(),
            filter: Filter::of(now),
        })
    }

    /// Lower and upper corner.
    pub(crate) fn bounds(&self) -> [[f32; 3]; 2] {
        let upper = std::array::from_fn(|k| self.origin[k] + self.spacing[k] * (self.dims[k] - 1) as f32);
        [self.origin, upper]
    }

    /// The value of a point of the grid.
    pub(crate) fn voxel(&self, [x, y, z]: [usize; 3]) -> f32 {
        self.values[x + self.dims[0] * (y + self.dims[1] * z)]
    }

    /// The value at a place; `None` outside.
    pub(crate) fn value(&self, p: [f32; 3]) -> Option<f32> {
        let (mut cell, mut share) = ([0_usize; 3], [0.0_f32; 3]);
        for k in 0..3 {
            let most = (self.dims[k] - 1) as f32;
            let coordinate = (p[k] - self.origin[k]) / self.spacing[k];
            // A place on the border is within, in spite of rounding; NaN is outside.
            if !(-1e-4..=most + 1e-4).contains(&coordinate) {
                return None;
            }
            let coordinate = coordinate.clamp(0.0, most);
            if self.filter != Filter::Nearest {
                cell[k] = (coordinate as usize).min(self.dims[k].saturating_sub(2));
                share[k] = coordinate - cell[k] as f32;
            } else {
                cell[k] = (coordinate + 0.5) as usize;
            }
        }
        match self.filter {
            Filter::Nearest => return Some(self.voxel(cell)),
            Filter::Cubic => return Some(self.smooth(cell, share)),
            Filter::Linear => {}
        }
        let at = |x: usize, y: usize, z: usize| {
            let within = |k: usize, step: usize| (cell[k] + step).min(self.dims[k] - 1);
            self.voxel([within(0, x), within(1, y), within(2, z)])
        };
        let mix = |a: f32, b: f32, share: f32| a + (b - a) * share;
        let row = |y: usize, z: usize| mix(at(0, y, z), at(1, y, z), share[0]);
        let plane = |z: usize| mix(row(0, z), row(1, z), share[1]);
        Some(mix(plane(0), plane(1), share[2]))
    }

    /// The value within a cell by the points around it; those of the border stand for those beyond.
    fn smooth(&self, cell: [usize; 3], share: [f32; 3]) -> f32 {
        let [xs, ys, zs] = share.map(cubic);
        let at = |k: usize, step: usize| (cell[k] + step).saturating_sub(1).min(self.dims[k] - 1);
        let row = |y: usize, z: usize| -> f32 {
            (0..4).map(|i| xs[i] * self.voxel([at(0, i), at(1, y), at(2, z)])).sum()
        };
        let plane = |z: usize| -> f32 { (0..4).map(|j| ys[j] * row(j, z)).sum() };
        (0..4).map(|k| zs[k] * plane(k)).sum()
    }

    /// Its change per unit of space at a point of the grid, by differences.
    pub(crate) fn gradient(&self, at: [usize; 3]) -> [f32; 3] {
        std::array::from_fn(|k| {
            let (mut below, mut above) = (at, at);
            below[k] = at[k].saturating_sub(1);
            above[k] = (at[k] + 1).min(self.dims[k] - 1);
            let way = (above[k] - below[k]) as f32 * self.spacing[k];
            if way > 0.0 { (self.voxel(above) - self.voxel(below)) / way } else { 0.0 }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubic_values_follow_parabolas() {
        let square = |filter| Field {
            dims: [6, 1, 1],
            origin: [0.0; 3],
            spacing: [2.0, 1.0, 1.0],
            values: (0..6).map(|x| (x * x) as f32).collect(),
            filter,
        };
        let at = |filter, x: f32| square(filter).value([2.0 * x, 0.0, 0.0]).expect("within");
        for x in [1.25, 2.5, 3.75] {
            assert!((at(Filter::Cubic, x) - x * x).abs() < 1e-5, "{x}");
            assert!(at(Filter::Linear, x) > x * x + 0.1, "straight lines lie above");
        }
        assert_eq!((at(Filter::Cubic, 5.0), at(Filter::Nearest, 2.6)), (25.0, 9.0), "at points");
    }
}

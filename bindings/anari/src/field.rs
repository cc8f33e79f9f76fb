// SPDX-License-Identifier: GPL-3.0-or-later
//! Spatial fields: values at the points of a regular grid, and between them.
//! Source: ANARI 1.1, KHR_SPATIAL_FIELD_STRUCTURED_REGULAR: the first point is the origin. Space: object. Tests: tests/volumes.rs.

use crate::ffi_array::Array;
use crate::object::Object;
use crate::types;

/// A field.
pub(crate) struct Field {
    /// Points along each axis, at least 1.
    pub(crate) dims: [usize; 3],
    pub(crate) origin: [f32; 3],
    /// From point to point, greater than 0.
    pub(crate) spacing: [f32; 3],
    values: Vec<f32>,
    linear: bool,
}

impl Field {
    /// The field of an object; an error in words where it has no values.
    pub(crate) fn new(object: &Object) -> Result<Self, String> {
        if object.subtype != "structuredRegular" {
            return Err(format!("subtype '{}': unsupported; allowed: structuredRegular", object.subtype));
        }
        let now = object.committed();
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
            linear: now.text("filter") != Some("nearest"),
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
            if self.linear {
                cell[k] = (coordinate as usize).min(self.dims[k].saturating_sub(2));
                share[k] = coordinate - cell[k] as f32;
            } else {
                cell[k] = (coordinate + 0.5) as usize;
            }
        }
        if !self.linear {
            return Some(self.voxel(cell));
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

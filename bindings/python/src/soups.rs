// SPDX-License-Identifier: GPL-3.0-or-later
//! Geometries as trees are built from them: arrays taken out of Python, with their transforms applied.
//! Tests: `tests/test_scene.py`, `tests/test_primitives.py`.

use gnurt_accel::{CurveBasis, CurveForm, Curves, Discs, Geometry, Grid, Grids, Quads, Spheres, Triangles};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::ffi_arrays::Rows;
use crate::geometries::{Kind, PointForm, StoredGeometry, uniform_scale};

/// Columns of an affine map.
type Placement = [[f64; 3]; 4];

/// A geometry's arrays.
pub(crate) enum Soup {
    Triangles(Vec<[f32; 3]>, Vec<[u32; 3]>),
    Quads(Vec<[f32; 3]>, Vec<[u32; 4]>),
    Grids(Vec<[f32; 3]>, Vec<Grid>),
    Spheres(Vec<[f32; 3]>, Vec<f32>),
    /// With normals, or facing each ray.
    Discs(Vec<[f32; 3]>, Vec<f32>, Option<Vec<[f32; 3]>>),
    Curves(Box<CurveSoup>),
}

/// Arrays of curves.
pub(crate) struct CurveSoup {
    basis: CurveBasis,
    form: CurveForm,
    vertices: Vec<[f32; 4]>,
    segments: Vec<u32>,
    tangents: Vec<[f32; 4]>,
    normals: Vec<[f32; 3]>,
    normal_tangents: Vec<[f32; 3]>,
}

/// Rows of a stored array.
pub(crate) fn stored_rows<T: pyo3::buffer::Element + Copy, const N: usize>(
    array: &Bound<'_, PyAny>,
) -> PyResult<Vec<[T; N]>> {
    let rows = Rows::<T>::new(array)?.ok_or_else(|| PyValueError::new_err("an array has gaps"))?;
    Ok(rows.all().as_chunks().0.to_vec())
}

/// Those of an array that may be absent.
fn optional<T: pyo3::buffer::Element + Copy, const N: usize>(
    py: Python<'_>,
    array: Option<&Py<PyAny>>,
) -> PyResult<Vec<[T; N]>> {
    array.map_or(Ok(Vec::new()), |array| stored_rows(array.bind(py)))
}

impl Soup {
    /// One of nothing.
    pub(crate) fn empty() -> Self {
        Self::Triangles(Vec::new(), Vec::new())
    }

    pub(crate) fn new(py: Python<'_>, geometry: &StoredGeometry) -> PyResult<Self> {
        let arrays = &geometry.arrays;
        let positions: Vec<[f32; 3]> = stored_rows(arrays.vertices.bind(py))?;
        let radii: Vec<f32> = optional::<_, 1>(py, arrays.radii.as_ref())?.into_flattened();
        let normals: Vec<[f32; 3]> = optional(py, arrays.normals.as_ref())?;
        let indices = arrays.indices.as_ref();
        Ok(match geometry.kind {
            Kind::Triangles => Self::Triangles(positions, optional(py, indices)?),
            Kind::Quads => Self::Quads(positions, optional(py, indices)?),
            Kind::Grids => Self::Grids(positions, optional(py, indices)?.into_iter().map(grid).collect()),
            Kind::Points(PointForm::Round) => Self::Spheres(positions, radii),
            Kind::Points(PointForm::Flat) => Self::Discs(positions, radii, None),
            Kind::Points(PointForm::Oriented) => Self::Discs(positions, radii, Some(normals)),
            Kind::Curves(basis, form) => Self::Curves(Box::new(CurveSoup {
                basis,
                form,
                vertices: positions.into_iter().zip(radii).map(|([x, y, z], r)| [x, y, z, r]).collect(),
                segments: optional::<_, 1>(py, indices)?.into_flattened(),
                tangents: optional(py, arrays.tangents.as_ref())?,
                normals,
                normal_tangents: optional(py, arrays.normal_tangents.as_ref())?,
            })),
        })
    }

    /// The same with its transform applied, which scales all directions alike unless it is of a mesh.
    pub(crate) fn placed(py: Python<'_>, geometry: &StoredGeometry) -> PyResult<Self> {
        let mut soup = Self::new(py, geometry)?;
        if let Some(placement) = &geometry.placement {
            soup.place(placement);
        }
        Ok(soup)
    }

    fn place(&mut self, placement: &Placement) {
        let scale = uniform_scale(placement).unwrap_or(1.0);
        let scaled = |x: f32| (f64::from(x) * scale) as f32;
        let places = |all: &mut [[f32; 3]]| all.iter_mut().for_each(|at| *at = carried(placement, *at));
        let turns = |all: &mut [[f32; 3]]| all.iter_mut().for_each(|way| *way = turned(placement, *way));
        match self {
            Self::Triangles(positions, _) | Self::Quads(positions, _) | Self::Grids(positions, _) => {
                places(positions);
            }
            Self::Spheres(centers, radii) | Self::Discs(centers, radii, None) => {
                places(centers);
                radii.iter_mut().for_each(|radius| *radius = scaled(*radius));
            }
            Self::Discs(centers, radii, Some(normals)) => {
                places(centers);
                radii.iter_mut().for_each(|radius| *radius = scaled(*radius));
                turns(normals);
            }
            Self::Curves(curves) => {
                for [x, y, z, r] in &mut curves.vertices {
                    [*x, *y, *z] = carried(placement, [*x, *y, *z]);
                    *r = scaled(*r);
                }
                for [x, y, z, r] in &mut curves.tangents {
                    [*x, *y, *z] = turned(placement, [*x, *y, *z]);
                    *r = scaled(*r);
                }
                turns(&mut curves.normals);
                turns(&mut curves.normal_tangents);
            }
        }
    }

    /// For a build.
    pub(crate) fn geometry(&self) -> Geometry<'_> {
        match self {
            Self::Triangles(positions, indices) => Triangles { positions, indices }.into(),
            Self::Quads(positions, indices) => Quads { positions, indices }.into(),
            Self::Grids(positions, grids) => Grids { positions, grids }.into(),
            Self::Spheres(centers, radii) => Spheres { centers, radii }.into(),
            Self::Discs(centers, radii, normals) => {
                Discs { centers, radii, normals: normals.as_deref() }.into()
            }
            Self::Curves(curves) => Curves {
                tangents: &curves.tangents,
                normals: &curves.normals,
                normal_tangents: &curves.normal_tangents,
                ..Curves::new(curves.basis, curves.form, &curves.vertices, &curves.segments)
            }
            .into(),
        }
    }
}

/// A row of numbers that were checked.
fn grid([first, stride, columns, rows]: [u32; 4]) -> Grid {
    let [width, height] = [columns, rows].map(|size| u16::try_from(size).unwrap_or_default());
    Grid { first, stride, width, height }
}

/// A transformed point.
fn carried(placement: &Placement, point: [f32; 3]) -> [f32; 3] {
    let [x, y, z, w] = placement;
    let [a, b, c] = point.map(f64::from);
    [0, 1, 2].map(|k| (x[k] * a + y[k] * b + z[k] * c + w[k]) as f32)
}

/// A transformed direction.
fn turned(&[x, y, z, _]: &Placement, direction: [f32; 3]) -> [f32; 3] {
    carried(&[x, y, z, [0.0; 3]], direction)
}

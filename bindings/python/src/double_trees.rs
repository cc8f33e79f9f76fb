// SPDX-License-Identifier: GPL-3.0-or-later
//! The trees of ray scenes in double precision, built again after each change. Structure as in `trees.rs`.
//! Tests: `tests/test_doubles.py`.

use std::collections::BTreeMap;
use std::sync::Arc;

use gnurt_accel::doubles::{DoubleInstance, DoubleMesh, DoubleScene};
use gnurt_accel::{BuildOptions, Threads};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::geometries::StoredGeometry;
use crate::soups::stored_rows;

/// The contents of an instance: a mesh, by its number, or another scene; and the transform.
pub(crate) type Placed = (Inner, [[f64; 3]; 4]);

/// The contents of an instance.
pub(crate) enum Inner {
    Mesh(u32),
    Scene(Option<Arc<DoubleScene>>),
}

/// Vertices, transformed if a mesh has a transform, and faces.
type Soup = (Vec<[f64; 3]>, Vec<[u32; 3]>);

/// The input of a scene, taken out of Python.
pub(crate) struct DoublePlan {
    all: Vec<Soup>,
    /// Meshes that instances show, as they are.
    shown: BTreeMap<u32, Soup>,
    placed_list: Vec<Placed>,
}

fn carried([x, y, z, w]: &[[f64; 3]; 4], [a, b, c]: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| x[k] * a + y[k] * b + z[k] * c + w[k])
}

fn scene(meshes: &[Soup], instances: &[DoubleInstance], threads: Threads) -> PyResult<Arc<DoubleScene>> {
    let meshes: Vec<_> =
        meshes.iter().map(|(positions, indices)| DoubleMesh::new(positions, indices)).collect();
    DoubleScene::build(&meshes, instances, &BuildOptions::default(), threads)
        .map(Arc::new)
        .map_err(|error| PyValueError::new_err(error.to_string()))
}

impl DoublePlan {
    pub(crate) fn new(
        py: Python<'_>,
        meshes: &[Option<StoredGeometry>],
        placed_list: Vec<Placed>,
    ) -> PyResult<Self> {
        let soup = |mesh: &StoredGeometry| {
            let faces = mesh.arrays.indices.as_ref().map(|faces| stored_rows(faces.bind(py)));
            Ok::<Soup, PyErr>((
                stored_rows(mesh.arrays.vertices.bind(py))?,
                faces.transpose()?.unwrap_or_default(),
            ))
        };
        let mut all = Vec::with_capacity(meshes.len());
        for mesh in meshes {
            let Some(mesh) = mesh else {
                all.push(Soup::default());
                continue;
            };
            let (mut positions, indices) = soup(mesh)?;
            if let Some(placement) = &mesh.placement {
                positions.iter_mut().for_each(|at| *at = carried(placement, *at));
            }
            all.push((positions, indices));
        }
        let mut shown = BTreeMap::new();
        for (inner, _) in &placed_list {
            if let Inner::Mesh(geom_id) = inner
                && let Some(Some(mesh)) = meshes.get(*geom_id as usize)
                && !shown.contains_key(geom_id)
            {
                shown.insert(*geom_id, soup(mesh)?);
            }
        }
        Ok(Self { all, shown, placed_list })
    }

    /// Builds; without the interpreter.
    pub(crate) fn build(self, threads: Threads) -> PyResult<Arc<DoubleScene>> {
        let mut shown = BTreeMap::new();
        for (id, soup) in self.shown {
            shown.insert(id, scene(&[soup], &[], threads)?);
        }
        let mut instances = Vec::with_capacity(self.placed_list.len());
        for (inner, placement) in self.placed_list {
            let inner = match inner {
                Inner::Mesh(geom_id) => shown.get(&geom_id).cloned(),
                Inner::Scene(scene) => scene,
            };
            let shown = inner.ok_or_else(|| PyValueError::new_err("an instance shows nothing"))?;
            instances.push(DoubleInstance { shown, placement, mask: u32::MAX });
        }
        scene(&self.all, &instances, threads)
    }
}

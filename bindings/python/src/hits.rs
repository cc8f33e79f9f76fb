// SPDX-License-Identifier: GPL-3.0-or-later
//! Hits of rays, as arrays. See docs/reference/python.md. Tests: `tests/test_rays.py`.

use std::sync::Arc;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::arrays::New;
use crate::pool::ThreadCount;
use crate::trees::Trees;

/// The data for normals, computed on request.
pub(crate) struct Found {
    pub(crate) trees: Arc<Trees>,
    pub(crate) threads: ThreadCount,
    /// Triangle, geometry, instance and leaf of each ray's hit, as the trees name them.
    pub(crate) ids: Vec<[u32; 4]>,
    /// Normals that needed the rays: of scenes with more than triangles.
    pub(crate) normals: Option<Py<PyAny>>,
}

/// Where normals and paths come from.
pub(crate) enum Origin {
    Query(Found),
    /// Of hits that were pickled.
    Pickle {
        normal: Py<PyAny>,
        path: Py<PyAny>,
    },
}

/// What pickle keeps: the function that makes hits again, and its arguments, arrays of these names.
fn reduced<'py>(
    hits: &Bound<'py, PyAny>,
    names: &[&str],
) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
    let arrays: PyResult<Vec<_>> = names.iter().map(|name| hits.getattr(*name)).collect();
    Ok((hits.get_type().getattr("_restored")?, PyTuple::new(hits.py(), arrays?)?))
}

/// Where each ray hits first. `len(hits)` is the number of rays. Of a scene of float64, `t`, `u`, `v` and `normal` are float64.
#[pyclass(module = "gnurt", frozen)]
pub(crate) struct Hits {
    /// float32 (n,): how many lengths of the direction away; inf where the ray missed.
    #[pyo3(get)]
    pub(crate) t: Py<PyAny>,
    /// int32 (n,): the row of `faces`, the point, or the curve; -1 where the ray missed.
    #[pyo3(get)]
    pub(crate) prim_id: Py<PyAny>,
    /// int32 (n,): the geometry; -1 where the ray missed.
    #[pyo3(get)]
    pub(crate) geom_id: Py<PyAny>,
    /// int32 (n,): the instance, of scenes in scenes the outermost; -1 where the ray missed, or hit a geometry itself.
    #[pyo3(get)]
    pub(crate) inst_id: Py<PyAny>,
    /// float32 (n,): weight of the triangle's second corner. Of quads from 0 on the edge of corners 0 and 3 to 1; along curves from
    /// 0 to 1; 0 of points.
    #[pyo3(get)]
    pub(crate) u: Py<PyAny>,
    /// float32 (n,): weight of the triangle's third corner. Of quads from 0 on the edge of corners 0 and 1 to 1; across flat curves
    /// from -1 to 1 and across oriented ones from 0 to 1; 0 of round curves and points.
    #[pyo3(get)]
    pub(crate) v: Py<PyAny>,
    pub(crate) count: usize,
    pub(crate) origin: Origin,
}

#[pymethods]
impl Hits {
    /// float32 (n, 3): unit normals; zeros where the ray missed. By the right hand rule of triangles and quads, outwards of
    /// spheres and round curves, on the side of the given ones of oriented discs and curves; zeros of flat ones, which face the ray.
    #[getter]
    fn normal(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let Found { trees, threads, ids, normals } = match &self.origin {
            Origin::Query(found) => found,
            Origin::Pickle { normal, .. } => return Ok(normal.clone_ref(py)),
        };
        if let Some(normals) = normals {
            return Ok(normals.clone_ref(py));
        }
        if let Some(scene) = &trees.doubles {
            let mut normals = New::<f64>::empty(py, self.count, 3)?;
            let all = normals.all();
            py.detach(|| {
                for (normal, [prim_id, geom_id, _, leaf_id]) in all.chunks_exact_mut(3).zip(ids) {
                    normal.copy_from_slice(&scene.normal(*leaf_id, *geom_id, *prim_id));
                }
            });
            return Ok(normals.done());
        }
        let mut normals = New::<f32>::empty(py, self.count, 3)?;
        let all = normals.all();
        let workers = threads.workers()?;
        py.detach(|| {
            workers.threads().run(|parallel| {
                let set =
                    |(normal, ids): (&mut [f32], &[u32; 4])| normal.copy_from_slice(&trees.normal(*ids));
                if parallel {
                    use rayon::prelude::*;
                    all.par_chunks_exact_mut(3).zip(ids).with_min_len(1024).for_each(set);
                } else {
                    all.chunks_exact_mut(3).zip(ids).for_each(set);
                }
            });
        });
        Ok(normals.done())
    }

    /// int32 (n, levels): the instances along the path to the hit in nested scenes, outermost first; then -1.
    #[getter]
    fn path(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let Found { trees, ids, .. } = match &self.origin {
            Origin::Query(found) => found,
            Origin::Pickle { path, .. } => return Ok(path.clone_ref(py)),
        };
        let levels = trees.levels();
        let mut paths = New::<u32>::empty(py, self.count, levels)?;
        let all = paths.all();
        py.detach(|| {
            for (path, &[prim_id, geom_id, inst_id, leaf_id]) in all.chunks_exact_mut(levels).zip(ids) {
                let inst_id = if prim_id == u32::MAX { u32::MAX } else { inst_id };
                trees.path([geom_id, inst_id, leaf_id], path);
            }
        });
        paths.rows_as("int32", levels)
    }

    fn __len__(&self) -> usize {
        self.count
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let hit: usize =
            self.prim_id.bind(py).call_method1("__ge__", (0,))?.call_method0("sum")?.extract()?;
        Ok(format!("<gnurt.Hits: {} rays, {hit} hit>", self.count))
    }

    /// For pickle: the arrays, without the scene.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let names = ["t", "prim_id", "geom_id", "inst_id", "u", "v", "normal", "path"];
        reduced(slf.as_any(), &names)
    }

    #[staticmethod]
    #[allow(clippy::too_many_arguments, reason = "an array each")]
    fn _restored(
        py: Python<'_>,
        t: Py<PyAny>,
        prim_id: Py<PyAny>,
        geom_id: Py<PyAny>,
        inst_id: Py<PyAny>,
        u: Py<PyAny>,
        v: Py<PyAny>,
        normal: Py<PyAny>,
        path: Py<PyAny>,
    ) -> PyResult<Self> {
        let count = t.bind(py).len()?;
        for array in [&prim_id, &geom_id, &inst_id, &u, &v, &normal, &path] {
            if array.bind(py).len()? != count {
                return Err(PyValueError::new_err(
                    "the pickle is damaged: its arrays have different lengths",
                ));
            }
        }
        let origin = Origin::Pickle { normal, path };
        Ok(Self { t, prim_id, geom_id, inst_id, u, v, count, origin })
    }
}

/// All hits of each ray, in order. The hits of ray `i` are `[splits[i]:splits[i + 1]]` of the other arrays.
#[pyclass(module = "gnurt", frozen, get_all)]
pub(crate) struct AllHits {
    /// int64 (n + 1,).
    pub(crate) splits: Py<PyAny>,
    /// int64 (m,): the ray.
    pub(crate) ray_id: Py<PyAny>,
    /// float32 (m,), as are u and v; int32 (m,) as are the others: see `Hits`.
    pub(crate) t: Py<PyAny>,
    pub(crate) prim_id: Py<PyAny>,
    pub(crate) geom_id: Py<PyAny>,
    pub(crate) inst_id: Py<PyAny>,
    /// int32 (m, levels).
    pub(crate) path: Py<PyAny>,
    pub(crate) u: Py<PyAny>,
    pub(crate) v: Py<PyAny>,
}

#[pymethods]
impl AllHits {
    fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
        Ok(self.splits.bind(py).len()? - 1)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let hits = self.t.bind(py).len()?;
        Ok(format!("<gnurt.AllHits: {} rays, {hits} hits>", self.__len__(py)?))
    }

    /// For pickle.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        reduced(slf.as_any(), &["splits", "ray_id", "t", "prim_id", "geom_id", "inst_id", "path", "u", "v"])
    }

    #[staticmethod]
    #[allow(clippy::too_many_arguments, reason = "an array each")]
    fn _restored(
        splits: Py<PyAny>,
        ray_id: Py<PyAny>,
        t: Py<PyAny>,
        prim_id: Py<PyAny>,
        geom_id: Py<PyAny>,
        inst_id: Py<PyAny>,
        path: Py<PyAny>,
        u: Py<PyAny>,
        v: Py<PyAny>,
    ) -> Self {
        Self { splits, ray_id, t, prim_id, geom_id, inst_id, path, u, v }
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt.RayScene`. Source: original; docs/python.md. Trees are built by the first query after a change.
//! Proof: `bindings/python/tests`.

use std::sync::{Arc, Mutex, PoisonError};

use pyo3::exceptions::{PyIndexError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use pyo3::types::{PyDict, PyList, PyTuple};

use crate::answers::{Asked, Which};
use crate::arrays::{Numbers, transform};
use crate::hits::{AllHits, Hits};
use crate::meshes::{Mesh, Placed};
use crate::pool::Workers;
use crate::rays::Rays;
use crate::trees::{Plan, Trees};

#[derive(Default)]
struct State {
    meshes: Vec<Option<Mesh>>,
    instances: Vec<Option<Placed>>,
    /// How often the above were changed.
    edits: u64,
    /// The last trees that were built, and after how many edits.
    trees: Option<(u64, Arc<Trees>)>,
}

impl State {
    /// The number of an edit that is being made, from 1 on.
    fn edit(&mut self) -> u64 {
        self.edits += 1;
        self.edits
    }
}

/// Trees as a query finds them.
enum Found {
    UpToDate(Arc<Trees>),
    /// What is to be built, and after how many edits.
    Due(Plan, u64),
}

/// Triangle meshes to be asked with rays and points. Every query may be called from several threads at once.
#[pyclass(module = "gnurt", frozen, subclass)]
#[derive(Default)]
pub(crate) struct RayScene {
    state: Mutex<State>,
}

type Object<'a, 'py> = &'a Bound<'py, PyAny>;

/// Rows of a matrix for columns of an affine map.
fn matrix(columns: &[[f64; 3]; 4]) -> Vec<Vec<f64>> {
    let mut rows: Vec<Vec<f64>> = (0..3).map(|k| columns.iter().map(|column| column[k]).collect()).collect();
    rows.push(vec![0.0, 0.0, 0.0, 1.0]);
    rows
}

impl RayScene {
    /// Under the lock, during which nothing of Python's runs that could come back here.
    fn with<R>(&self, py: Python<'_>, job: impl FnOnce(&mut State) -> R) -> R {
        job(&mut self.state.lock_py_attached(py).unwrap_or_else(PoisonError::into_inner))
    }

    fn asked(&self, py: Python<'_>, threads: usize) -> PyResult<Asked> {
        let workers = Workers::new(threads)?;
        let found = self.with(py, |state| match &state.trees {
            Some((edits, trees)) if *edits == state.edits => Ok(Found::UpToDate(trees.clone())),
            before => {
                let before = before.as_ref().map(|(_, trees)| trees.clone());
                let plan = Plan::new(py, &state.meshes, &state.instances, before)?;
                PyResult::Ok(Found::Due(plan, state.edits))
            }
        })?;
        let trees = match found {
            Found::UpToDate(trees) => trees,
            Found::Due(plan, edits) => {
                // Two threads that come at once both build; the answers are the same.
                let trees = Arc::new(py.detach(|| plan.build(workers.threads()))?);
                self.with(py, |state| {
                    // Who edits meanwhile has made these trees those of an earlier state, which others must not take for theirs.
                    if state.edits == edits {
                        state.trees = Some((edits, trees.clone()));
                    }
                });
                trees
            }
        };
        Ok(Asked { trees, workers })
    }

    fn no_geometry(id: usize) -> PyErr {
        PyIndexError::new_err(format!("there is no geometry {id}"))
    }
}

#[pymethods]
impl RayScene {
    #[new]
    fn new() -> Self {
        Self::default()
    }

    #[pyo3(signature = (vertices, faces, transform=None, *, copy=true))]
    fn add_triangles(
        &self,
        py: Python<'_>,
        vertices: Object,
        faces: Object,
        transform: Option<Object>,
        copy: bool,
    ) -> PyResult<usize> {
        let mesh = Mesh::new(vertices, faces, transform, copy)?;
        Ok(self.with(py, |state| {
            let edit = state.edit();
            state.meshes.push(Some(Mesh { shape: edit, state: edit, ..mesh }));
            state.meshes.len() - 1
        }))
    }

    #[pyo3(signature = (geom_id, transform))]
    fn add_instance(&self, py: Python<'_>, geom_id: usize, transform: Object) -> PyResult<usize> {
        let place = self::transform("transform", transform)?;
        self.with(py, |state| {
            if !matches!(state.meshes.get(geom_id), Some(Some(_))) {
                return Err(Self::no_geometry(geom_id));
            }
            state.edit();
            state.instances.push(Some(Placed { geom_id: geom_id as u32, place }));
            Ok(state.instances.len() - 1)
        })
    }

    #[pyo3(signature = (geom_id=None, *, inst_id=None, vertices=None, transform=None, copy=true))]
    fn update(
        &self,
        py: Python<'_>,
        geom_id: Option<usize>,
        inst_id: Option<usize>,
        vertices: Option<Object>,
        transform: Option<Object>,
        copy: bool,
    ) -> PyResult<()> {
        let place = transform.map(|place| self::transform("transform", place)).transpose()?;
        let moved = match (geom_id, vertices) {
            (Some(id), Some(vertices)) => {
                let mesh = self.with(py, |state| {
                    state.meshes.get(id).and_then(Option::as_ref).map(|mesh| mesh.shared(py))
                });
                Some(mesh.ok_or_else(|| Self::no_geometry(id))?.moved(py, vertices, copy)?)
            }
            _ => None,
        };
        self.with(py, |state| match (geom_id, inst_id) {
            (Some(id), None) => {
                let edit = state.edit();
                let mesh = state.meshes.get_mut(id).and_then(Option::as_mut);
                let mesh = mesh.ok_or_else(|| Self::no_geometry(id))?;
                mesh.state = edit;
                mesh.place = place.or(mesh.place);
                if let Some(vertices) = moved {
                    (mesh.vertices, mesh.shape) = (vertices, edit);
                }
                Ok(())
            }
            (None, Some(id)) if vertices.is_none() => {
                let placed = state.instances.get_mut(id).and_then(Option::as_mut);
                let placed =
                    placed.ok_or_else(|| PyIndexError::new_err(format!("there is no instance {id}")))?;
                placed.place = place.unwrap_or(placed.place);
                state.edit();
                Ok(())
            }
            (None, Some(_)) => {
                Err(PyTypeError::new_err("vertices: an instance has none of its own; update its geometry"))
            }
            _ => Err(PyTypeError::new_err("update() takes either geom_id or inst_id")),
        })
    }

    #[pyo3(signature = (geom_id=None, *, inst_id=None))]
    fn remove(&self, py: Python<'_>, geom_id: Option<usize>, inst_id: Option<usize>) -> PyResult<()> {
        self.with(py, |state| {
            let gone = match (geom_id, inst_id) {
                (Some(id), None) => {
                    let is_shown = |placed: &Placed| placed.geom_id as usize == id;
                    state
                        .instances
                        .iter_mut()
                        .filter(|at| at.as_ref().is_some_and(is_shown))
                        .for_each(|at| *at = None);
                    state.meshes.get_mut(id).and_then(Option::take).map(drop)
                }
                (None, Some(id)) => state.instances.get_mut(id).and_then(Option::take).map(drop),
                _ => return Err(PyTypeError::new_err("remove() takes either geom_id or inst_id")),
            };
            state.edit();
            gone.ok_or_else(|| match geom_id {
                Some(id) => Self::no_geometry(id),
                None => {
                    PyIndexError::new_err(format!("there is no instance {}", inst_id.unwrap_or_default()))
                }
            })
        })
    }

    #[pyo3(signature = (*, threads=0))]
    fn commit(&self, py: Python<'_>, threads: usize) -> PyResult<()> {
        self.asked(py, threads).map(drop)
    }

    #[pyo3(signature = (origins, directions, t_near=None, t_far=None, *, threads=0))]
    fn intersect(
        &self,
        py: Python<'_>,
        origins: Object,
        directions: Object,
        t_near: Option<Object>,
        t_far: Option<Object>,
        threads: usize,
    ) -> PyResult<Hits> {
        let rays = Rays::new(origins, directions, t_near, t_far)?;
        self.asked(py, threads)?.intersect(py, &rays)
    }

    #[pyo3(signature = (origins, directions, t_near=None, t_far=None, *, threads=0))]
    fn occluded(
        &self,
        py: Python<'_>,
        origins: Object,
        directions: Object,
        t_near: Option<Object>,
        t_far: Option<Object>,
        threads: usize,
    ) -> PyResult<Py<PyAny>> {
        let rays = Rays::new(origins, directions, t_near, t_far)?;
        self.asked(py, threads)?.occluded(py, &rays)
    }

    #[pyo3(signature = (origins, directions, t_near=None, t_far=None, *, max_hits=None, threads=0))]
    fn all_hits(
        &self,
        origins: Object,
        directions: Object,
        t_near: Option<Object>,
        t_far: Option<Object>,
        max_hits: Option<usize>,
        threads: usize,
    ) -> PyResult<AllHits> {
        let py = origins.py();
        let rays = Rays::new(origins, directions, t_near, t_far)?;
        self.asked(py, threads)?.all_hits(py, &rays, Which::First(max_hits.unwrap_or(usize::MAX)))
    }

    #[pyo3(signature = (origins, directions, t_near=None, t_far=None, *, threads=0))]
    fn crossing_hits(
        &self,
        py: Python<'_>,
        origins: Object,
        directions: Object,
        t_near: Option<Object>,
        t_far: Option<Object>,
        threads: usize,
    ) -> PyResult<AllHits> {
        let rays = Rays::new(origins, directions, t_near, t_far)?;
        self.asked(py, threads)?.all_hits(py, &rays, Which::Crossed)
    }

    #[pyo3(signature = (origins, directions, t_near=None, t_far=None, *, threads=0))]
    fn crossings(
        &self,
        py: Python<'_>,
        origins: Object,
        directions: Object,
        t_near: Option<Object>,
        t_far: Option<Object>,
        threads: usize,
    ) -> PyResult<Py<PyAny>> {
        let rays = Rays::new(origins, directions, t_near, t_far)?;
        self.asked(py, threads)?.crossings(py, &rays)
    }

    #[pyo3(signature = (points, *, threads=0))]
    fn contains(&self, py: Python<'_>, points: Object, threads: usize) -> PyResult<Py<PyAny>> {
        let points = Numbers::new("points", points, Some(3))?.points();
        self.asked(py, threads)?.contains(py, &points)
    }

    #[pyo3(signature = (points, *, threads=0))]
    fn closest_point<'py>(
        &self,
        py: Python<'py>,
        points: Object,
        threads: usize,
    ) -> PyResult<Bound<'py, PyTuple>> {
        let points = Numbers::new("points", points, Some(3))?.points();
        PyTuple::new(py, self.asked(py, threads)?.closest_point(py, &points, false)?)
    }

    /// For the packages whose names we have: as `closest_point`, then `(n, 2)` weights and `(n, 3)` normals.
    #[pyo3(signature = (points, *, threads=0))]
    fn _nearest<'py>(
        &self,
        py: Python<'py>,
        points: Object,
        threads: usize,
    ) -> PyResult<Bound<'py, PyTuple>> {
        let points = Numbers::new("points", points, Some(3))?.points();
        PyTuple::new(py, self.asked(py, threads)?.closest_point(py, &points, true)?)
    }

    #[pyo3(signature = (points, *, threads=0))]
    fn distance(&self, py: Python<'_>, points: Object, threads: usize) -> PyResult<Py<PyAny>> {
        let points = Numbers::new("points", points, Some(3))?.points();
        self.asked(py, threads)?.distance(py, &points, false)
    }

    #[pyo3(signature = (points, *, threads=0))]
    fn signed_distance(&self, py: Python<'_>, points: Object, threads: usize) -> PyResult<Py<PyAny>> {
        let points = Numbers::new("points", points, Some(3))?.points();
        self.asked(py, threads)?.distance(py, &points, true)
    }

    /// What pickle and `save` keep: arrays, not trees.
    fn __getstate__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (meshes, instances) = (PyList::empty(py), PyList::empty(py));
        self.with(py, |state| -> PyResult<()> {
            for mesh in &state.meshes {
                match mesh {
                    None => meshes.append(py.None())?,
                    Some(Mesh { vertices, faces, place, .. }) => {
                        meshes.append((vertices, faces, place.as_ref().map(matrix)))?;
                    }
                }
            }
            for placed in &state.instances {
                match placed {
                    None => instances.append(py.None())?,
                    Some(Placed { geom_id, place }) => instances.append((geom_id, matrix(place)))?,
                }
            }
            Ok(())
        })?;
        let all = PyDict::new(py);
        all.set_item("meshes", meshes)?;
        all.set_item("instances", instances)?;
        Ok(all)
    }

    fn __setstate__(&self, py: Python<'_>, kept: &Bound<'_, PyDict>) -> PyResult<()> {
        let part = |name: &str| -> PyResult<Vec<Bound<'_, PyAny>>> {
            let list = kept.get_item(name)?.ok_or_else(|| PyValueError::new_err(format!("no {name}")))?;
            list.try_iter()?.collect()
        };
        let (mut meshes, mut instances) = (Vec::new(), Vec::new());
        for mesh in part("meshes")? {
            meshes.push(
                match mesh.extract::<Option<(Bound<PyAny>, Bound<PyAny>, Option<Bound<PyAny>>)>>()? {
                    None => None,
                    Some((vertices, faces, place)) => {
                        Some(Mesh::new(&vertices, &faces, place.as_ref(), false)?)
                    }
                },
            );
        }
        for placed in part("instances")? {
            instances.push(match placed.extract::<Option<(usize, Bound<PyAny>)>>()? {
                None => None,
                Some((id, _)) if !matches!(meshes.get(id), Some(Some(_))) => {
                    return Err(Self::no_geometry(id));
                }
                Some((id, place)) => {
                    Some(Placed { geom_id: id as u32, place: transform("transform", &place)? })
                }
            });
        }
        self.with(py, |state| {
            let edit = state.edit();
            for mesh in meshes.iter_mut().flatten() {
                (mesh.shape, mesh.state) = (edit, edit);
            }
            *state = State { meshes, instances, edits: edit, trees: None };
        });
        Ok(())
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        self.with(py, |state| {
            let geometries = state.meshes.iter().flatten().count();
            let instances = state.instances.iter().flatten().count();
            format!("<gnurt.RayScene: {geometries} geometries, {instances} instances>")
        })
    }
}

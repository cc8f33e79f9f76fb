// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt.RayScene`. See docs/reference/python.md. Trees are built by the first query after a change.
//! Tests: `bindings/python/tests`.

use std::sync::{Arc, Mutex, PoisonError};

use gnurt_accel::DEEPEST_SCENE;
use pyo3::exceptions::{PyIndexError, PyTypeError, PyValueError};
use pyo3::gc::{PyTraverseError, PyVisit};
use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use pyo3::types::{PyDict, PyList, PyTuple};

use crate::answers::{RayQuery, Which};
use crate::arrays::{Numbers, numpy, transform};
use crate::geometries::{CurveArguments, Kind, PointArguments, StoredGeometry, matrix};
use crate::hits::{AllHits, Hits};
use crate::pool::{ThreadCount, Workers};
use crate::rays::Rays;
use crate::trees::{PlacedGeometry, Plan, Shows, Trees};

/// The contents of an instance.
enum Shown {
    Mesh(u32),
    /// All of another scene, in its state at the query.
    Scene(Py<RayScene>),
}

impl Shown {
    /// The scene, if it is one.
    fn scene(&self, py: Python<'_>) -> Option<Py<RayScene>> {
        match self {
            Self::Mesh(_) => None,
            Self::Scene(scene) => Some(scene.clone_ref(py)),
        }
    }

    /// The same.
    fn shared(&self, py: Python<'_>) -> Self {
        match self {
            Self::Mesh(geom_id) => Self::Mesh(*geom_id),
            Self::Scene(scene) => Self::Scene(scene.clone_ref(py)),
        }
    }
}

/// The contents and the transform: columns of an affine map.
type Instance = (Shown, [[f64; 3]; 4]);

#[derive(Default)]
struct State {
    meshes: Vec<Option<StoredGeometry>>,
    instances: Vec<Option<Instance>>,
    /// Whether vertices and answers are in double precision.
    is_double: bool,
    /// How often the above were changed.
    edits: u64,
    /// The last trees that were built, and after how many edits.
    trees: Option<(u64, Arc<Trees>)>,
}

impl State {
    /// Scenes that instances show, and the numbers of these.
    fn scenes(&self, py: Python<'_>) -> Vec<(u32, Py<RayScene>)> {
        let scene = |(id, instance): (u32, &Option<_>)| match instance {
            Some((Shown::Scene(scene), _)) => Some((id, scene.clone_ref(py))),
            Some((Shown::Mesh(_), _)) | None => None,
        };
        (0..).zip(&self.instances).filter_map(scene).collect()
    }

    /// The meshes, with the same arrays.
    fn meshes(&self, py: Python<'_>) -> Vec<Option<StoredGeometry>> {
        self.meshes.iter().map(|mesh| mesh.as_ref().map(|mesh| mesh.shared(py))).collect()
    }

    /// Instances for trees, where those of scenes, ascending by number, are known.
    fn placed_list(&self, scenes: &[(u32, Arc<Trees>)]) -> Vec<(u32, PlacedGeometry)> {
        let mut scenes = scenes.iter();
        let placed_list = |(id, instance): (u32, &Option<Instance>)| {
            let (shown, placement) = instance.as_ref()?;
            let shows = match shown {
                Shown::Mesh(geom_id) => Shows::Mesh(*geom_id),
                Shown::Scene(_) => Shows::Scene(scenes.next()?.1.clone()),
            };
            Some((id, PlacedGeometry { shows, placement: *placement }))
        };
        (0..).zip(&self.instances).filter_map(placed_list).collect()
    }

    /// The number of an edit that is being made, from 1 on.
    fn edit(&mut self) -> u64 {
        self.edits += 1;
        self.edits
    }
}

/// Trees as a query finds them.
enum Found {
    UpToDate(Arc<Trees>),
    /// The geometry of the new trees, and the trees of an earlier state.
    Dirty {
        meshes: Vec<Option<StoredGeometry>>,
        placed_list: Vec<(u32, PlacedGeometry)>,
        before: Option<Arc<Trees>>,
        is_double: bool,
    },
}

/// Triangles, quads, grids, points and curves for queries with rays and points. Every query may be called from several threads at once.
#[pyclass(module = "gnurt", frozen, subclass)]
#[derive(Default)]
pub(crate) struct RayScene {
    state: Mutex<State>,
}

/// Held while a scene is added to another, from the check for a circle on: two threads could close one
/// together.
static NESTING: Mutex<()> = Mutex::new(());

const SINGLE: &str = "float32";
const DOUBLE: &str = "float64";

/// Whether the argument `dtype` is the type of double precision.
fn is_double(dtype: Object) -> PyResult<bool> {
    let found = numpy(dtype.py())?.call_method1("dtype", (dtype,));
    let name: Option<String> = found.ok().and_then(|found| found.getattr("name").ok()?.extract().ok());
    match name.as_deref() {
        Some(SINGLE) => Ok(false),
        Some(DOUBLE) => Ok(true),
        _ => Err(PyValueError::new_err(format!("dtype: float32 or float64, not {dtype}"))),
    }
}

type Object<'a, 'py> = &'a Bound<'py, PyAny>;

impl RayScene {
    /// Under the lock, during which nothing of Python's is made or dropped: that may run any code of a program (a collection of
    /// garbage, a destructor), which could come back here.
    fn with<R>(&self, py: Python<'_>, job: impl FnOnce(&mut State) -> R) -> R {
        job(&mut self.state.lock_py_attached(py).unwrap_or_else(PoisonError::into_inner))
    }

    fn query(&self, py: Python<'_>, threads: i64) -> PyResult<RayQuery> {
        let count = usize::try_from(threads);
        let count = count.map_err(|_| PyValueError::new_err(format!("threads: 0 or more, not {threads}")))?;
        let workers = ThreadCount::new(count)?.workers()?;
        let trees = self.trees(py, &workers, &mut Vec::new())?;
        Ok(RayQuery { trees, workers })
    }

    /// The trees of its current contents; `known` are those of scenes visited already, by their addresses.
    fn trees(
        &self,
        py: Python<'_>,
        workers: &Workers,
        known: &mut Vec<(*const Self, Arc<Trees>)>,
    ) -> PyResult<Arc<Trees>> {
        loop {
            // Scenes in it come first, and outside of its lock, so that locks cannot wait for each other.
            let (edits, scenes) = self.with(py, |state| (state.edits, state.scenes(py)));
            let mut inner = Vec::with_capacity(scenes.len());
            for (id, scene) in scenes {
                let scene = scene.get();
                let trees = match known.iter().find(|(at, _)| std::ptr::eq(*at, scene)) {
                    Some((_, trees)) => trees.clone(),
                    None => {
                        let trees = scene.trees(py, workers, known)?;
                        known.push((scene, trees.clone()));
                        trees
                    }
                };
                if trees.levels() as u32 >= DEEPEST_SCENE {
                    return Err(Self::too_deep());
                }
                inner.push((id, trees));
            }
            let found = self.with(py, |state| match &state.trees {
                _ if state.edits != edits => None,
                Some((edits, trees)) if *edits == state.edits && trees.show(&inner) => {
                    Some(Found::UpToDate(trees.clone()))
                }
                before => {
                    let before = before.as_ref().map(|(_, trees)| trees.clone());
                    Some(Found::Dirty {
                        meshes: state.meshes(py),
                        placed_list: state.placed_list(&inner),
                        before,
                        is_double: state.is_double,
                    })
                }
            });
            match found {
                // The scene was edited meanwhile.
                None => {}
                Some(Found::UpToDate(trees)) => return Ok(trees),
                Some(Found::Dirty { meshes, placed_list, before, is_double }) => {
                    let plan = Plan::new(py, &meshes, placed_list, before, is_double)?;
                    // Two threads that come at once both build; the answers are the same.
                    let trees = Arc::new(py.detach(|| plan.build(workers.threads()))?);
                    self.with(py, |state| {
                        // A concurrent edit makes these trees those of an earlier state; others must not use
                        // them as current.
                        if state.edits == edits {
                            state.trees = Some((edits, trees.clone()));
                        }
                    });
                    return Ok(trees);
                }
            }
        }
    }

    /// Whether another scene is this one or contained in it, searched to this depth. Visited ones stay in
    /// `seen`.
    fn holds(&self, py: Python<'_>, other: &Self, deepest: u32, seen: &mut Vec<Py<Self>>) -> PyResult<bool> {
        if std::ptr::eq(self, other) {
            return Ok(true);
        }
        let scenes = self.with(py, |state| state.scenes(py));
        if deepest == 0 && !scenes.is_empty() {
            return Err(Self::too_deep());
        }
        for (_, scene) in scenes {
            let holds = scene.get().holds(py, other, deepest - 1, seen)?;
            seen.push(scene);
            if holds {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Runs `change` if none of `scenes` is this one or holds it; else that is the error. No other scene comes into a scene meanwhile.
    fn unless_held<R>(
        &self,
        py: Python<'_>,
        scenes: &[Py<Self>],
        held: &str,
        change: impl FnOnce() -> PyResult<R>,
    ) -> PyResult<R> {
        if scenes.is_empty() {
            return change();
        }
        // Visited scenes are dropped after the lock.
        let mut seen = Vec::new();
        let _alone = NESTING.lock_py_attached(py).unwrap_or_else(PoisonError::into_inner);
        for scene in scenes {
            if scene.get().holds(py, self, DEEPEST_SCENE, &mut seen)? {
                return Err(PyValueError::new_err(held.to_owned()));
            }
        }
        change()
    }

    /// The argument for an instance's contents: a geometry's number, or a scene.
    fn shown(given: Object) -> PyResult<Shown> {
        if let Ok(scene) = given.cast::<Self>() {
            return Ok(Shown::Scene(scene.clone().unbind()));
        }
        let id: usize = given.extract()?;
        u32::try_from(id).map(Shown::Mesh).map_err(|_| Self::no_geometry(id))
    }

    fn type_name(&self, py: Python<'_>) -> &'static str {
        if self.with(py, |state| state.is_double) { DOUBLE } else { SINGLE }
    }

    /// Scenes of one precision show each other.
    fn check_types(&self, py: Python<'_>, scenes: &[Py<Self>]) -> PyResult<()> {
        let ours = self.type_name(py);
        match scenes.iter().map(|scene| scene.get().type_name(py)).find(|theirs| *theirs != ours) {
            None => Ok(()),
            Some(theirs) => Err(PyValueError::new_err(format!(
                "shown: a scene of {theirs} does not go into one of {ours}"
            ))),
        }
    }

    /// Takes a geometry in, and returns its number.
    fn add(&self, py: Python<'_>, geometry: StoredGeometry) -> usize {
        self.with(py, |state| {
            let edit = state.edit();
            state.meshes.push(Some(StoredGeometry { shape: edit, state: edit, ..geometry }));
            state.meshes.len() - 1
        })
    }

    /// The kinds besides triangles are there in single precision only.
    fn needs_single(&self, py: Python<'_>, call: &str) -> PyResult<()> {
        if self.type_name(py) == DOUBLE {
            return Err(PyTypeError::new_err(format!(
                "{call}: unsupported in a scene of float64, which has triangles only; make one of float32"
            )));
        }
        Ok(())
    }

    fn too_deep() -> PyErr {
        PyValueError::new_err(format!("scenes are nested more than {DEEPEST_SCENE} levels deep"))
    }

    fn no_geometry(id: usize) -> PyErr {
        PyIndexError::new_err(format!("geometry {id} does not exist"))
    }
}

#[pymethods]
impl RayScene {
    /// `dtype`: float32, or float64 for vertices as they are given, exact hits and answers in float64.
    #[new]
    #[pyo3(signature = (dtype=None))]
    fn new(dtype: Option<Object>) -> PyResult<Self> {
        let is_double = dtype.map_or(Ok(false), is_double)?;
        Ok(Self { state: Mutex::new(State { is_double, ..State::default() }) })
    }

    /// The type of vertices and of answers: float32, or float64.
    #[getter]
    fn dtype(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        Ok(numpy(py)?.call_method1("dtype", (self.type_name(py),))?.unbind())
    }

    /// Adds a mesh and returns its number, geom_id. `vertices`: (n, 3) floats; `faces`: (m, 3) whole numbers, rows of `vertices`;
    /// `transform`: (4, 4) or (3, 4), applied to columns. Arrays are copied; `copy=False` keeps float32 and uint32 arrays, which then must not change.
    #[pyo3(signature = (vertices, faces, transform=None, *, copy=true))]
    fn add_triangles(
        &self,
        py: Python<'_>,
        vertices: Object,
        faces: Object,
        transform: Option<Object>,
        copy: bool,
    ) -> PyResult<usize> {
        let mesh = StoredGeometry::mesh(vertices, faces, Kind::Triangles, copy, self.type_name(py))?;
        Ok(self.add(py, mesh.placed(transform)?))
    }

    /// Adds a mesh of quads and returns its number, geom_id. `vertices`: (n, 3) floats; `faces`: (m, 4) whole numbers, rows of
    /// `vertices` around each quad. A quad is the triangles of its corners 0, 1, 3 and 2, 3, 1 and need not be flat; it is a
    /// triangle where corners 2 and 3 are one. `transform` and `copy` as of `add_triangles`. Scenes of float64 have none.
    #[pyo3(signature = (vertices, faces, transform=None, *, copy=true))]
    fn add_quads(
        &self,
        py: Python<'_>,
        vertices: Object,
        faces: Object,
        transform: Option<Object>,
        copy: bool,
    ) -> PyResult<usize> {
        self.needs_single(py, "add_quads")?;
        let mesh = StoredGeometry::mesh(vertices, faces, Kind::Quads, copy, SINGLE)?;
        Ok(self.add(py, mesh.placed(transform)?))
    }

    /// Adds grids of vertices and returns their number, geom_id: fields of heights, sheets of cloth. `vertices`: (n, 3) floats.
    /// `grids`: (m, 4) whole numbers: of each grid the first vertex, the vertices from the start of a row to that of the next, and its
    /// columns and rows of vertices, 2 to 65535 each. A cell between four vertices is a quad as of `add_quads` in a fifth of
    /// the memory, corners 0 and 1 in one row; prim_id counts cells, grid by grid, then row by row. `transform` and `copy` as of
    /// `add_triangles`. Scenes of float64 have none.
    #[pyo3(signature = (vertices, grids, transform=None, *, copy=true))]
    fn add_grids(
        &self,
        py: Python<'_>,
        vertices: Object,
        grids: Object,
        transform: Option<Object>,
        copy: bool,
    ) -> PyResult<usize> {
        self.needs_single(py, "add_grids")?;
        Ok(self.add(py, StoredGeometry::grids(vertices, grids, copy)?.placed(transform)?))
    }

    /// Adds points with a radius and returns their number, geom_id. `vertices`: (n, 3) floats, the centres; `radii`: (n,) floats
    /// from 0 on, or one number for all, in units of the vertices. `form`: "round" for spheres, which rays hit from inside, too,
    /// "flat" for discs that face each ray, "oriented" for discs across `normals`, (n, 3) of any length. Points of radius 0 or
    /// with a normal of zero are left out. `transform`: as of `add_triangles`, with the same scale in all directions; `copy`:
    /// the same. Scenes of float64 have none.
    #[pyo3(signature = (vertices, radii, transform=None, *, form="round", normals=None, copy=true))]
    #[allow(clippy::too_many_arguments, reason = "those of the call")]
    fn add_points(
        &self,
        py: Python<'_>,
        vertices: Object,
        radii: Object,
        transform: Option<Object>,
        form: &str,
        normals: Option<Object>,
        copy: bool,
    ) -> PyResult<usize> {
        self.needs_single(py, "add_points")?;
        let points = StoredGeometry::points(&PointArguments { vertices, radii, form, normals }, copy)?;
        Ok(self.add(py, points.placed(transform)?))
    }

    /// Adds curves with a radius and returns their number, geom_id. `vertices`: (n, 3) floats, strand by strand; `radii`: (n,)
    /// floats from 0 on, or one number for all, in units of the vertices, less than those of the bends. `counts`: how many
    /// vertices each strand has, whose sum is n, by default one strand of all; or `segments`: (m,) whole numbers, the first
    /// vertex of each curve. `prim_id` counts curves, strand by strand.
    ///
    /// A curve has 4 vertices, or 2 with `basis` "linear" or "hermite". "bezier" goes from the first to the last, which the next
    /// curve shares. "catmull-rom" goes from the second to the third; "bspline" meets none; the next curve shares three.
    /// "hermite" has `tangents`, (n, 4): derivatives of position and radius. `form`: "flat" for ribbons that face each
    /// ray, "round" for tubes without caps, and cones with spheres at their ends where straight, "oriented" for ribbons across
    /// `normals`, (n, 3), which have `normal_tangents`, (n, 3), on Hermite curves. Curves without length or radius are left out.
    /// `transform`: as of `add_triangles`, with the same scale in all directions; `copy`: the same. Scenes of float64 have none.
    #[pyo3(signature = (vertices, radii, transform=None, *, counts=None, segments=None, basis="bspline", form="round", normals=None, tangents=None, normal_tangents=None, copy=true))]
    #[allow(clippy::too_many_arguments, reason = "those of the call")]
    fn add_curves(
        &self,
        py: Python<'_>,
        vertices: Object,
        radii: Object,
        transform: Option<Object>,
        counts: Option<Object>,
        segments: Option<Object>,
        basis: &str,
        form: &str,
        normals: Option<Object>,
        tangents: Option<Object>,
        normal_tangents: Option<Object>,
        copy: bool,
    ) -> PyResult<usize> {
        self.needs_single(py, "add_curves")?;
        let given = CurveArguments {
            vertices,
            radii,
            counts,
            segments,
            basis,
            form,
            normals,
            tangents,
            normal_tangents,
        };
        Ok(self.add(py, StoredGeometry::curves(&given, copy)?.placed(transform)?))
    }

    /// Shows a geometry, by its number, or all of another RayScene once more, transformed by `transform`, and
    /// returns its number, inst_id.
    #[pyo3(signature = (shown, transform))]
    fn add_instance(slf: &Bound<'_, Self>, shown: Object, transform: Object) -> PyResult<usize> {
        let (py, this) = (slf.py(), slf.get());
        let placement = self::transform("transform", transform)?;
        let shown = Self::shown(shown)?;
        let scenes = shown.scene(py).into_iter().collect::<Vec<_>>();
        this.check_types(py, &scenes)?;
        this.unless_held(
            py,
            &scenes,
            "shown: this scene is nested in it; a scene cannot contain itself",
            || {
                this.with(py, |state| {
                    if let Shown::Mesh(id) = shown
                        && !matches!(state.meshes.get(id as usize), Some(Some(_)))
                    {
                        return Err(Self::no_geometry(id as usize));
                    }
                    state.edit();
                    state.instances.push(Some((shown, placement)));
                    Ok(state.instances.len() - 1)
                })
            },
        )
    }

    /// Gives a geometry other vertices (the same number) or another transform, or an instance another
    /// transform. The next query uses them.
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
        let placement = transform.map(|placement| self::transform("transform", placement)).transpose()?;
        let mut moved = None;
        if let Some(id) = geom_id {
            let geometry = self
                .with(py, |state| state.meshes.get(id).and_then(Option::as_ref).map(|at| at.shared(py)))
                .ok_or_else(|| Self::no_geometry(id))?;
            geometry.check_placement(placement.as_ref())?;
            moved = match vertices {
                Some(vertices) => Some(geometry.moved(py, vertices, copy, self.type_name(py))?),
                None => None,
            };
        }
        // Removed objects are released to Python after the lock.
        let gone = self.with(py, |state| match (geom_id, inst_id) {
            (Some(id), None) => {
                let edit = state.edit();
                let mesh = state.meshes.get_mut(id).and_then(Option::as_mut);
                let mesh = mesh.ok_or_else(|| Self::no_geometry(id))?;
                mesh.state = edit;
                mesh.placement = placement.or(mesh.placement);
                Ok(moved.map(|vertices| {
                    mesh.shape = edit;
                    std::mem::replace(&mut mesh.arrays.vertices, vertices)
                }))
            }
            (None, Some(id)) if vertices.is_none() => {
                let placed_list = state.instances.get_mut(id).and_then(Option::as_mut);
                let placed_list = placed_list
                    .ok_or_else(|| PyIndexError::new_err(format!("instance {id} does not exist")))?;
                placed_list.1 = placement.unwrap_or(placed_list.1);
                state.edit();
                Ok(None)
            }
            (None, Some(_)) => {
                Err(PyTypeError::new_err("vertices: an instance has none of its own; update its geometry"))
            }
            _ => Err(PyTypeError::new_err("update() takes either geom_id or inst_id")),
        })?;
        drop(gone);
        Ok(())
    }

    /// Takes a geometry away, with the instances of it, or an instance. Numbers of others stay.
    #[pyo3(signature = (geom_id=None, *, inst_id=None))]
    fn remove(&self, py: Python<'_>, geom_id: Option<usize>, inst_id: Option<usize>) -> PyResult<()> {
        // Removed objects are released to Python after the lock.
        let (mesh, instance) = self.with(py, |state| {
            let gone = match (geom_id, inst_id) {
                (Some(id), None) => {
                    let is_shown =
                        |(shown, _): &Instance| matches!(shown, Shown::Mesh(mesh) if *mesh as usize == id);
                    state
                        .instances
                        .iter_mut()
                        .filter(|at| at.as_ref().is_some_and(is_shown))
                        .for_each(|at| *at = None);
                    (state.meshes.get_mut(id).and_then(Option::take), None)
                }
                (None, Some(id)) => (None, state.instances.get_mut(id).and_then(Option::take)),
                _ => return Err(PyTypeError::new_err("remove() takes either geom_id or inst_id")),
            };
            state.edit();
            Ok(gone)
        })?;
        match (mesh, instance, geom_id) {
            (None, None, Some(id)) => Err(Self::no_geometry(id)),
            (None, None, None) => {
                let id = inst_id.unwrap_or_default();
                Err(PyIndexError::new_err(format!("instance {id} does not exist")))
            }
            _ => Ok(()),
        }
    }

    /// Builds the trees that are due now, not at the next query.
    #[pyo3(signature = (*, threads=0))]
    fn commit(&self, py: Python<'_>, threads: i64) -> PyResult<()> {
        self.query(py, threads).map(drop)
    }

    /// Where each ray hits first: `Hits`. `origins` and `directions`: (n, 3), or (1, 3) for all rays; `t_near` and `t_far`: numbers, or
    /// (n,); `t` counts lengths of the direction. `threads`: 0 = one for each core, 1 = the calling thread.
    #[pyo3(signature = (origins, directions, t_near=None, t_far=None, *, threads=0))]
    fn intersect(
        &self,
        py: Python<'_>,
        origins: Object,
        directions: Object,
        t_near: Option<Object>,
        t_far: Option<Object>,
        threads: i64,
    ) -> PyResult<Hits> {
        let rays = Rays::new(origins, directions, t_near, t_far)?;
        self.query(py, threads)?.intersect(py, &rays)
    }

    /// bool (n,): whether anything lies between `t_near` and `t_far`. Arguments as of `intersect`; faster.
    #[pyo3(signature = (origins, directions, t_near=None, t_far=None, *, threads=0))]
    fn occluded(
        &self,
        py: Python<'_>,
        origins: Object,
        directions: Object,
        t_near: Option<Object>,
        t_far: Option<Object>,
        threads: i64,
    ) -> PyResult<Py<PyAny>> {
        let rays = Rays::new(origins, directions, t_near, t_far)?;
        self.query(py, threads)?.occluded(py, &rays)
    }

    /// Everything that each ray hits, nearest first: `AllHits`. `max_hits` keeps the nearest of each ray. Arguments as of `intersect`.
    #[pyo3(signature = (origins, directions, t_near=None, t_far=None, *, max_hits=None, threads=0))]
    fn all_hits(
        &self,
        origins: Object,
        directions: Object,
        t_near: Option<Object>,
        t_far: Option<Object>,
        max_hits: Option<i64>,
        threads: i64,
    ) -> PyResult<AllHits> {
        let py = origins.py();
        let rays = Rays::new(origins, directions, t_near, t_far)?;
        let most = max_hits.map_or(Ok(usize::MAX), |most| {
            usize::try_from(most)
                .map_err(|_| PyValueError::new_err(format!("max_hits: 0 or more, not {most}")))
        })?;
        self.query(py, threads)?.all_hits(py, &rays, Which::First(most))
    }

    /// The crossings that `crossings` counts, one hit each: `AllHits`.
    #[pyo3(signature = (origins, directions, t_near=None, t_far=None, *, threads=0))]
    fn crossing_hits(
        &self,
        py: Python<'_>,
        origins: Object,
        directions: Object,
        t_near: Option<Object>,
        t_far: Option<Object>,
        threads: i64,
    ) -> PyResult<AllHits> {
        let rays = Rays::new(origins, directions, t_near, t_far)?;
        self.query(py, threads)?.all_hits(py, &rays, Which::Crossed)
    }

    /// int32 (n,): how often each ray goes through a surface. A hit of an edge or a corner that triangles share counts once, so that
    /// a closed mesh is crossed an even number of times from outside. Arguments as of `intersect`.
    #[pyo3(signature = (origins, directions, t_near=None, t_far=None, *, threads=0))]
    fn crossings(
        &self,
        py: Python<'_>,
        origins: Object,
        directions: Object,
        t_near: Option<Object>,
        t_far: Option<Object>,
        threads: i64,
    ) -> PyResult<Py<PyAny>> {
        let rays = Rays::new(origins, directions, t_near, t_far)?;
        self.query(py, threads)?.crossings(py, &rays)
    }

    /// bool (n,): whether `points`, (n, 3), lie inside of closed meshes, their surface included.
    #[pyo3(signature = (points, *, threads=0))]
    fn contains(&self, py: Python<'_>, points: Object, threads: i64) -> PyResult<Py<PyAny>> {
        let points = Numbers::new("points", points, Some(3))?.points();
        self.query(py, threads)?.contains(py, &points)
    }

    /// The nearest point of all surfaces for each of `points`, (n, 3): points (n, 3), distances (n,), prim_id (n,), geom_id (n,).
    #[pyo3(signature = (points, *, threads=0))]
    fn closest_point<'py>(
        &self,
        py: Python<'py>,
        points: Object,
        threads: i64,
    ) -> PyResult<Bound<'py, PyTuple>> {
        let points = Numbers::new("points", points, Some(3))?.points();
        PyTuple::new(py, self.query(py, threads)?.closest_point(py, &points, false)?)
    }

    /// For the packages whose names we have: as `closest_point`, then `(n, 2)` weights and `(n, 3)` normals.
    #[pyo3(signature = (points, *, threads=0))]
    fn _nearest<'py>(&self, py: Python<'py>, points: Object, threads: i64) -> PyResult<Bound<'py, PyTuple>> {
        let points = Numbers::new("points", points, Some(3))?.points();
        PyTuple::new(py, self.query(py, threads)?.closest_point(py, &points, true)?)
    }

    /// float64 (n,): the distance of `points`, (n, 3), from the nearest surface; inf where there is none.
    #[pyo3(signature = (points, *, threads=0))]
    fn distance(&self, py: Python<'_>, points: Object, threads: i64) -> PyResult<Py<PyAny>> {
        let points = Numbers::new("points", points, Some(3))?.points();
        self.query(py, threads)?.distance(py, &points, false)
    }

    /// float64 (n,): as `distance`, negative inside of closed meshes.
    #[pyo3(signature = (points, *, threads=0))]
    fn signed_distance(&self, py: Python<'_>, points: Object, threads: i64) -> PyResult<Py<PyAny>> {
        let points = Numbers::new("points", points, Some(3))?.points();
        self.query(py, threads)?.distance(py, &points, true)
    }

    /// State for pickle and `save`: arrays without trees.
    fn __getstate__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (now_meshes, now_instances) = self.with(py, |state| {
            let shared =
                |at: &Option<Instance>| at.as_ref().map(|(shown, placement)| (shown.shared(py), *placement));
            (state.meshes(py), state.instances.iter().map(shared).collect::<Vec<_>>())
        });
        let (meshes, instances) = (PyList::empty(py), PyList::empty(py));
        for mesh in now_meshes {
            match mesh {
                None => meshes.append(py.None())?,
                Some(mesh) => meshes.append(mesh.pickled(py)?)?,
            }
        }
        for placed_list in now_instances {
            match placed_list {
                None => instances.append(py.None())?,
                Some((Shown::Mesh(geom_id), placement)) => instances.append((geom_id, matrix(&placement)))?,
                Some((Shown::Scene(scene), placement)) => instances.append((scene, matrix(&placement)))?,
            }
        }
        let all = PyDict::new(py);
        all.set_item("meshes", meshes)?;
        all.set_item("instances", instances)?;
        // States of earlier versions have none: they are of float32.
        if self.with(py, |state| state.is_double) {
            all.set_item("dtype", DOUBLE)?;
        }
        Ok(all)
    }

    fn __setstate__(&self, py: Python<'_>, retained: &Bound<'_, PyDict>) -> PyResult<()> {
        let part = |name: &str| -> PyResult<Vec<Bound<'_, PyAny>>> {
            let list = retained.get_item(name)?.ok_or_else(|| PyValueError::new_err(format!("no {name}")))?;
            list.try_iter()?.collect()
        };
        let is_double = retained.get_item("dtype")?.map_or(Ok(false), |dtype| is_double(&dtype))?;
        let dtype = if is_double { DOUBLE } else { SINGLE };
        let (mut meshes, mut instances) = (Vec::new(), Vec::new());
        for mesh in part("meshes")? {
            meshes.push(match mesh.is_none() {
                true => None,
                false => Some(StoredGeometry::restored(&mesh, dtype)?),
            });
        }
        for placed_list in part("instances")? {
            instances.push(match placed_list.extract::<Option<(Bound<PyAny>, Bound<PyAny>)>>()? {
                None => None,
                Some((shown, placement)) => {
                    let (shown, placement) = (Self::shown(&shown)?, transform("transform", &placement)?);
                    match &shown {
                        Shown::Mesh(id) if !matches!(meshes.get(*id as usize), Some(Some(_))) => {
                            return Err(Self::no_geometry(*id as usize));
                        }
                        _ => Some((shown, placement)),
                    }
                }
            });
        }
        let scenes: Vec<_> =
            instances.iter().flatten().filter_map(|(shown, _): &Instance| shown.scene(py)).collect();
        let before = self.unless_held(py, &scenes, "a scene cannot show itself", || {
            Ok(self.with(py, |state| {
                let edit = state.edit();
                for mesh in meshes.iter_mut().flatten() {
                    (mesh.shape, mesh.state) = (edit, edit);
                }
                std::mem::replace(state, State { meshes, instances, is_double, edits: edit, trees: None })
            }))
        })?;
        drop(before);
        Ok(())
    }

    /// For the garbage collector: scenes may be nested, and arrays may be of any class.
    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        // A locked scene is in use.
        let Ok(state) = self.state.try_lock() else { return Ok(()) };
        for mesh in state.meshes.iter().flatten() {
            mesh.traverse(&visit)?;
        }
        for (shown, _) in state.instances.iter().flatten() {
            if let Shown::Scene(scene) = shown {
                visit.call(scene)?;
            }
        }
        Ok(())
    }

    fn __clear__(&self) {
        let gone = self.state.try_lock().map(|mut state| std::mem::take(&mut *state));
        drop(gone);
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        self.with(py, |state| {
            let geometries = state.meshes.iter().flatten().count();
            let instances = state.instances.iter().flatten().count();
            format!("<gnurt.RayScene: {geometries} geometries, {instances} instances>")
        })
    }
}

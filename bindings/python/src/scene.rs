// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt.Scene`: what pictures are made of. See docs/reference/python.md.
//! What is put somewhere is known by the number of its instance. Tests: `tests/test_pictures.py`.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use gnurt::FORMATS;
use gnurt::osl::Script;
use gnurt::scene::{Affine, InstanceId, MaterialId, MeshId, Scene as Description, io};
use gnurt::scene::{Camera, Material, Mesh as SceneMesh, Projection, Surface};
use gnurt::shading::SurfaceShader;
use pyo3::exceptions::{PyIndexError, PyOSError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use pyo3::types::PyDict;

use crate::arrays::{Numbers, transform};
use crate::describing::{self, NewMaterial};
use crate::given::Given;
use crate::lights;
use crate::meshes::Mesh;
use crate::picture::Picture;
use crate::rendering::{BuildRequest, Growing};
use crate::stage::Stage;

/// Meshes, materials, lights and cameras, of which pictures are made.
#[pyclass(module = "gnurt", frozen, subclass)]
#[derive(Default)]
pub(crate) struct Scene {
    stage: Mutex<Stage>,
}

type Object<'a, 'py> = &'a Bound<'py, PyAny>;

/// A camera as `gnurt.Camera` takes it.
#[derive(IntoPyObject)]
struct CameraRow {
    name: String,
    eye: [f32; 3],
    target: [f32; 3],
    up: [f32; 3],
    fov: f32,
    projection: String,
    view_height: Option<f32>,
    aperture: f32,
    focus: Option<f32>,
}

impl Scene {
    fn with<R>(&self, py: Python<'_>, job: impl FnOnce(&mut Stage) -> R) -> R {
        job(&mut self.stage.lock_py_attached(py).unwrap_or_else(PoisonError::into_inner))
    }

    /// By a thread that does not hold the interpreter's lock.
    fn shoot(&self, request: &BuildRequest) -> PyResult<crate::stage::Shot> {
        let pool = request.threads.pool()?;
        self.stage.lock().unwrap_or_else(PoisonError::into_inner).shoot(&request.view, &pool)
    }
}

fn scene_error(error: &io::Error) -> PyErr {
    match error.kind {
        io::ErrorKind::Io => PyOSError::new_err(error.to_string()),
        _ => PyValueError::new_err(error.to_string()),
    }
}

/// Rows of so many numbers, one for each vertex.
fn per_vertex<const N: usize>(name: &str, value: Option<Object>, vertices: usize) -> PyResult<Vec<[f32; N]>> {
    let Some(value) = value else { return Ok(Vec::new()) };
    let numbers = Numbers::new(name, value, Some(N))?;
    if numbers.count() != vertices {
        return Err(PyValueError::new_err(format!(
            "{name}: expected shape ({vertices}, {N}), one row for each vertex, not ({}, {N})",
            numbers.count()
        )));
    }
    Ok(numbers.singles())
}

/// A material on its way into a scene.
enum Compiled {
    Material(Material),
    Script(String, Script, Arc<dyn SurfaceShader>),
}

impl Compiled {
    /// Shaders take their time, so neither the interpreter nor the scene waits for them.
    fn new(py: Python<'_>, material: NewMaterial) -> PyResult<Self> {
        match material {
            NewMaterial::Material(material) => Ok(Self::Material(material)),
            NewMaterial::Script(name, script) => py.detach(move || match script.surface() {
                Ok(surface) => Ok(Self::Script(name, script, surface)),
                Err(why) => Err(PyValueError::new_err(format!("shader: {why}"))),
            }),
        }
    }

    /// As the scene has it.
    fn put(self, stage: &mut Stage) -> Material {
        match self {
            Self::Material(material) => material,
            Self::Script(name, script, surface) => {
                Material::of(name, Surface::Shader(stage.add_script(script, surface)))
            }
        }
    }
}

fn material_id(scene: &Description, material: usize) -> PyResult<MaterialId> {
    let count = scene.materials().len();
    match u32::try_from(material) {
        Ok(id) if material < count => Ok(MaterialId(id)),
        _ => Err(PyIndexError::new_err(format!(
            "material: there is no material {material}; there are {count}"
        ))),
    }
}

fn instance_id(scene: &Description, instance: usize) -> PyResult<InstanceId> {
    let count = scene.instances().len();
    match u32::try_from(instance) {
        Ok(id) if instance < count => Ok(InstanceId(id)),
        _ => Err(PyIndexError::new_err(format!(
            "instance: there is no instance {instance}; there are {count}"
        ))),
    }
}

#[pymethods]
impl Scene {
    #[new]
    fn new() -> Self {
        Self::default()
    }

    /// What `load` finds; and what was odd about the file.
    #[staticmethod]
    fn _load(py: Python<'_>, source: PathBuf) -> PyResult<(Self, Vec<String>)> {
        let loaded = py.detach(|| gnurt::load_scene(&source)).map_err(|error| scene_error(&error))?;
        let warnings = loaded.warnings.iter().map(ToString::to_string).collect();
        Ok((Self { stage: Mutex::new(Stage::of(loaded.scene)) }, warnings))
    }

    /// All files that a scene is read from, those included that are missing.
    #[staticmethod]
    fn _files(py: Python<'_>, source: PathBuf) -> PyResult<Vec<PathBuf>> {
        Ok(py.detach(|| gnurt::load_scene(&source)).map_err(|error| scene_error(&error))?.files)
    }

    fn _take(&self, py: Python<'_>, other: &Bound<'_, Self>) {
        let copy = other.get().with(py, Stage::copy);
        self.with(py, |stage| *stage = copy);
    }

    /// Writes it in the format of the name. What the format cannot hold is told.
    fn _save(&self, py: Python<'_>, path: PathBuf) -> PyResult<Vec<String>> {
        let scene = self.with(py, |stage| stage.scene().clone());
        let reported = py.detach(|| FORMATS.save(&scene, &path)).map_err(|error| scene_error(&error))?;
        Ok(reported.iter().map(ToString::to_string).collect())
    }

    fn _add_material(&self, py: Python<'_>, arguments: &Bound<'_, PyDict>) -> PyResult<u32> {
        let mut given = Given::new(arguments);
        let material = describing::material(&mut given)?;
        given.end()?;
        let material = Compiled::new(py, material)?;
        self.with(py, |stage| {
            let material = material.put(stage);
            Ok(stage.edit(|scene| scene.add_material(material.clone()).0))
        })
    }

    fn _set_material(&self, py: Python<'_>, number: usize, arguments: &Bound<'_, PyDict>) -> PyResult<()> {
        let mut given = Given::new(arguments);
        let material = describing::material(&mut given)?;
        given.end()?;
        let material = Compiled::new(py, material)?;
        self.with(py, |stage| {
            let id = material_id(stage.scene(), number)?;
            let material = material.put(stage);
            stage.edit(|scene| *scene.edit_material(id) = material.clone());
            Ok(())
        })
    }

    #[expect(clippy::too_many_arguments, reason = "what a mesh may have")]
    fn _add_mesh(
        &self,
        py: Python<'_>,
        vertices: Object,
        faces: Object,
        material: Option<usize>,
        normals: Option<Object>,
        texcoords: Option<Object>,
        colors: Option<Object>,
        placement: Option<Object>,
        name: &str,
    ) -> PyResult<u32> {
        let mesh = Mesh::new(vertices, faces, placement, false)?;
        let positions = mesh.positions(py)?;
        let count = positions.len();
        let described = SceneMesh {
            name: name.into(),
            normals: per_vertex("normals", normals, count)?,
            texcoords: per_vertex("texcoords", texcoords, count)?,
            colors: per_vertex("colors", colors, count)?,
            indices: mesh.indices(py)?,
            positions,
            ..SceneMesh::default()
        };
        let at = mesh.placement.map_or(Affine::IDENTITY, |columns| Affine { columns });
        self.with(py, |stage| {
            let material = material.map(|number| material_id(stage.scene(), number)).transpose()?;
            let shared = Arc::new(described);
            Ok(stage.edit(|scene| {
                let material = material.unwrap_or_else(|| plain(scene));
                let mesh = scene.add_mesh(SceneMesh { material, ..(*shared).clone() });
                let object = scene.add_object_of(name, vec![mesh]);
                scene.instantiate(object, at).0
            }))
        })
    }

    fn _add_instance(&self, py: Python<'_>, of: usize, placement: Object) -> PyResult<u32> {
        let at = Affine { columns: transform("transform", placement)? };
        self.with(py, |stage| {
            let object = stage.scene().instance(instance_id(stage.scene(), of)?).object;
            Ok(stage.edit(|scene| scene.instantiate(object, at).0))
        })
    }

    fn _update(
        &self,
        py: Python<'_>,
        instance: usize,
        placement: Option<Object>,
        visible: Option<bool>,
        vertices: Option<Object>,
        material: Option<usize>,
    ) -> PyResult<()> {
        let at = placement.map(|placement| transform("transform", placement)).transpose()?;
        let numbers = vertices.map(|vertices| Numbers::new("vertices", vertices, Some(3))).transpose()?;
        self.with(py, |stage| {
            let scene = stage.scene();
            let id = instance_id(scene, instance)?;
            let material = material.map(|number| material_id(scene, number)).transpose()?;
            let meshes: Vec<MeshId> = scene.object(scene.instance(id).object).meshes.clone();
            let moved = match numbers {
                None => None,
                Some(numbers) => {
                    let &[mesh] = &meshes[..] else {
                        let count = meshes.len();
                        return Err(PyValueError::new_err(format!(
                            "vertices: instance {instance} shows {count} meshes; only one can be given vertices"
                        )));
                    };
                    let expected = scene.mesh(mesh).positions.len();
                    if numbers.count() != expected {
                        return Err(PyValueError::new_err(format!(
                            "vertices: expected shape ({expected}, 3) as before, not ({}, 3)",
                            numbers.count()
                        )));
                    }
                    Some((mesh, numbers.singles::<3>()))
                }
            };
            stage.edit(|scene| {
                if at.is_some() || visible.is_some() {
                    let edited = scene.edit_instance(id);
                    edited.world_from_object =
                        at.map_or(edited.world_from_object, |columns| Affine { columns });
                    edited.visible = visible.unwrap_or(edited.visible);
                }
                if let Some((mesh, positions)) = &moved {
                    let mesh = scene.edit_mesh(*mesh);
                    mesh.positions.clone_from(positions);
                    // They were those of the shape before.
                    mesh.normals.clear();
                    mesh.tangents.clear();
                }
                for mesh in meshes.iter().filter(|_| material.is_some()) {
                    scene.edit_mesh(*mesh).material = material.unwrap_or_default();
                }
            });
            Ok(())
        })
    }

    fn _add_light(&self, py: Python<'_>, kind: &str, arguments: &Bound<'_, PyDict>) -> PyResult<u32> {
        let mut given = Given::new(arguments);
        let light = describing::light(kind, &mut given)?;
        given.end()?;
        let made = py.detach(|| lights::made(light))?;
        Ok(self.with(py, |stage| lights::add(stage, made)))
    }

    fn _set_light(
        &self,
        py: Python<'_>,
        number: usize,
        kind: &str,
        arguments: &Bound<'_, PyDict>,
    ) -> PyResult<()> {
        let mut given = Given::new(arguments);
        let light = describing::light(kind, &mut given)?;
        given.end()?;
        let made = py.detach(|| lights::made(light))?;
        self.with(py, |stage| lights::set(stage, number, made))
    }

    fn _add_camera(&self, py: Python<'_>, arguments: &Bound<'_, PyDict>) -> PyResult<u32> {
        let mut given = Given::new(arguments);
        let camera = describing::camera(&mut given)?;
        given.end()?;
        Ok(self.with(py, |stage| stage.edit(|scene| scene.add_camera(camera.clone()).0)))
    }

    fn _cameras(&self, py: Python<'_>) -> Vec<CameraRow> {
        self.with(py, |stage| {
            let row = |camera: &Camera| CameraRow {
                name: camera.name.clone(),
                eye: camera.eye,
                target: camera.target,
                up: camera.up,
                fov: camera.fov_y,
                projection: camera.projection.to_string(),
                view_height: match camera.projection {
                    Projection::Orthographic { height } => Some(height),
                    _ => None,
                },
                aperture: camera.lens.aperture,
                focus: camera.lens.focus,
            };
            stage.scene().cameras().iter().map(row).collect()
        })
    }

    /// What is to be told of shaders and has not been.
    fn _progress(&self, py: Python<'_>) -> Vec<String> {
        self.with(py, Stage::progress)
    }

    #[getter]
    fn materials(&self, py: Python<'_>) -> Vec<String> {
        self.with(py, |stage| {
            stage.scene().materials().iter().map(|material| material.name.clone()).collect()
        })
    }

    #[getter]
    fn instances(&self, py: Python<'_>) -> Vec<String> {
        self.with(py, |stage| {
            stage.scene().instances().iter().map(|instance| instance.name.clone()).collect()
        })
    }

    /// Names of clips, and how long each is.
    #[getter]
    fn animations(&self, py: Python<'_>) -> Vec<String> {
        self.with(py, |stage| {
            let clips = stage.scene().animation().map(|animation| &animation.clips);
            clips.into_iter().flatten().map(|clip| clip.name.clone()).collect()
        })
    }

    #[pyo3(signature = (arguments, progress=None))]
    fn _render(
        &self,
        py: Python<'_>,
        arguments: &Bound<'_, PyDict>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Picture> {
        let request = BuildRequest::new(arguments)?;
        request.render(py, progress, || self.shoot(&request))
    }

    fn _grow(&self, py: Python<'_>, arguments: &Bound<'_, PyDict>) -> PyResult<Growing> {
        let request = BuildRequest::new(arguments)?;
        let shot = crate::watch::watched(py, None, |_| self.shoot(&request))?;
        Growing::new(request, shot)
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        self.with(py, |stage| {
            let scene = stage.scene();
            let triangles: usize = scene.meshes().iter().map(|mesh| mesh.indices.len()).sum();
            format!(
                "<gnurt.Scene: {triangles} triangles, {} instances, {} materials, {} lights, {} cameras>",
                scene.instances().len(),
                scene.materials().len(),
                scene.lights().len(),
                scene.cameras().len()
            )
        })
    }
}

/// The material of meshes that are given none.
fn plain(scene: &mut Description) -> MaterialId {
    const NAME: &str = "default";
    let known = scene.materials().iter().position(|material| material.name == NAME);
    known.map_or_else(
        || scene.add_material(gnurt::scene::Material::matte(NAME, [0.8; 3])),
        |number| MaterialId(number as u32),
    )
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt.Scene`: the description of pictures. See docs/reference/python.md. An instance is identified by its
//! number. Tests: `tests/test_pictures.py`.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use gnurt::FORMATS;
use gnurt::scene::{Affine, InstanceId, MeshId, Scene as Description, io};
use gnurt::scene::{Camera, Object as SceneObject, Projection, RayMask, Texture};
use gnurt::shading::texture::TextureSampler;
use pyo3::exceptions::{PyIndexError, PyOSError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use pyo3::types::PyDict;

use crate::arrays::{Numbers, transform};
use crate::described_mesh::DescribedMesh;
use crate::described_strands::strands;
use crate::describing;
use crate::displacements;
use crate::frames::Frames;
use crate::given::Given;
use crate::lights;
use crate::materials::{Compiled, material_id, plain};
use crate::media;
use crate::pickled;
use crate::picture::Picture;
use crate::rendering::{BuildRequest, Growing};
use crate::shade;
use crate::stage::Stage;
use crate::textures::{self, Pictures};

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
    shift: [f32; 2],
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

/// Textures of a scene, for descriptions of materials and lights.
struct Textures<'a, 'py>(&'a Scene, Python<'py>);

impl Pictures for Textures<'_, '_> {
    fn texture(&self, number: usize) -> PyResult<Texture> {
        self.0.with(self.1, |stage| stage.texture(number))
    }

    fn sampler(&self, number: usize) -> PyResult<Arc<TextureSampler>> {
        self.0.with(self.1, |stage| stage.sampler(number))
    }
}

/// Kinds of rays, in the order of their bits.
const RAYS: [&str; 3] = ["camera", "shadow", "other"];

fn instance_id(scene: &Description, instance: usize) -> PyResult<InstanceId> {
    let count = scene.instances().len();
    match u32::try_from(instance) {
        Ok(id) if instance < count => Ok(InstanceId(id)),
        _ => {
            Err(PyIndexError::new_err(format!("instance: {instance} is out of range; the scene has {count}")))
        }
    }
}

#[pymethods]
impl Scene {
    #[new]
    fn new() -> Self {
        Self::default()
    }

    /// The scene of `load`, and the warnings about the file.
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

    /// State for pickle: the description, and shaders with the texts of their files.
    fn __getstate__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let parts = self.with(py, |stage| stage.parts());
        pickled::state(py, &parts)
    }

    fn __setstate__(&self, py: Python<'_>, state: &Bound<'_, PyDict>) -> PyResult<()> {
        let stage = pickled::stage(py, state)?;
        let before = self.with(py, |own| std::mem::replace(own, stage));
        py.detach(|| drop(before));
        Ok(())
    }

    fn _take(&self, py: Python<'_>, other: &Bound<'_, Self>) {
        let copy = other.get().with(py, Stage::copy);
        self.with(py, |stage| *stage = copy);
    }

    /// Writes it in the format of the file's extension. Returns warnings about features that the format
    /// cannot hold.
    fn _save(&self, py: Python<'_>, path: PathBuf) -> PyResult<Vec<String>> {
        let scene = self.with(py, |stage| stage.scene().clone());
        let reported = py.detach(|| FORMATS.save(&scene, &path)).map_err(|error| scene_error(&error))?;
        Ok(reported.iter().map(ToString::to_string).collect())
    }

    fn _add_material(&self, py: Python<'_>, arguments: &Bound<'_, PyDict>) -> PyResult<u32> {
        let mut given = Given::new(arguments);
        let material = describing::material(&mut given, &Textures(self, py))?;
        given.end()?;
        let material = Compiled::new(py, material)?;
        self.with(py, |stage| {
            let (material, displacement) = material.put(stage)?;
            Ok(stage.edit(|scene| {
                let id = scene.add_material(material.clone());
                displacements::set(scene, id, displacement);
                id.0
            }))
        })
    }

    fn _set_material(&self, py: Python<'_>, number: usize, arguments: &Bound<'_, PyDict>) -> PyResult<()> {
        let mut given = Given::new(arguments);
        let material = describing::material(&mut given, &Textures(self, py))?;
        given.end()?;
        let material = Compiled::new(py, material)?;
        self.with(py, |stage| {
            let id = material_id(stage.scene(), number)?;
            let (material, displacement) = material.put(stage)?;
            stage.edit(|scene| {
                *scene.edit_material(id) = material.clone();
                displacements::set(scene, id, displacement);
            });
            Ok(())
        })
    }

    fn _shade(&self, py: Python<'_>, material: &str, arguments: &Bound<'_, PyDict>) -> PyResult<Vec<usize>> {
        let names: Vec<String> = self.with(py, |stage| {
            stage.scene().materials().iter().map(|material| material.name.clone()).collect()
        });
        let shaded = shade::shaded(py, material, &names, arguments, &Textures(self, py))?;
        Ok(self.with(py, |stage| {
            let mut numbers: Vec<usize> = shaded.into_iter().flat_map(|shaded| shaded.put(stage)).collect();
            numbers.sort_unstable();
            numbers
        }))
    }

    fn _add_medium(&self, py: Python<'_>, arguments: &Bound<'_, PyDict>) -> PyResult<u32> {
        let mut given = Given::new(arguments);
        let medium = media::medium(py, &mut given)?;
        given.end()?;
        Ok(self.with(py, |stage| stage.edit(|scene| scene.add_medium(medium.clone()).0)))
    }

    fn _set_medium(&self, py: Python<'_>, number: usize, arguments: &Bound<'_, PyDict>) -> PyResult<()> {
        let mut given = Given::new(arguments);
        let medium = media::medium(py, &mut given)?;
        given.end()?;
        self.with(py, |stage| {
            let id = media::medium_id(stage.scene(), number)?;
            stage.edit(|scene| *scene.edit_medium(id) = medium.clone());
            Ok(())
        })
    }

    fn _add_texture(&self, py: Python<'_>, arguments: &Bound<'_, PyDict>) -> PyResult<u32> {
        let mut given = Given::new(arguments);
        let texture = textures::texture(py, &mut given)?;
        given.end()?;
        Ok(self.with(py, |stage| stage.edit(|scene| scene.add_texture(texture.clone()).0)))
    }

    fn _set_texture(&self, py: Python<'_>, number: usize, arguments: &Bound<'_, PyDict>) -> PyResult<()> {
        let mut given = Given::new(arguments);
        let texture = textures::texture(py, &mut given)?;
        given.end()?;
        self.with(py, |stage| stage.set_texture(number, &texture))
    }

    fn _add_mesh(&self, py: Python<'_>, arguments: &Bound<'_, PyDict>) -> PyResult<u32> {
        let mut given = Given::new(arguments);
        let described = DescribedMesh::new(py, &mut given)?;
        self.show(py, given, described)
    }

    /// Curves, or spheres.
    fn _add_strands(&self, py: Python<'_>, has_curves: bool, arguments: &Bound<'_, PyDict>) -> PyResult<u32> {
        let mut given = Given::new(arguments);
        let described = strands(&mut given, has_curves)?;
        self.show(py, given, described)
    }

    /// Replaces the meshes of an instance's object, for all instances of it.
    fn _set_mesh(&self, py: Python<'_>, instance: usize, arguments: &Bound<'_, PyDict>) -> PyResult<()> {
        let mut given = Given::new(arguments);
        let described = DescribedMesh::new(py, &mut given)?;
        given.end()?;
        self.with(py, |stage| {
            let object = stage.scene().instance(instance_id(stage.scene(), instance)?).object;
            let meshes = placed(stage, described)?;
            stage.edit(|scene| {
                let mut known: Vec<MeshId> = scene.object(object).meshes.clone();
                known.truncate(meshes.len());
                for (i, mesh) in meshes.iter().enumerate() {
                    match known.get(i) {
                        Some(&id) => scene.replace_mesh(id, mesh.clone()),
                        None => known.push(scene.add_mesh(mesh.clone())),
                    }
                }
                if scene.object(object).meshes != known {
                    let SceneObject { meshes, .. } = scene.edit_object(object);
                    *meshes = known;
                }
            });
            Ok(())
        })
    }

    fn _add_instance(&self, py: Python<'_>, of: usize, placement: Object) -> PyResult<u32> {
        let at = Affine { columns: transform("transform", placement)? };
        self.with(py, |stage| {
            let object = stage.scene().instance(instance_id(stage.scene(), of)?).object;
            Ok(stage.edit(|scene| scene.instantiate(object, at).0))
        })
    }

    #[expect(clippy::too_many_arguments, reason = "what an instance may have")]
    fn _update(
        &self,
        py: Python<'_>,
        instance: usize,
        placement: Option<Object>,
        visible: Option<bool>,
        vertices: Option<Object>,
        material: Option<usize>,
        rays: Option<Object>,
    ) -> PyResult<()> {
        let mask = match rays {
            None => None,
            Some(rays) => {
                let arguments = PyDict::new(py);
                arguments.set_item("rays", rays)?;
                Given::new(&arguments).words("rays", &RAYS)?
            }
        };
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
                if at.is_some() || visible.is_some() || mask.is_some() {
                    let edited = scene.edit_instance(id);
                    edited.world_from_object =
                        at.map_or(edited.world_from_object, |columns| Affine { columns });
                    edited.visible = visible.unwrap_or(edited.visible);
                    edited.mask = mask.map_or(edited.mask, RayMask);
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
        let light = describing::light(kind, &mut given, &Textures(self, py))?;
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
        let light = describing::light(kind, &mut given, &Textures(self, py))?;
        given.end()?;
        let made = py.detach(|| lights::made(light))?;
        self.with(py, |stage| lights::set(stage, number, made))
    }

    /// The number of a new light with a shader, or replaces such a light.
    fn _put_light_shader(
        &self,
        py: Python<'_>,
        number: Option<usize>,
        arguments: &Bound<'_, PyDict>,
    ) -> PyResult<u32> {
        let mut given = Given::new(arguments);
        let script = crate::scripts::script(&mut given, &Textures(self, py))?;
        given.end()?;
        let script = script.ok_or_else(|| PyValueError::new_err("shader: is missing"))?;
        let wrong = |why| PyValueError::new_err(format!("shader: {why}"));
        let light = py.detach(|| script.light()).map_err(wrong)?;
        self.with(py, |stage| stage.put_light_script(number, script, light))
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
                shift: camera.shift,
                aperture: camera.lens.aperture,
                focus: camera.lens.focus,
            };
            stage.scene().cameras().iter().map(row).collect()
        })
    }

    /// Unreported messages of shaders.
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

    /// Changes a value by text.
    fn _set(&self, py: Python<'_>, change: &str) -> PyResult<()> {
        self.with(py, |stage| stage.change(change)).map_err(PyValueError::new_err)
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

    fn _frames(
        &self,
        py: Python<'_>,
        times: &Bound<'_, PyDict>,
        arguments: &Bound<'_, PyDict>,
    ) -> PyResult<Frames> {
        Frames::new(self.with(py, Stage::copy), times, arguments)
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

/// Meshes with the numbers of their materials, checked.
impl Scene {
    /// Shows a described mesh, whose last arguments are read here.
    fn show(&self, py: Python<'_>, mut given: Given, described: DescribedMesh) -> PyResult<u32> {
        let mask = given.words("rays", &RAYS)?;
        given.end()?;
        let at = described.placement.map_or(Affine::IDENTITY, |columns| Affine { columns });
        self.with(py, |stage| {
            let (name, meshes) = (described.name.clone(), placed(stage, described)?);
            Ok(stage.edit(|scene| {
                let meshes = meshes.iter().map(|mesh| scene.add_mesh(mesh.clone())).collect();
                let object = scene.add_object_of(&name[..], meshes);
                let id = scene.instantiate(object, at);
                if let Some(mask) = mask {
                    scene.edit_instance(id).mask = RayMask(mask);
                }
                id.0
            }))
        })
    }
}

fn placed(stage: &mut Stage, described: DescribedMesh) -> PyResult<Vec<Arc<gnurt::scene::Mesh>>> {
    let materials = match &described.materials {
        Some(numbers) => {
            numbers.iter().map(|&number| material_id(stage.scene(), number)).collect::<PyResult<_>>()?
        }
        None => vec![stage.edit(plain)],
    };
    let placed = |(slot, mesh): (usize, _)| {
        let material = materials[slot];
        Arc::new(gnurt::scene::Mesh { material, ..mesh })
    };
    Ok(described.parts.into_iter().map(placed).collect())
}

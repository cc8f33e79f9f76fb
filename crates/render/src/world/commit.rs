// SPDX-License-Identifier: GPL-3.0-or-later
//! Commit: from a description to a world, doing only what is due.
//! Source: original. What was edited since the last commit is in the scene's log: an object is built again if its list
//! of meshes or one of its meshes changed, or if it is needed for the first time; the top tree always is.
//! Proof: `crates/render/tests/commit.rs`.

use std::collections::BTreeSet;
use std::sync::{Arc, OnceLock};
use std::time::Instant;

use glam::Vec3;
use gnurt_accel::{BuildOptions, Instance, Memory, ObjectTree, SceneTree, Threads, Triangles};
use gnurt_scene::edit::Edit;
use gnurt_scene::{Mesh, MeshId, ObjectId, Scene, Surface};

use super::instance::PlacedInstance;
use super::{
    CommitOptions, CommitReport, Followed, ShaderTable, Shading, World, WorldObject, lights, materials,
};
use crate::error::CommitError;

impl World {
    /// Brings the world up to date with `scene`. A world follows one scene: only what its log says was edited since
    /// the last commit is built again. Bad primitives and instances are dropped and counted.
    ///
    /// # Errors
    /// [`CommitError`] if the scene names things that are not there; the world stays as it was.
    pub fn commit(
        &mut self,
        scene: &Scene,
        shaders: &ShaderTable,
        options: &CommitOptions,
        pool: &rayon::ThreadPool,
    ) -> Result<CommitReport, CommitError> {
        commit(self, scene, shaders, options, pool)
    }
}

fn commit(
    world: &mut World,
    scene: &Scene,
    shaders: &ShaderTable,
    options: &CommitOptions,
    pool: &rayon::ThreadPool,
) -> Result<CommitReport, CommitError> {
    let start = Instant::now();
    check(scene, shaders)?;
    let due = Due::new(world, scene, options);
    let mut report = CommitReport::default();

    let objects = build_objects(world, scene, &due, options.memory, pool, &mut report);
    let instances = place_instances(scene, &objects, &mut report);
    let tree = SceneTree::build(&tree_instances(scene, &instances));
    report.dropped_instances += tree.dropped_instances() as usize;
    let bad = |object: &Arc<WorldObject>| object.tree.bad_primitives().total() as usize;
    report.dropped_triangles = objects.iter().flatten().map(bad).sum();

    let surfaces = materials::surfaces(scene, shaders, options.force_diffuse);
    let bounds = tree.bounds();
    let lights =
        lights::lights(scene, &instances, shaders, options, [bounds.min, bounds.max].map(Vec3::from));
    let all_opaque = surfaces.iter().all(|surface| surface.is_opaque());
    let all_solid = surfaces.iter().all(|surface| surface.is_solid());
    *world = World {
        objects: Arc::new(objects),
        instances: Arc::new(instances),
        tree: Arc::new(tree),
        shading: Arc::new(Shading {
            plain: surfaces.iter().map(|surface| surface.plain_albedo()).collect(),
            lambertian: surfaces.iter().map(|surface| materials::lambertian(&**surface)).collect(),
            surfaces,
            lights: lights.shaders,
            plugin_lights: lights.plugins,
            environment: lights.environment,
            all_opaque,
            all_solid,
            parts: lights.parts,
            light_set: OnceLock::new(),
            shader_lamps: OnceLock::new(),
        }),
        face_normals: options.force_diffuse,
        follows: Some(Followed { cursor: scene.cursor(), options: *options }),
    };
    report.build_seconds = start.elapsed().as_secs_f64();
    Ok(report)
}

/// What has to be built again.
struct Due {
    everything: bool,
    meshes: BTreeSet<MeshId>,
    objects: BTreeSet<ObjectId>,
}

impl Due {
    fn new(world: &World, scene: &Scene, options: &CommitOptions) -> Self {
        let mut due = Self { everything: false, meshes: BTreeSet::new(), objects: BTreeSet::new() };
        match &world.follows {
            // A cursor ahead of the log is another scene's.
            Some(followed) if followed.options == *options && followed.cursor <= scene.cursor() => {
                for edit in scene.edits_since(followed.cursor) {
                    match edit {
                        Edit::Mesh(id) => _ = due.meshes.insert(id),
                        Edit::Object(id) => _ = due.objects.insert(id),
                        _ => {}
                    }
                }
            }
            _ => due.everything = true,
        }
        due
    }

    fn object(&self, id: ObjectId, meshes: &[MeshId]) -> bool {
        self.everything || self.objects.contains(&id) || meshes.iter().any(|mesh| self.meshes.contains(mesh))
    }
}

/// The tree of each object that a visible instance shows: the old one where it is still good.
fn build_objects(
    world: &World,
    scene: &Scene,
    due: &Due,
    memory: Memory,
    pool: &rayon::ThreadPool,
    report: &mut CommitReport,
) -> Vec<Option<Arc<WorldObject>>> {
    let needed: BTreeSet<ObjectId> =
        scene.instances().iter().filter(|i| i.visible).map(|i| i.object).collect();
    let mut objects = vec![None; scene.objects().len()];
    for id in needed {
        let meshes = &scene.object(id).meshes;
        let old = world.objects.get(id.index()).cloned().flatten();
        let object = match old.filter(|_| !due.object(id, meshes)) {
            Some(object) => object,
            None => {
                report.built_objects += 1;
                Arc::new(build_object(scene, meshes, memory, pool))
            }
        };
        objects[id.index()] = Some(object);
    }
    objects
}

fn build_object(scene: &Scene, ids: &[MeshId], memory: Memory, pool: &rayon::ThreadPool) -> WorldObject {
    // Shared with the scene, which copies what it edits later.
    let meshes: Vec<Arc<Mesh>> = ids.iter().map(|id| scene.meshes()[id.index()].clone()).collect();
    let triangles: Vec<_> =
        meshes.iter().map(|m| Triangles { positions: &m.positions, indices: &m.indices }).collect();
    let options = BuildOptions { memory, ..BuildOptions::default() };
    let tree = ObjectTree::build(&triangles, &options, Threads::Pool(pool));
    WorldObject { meshes, tree: Arc::new(tree) }
}

/// Transforms of the visible instances; those that flatten are dropped and counted.
fn place_instances(
    scene: &Scene,
    objects: &[Option<Arc<WorldObject>>],
    report: &mut CommitReport,
) -> Vec<Option<PlacedInstance>> {
    let place = |instance: &gnurt_scene::Instance| {
        let object = objects[instance.object.index()].clone().filter(|_| instance.visible)?;
        let placed = PlacedInstance::new(object, instance.object, &instance.world_from_object);
        report.dropped_instances += usize::from(placed.is_none());
        placed
    };
    scene.instances().iter().map(place).collect()
}

/// What the top tree is built over: position for position the scene's instances, empty where rays meet nothing.
fn tree_instances(scene: &Scene, placed: &[Option<PlacedInstance>]) -> Vec<Instance> {
    let nothing = Arc::new(ObjectTree::build(&[], &BuildOptions::default(), Threads::Single));
    placed
        .iter()
        .zip(scene.instances())
        .map(|(placed, instance)| match placed {
            Some(placed) => Instance::new(placed.object.tree.clone(), instance.world_from_object.columns),
            None => Instance::identity(nothing.clone()),
        })
        .collect()
}

/// Whether all ids name something.
fn check(scene: &Scene, shaders: &ShaderTable) -> Result<(), CommitError> {
    let dangling = |what, index, used, id| CommitError::DanglingId { what, index, used, id };
    for (index, instance) in scene.instances().iter().enumerate() {
        if instance.object.index() >= scene.objects().len() {
            return Err(dangling("instance", index, "object", instance.object.0));
        }
    }
    for (index, object) in scene.objects().iter().enumerate() {
        if let Some(mesh) = object.meshes.iter().find(|mesh| mesh.index() >= scene.meshes().len()) {
            return Err(dangling("object", index, "mesh", mesh.0));
        }
    }
    for (index, mesh) in scene.meshes().iter().enumerate() {
        if mesh.material.index() >= scene.materials().len() {
            return Err(dangling("mesh", index, "material", mesh.material.0));
        }
    }
    for (index, material) in scene.materials().iter().enumerate() {
        if let Some(texture) = materials::textures_of(material).find(|t| t.index() >= scene.textures().len())
        {
            return Err(dangling("material", index, "texture", texture.0));
        }
        if let Surface::Shader(shader) = material.surface
            && shader as usize >= shaders.surfaces.len()
        {
            let known = shaders.surfaces.len();
            return Err(CommitError::UnknownShader { material: index, shader, known });
        }
    }
    lights::check(scene)
}

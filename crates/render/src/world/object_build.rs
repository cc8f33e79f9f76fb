// SPDX-License-Identifier: GPL-3.0-or-later
//! Committed objects: their arrays and the trees over them. Space: object.
//! Edits of meshes and of an object's list come here; trees of all objects that are due are built side by side.
//! Invariant: an object has a tree while a visible instance shows it. Tests: crates/render/tests/commit.rs.

use std::collections::HashSet;
use std::sync::Arc;

use gnurt_accel::threads;
use gnurt_accel::{
    BuildOptions, Geometry, Motion, MovingTree, MovingTriangles, ObjectTree, SharedList, Threads, Update,
};
use gnurt_scene::animation::Exposure;
use gnurt_scene::{Mesh, MeshId, Scene};
use gnurt_shading::DisplacementShader;

use super::areas::Areas;
use super::crowds::{Crowds, Kind};
use super::object::{ObjectSlot, WorldObject, bends, materials_of};
use super::strands::Arrays;
use super::table::{CommitOptions, ShaderTable};
use crate::displacement::{MOST_VERTICES, Meshes, displace};

/// Objects that became others, ascending.
#[derive(Default)]
pub(super) struct ChangedObjects {
    pub(super) ids: Vec<u32>,
    /// Trees that were built for them, at least in part.
    pub(super) built: usize,
    /// Trees that were refitted.
    pub(super) refitted: usize,
    /// Whether the traced geometry has changed: meshes may have changed texture coordinates only.
    pub(super) reshaped: bool,
    /// Reports of displacement.
    pub(super) warnings: Vec<String>,
}

/// Updates those of `dirty`, ascending: builds needed objects, drops unused ones.
pub(super) fn update(
    objects: &mut SharedList<ObjectSlot>,
    crowds: &Crowds,
    dirty: &[u32],
    scene: (&Scene, &Exposure),
    shaders: &ShaderTable,
    trees: BuildOptions,
    pool: &rayon::ThreadPool,
) -> ChangedObjects {
    let needed = |&&id: &&u32| objects[id as usize].users > 0;
    let ids: Vec<u32> = dirty.iter().filter(needed).copied().collect();
    // The kinds of all are known before the first is built, because these identify the crowds.
    let show = |n: usize| Shown::new(scene, &shaders.displacements, ids[n]);
    let shown: Vec<Shown> = match scene.0.displacements().next() {
        // Edits of small scenes do not wait for the pool.
        None => (0..ids.len()).map(show).collect(),
        Some(_) => pool.install(|| threads::map(ids.len() > 1, ids.len(), show)),
    };
    let mut warnings = Vec::new();
    let found: Vec<Found> = ids
        .iter()
        .zip(shown)
        .map(|(&id, mut shown)| {
            warnings.append(&mut shown.warnings);
            Found::new(shown.object, id, scene.0, objects, crowds)
        })
        .collect();
    warnings.dedup();
    prepare_crowds(&found, &trees, pool);
    let build = |found: &Found| {
        let (object, update) = build(found, &trees, pool);
        (Arc::new(object), update)
    };
    let made: Vec<(Arc<WorldObject>, Option<Update>)> = match &found[..] {
        [found] => vec![build(found)],
        // Large and small ones come in any order: each is shared out for itself, too.
        _ => pool.install(|| threads::map(true, found.len(), |n| build(&found[n]))),
    };
    let count = |of: fn(Update) -> bool| made.iter().filter(|(_, update)| update.is_some_and(of)).count();
    let refitted = count(|update| update == Update::Refitted);
    let built = count(|update| update != Update::Refitted);
    for &id in dirty {
        let slot = objects.edit(id as usize);
        if slot.users == 0 {
            slot.object = None;
        }
    }
    for (&id, (object, _)) in ids.iter().zip(made) {
        objects.edit(id as usize).object = Some(object);
    }
    ChangedObjects { ids, built, refitted, reshaped: built + refitted > 0, warnings }
}

/// The meshes of an object as rays see them: displaced.
struct Shown {
    object: Meshes,
    warnings: Vec<String>,
}

impl Shown {
    fn new(
        (scene, exposure): (&Scene, &Exposure),
        displacements: &[Arc<dyn DisplacementShader>],
        id: u32,
    ) -> Self {
        let object = &scene.objects()[id as usize];
        // Shared with the scene, which copies a mesh before it edits it.
        let meshes: Vec<Arc<Mesh>> =
            object.meshes.iter().map(|id| scene.meshes()[id.index()].clone()).collect();
        let exposed =
            |id: &MeshId| exposure.meshes.iter().find(|(mesh, keys)| mesh == id && !keys.is_empty());
        let keys = |id: &MeshId| exposed(id).map(|(_, keys)| keys.clone()).unwrap_or_default();
        let keys: Vec<Vec<Arc<Mesh>>> = object.meshes.iter().map(keys).collect();
        let (mut object, mut warnings) = (Meshes { meshes, keys }, Vec::new());
        displace(scene, displacements, MOST_VERTICES, &mut object, &mut warnings);
        Self { object, warnings }
    }
}

/// An object as the scene has it now.
struct Found {
    meshes: Vec<Arc<Mesh>>,
    /// As those of a [`WorldObject`].
    keys: Vec<Vec<Arc<Mesh>>>,
    motion: gnurt_scene::Motion,
    kind: Option<Arc<Kind>>,
    /// Its previous state, if at most vertices have moved.
    before: Option<Arc<WorldObject>>,
}

impl Found {
    fn new(
        Meshes { meshes, keys }: Meshes,
        id: u32,
        scene: &Scene,
        objects: &SharedList<ObjectSlot>,
        crowds: &Crowds,
    ) -> Self {
        let object = &scene.objects()[id as usize];
        let before = objects[id as usize].object.clone().filter(|before| !bends(&before.keys));
        let before = before.filter(|before| same_topology(&before.meshes, &meshes));
        // An object that deforms during the open shutter has a tree of its own.
        let moves = !bends(&keys)
            && meshes.iter().all(|mesh| mesh.has_triangles())
            && !matches!(object.motion, gnurt_scene::Motion::Static | gnurt_scene::Motion::Rigid);
        let known = before.as_ref().and_then(|before| before.kind.clone());
        let kind = moves.then(|| known.unwrap_or_else(|| crowds.kind_of(&meshes)));
        Self { meshes, keys, motion: object.motion, kind, before }
    }

    /// The topology that it shares with other objects. An object that already has its own tree keeps it.
    fn crowd(&self) -> Option<&Arc<Kind>> {
        let shares = self.before.as_ref().is_none_or(|before| before.tree.is_posed());
        self.kind.as_ref().filter(|kind| shares && kind.is_of_many())
    }

    fn arrays(&self) -> Vec<Arrays> {
        self.meshes.iter().map(|mesh| Arrays::of(mesh)).collect()
    }

    fn geometries<'a>(&'a self, arrays: &'a [Arrays]) -> Vec<Geometry<'a>> {
        self.meshes.iter().zip(arrays).map(|(mesh, arrays)| arrays.geometry(mesh)).collect()
    }
}

/// Builds the structures that objects of a kind will share, over the first of them: once, by all threads.
/// Parallel builds of the same crowd would not wait for each other, but each build the structure.
fn prepare_crowds(found: &[Found], trees: &BuildOptions, pool: &rayon::ThreadPool) {
    let mut visible: HashSet<*const Kind> = HashSet::new();
    let firsts: Vec<(&Found, &Arc<Kind>)> = found
        .iter()
        .filter_map(|found| Some((found, found.crowd()?)))
        .filter(|(_, kind)| visible.insert(Arc::as_ptr(kind)))
        .collect();
    let prepare = |(found, kind): &(&Found, &Arc<Kind>)| {
        kind.crowd.prepare(&found.geometries(&found.arrays()), trees, Threads::Pool(pool));
    };
    match &firsts[..] {
        [first] => prepare(first),
        _ => pool.install(|| threads::for_each(true, firsts.len(), &|n| prepare(&firsts[n]))),
    }
}

/// An object, and its update: it keeps the previous tree if no triangle has moved, and refits it if vertices
/// have. Objects of the same topology share structures.
fn build(found: &Found, trees: &BuildOptions, pool: &rayon::ThreadPool) -> (WorldObject, Option<Update>) {
    let Found { meshes, keys, motion: moves, kind, before } = found;
    if bends(keys) {
        return exposed(*moves, meshes.clone(), keys.clone(), trees, pool);
    }
    let known = before.as_ref().map(|before| match before.motion == *moves {
        true => before.moving.clone(),
        false => MovingTree::of(before.tree.clone(), motion(*moves)),
    });
    let known = before.as_ref().zip(known);
    let (moving, update) = match known {
        Some((before, moving)) if same_positions(&before.meshes, meshes) => (moving, None),
        known => {
            let arrays = found.arrays();
            let geometries = found.geometries(&arrays);
            let threads = Threads::Pool(pool);
            match (found.crowd(), known) {
                (Some(kind), known) => {
                    let tree = kind.crowd.pose(&geometries, trees, threads);
                    let is_fitted = known.is_some() && tree.is_posed();
                    let update = if is_fitted { Update::Refitted } else { Update::Rebuilt };
                    (MovingTree::of(tree, motion(*moves)), Some(update))
                }
                (None, Some((_, mut moving))) => {
                    let update = moving.update(&geometries, trees, threads);
                    (moving, Some(update))
                }
                (None, None) => {
                    let moving = MovingTree::build(&geometries, trees, motion(*moves), threads);
                    (moving, Some(Update::Rebuilt))
                }
            }
        }
    };
    (object(moving, *moves, meshes.clone(), keys.clone(), kind.clone(), false), update)
}

/// An object of meshes, with its tree.
fn object(
    moving: MovingTree,
    motion: gnurt_scene::Motion,
    meshes: Vec<Arc<Mesh>>,
    keys: Vec<Vec<Arc<Mesh>>>,
    kind: Option<Arc<Kind>>,
    bends: bool,
) -> WorldObject {
    WorldObject {
        tree: moving.tree().clone(),
        materials: materials_of(&meshes),
        moving,
        motion,
        meshes,
        keys,
        kind,
        members: None,
        bends,
        members_move: false,
        areas: Areas::default(),
    }
}

/// An object some of whose meshes bend while the shutter is open. Its tree is built.
fn exposed(
    motion_of_object: gnurt_scene::Motion,
    meshes: Vec<Arc<Mesh>>,
    keys: Vec<Vec<Arc<Mesh>>>,
    trees: &BuildOptions,
    pool: &rayon::ThreadPool,
) -> (WorldObject, Option<Update>) {
    let lists: Vec<Vec<&[[f32; 3]]>> =
        keys.iter().map(|keys| keys.iter().map(|mesh| &mesh.positions[..]).collect()).collect();
    let mut geometries: Vec<Geometry> = Vec::with_capacity(meshes.len());
    let arrays: Vec<Arrays> = meshes.iter().map(|mesh| Arrays::of(mesh)).collect();
    for ((mesh, keys), arrays) in meshes.iter().zip(&lists).zip(&arrays) {
        geometries.push(match keys.is_empty() {
            true => arrays.geometry(mesh),
            // Curves and spheres stay where they are when the shutter opens.
            false if !mesh.has_triangles() => arrays.geometry(mesh),
            false => MovingTriangles { keys, indices: &mesh.indices }.into(),
        });
    }
    let tree = Arc::new(ObjectTree::build_from(&geometries, trees, Threads::Pool(pool)));
    let moving = MovingTree::of(tree, motion(motion_of_object));
    (object(moving, motion_of_object, meshes, keys, None, true), Some(Update::Rebuilt))
}

/// How the trees of a commit are built.
pub(super) fn build_options(options: &CommitOptions) -> BuildOptions {
    let &CommitOptions { memory, quality, .. } = options;
    BuildOptions { memory, quality, ..BuildOptions::default() }
}

fn motion(motion: gnurt_scene::Motion) -> Motion {
    match motion {
        gnurt_scene::Motion::Auto => Motion::Auto,
        gnurt_scene::Motion::Static => Motion::Static,
        gnurt_scene::Motion::Rigid => Motion::Rigid,
        gnurt_scene::Motion::Deforming => Motion::Deforming,
        gnurt_scene::Motion::Known => Motion::Known,
    }
}

/// Whether at most vertices have moved.
fn same_topology(before: &[Arc<Mesh>], now: &[Arc<Mesh>]) -> bool {
    let same = |(a, b): (&Arc<Mesh>, &Arc<Mesh>)| {
        Arc::ptr_eq(a, b)
            || (a.positions.len() == b.positions.len()
                && a.indices == b.indices
                && a.primitives == b.primitives)
    };
    before.len() == now.len() && before.iter().zip(now).all(same)
}

/// Whether rays see no difference, where the topology is the same. Where something moved the answer comes soon: mostly the
/// first vertex has.
fn same_positions(before: &[Arc<Mesh>], now: &[Arc<Mesh>]) -> bool {
    let bits = |p: &[f32; 3]| p.map(f32::to_bits);
    let same = |(a, b): (&Arc<Mesh>, &Arc<Mesh>)| {
        Arc::ptr_eq(a, b) || a.positions.iter().zip(&b.positions).all(|(a, b)| bits(a) == bits(b))
    };
    before.iter().zip(now).all(same)
}

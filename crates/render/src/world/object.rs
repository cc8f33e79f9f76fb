// SPDX-License-Identifier: GPL-3.0-or-later
//! Committed objects: their arrays and the trees over them. Source: original. Space: object.
//! Edits of meshes and of an object's list come here; trees of all objects that are due are built side by side.
//! Invariant: an object has a tree while a visible instance shows it. Proof: crates/render/tests/commit.rs.

use std::sync::Arc;

use gnurt_accel::{BuildOptions, Memory, ObjectTree, SharedList, Threads, Triangles};
use gnurt_scene::{Mesh, Scene};
use rayon::prelude::*;

/// An object's arrays and the tree over them.
pub(crate) struct WorldObject {
    /// By geometry id: what the scene's meshes were at commit. Shared with the scene until it edits them.
    pub(crate) meshes: Vec<Arc<Mesh>>,
    pub(crate) tree: Arc<ObjectTree>,
}

/// What there is of an object of the scene.
#[derive(Clone, Default)]
pub(super) struct ObjectSlot {
    /// `None` where no visible instance needs it.
    pub(super) object: Option<Arc<WorldObject>>,
    /// Visible instances.
    pub(super) users: u32,
}

/// Objects that became others, ascending.
#[derive(Default)]
pub(super) struct ChangedObjects {
    pub(super) ids: Vec<u32>,
    /// Trees that were built for them.
    pub(super) built: usize,
    /// Whether what rays meet has changed: meshes may have got other coordinates for textures only.
    pub(super) reshaped: bool,
}

/// Brings those of `due`, ascending, up to date: builds what is needed, lets go what is not.
pub(super) fn update(
    objects: &mut SharedList<ObjectSlot>,
    due: &[u32],
    scene: &Scene,
    memory: Memory,
    pool: &rayon::ThreadPool,
) -> ChangedObjects {
    let needed = |&&id: &&u32| objects[id as usize].users > 0;
    let ids: Vec<u32> = due.iter().filter(needed).copied().collect();
    let before = |id: u32| objects[id as usize].object.clone();
    let build = |&id: &u32| {
        let before = before(id);
        let object = Arc::new(build(scene, id, before.as_deref(), memory, pool));
        let same = before.is_some_and(|before| Arc::ptr_eq(&before.tree, &object.tree));
        (object, !same)
    };
    let made: Vec<(Arc<WorldObject>, bool)> = match &ids[..] {
        [id] => vec![build(id)],
        // Large and small ones come in any order: each is shared out for itself, too.
        _ => pool.install(|| ids.par_iter().with_max_len(1).map(build).collect()),
    };
    let built = made.iter().filter(|(_, is_new)| *is_new).count();
    for &id in due {
        let slot = objects.edit(id as usize);
        if slot.users == 0 {
            slot.object = None;
        }
    }
    for (&id, (object, _)) in ids.iter().zip(made) {
        objects.edit(id as usize).object = Some(object);
    }
    ChangedObjects { ids, built, reshaped: built > 0 }
}

/// An object as the scene has it now; its tree is the one before where no triangle has moved.
fn build(
    scene: &Scene,
    id: u32,
    before: Option<&WorldObject>,
    memory: Memory,
    pool: &rayon::ThreadPool,
) -> WorldObject {
    // Shared with the scene, which copies what it edits later.
    let ids = &scene.objects()[id as usize].meshes;
    let meshes: Vec<Arc<Mesh>> = ids.iter().map(|id| scene.meshes()[id.index()].clone()).collect();
    if let Some(before) = before.filter(|before| same_triangles(&before.meshes, &meshes)) {
        return WorldObject { meshes, tree: before.tree.clone() };
    }
    let triangles: Vec<_> =
        meshes.iter().map(|m| Triangles { positions: &m.positions, indices: &m.indices }).collect();
    let options = BuildOptions { memory, ..BuildOptions::default() };
    let tree = ObjectTree::build(&triangles, &options, Threads::Pool(pool));
    WorldObject { meshes, tree: Arc::new(tree) }
}

/// Whether rays see no difference. Where something moved the answer comes soon: mostly the first vertex has.
fn same_triangles(before: &[Arc<Mesh>], now: &[Arc<Mesh>]) -> bool {
    let same_bits = |a: &[[f32; 3]], b: &[[f32; 3]]| {
        let bits = |p: &[f32; 3]| p.map(f32::to_bits);
        a.len() == b.len() && a.iter().zip(b).all(|(a, b)| bits(a) == bits(b))
    };
    let same = |(a, b): (&Arc<Mesh>, &Arc<Mesh>)| {
        Arc::ptr_eq(a, b) || (same_bits(&a.positions, &b.positions) && a.indices == b.indices)
    };
    before.len() == now.len() && before.iter().zip(now).all(same)
}

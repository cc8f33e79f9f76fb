// SPDX-License-Identifier: GPL-3.0-or-later
//! The top tree over the instances that rays may meet, made anew when one of them moved, came or went.
//! Source: [WBS03a], the paper's section 6. Space: world.
//! The list that it is built from has an entry for each instance of the scene, so that hits name those; it is written by all
//! threads and lives for the build only. Proof: crates/render/tests/{commit,edits}.rs.

use std::sync::Arc;

use gnurt_accel::{BuildOptions, Instance, ObjectTree, SceneTree, Threads};
use gnurt_scene::Scene;
use rayon::prelude::*;

use super::chunked::Chunked;
use super::instance::InstanceSlot;

/// The top tree over instances as they are now.
pub(super) fn build(
    scene: &Scene,
    instances: &Chunked<InstanceSlot>,
    pool: &rayon::ThreadPool,
) -> Arc<SceneTree> {
    let nothing = Arc::new(ObjectTree::build(&[], &BuildOptions::default(), Threads::Single));
    let shown = |place: usize, slot: &InstanceSlot| match slot.placed() {
        Some(placed) => {
            let world_from_object = scene.instances()[place].world_from_object.columns;
            Instance::new(placed.object.tree.clone(), world_from_object)
        }
        None => Instance::identity(nothing.clone()),
    };
    let of_chunk = |(first, slots): (usize, &[InstanceSlot])| {
        slots.iter().enumerate().map(|(i, slot)| shown(first + i, slot)).collect::<Vec<_>>()
    };
    let list: Vec<Instance> = pool.install(|| instances.par_chunks().flat_map_iter(of_chunk).collect());
    Arc::new(SceneTree::build(&list))
}

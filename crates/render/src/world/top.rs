// SPDX-License-Identifier: GPL-3.0-or-later
//! The top tree over the instances that rays may meet, brought up to date when some of them moved, came or went.
//! Source: [WBS03a], the paper's section 6. Space: world.
//! It has an entry for each instance of the scene, so that hits name those. If most of them changed, as at
//! first, it is built; else it is an update of the previous one, which frames in flight keep. Tests:
//! crates/render/tests/{commit,edits}.rs.

use std::sync::Arc;

use gnurt_accel::threads::extend;
use gnurt_accel::{BuildOptions, Instance, ObjectTree, SceneTree, SharedList, Threads};
use gnurt_scene::Scene;

use super::instance::InstanceSlot;

/// The top tree over instances as they are now, where those of `changed`, ascending, are others than `before`.
pub(super) fn after(
    before: &SceneTree,
    scene: &Scene,
    instances: &SharedList<InstanceSlot>,
    changed: &[u32],
    pool: &rayon::ThreadPool,
) -> Arc<SceneTree> {
    let shown = |index: usize| {
        let placed = instances[index].placed()?;
        let shape = placed.object.shape();
        let instance = match &placed.motion {
            Some(motion) => Instance::moving(shape, motion.clone()),
            None => Instance::new(shape, scene.instances()[index].world_from_object.columns),
        };
        Some(instance.with_mask(placed.mask.0))
    };
    let threads = Threads::Pool(pool);
    let tree = if changed.len() > instances.len() / 2 {
        let nothing = Arc::new(ObjectTree::build(&[], &BuildOptions::default(), Threads::Single));
        let shown_or_nothing =
            |index: usize| shown(index).unwrap_or_else(|| Instance::identity(nothing.clone()));
        let mut list: Vec<Instance> = Vec::new();
        pool.install(|| extend(true, &mut list, instances.len(), shown_or_nothing));
        SceneTree::build(&list, &BuildOptions::default(), threads)
    } else {
        let change = |n: usize| (changed[n], shown(changed[n] as usize));
        let mut changes: Vec<(u32, Option<Instance>)> = Vec::new();
        let few = if changed.len() > FEW { threads } else { Threads::Single };
        few.run(|parallel| extend(parallel, &mut changes, changed.len(), change));
        before.updated(instances.len(), &changes, threads)
    };
    Arc::new(tree)
}

/// Instances that are not worth a thread.
const FEW: usize = 64;

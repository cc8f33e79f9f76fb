// SPDX-License-Identifier: GPL-3.0-or-later
//! Many objects of one kind, each in its own pose: trees that share their structure; equal poses share one
//! tree. [SIP06], section 6, requests it. Space: object.
//! Invariant: a tree is that of its pose, independent of the order of requests. Tests: `tests/poses.rs`.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::{Arc, Mutex, OnceLock, PoisonError, Weak};

use gnurt_accel_core::geometry::GeometryKind;

use crate::{BuildOptions, Geometry, ObjectTree, Threads};

/// The poses of one object. Threads may request several at a time.
#[derive(Debug, Default)]
pub struct Crowd {
    /// Built over the first pose; all others share its structure.
    first: OnceLock<ObjectTree>,
    /// By the hash of their positions. Dropped with their last user.
    poses: Mutex<HashMap<u64, Vec<Weak<ObjectTree>>>>,
}

/// The largest expected cost of rays through a pose, relative to the first one; a pose beyond that gets a
/// tree of its own. Characters stay below 1.5; unrelated shapes with the same triangles come to 3 and more.
pub(crate) const MOST_GROWTH: f64 = 2.0;

impl Crowd {
    /// The tree over an object in this pose. The first one is built, in the quality of `options`; others
    /// share its structure, and an equal pose that is still in use is that tree. An object that cannot share,
    /// because it has other triangles than the first, or fits badly under its structure, is built separately;
    /// so are all objects under kd-trees.
    #[must_use]
    pub fn pose(&self, geometries: &[Geometry], options: &BuildOptions, threads: Threads) -> Arc<ObjectTree> {
        let key = mixed(geometries);
        if let Some(known) = self.known(key, geometries) {
            return known;
        }
        match self.first(geometries, options, threads).posed_from(geometries, threads) {
            Ok(tree) if tree.cost_growth() <= MOST_GROWTH => self.keep(key, geometries, Arc::new(tree)),
            _ => Arc::new(ObjectTree::build_from(geometries, options, threads)),
        }
    }

    /// Builds the structure that poses share, over this one, unless it exists. Call this before requests for
    /// many poses at a time by threads of one pool: threads that enter [`pose`](Self::pose) together and find
    /// no structure build it each for itself, and all but one of these trees are dropped.
    pub fn prepare(&self, geometries: &[Geometry], options: &BuildOptions, threads: Threads) {
        self.first(geometries, options, threads);
    }

    /// Not built inside of the lock: a thread that waits for others takes up their work, and that may be a pose of this crowd.
    fn first(&self, geometries: &[Geometry], options: &BuildOptions, threads: Threads) -> &ObjectTree {
        if let Some(first) = self.first.get() {
            return first;
        }
        let built = ObjectTree::build_from(geometries, options, threads);
        // Only the shared part of it must stay.
        let shared = built.posed_from(geometries, threads).unwrap_or(built);
        // A second thread takes the tree of the first.
        self.first.get_or_init(|| shared)
    }

    /// The number of poses in use.
    #[must_use]
    pub fn poses(&self) -> usize {
        let poses = self.poses.lock().unwrap_or_else(PoisonError::into_inner);
        poses.values().flatten().filter(|pose| pose.strong_count() > 0).count()
    }

    fn known(&self, key: u64, geometries: &[Geometry]) -> Option<Arc<ObjectTree>> {
        let same: Vec<Arc<ObjectTree>> = {
            let poses = self.poses.lock().unwrap_or_else(PoisonError::into_inner);
            poses.get(&key)?.iter().filter_map(Weak::upgrade).collect()
        };
        same.into_iter().find(|tree| tree.is_pose_of(geometries))
    }

    /// Stores a pose, and drops some unused ones. If another thread has stored the same one, that is
    /// returned.
    fn keep(&self, key: u64, geometries: &[Geometry], tree: Arc<ObjectTree>) -> Arc<ObjectTree> {
        if let Some(known) = self.known(key, geometries) {
            return known;
        }
        let mut poses = self.poses.lock().unwrap_or_else(PoisonError::into_inner);
        // Now and then, so that it costs little for each.
        if poses.len() == poses.capacity() {
            poses.retain(|_, same| same.iter().any(|pose| pose.strong_count() > 0));
        }
        match poses.entry(key) {
            Entry::Occupied(mut same) => same.get_mut().push(Arc::downgrade(&tree)),
            Entry::Vacant(vacant) => drop(vacant.insert(vec![Arc::downgrade(&tree)])),
        }
        tree
    }
}

/// The bits of all positions of surfaces, mixed. Equal positions have equal hashes; different ones seldom do.
fn mixed(geometries: &[Geometry]) -> u64 {
    let mut lanes = [0x9e37_79b9_7f4a_7c15_u64; 4];
    for geometry in geometries {
        let positions = match &geometry.kind {
            GeometryKind::Triangles(mesh) => mesh.positions,
            GeometryKind::Quads(mesh) => mesh.positions,
            _ => &[],
        };
        lanes[0] ^= positions.len() as u64;
        let floats = positions.as_flattened();
        let parts = floats.chunks(8);
        for eight in parts {
            for (lane, two) in lanes.iter_mut().zip(eight.chunks(2)) {
                let value = two.iter().fold(0, |value: u64, x| value << 32 | u64::from(x.to_bits()));
                *lane = (*lane ^ value).wrapping_mul(0xff51_afd7_ed55_8ccd).rotate_left(29);
            }
        }
    }
    lanes
        .into_iter()
        .fold(0, |sum: u64, lane| (sum ^ lane).rotate_left(17).wrapping_mul(0xc4ce_b9fe_1a85_ec53))
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Objects of the same triangles at different vertices: characters of one kind, each in its own pose. Many of
//! them share the structure of one tree automatically. [SIP06], section 6, requests it. When it pays is in
//! docs/explanation/moving.md.
//! Invariant: hits do not depend on it. Tests: `tests`, crates/render/tests/commit.rs.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError, Weak};

use gnurt_accel::Crowd;
use gnurt_scene::Mesh;

/// Fewer objects than this stay by themselves, and so do all that have fewer triangles than this together: trees by themselves
/// are faster as long as they fit into the caches.
const MANY: usize = 8;
const MANY_TRIANGLES: usize = 200_000;

/// A topology, held by each object that has it.
pub(super) struct Kind {
    triangles: usize,
    /// The trees of sharing objects.
    pub(super) crowd: Crowd,
}

/// The topologies that there are. Copies of a world share them.
#[derive(Clone, Default)]
pub(super) struct Crowds(Arc<Mutex<HashMap<[u64; 2], Weak<Kind>>>>);

impl Crowds {
    /// The topology of these meshes.
    pub(super) fn kind_of(&self, meshes: &[Arc<Mesh>]) -> Arc<Kind> {
        let key = key(meshes);
        let mut kinds = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        // Now and then, so that it costs little for each.
        if kinds.len() == kinds.capacity() {
            kinds.retain(|_, kind| kind.strong_count() > 0);
        }
        let known = kinds.entry(key).or_default();
        known.upgrade().unwrap_or_else(|| {
            let triangles = meshes.iter().map(|mesh| mesh.indices.len()).sum();
            let kind = Arc::new(Kind { triangles, crowd: Crowd::default() });
            *known = Arc::downgrade(&kind);
            kind
        })
    }
}

impl Kind {
    /// Whether it has enough objects for sharing.
    pub(super) fn is_of_many(self: &Arc<Self>) -> bool {
        let count = Arc::strong_count(self);
        count >= MANY && count * self.triangles >= MANY_TRIANGLES
    }
}

/// Triangles and numbers of vertices, mixed. Should others ever come to the same, a crowd finds that out, and builds for them.
fn key(meshes: &[Arc<Mesh>]) -> [u64; 2] {
    const BY: [u64; 4] =
        [0x9e37_79b9_7f4a_7c15, 0xff51_afd7_ed55_8ccd, 0xc4ce_b9fe_1a85_ec53, 0xd6e8_feb8_6659_fd93];
    let mut lanes = BY;
    let mut mix = |values: [u32; 4]| {
        for ((lane, value), by) in lanes.iter_mut().zip(values).zip(BY) {
            *lane = (*lane ^ u64::from(value)).wrapping_mul(by).rotate_left(29);
        }
    };
    for mesh in meshes {
        let [vertices, triangles] = [mesh.positions.len(), mesh.indices.len()].map(|n| n as u32);
        mix([vertices, triangles, 1, 2]);
        let (fours, rest) = mesh.indices.as_flattened().as_chunks::<4>();
        fours.iter().for_each(|&four| mix(four));
        rest.iter().for_each(|&one| mix([one, 3, 4, 5]));
    }
    let [a, b, c, d] = lanes;
    let fold =
        |x: u64, y: u64| (x ^ y.rotate_left(31)).wrapping_mul(BY[0]).rotate_left(33).wrapping_mul(BY[1]);
    [fold(fold(a, b), fold(c, d)), fold(fold(d, a), fold(b, c))]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh(shift: f32, last: u32) -> Vec<Arc<Mesh>> {
        let positions = vec![[shift; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let indices = vec![[0, 1, last]; MANY_TRIANGLES / MANY];
        vec![Arc::new(Mesh { positions, indices, ..Mesh::default() })]
    }

    #[test]
    fn many_of_a_kind_are_found() {
        let crowds = Crowds::default();
        let mut kinds: Vec<Arc<Kind>> = (0..MANY).map(|i| crowds.kind_of(&mesh(i as f32, 2))).collect();
        let other = crowds.kind_of(&mesh(0.0, 3));
        assert!(kinds[0].is_of_many() && !other.is_of_many(), "eight are many, one is not");
        assert!(kinds.iter().all(|kind| Arc::ptr_eq(kind, &kinds[0])), "they are of one kind");
        kinds.pop();
        assert!(!kinds[0].is_of_many(), "seven are not");
        drop((kinds, other));
        for i in 0..100 {
            crowds.kind_of(&mesh(0.0, i % 4));
        }
        let cached = crowds.0.lock().expect("nobody panics").len();
        assert!(cached <= 8, "{cached} kinds are remembered");
    }
}

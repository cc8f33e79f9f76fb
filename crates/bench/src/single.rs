// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays with times, traced in Embree one by one, and whether both engines hit the same.
//! Tests: `tests::other_answers_are_counted`, and the tests of the benchmarks that use it.

use gnurt::accel::{HitBatch, INVALID_ID, RayBatch};

use crate::ffi_embree::{Active, Arguments, Packet, Scene};

/// Embree's closest hits: instance, primitive and distance.
pub(crate) fn closest(scene: &Scene, rays: &RayBatch, hits: &mut HitBatch) {
    let (arguments, active) = (Arguments::new(false), Active([-1; 1]));
    let mut packet = Packet::<1>::new();
    hits.reset(rays.len());
    for i in 0..rays.len() {
        let ray = rays.get(i);
        for k in 0..3 {
            (packet.org[k], packet.dir[k]) = ([ray.org[k]], [ray.dir[k]]);
        }
        (packet.t_near, packet.t_far) = ([ray.t_near], [ray.t_far]);
        (packet.time, packet.geom_id, packet.inst_id) = ([ray.time], [INVALID_ID], [INVALID_ID]);
        scene.intersect(&active, &mut packet, &arguments);
        if packet.geom_id[0] != INVALID_ID {
            hits.t[i] = packet.t_far[0];
            (hits.prim_id[i], hits.inst_id[i]) = (packet.prim_id[0], packet.inst_id[0]);
        }
    }
}

/// Rays that hit something.
pub(crate) fn hit_count(hits: &HitBatch) -> usize {
    hits.prim_id.iter().filter(|&&id| id != INVALID_ID).count()
}

/// Whether both hit the same instances at the same distances, to `tolerance` of a distance, except for one
/// ray in `one_in`: Embree's default test is not watertight, its arithmetic differs, and neighbours meet at
/// edges.
pub(crate) fn agree(ours: &HitBatch, theirs: &HitBatch, tolerance: f32, one_in: usize) -> Result<(), String> {
    let differs = |&i: &usize| {
        let (t, other) = (ours.t[i], theirs.t[i]);
        let is_near = t == other || (t - other).abs() <= tolerance * t.min(other).max(1e-3);
        // A scene of one mesh has no instances to Embree, and one to us.
        let instance = theirs.inst_id[i];
        !is_near || (instance != INVALID_ID && instance != ours.inst_id[i])
    };
    let count = theirs.t.len();
    let wrong = (0..count).filter(differs).count();
    match wrong * one_in > count {
        true => Err(format!("{wrong} of {count} rays hit something else than ours")),
        false => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_answers_are_counted() {
        let hits = |t: f32, inst_id: u32| HitBatch {
            t: vec![1.0, t],
            prim_id: vec![0, INVALID_ID],
            inst_id: vec![3, inst_id],
            ..HitBatch::default()
        };
        let ours = hits(f32::INFINITY, INVALID_ID);
        assert_eq!(agree(&ours, &ours, 1e-4, 1000), Ok(()), "misses are equal");
        assert_eq!(hit_count(&ours), 1);
        for other in [hits(2.0, INVALID_ID), hits(f32::INFINITY, 4)] {
            assert!(agree(&ours, &other, 1e-4, 2).is_ok(), "one of two may differ");
            let why = agree(&ours, &other, 1e-4, 3).expect_err("one of two is too many");
            assert!(why.contains("1 of 2 rays"), "{why}");
        }
    }
}

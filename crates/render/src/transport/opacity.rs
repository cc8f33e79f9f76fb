// SPDX-License-Identifier: GPL-3.0-or-later
//! Surfaces that are there in part: a path meets one with the probability that it covers, else it goes straight on; a
//! shadow ray goes through with the share that is left.
//! Invariant: a layer's chance is of the path's key as it was sent through the layers before.
//! Tests: crates/render/tests/{path,many_lights}.rs.

use glam::Vec3;
use gnurt_accel::Ray;
use gnurt_shading::SampleKey;
use gnurt_shading::sampling::{purpose, sample_pair};

/// See-through surfaces that a ray may pass between two vertices; behind more it is dark.
pub(crate) const MOST_LAYERS: u32 = 256;
/// Branch of a path's key where it goes straight on.
const STRAIGHT: u32 = 2;

/// Whether a path with this number of edges hits a surface of this coverage; else it passes through.
pub(crate) fn is_met(seed: u64, key: SampleKey, edges: u32, coverage: f32) -> bool {
    coverage >= 1.0 || probability(seed, key, edges) < coverage
}

/// The number in [0, 1) by which a path with this number of edges decides that.
pub(crate) fn probability(seed: u64, key: SampleKey, edges: u32) -> f32 {
    sample_pair(seed, key, edges, purpose::COVERAGE)[0]
}

/// For paths with one number in [0, 1) for all layers of an edge: the number that decides about the next layer; `None` = this one is met.
pub(crate) fn passed(probability: f32, coverage: f32) -> Option<f32> {
    let goes_on = coverage < 1.0 && probability >= coverage;
    goes_on.then(|| ((probability - coverage) / (1.0 - coverage)).min(1.0 - f32::EPSILON / 2.0))
}

/// The remainder of a ray after a surface, from `onward`. It ends where the original ray ends: rays leave
/// surfaces with a small offset, and a surface behind the end, such as the light itself, must stay behind it.
pub(crate) fn rest(ray: &Ray, onward: Ray) -> Ray {
    if !ray.t_far.is_finite() {
        return onward;
    }
    let dir = Vec3::from(ray.dir);
    let offset = Vec3::from(ray.org) + dir * ray.t_far - Vec3::from(onward.org);
    onward.within(0.0, (offset.dot(dir) * (1.0 - 4.0 * f32::EPSILON)).max(0.0))
}

/// The key of a path that passed a transparent part.
pub(crate) fn key_beyond(key: SampleKey) -> SampleKey {
    key.fork(STRAIGHT)
}

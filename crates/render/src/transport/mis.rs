// SPDX-License-Identifier: GPL-3.0-or-later
//! Weights of light that two strategies sample. Source: [VG95]: the power heuristic (exponent 2) for paths,
//! which choose between one light sample and one ray; the balance heuristic where either way takes several
//! samples, or virtual lights are made both ways.
//! Invariant: `w(a, b) + w(b, a)` is 1 for either where a density is above zero and both are finite.
//! Tests: `tests::weights_add_up`.

use glam::Vec3;
use gnurt_shading::lights::LightSet;
use gnurt_shading::real::Real;

use super::paths::{Origin, Path};
use crate::guide::Recorder;

/// Weight of a sample with density `own` if another technique has density `other`; of one point or of many.
#[inline(always)]
pub(crate) fn power_heuristic<R: Real>(own: R, other: R) -> R {
    let (zero, one) = (own.all(0.0), own.all(1.0));
    // The ratio is squared, not the densities: these may be huge or tiny.
    let ratio = other / own;
    let weight = R::pick(own.above(zero), one / (one + ratio * ratio), zero);
    R::pick(own.is_number(), weight, one)
}

/// Weight of a sample with density `own` if another technique has density `other`, each times its number of
/// samples.
#[inline(always)]
pub(crate) fn balance_heuristic(own: f32, other: f32) -> f32 {
    own * over_both(own, other)
}

/// The same over `own`.
#[inline(always)]
pub(crate) fn over_both(own: f32, other: f32) -> f32 {
    1.0 / (own + other)
}

/// How much the light counts that a path's ray along `dir` found on shape `ids` (leaf, mesh, primitive) at `p`:
/// light samples find it, too.
pub(crate) fn weigh(lights: &LightSet, path: &Path, ids: [u32; 3], p: Vec3, dir: Vec3) -> f32 {
    let (Some(origin), Some(shape)) = (path.from, lights.shape(ids, dir)) else {
        return 1.0;
    };
    let dist = (p - origin.p).length();
    let pdf = if splits(lights, path.edges - 1) {
        lights.pdf_shape_in_group(origin.p, origin.ns, shape, dir, dist)
    } else {
        lights.pdf_shape(origin.p, origin.ns, shape, dir, dist)
    };
    power_heuristic(origin.pdf, pdf)
}

/// The same for light of the environment.
pub(crate) fn weigh_environment(lights: &LightSet, path: &Path, dir: Vec3) -> f32 {
    let Some(origin) = path.from else { return 1.0 };
    let pdf = if splits(lights, path.edges - 1) {
        lights.pdf_environment_in_group(origin.ns, dir)
    } else {
        lights.pdf_environment(origin.p, origin.ns, dir)
    };
    power_heuristic(origin.pdf, pdf)
}

/// The ratio of two weights of light that a path's ray along `dir` found: had its direction been chosen by lobes alone, over that which it has.
/// A guide learns the light that paths without it would find beside light samples, not light that only its pilot finds that often.
pub(crate) fn unguided_share(
    recorder: &Recorder,
    path: &Path,
    dir: Vec3,
    weight: impl Fn(&Path) -> f32,
) -> f32 {
    let (Some(origin), Some(pdf)) = (path.from, recorder.pdf_of_lobes(path.trail, dir)) else { return 1.0 };
    let now = weight(path);
    let by_lobes = weight(&Path { from: Some(Origin { pdf, ..origin }), ..*path });
    if now > 0.0 { by_lobes / now } else { 1.0 }
}

/// Whether a vertex that a path reached by this number of edges samples each group of lights. Of several only the first
/// does, because its noise is seen most, and longer paths would send more rays for less. One group is sampled by all.
pub(crate) fn splits(lights: &LightSet, edges: u32) -> bool {
    let groups = lights.split_groups().len();
    groups == 1 || groups > 1 && edges == 1
}

/// How many lights a vertex samples at most.
pub(crate) fn most_light_samples(lights: &LightSet) -> usize {
    lights.split_groups().len().max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_add_up() {
        for (a, b) in [(1.0_f32, 1.0), (1e-30, 1e30), (3.0, 0.5), (1e38, 1e-3), (0.2, 0.0)] {
            let sum = power_heuristic(a, b) + power_heuristic(b, a);
            assert!((sum - 1.0).abs() < 1e-6, "{a} and {b}: {sum}");
        }
        for (a, b) in [(1.0, 1.0), (3.0, 0.5), (0.2, 0.0)] {
            let sum = balance_heuristic(a, b) + balance_heuristic(b, a);
            assert!((sum - 1.0).abs() < 1e-6, "{a} and {b}: {sum}");
        }
        assert_eq!(balance_heuristic(3.0, 1.0), 0.75, "by the densities");
        assert_eq!(power_heuristic(3.0_f32, 1.0), 0.9, "by the squares");
        assert_eq!(power_heuristic(0.0_f32, 0.0), 0.0, "what is not sampled has no weight");
    }
}

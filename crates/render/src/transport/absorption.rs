// SPDX-License-Identifier: GPL-3.0-or-later
//! Absorption between surfaces along paths from the eye.
//! Source: Beer's law; the rule is that of `gnurt_shading::bsdf::Medium`. Space: world.
//! A segment through transparent parts is one segment: it ends where the path stops. Invariant: worlds
//! without media skip this.
//! Tests: crates/render/tests/agreement.rs.

use gnurt_shading::SurfaceBatch;
use gnurt_shading::bsdf::{ClosureBatch, left_after};

use super::opacity;
use super::paths::Paths;
use crate::options::RenderOptions;
use crate::world::HitLanes;

/// Applies the absorption along these paths, up to the points that stop them.
pub(crate) fn absorb(
    options: &RenderOptions,
    (paths, from): (&mut Paths, HitLanes),
    numbers: &[u32],
    points: &SurfaceBatch,
    closures: &ClosureBatch,
) {
    if !paths.has_media() {
        return;
    }
    for (k, &number) in numbers.iter().enumerate() {
        let number = number as usize;
        let path = paths.get(number, from.keys[number]);
        if closures.is_partly_transparent()
            && !opacity::is_met(options.seed, path.key, path.edges, closures.coverage(k))
        {
            continue;
        }
        let left = left_after(
            (points.p.get(k) - path.start).length(),
            [path.absorption, closures.medium(k).on(true)],
        );
        paths.dim(number, left);
    }
}

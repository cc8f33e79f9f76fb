// SPDX-License-Identifier: GPL-3.0-or-later
//! Points of surfaces at which chains of a search go on: delta lobes that follow the mesh's own normals.
//! A path that is mirrored or refracted at such points only is one that a search can find. Normals by maps, dispersion, curves
//! and bent normals at grazing angles are left to scattered rays. Space: world.
//! Invariant: searches and paths decide by this one rule, so that no light counts twice.
//! Tests: crates/render/tests/caustics.rs.

use glam::Vec3;
use gnurt_shading::bsdf::{Bsdf, ClosureBatch};
use gnurt_shading::{SurfaceBatch, SurfacePoint};

use super::differential::{mirrored, refracted};
use super::known::Caustics;
use crate::world::{Bend, World};

/// The largest square of the difference of directions that are one.
const SAME: f32 = 1e-6;

/// Such a point.
#[derive(Clone, Debug)]
pub(crate) struct SmoothPoint {
    pub(super) point: SurfacePoint,
    pub(super) bsdf: Bsdf,
    pub(super) bend: Bend,
    /// Index on the side of the ray over that beyond.
    pub(super) eta: f32,
    /// Where light is mirrored and where it goes through, with its share.
    pub(super) branches: [Option<(Vec3, Vec3)>; 2],
}

impl SmoothPoint {
    /// Point `k`, if it is one.
    pub(crate) fn of(
        (world, caustics): (&World, &Caustics),
        (points, closures): (&SurfaceBatch, &ClosureBatch),
        k: usize,
    ) -> Option<Self> {
        if !caustics.is_smooth(world.material_of(points.leaf_id[k], points.geom_id[k])) {
            return None;
        }
        let bsdf = closures.point(k).bsdf;
        if !bsdf.has_deltas() || bsdf.is_dispersed() {
            return None;
        }
        let (point, dir) = (points.point(k), points.ray_dir.get(k));
        let eta = bsdf.etas().x;
        let expected = [Some(mirrored(dir, point.ns)), refracted(dir, point.ns, eta)];
        let mut branches = [None; 2];
        for (k, (branch, expected)) in bsdf.delta_branches(-dir).into_iter().zip(expected).enumerate() {
            let (Some(sample), Some(expected)) = (branch, expected) else { continue };
            if sample.wi.distance_squared(expected) < SAME && sample.weight != Vec3::ZERO {
                branches[k] = Some((sample.wi, sample.weight));
            }
        }
        if branches == [None; 2] {
            return None;
        }
        let bend = world.bend(points, k, &point)?;
        Some(Self { point, bsdf, bend, eta, branches })
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Hits of `gnurt/rays.h`, in double precision whatever the scene is in. Tests: `tests/c/rays.c`, `tests/c/doubles.c`.

use gnurt_accel::doubles::{DoubleHit, DoublePoint};
use gnurt_accel::{Hit, PointHit};

use crate::ray_scene::{Built, query_tree};

/// A hit with the trees' ids, or a nearest point at its distance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Found {
    pub(crate) t: f64,
    pub(crate) u: f64,
    pub(crate) v: f64,
    pub(crate) prim_id: u32,
    pub(crate) geom_id: u32,
    pub(crate) inst_id: u32,
    pub(crate) leaf_id: u32,
}

impl From<Hit> for Found {
    fn from(Hit { t, u, v, prim_id, geom_id, inst_id, leaf_id }: Hit) -> Self {
        Self { t: t.into(), u: u.into(), v: v.into(), prim_id, geom_id, inst_id, leaf_id }
    }
}

impl From<DoubleHit> for Found {
    fn from(DoubleHit { t, u, v, prim_id, geom_id, inst_id, leaf_id }: DoubleHit) -> Self {
        Self { t, u, v, prim_id, geom_id, inst_id, leaf_id }
    }
}

impl From<PointHit> for Found {
    fn from(near: PointHit) -> Self {
        let PointHit { distance: t, u, v, prim_id, geom_id, inst_id, leaf_id, .. } = near;
        Self { t, u: u.into(), v: v.into(), prim_id, geom_id, inst_id, leaf_id }
    }
}

impl From<DoublePoint> for Found {
    fn from(near: DoublePoint) -> Self {
        let DoublePoint { distance: t, u, v, prim_id, geom_id, inst_id, leaf_id, .. } = near;
        Self { t, u, v, prim_id, geom_id, inst_id, leaf_id }
    }
}

/// The unit normal of a hit at a point; zeros where there is none.
pub(crate) fn normal(built: &Built, hit: &Found, at: impl FnOnce() -> [f64; 3]) -> [f64; 3] {
    if let Some(doubles) = &built.doubles {
        return doubles.normal(hit.leaf_id, hit.geom_id, hit.prim_id);
    }
    let [t, u, v] = [hit.t, hit.u, hit.v].map(|x| x as f32);
    let Found { prim_id, geom_id, inst_id, leaf_id, .. } = *hit;
    let hit = Hit { t, u, v, prim_id, geom_id, inst_id, leaf_id };
    query_tree!(built, tree => tree.normal_at(&hit, at())).unwrap_or_default().map(f64::from)
}

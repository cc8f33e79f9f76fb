// SPDX-License-Identifier: GPL-3.0-or-later
//! Eight rays that are traced together, and the best hits of each.
//! Source: the paper's section 5.1 (rays in SIMD lanes), widened from four to eight.
//! Space: as the rays that went in.
//! Invariant: lanes outside `active` hold a copy of an active lane's ray (`RayTile::gather`), so that no garbage meets the
//! arithmetic.

use gnurt_accel_core::nearest::{Kind, closer};
use gnurt_accel_core::tile::{NearestTile, PerRay, RayTile};
use gnurt_simd::{Simd, f32x8, mask32x8, prelude::*, u32x8};

/// Rays per packet.
pub(crate) const WIDTH: usize = 8;

/// Rays in lanes.
#[derive(Clone, Copy)]
pub(crate) struct RayPacket<S: Simd> {
    pub(crate) org: [f32x8<S>; 3],
    pub(crate) dir: [f32x8<S>; 3],
    pub(crate) t_near: f32x8<S>,
    pub(crate) active: mask32x8<S>,
}

/// Best hits in lanes; see `Nearest`.
#[derive(Clone, Copy)]
pub(crate) struct NearestPacket<S: Simd> {
    pub(crate) t: f32x8<S>,
    pub(crate) u: f32x8<S>,
    pub(crate) v: f32x8<S>,
    pub(crate) number: u32x8<S>,
    pub(crate) slot: u32x8<S>,
}

/// Where lanes meet a triangle.
#[derive(Clone, Copy)]
pub(crate) struct HitPacket<S: Simd> {
    pub(crate) t: f32x8<S>,
    pub(crate) u: f32x8<S>,
    pub(crate) v: f32x8<S>,
    /// Lanes that do.
    pub(crate) hit: mask32x8<S>,
}

impl<S: Simd> RayPacket<S> {
    /// Rays `first..first + 8` of a tile, of which those in `active` count, and the first does.
    #[inline(always)]
    pub(crate) fn from_tile(simd: S, rays: &RayTile, first: usize, active: mask32x8<S>) -> Self {
        let load = |values: &PerRay| f32x8::from_slice(simd, &values[first..first + WIDTH]);
        let org = [load(&rays.org[0]), load(&rays.org[1]), load(&rays.org[2])];
        let dir = [load(&rays.dir[0]), load(&rays.dir[1]), load(&rays.dir[2])];
        Self { org, dir, t_near: load(&rays.t_near), active }
    }
}

impl<S: Simd> NearestPacket<S> {
    /// Lanes `first..first + 8` of a tile.
    #[inline(always)]
    pub(crate) fn load(simd: S, tile: &NearestTile, first: usize) -> Self {
        let load = |values: &PerRay| f32x8::from_slice(simd, &values[first..first + WIDTH]);
        let number = u32x8::from_slice(simd, &tile.number[first..first + WIDTH]);
        let slot = u32x8::from_slice(simd, &tile.slot[first..first + WIDTH]);
        Self { t: load(&tile.t), u: load(&tile.u), v: load(&tile.v), number, slot }
    }

    /// Puts them back.
    #[inline(always)]
    pub(crate) fn store(&self, tile: &mut NearestTile, first: usize) {
        self.t.store_slice(&mut tile.t[first..first + WIDTH]);
        self.u.store_slice(&mut tile.u[first..first + WIDTH]);
        self.v.store_slice(&mut tile.v[first..first + WIDTH]);
        self.number.store_slice(&mut tile.number[first..first + WIDTH]);
        self.slot.store_slice(&mut tile.slot[first..first + WIDTH]);
    }

    /// `Nearest::offer` in lanes.
    #[inline(always)]
    pub(crate) fn offer(&mut self, simd: S, kind: Kind, hits: &HitPacket<S>, number: u32, slot: u32) {
        let (number, slot) = (u32x8::splat(simd, number), u32x8::splat(simd, slot));
        let (t, better) = match kind {
            Kind::Any => (f32x8::splat(simd, f32::NEG_INFINITY), hits.hit),
            Kind::Closest => {
                let closer = closer([hits.t, self.t], [slot, self.slot], [number, self.number]);
                (hits.t, hits.hit & closer)
            }
        };
        self.t = better.select(t, self.t);
        self.u = better.select(hits.u, self.u);
        self.v = better.select(hits.v, self.v);
        self.number = better.select(number, self.number);
        self.slot = better.select(slot, self.slot);
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Up to sixteen rays without heap memory: queries of programs with a few rays at a time.
//! Space: that of the queried structure.
//! Invariant: the result of a ray is that of the same ray by itself. Tests: `tests/packets.rs`.

use gnurt_accel_core::bits::{all, each};
use gnurt_accel_core::nearest::Kind;
use gnurt_accel_core::tile::{LANES, NearestTile, RayTile};
use gnurt_accel_core::traversal::TileTraversal;

use crate::batch_run::by_mask;
use crate::engine::Engine;
use crate::target::Target;
use crate::{Coherence, Counters, Hit, Query, Ray};

/// Up to [`MOST`](Self::MOST) rays of one query.
#[derive(Clone, Debug)]
pub struct Packet {
    rays: RayTile,
    nearest: NearestTile,
    masks: [u32; LANES],
    count: usize,
}

impl Packet {
    /// Rays that fit.
    pub const MOST: usize = LANES;

    /// No rays.
    #[must_use]
    #[inline]
    pub fn new() -> Self {
        Self { rays: RayTile::EMPTY, nearest: NearestTile::EMPTY, masks: [0; LANES], count: 0 }
    }

    /// Number of rays.
    #[must_use]
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Puts a ray behind the others. Panics where [`MOST`](Self::MOST) are there.
    #[inline]
    pub fn push(&mut self, ray: &Ray) {
        let lane = self.count;
        self.masks[lane] = ray.mask;
        for k in 0..3 {
            self.rays.org[k][lane] = ray.org[k];
            self.rays.dir[k][lane] = ray.dir[k];
        }
        self.rays.t_near[lane] = ray.t_near;
        self.rays.time[lane] = ray.time;
        self.rays.is_timed |= ray.time != 0.0;
        self.nearest.t[lane] = ray.t_far;
        self.count += 1;
    }
}

impl Default for Packet {
    fn default() -> Self {
        Self::new()
    }
}

impl Target<'_> {
    /// Traces the rays of a packet, which then is used up, and says which of them have hit something, as bits.
    fn packet(self, query: &Query, packet: &mut Packet, kind: Kind) -> u64 {
        let engine = Engine::at(query.level);
        let Packet { rays, nearest, masks, count } = packet;
        let sound = engine.tiles.sound(rays, nearest) & all(*count);
        let incoherent = query.coherence == Coherence::Incoherent;
        if !incoherent && sound != 0 && sound == all(*count) {
            let direction_classes = engine.tiles.direction_classes(rays);
            let (direction_class, alike) = direction_classes.like(0, sound & direction_classes.regular);
            if alike == sound {
                rays.set_coherent(*count, direction_class, nearest);
            }
        }
        let counters = &mut Counters::default();
        let see = |i: usize| masks[i % LANES] & query.mask;
        let is_shared = masks[..*count].iter().all(|&mask| mask == masks[0]);
        by_mask(rays, sound, is_shared, see, |rays, active| {
            self.tile(
                engine,
                &mut TileTraversal { rays, active, kind, slot: 0, nearest, counters },
                incoherent,
            );
        });
        sound & engine.tiles.hit(nearest)
    }

    /// Reports the closest hit of each ray of a packet that has one.
    pub(crate) fn closest_of_packet(
        self,
        query: &Query,
        mut packet: Packet,
        mut report: impl FnMut(usize, Hit),
    ) {
        let hit = self.packet(query, &mut packet, Kind::Closest);
        each(hit, |i| report(i, self.hit(&packet.nearest.get(i))));
    }

    /// Which rays of a packet hit anything, as bits.
    pub(crate) fn any_of_packet(self, query: &Query, mut packet: Packet) -> u64 {
        self.packet(query, &mut packet, Kind::Any)
    }
}

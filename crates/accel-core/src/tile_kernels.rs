// SPDX-License-Identifier: GPL-3.0-or-later
//! Operations on whole tiles outside of trees, sixteen rays at a time: a table of small functions for each
//! level.
//! Space: that of the rays.
//! Invariant: every level returns the same bits. Tests: `tests::direction_classes_split_a_tile`,
//! `tests/pencils.rs` and `tests/instances.rs` of `gnurt-accel`.

use std::marker::PhantomData;

use gnurt_simd::{Simd, Token, by_level, f32x16, kernel, mask32x16, prelude::*, u32x16};

use crate::affine::ObjectFromWorld;
use crate::bits::TILE;
use crate::direction_class::DirectionClasses;
use crate::hit::{HitBatch, INVALID_ID};
use crate::ray::Ray;
use crate::ray_batch::RayBatch;
use crate::tile::{LANES, NearestTile, PerRay, RayTile, chunk};

/// The operations of one level on tiles. Made by [`TileKernels::of`]; its functions run with that level's
/// instructions.
#[derive(Clone, Copy)]
pub struct TileKernels {
    token: Token,
    table: &'static Table,
}

struct Table {
    sound: fn(Token, &RayTile, &NearestTile) -> u64,
    direction_classes: fn(Token, &RayTile) -> DirectionClasses,
    codes: fn(Token, &DirectionClasses, u64) -> [u32; TILE],
    hit: fn(Token, &NearestTile) -> u64,
    fill: fn(Token, &mut RayTile, [f32; 3], &mut NearestTile) -> u64,
    carry: fn(Token, &ObjectFromWorld, &RayTile, &mut RayTile),
    load: fn(Token, &RayBatch, usize, &mut RayTile, &mut NearestTile) -> u64,
    store: fn(Token, &NearestTile, OfOneObject, &mut HitBatch, usize),
}

/// Instance and number of an object, and the first numbers of its meshes but the first.
type OfOneObject<'a> = ([u32; 2], &'a [u32]);

struct For<S>(PhantomData<S>);

impl<S: Simd> For<S> {
    const TABLE: Table = Table {
        sound: kernel!(S, |simd, rays, nearest| sound(simd, rays, nearest)),
        direction_classes: kernel!(S, |simd, rays| direction_classes(simd, rays)),
        codes: kernel!(S, |simd, direction_classes, sound| codes(simd, direction_classes, sound)),
        hit: kernel!(S, |simd, nearest| hit(simd, nearest)),
        fill: kernel!(S, |simd, rays, org, nearest| fill(simd, rays, org, nearest)),
        carry: kernel!(S, |simd, map, rays, inside| carry(simd, map, rays, inside)),
        load: kernel!(S, |simd, batch, first, rays, nearest| load(simd, batch, first, rays, nearest)),
        store: kernel!(S, |simd, nearest, object, hits, first| store(simd, nearest, object, hits, first)),
    };
}

impl TileKernels {
    /// Those of a level.
    #[must_use]
    pub fn of(token: Token) -> Self {
        Self { token, table: by_level!(token, S => &For::<S>::TABLE) }
    }

    /// Bits of the rays that can hit something: [`Ray::is_sound`] for each.
    #[inline]
    #[must_use]
    pub fn sound(&self, rays: &RayTile, nearest: &NearestTile) -> u64 {
        (self.table.sound)(self.token, rays, nearest)
    }

    /// The direction classes of the rays.
    #[inline]
    #[must_use]
    pub fn direction_classes(&self, rays: &RayTile) -> DirectionClasses {
        (self.table.direction_classes)(self.token, rays)
    }

    /// The direction class of each ray as a number below [`DirectionClasses::CODES`]; a special one for rays
    /// that are not in `sound`.
    #[inline]
    #[must_use]
    pub fn codes(&self, direction_classes: &DirectionClasses, sound: u64) -> [u32; TILE] {
        (self.table.codes)(self.token, direction_classes, sound)
    }

    /// Bits of the rays that have hit something.
    #[inline]
    #[must_use]
    pub fn hit(&self, nearest: &NearestTile) -> u64 {
        (self.table.hit)(self.token, nearest)
    }

    /// Completes a tile of rays from one point with existing directions, and far ends in `nearest`, which is
    /// empty otherwise; returns bits of the valid ones. Other lanes get the direction of the first and no
    /// extent.
    #[inline]
    pub fn fill(&self, rays: &mut RayTile, org: [f32; 3], nearest: &mut NearestTile) -> u64 {
        (self.table.fill)(self.token, rays, org, nearest)
    }

    /// Carries the rays of a tile into the space of an instance.
    #[inline]
    pub fn carry(&self, map: &ObjectFromWorld, rays: &RayTile, inside: &mut RayTile) {
        (self.table.carry)(self.token, map, rays, inside);
    }

    /// Loads rays `first..first + 64` of a batch, which has as many; returns the bits of [`sound`](Self::sound).
    #[inline]
    pub fn load(&self, batch: &RayBatch, first: usize, rays: &mut RayTile, nearest: &mut NearestTile) -> u64 {
        (self.table.load)(self.token, batch, first, rays, nearest)
    }

    /// Writes a whole tile, whose hits are on few meshes of one object, from lane `first` on.
    #[inline]
    pub fn store(&self, nearest: &NearestTile, object: OfOneObject, hits: &mut HitBatch, first: usize) {
        (self.table.store)(self.token, nearest, object, hits, first);
    }
}

#[inline(always)]
fn sound<S: Simd>(simd: S, rays: &RayTile, nearest: &NearestTile) -> u64 {
    let (limit, most) = (f32x16::splat(simd, Ray::FARTHEST_ORIGIN), f32x16::splat(simd, f32::MAX));
    let zero = f32x16::splat(simd, 0.0);
    let mut bits = 0;
    for first in (0..TILE).step_by(LANES) {
        let mut sound = chunk(simd, &rays.t_near, first).simd_le(chunk(simd, &nearest.t, first));
        let mut moves = mask32x16::splat(simd, false);
        for k in 0..3 {
            let dir = chunk(simd, &rays.dir[k], first);
            sound &= chunk(simd, &rays.org[k], first).abs().simd_le(limit) & dir.abs().simd_le(most);
            moves |= dir.simd_ne(zero);
        }
        bits |= (sound & moves).to_bitmask() << first;
    }
    bits
}

#[inline(always)]
fn direction_classes<S: Simd>(simd: S, rays: &RayTile) -> DirectionClasses {
    let mut classes = DirectionClasses::default();
    let (short, long) = (f32x16::splat(simd, Ray::SHORTEST), f32x16::splat(simd, Ray::LONGEST));
    for first in (0..TILE).step_by(LANES) {
        let dir = rays.dir_lanes(simd, [0, 1, 2], first);
        let [x, y, z] = [dir[0].abs(), dir[1].abs(), dir[2].abs()];
        let longest = x.max(y).max(z);
        let regular = longest.simd_ge(short) & longest.simd_le(long);
        classes.regular |= regular.to_bitmask() << first;
        classes.along_x |= (x.simd_ge(y) & x.simd_ge(z)).to_bitmask() << first;
        classes.along_y |= y.simd_ge(z).to_bitmask() << first;
        for (backwards, dir) in classes.backwards.iter_mut().zip(dir) {
            *backwards |= dir.is_sign_negative().to_bitmask() << first;
        }
    }
    classes
}

#[inline(always)]
fn lanes<S: Simd>(simd: S, code: usize) -> u32x16<S> {
    u32x16::splat(simd, code as u32)
}

/// `code` for the lanes of the lowest sixteen bits.
#[inline(always)]
fn choose<S: Simd>(simd: S, bits: u64, code: usize, other: u32x16<S>) -> u32x16<S> {
    mask32x16::from_bitmask(simd, bits & 0xffff).select(lanes(simd, code), other)
}

#[inline(always)]
fn codes<S: Simd>(simd: S, direction_classes: &DirectionClasses, sound: u64) -> [u32; TILE] {
    let mut codes = [0; TILE];
    let [x, y, z] = direction_classes.backwards;
    for (at, codes) in codes.chunks_exact_mut(LANES).enumerate() {
        let at = at * LANES;
        let axis = choose(
            simd,
            direction_classes.along_x >> at,
            0,
            choose(simd, direction_classes.along_y >> at, 8, lanes(simd, 16)),
        );
        let signs = choose(simd, x >> at, 4, lanes(simd, 0))
            + choose(simd, y >> at, 2, lanes(simd, 0))
            + choose(simd, z >> at, 1, lanes(simd, 0));
        let code = choose(simd, !direction_classes.regular >> at, DirectionClasses::CODES - 1, axis + signs);
        choose(simd, !sound >> at, DirectionClasses::CODES, code).store_slice(codes);
    }
    codes
}

#[inline(always)]
fn hit<S: Simd>(simd: S, nearest: &NearestTile) -> u64 {
    let none = u32x16::splat(simd, INVALID_ID);
    let mut bits = 0;
    for first in (0..TILE).step_by(LANES) {
        let number = u32x16::from_slice(simd, &nearest.number[first..first + LANES]);
        bits |= (!number.simd_eq(none)).to_bitmask() << first;
    }
    bits
}

#[inline(always)]
fn fill<S: Simd>(simd: S, rays: &mut RayTile, org: [f32; 3], nearest: &mut NearestTile) -> u64 {
    for (lanes, org) in rays.org.iter_mut().zip(org) {
        *lanes = [org; TILE];
    }
    rays.is_full = true;
    let sound = sound(simd, rays, nearest);
    if sound != u64::MAX {
        let first = sound.trailing_zeros() as usize & (TILE - 1);
        let copied = [rays.dir[0][first], rays.dir[1][first], rays.dir[2][first]];
        let none = f32x16::splat(simd, f32::NEG_INFINITY);
        for at in (0..TILE).step_by(LANES) {
            let keep = mask32x16::from_bitmask(simd, sound >> at & 0xffff);
            for (lanes, copied) in rays.dir.iter_mut().zip(copied) {
                let copied = f32x16::splat(simd, copied);
                keep.select(chunk(simd, lanes, at), copied).store_slice(&mut lanes[at..at + LANES]);
            }
            let t = chunk(simd, &nearest.t, at);
            keep.select(t, none).store_slice(&mut nearest.t[at..at + LANES]);
        }
    }
    sound
}

#[inline(always)]
fn carry<S: Simd>(simd: S, map: &ObjectFromWorld, rays: &RayTile, inside: &mut RayTile) {
    let [high, low] = map.translation;
    let at = |value: f32| f32x16::splat(simd, value);
    for first in (0..TILE).step_by(LANES) {
        let load = |values: &PerRay| f32x16::from_slice(simd, &values[first..first + LANES]);
        let [ox, oy, oz] = [load(&rays.org[0]), load(&rays.org[1]), load(&rays.org[2])];
        let [dx, dy, dz] = [load(&rays.dir[0]), load(&rays.dir[1]), load(&rays.dir[2])];
        let fx = (ox - at(high[0])) - at(low[0]);
        let fy = (oy - at(high[1])) - at(low[1]);
        let fz = (oz - at(high[2])) - at(low[2]);
        for (k, row) in map.rows.iter().enumerate() {
            let org = at(row[0]) * fx + at(row[1]) * fy + at(row[2]) * fz;
            let dir = at(row[0]) * dx + at(row[1]) * dy + at(row[2]) * dz;
            org.store_slice(&mut inside.org[k][first..first + LANES]);
            dir.store_slice(&mut inside.dir[k][first..first + LANES]);
        }
    }
    inside.t_near = rays.t_near;
    inside.mask = rays.mask;
    if rays.is_timed {
        (inside.time, inside.is_timed) = (rays.time, true);
    }
}

/// 64 values from `first` on.
#[inline(always)]
fn copy<S: Simd>(simd: S, from: &[f32], first: usize, to: &mut PerRay) {
    let from = &from[first..first + TILE];
    for at in (0..TILE).step_by(LANES) {
        f32x16::from_slice(simd, &from[at..at + LANES]).store_slice(&mut to[at..at + LANES]);
    }
}

#[inline(always)]
fn load<S: Simd>(
    simd: S,
    batch: &RayBatch,
    first: usize,
    rays: &mut RayTile,
    nearest: &mut NearestTile,
) -> u64 {
    rays.direction_class = None;
    for k in 0..3 {
        copy(simd, &batch.org[k], first, &mut rays.org[k]);
        copy(simd, &batch.dir[k], first, &mut rays.dir[k]);
    }
    copy(simd, &batch.t_near, first, &mut rays.t_near);
    copy(simd, &batch.t_far, first, &mut nearest.t);
    rays.set_times(&batch.time, first, TILE);
    nearest.number = [INVALID_ID; TILE];
    nearest.slot = [INVALID_ID; TILE];
    sound(simd, rays, nearest)
}

#[inline(always)]
fn store<S: Simd>(
    simd: S,
    nearest: &NearestTile,
    ([inst_id, leaf_id], starts): OfOneObject,
    hits: &mut HitBatch,
    first: usize,
) {
    let (none, zero) = (u32x16::splat(simd, INVALID_ID), f32x16::splat(simd, 0.0));
    for lane in (0..TILE).step_by(LANES) {
        let at = first + lane..first + lane + LANES;
        let number = u32x16::from_slice(simd, &nearest.number[lane..lane + LANES]);
        let missed = number.simd_eq(none);
        let t = missed.select(f32x16::splat(simd, f32::INFINITY), chunk(simd, &nearest.t, lane));
        let u = missed.select(zero, chunk(simd, &nearest.u, lane));
        let v = missed.select(zero, chunk(simd, &nearest.v, lane));
        let (mut geometry, mut start) = (u32x16::splat(simd, 0), u32x16::splat(simd, 0));
        for (id, &from) in (1..).zip(starts) {
            let from = u32x16::splat(simd, from);
            let is_later = number.simd_ge(from);
            geometry = is_later.select(u32x16::splat(simd, id), geometry);
            start = is_later.select(from, start);
        }
        t.store_slice(&mut hits.t[at.clone()]);
        u.store_slice(&mut hits.u[at.clone()]);
        v.store_slice(&mut hits.v[at.clone()]);
        missed.select(none, number - start).store_slice(&mut hits.prim_id[at.clone()]);
        missed.select(none, geometry).store_slice(&mut hits.geom_id[at.clone()]);
        missed.select(none, u32x16::splat(simd, leaf_id)).store_slice(&mut hits.leaf_id[at.clone()]);
        missed.select(none, u32x16::splat(simd, inst_id)).store_slice(&mut hits.inst_id[at]);
    }
}

#[cfg(test)]
mod tests {
    use gnurt_simd::Level;

    use super::*;
    use crate::direction_class::DirectionClass;

    #[test]
    fn direction_classes_split_a_tile() {
        let mut rays = RayBatch::default();
        for i in 0..64 {
            let sign = |bit: u32| if i >> bit & 1 == 1 { -1.0 } else { 1.0 };
            let mut dir = [0.5 * sign(0), 0.25 * sign(1), 0.0 * sign(2)];
            dir[i / 20 % 3] = 2.0 * sign(i as u32 / 20 % 3);
            rays.push(Ray::new([i as f32, 0.0, 0.0], if i == 63 { [0.0; 3] } else { dir }));
        }
        for level in Level::available() {
            let (mut tile, mut nearest) = (RayTile::EMPTY, NearestTile::EMPTY);
            let kernels = TileKernels::of(level.token());
            assert_eq!(tile.load(&rays, 0, &mut nearest), TILE, "all of them");
            let sound = kernels.sound(&tile, &nearest);
            let classes = kernels.direction_classes(&tile);
            let codes = kernels.codes(&classes, sound);
            assert_eq!(sound, u64::MAX >> 1, "one ray does not move, at {level}");
            for (i, &code) in codes.iter().enumerate() {
                let DirectionClass { backwards: [x, y, z], longest_axis } = classes.of(i);
                let own = 8 * longest_axis + 4 * usize::from(x) + 2 * usize::from(y) + usize::from(z);
                let own = if i == 63 { DirectionClasses::CODES } else { own };
                assert_eq!(code as usize, own, "code of ray {i} at {level}");
                let known = (i != 63).then(|| classes.of(i));
                assert_eq!(DirectionClass::of_code(own), known, "heading of ray {i} at {level}");
            }
            let mut left = sound;
            while left != 0 {
                let first = left.trailing_zeros() as usize;
                let (direction_class, bits) = classes.like(first, left);
                for i in (0..64).filter(|i| bits >> i & 1 == 1) {
                    let ray = rays.get(i);
                    let backwards = ray.dir.map(|x| x.is_sign_negative());
                    let own = DirectionClass { backwards, longest_axis: ray.longest_axis() };
                    assert_eq!(own, direction_class, "ray {i} goes like ray {first}");
                }
                left &= !bits;
            }
            let (mut rays, mut best) = (RayTile::EMPTY, NearestTile::EMPTY);
            assert_eq!(tile.gather(&nearest, 0b1_0110, &mut rays, &mut best), 3, "three of them");
            assert_eq!(rays.org[0][..4], [1.0, 2.0, 4.0, 1.0], "side by side, then copies of the first");
            assert!(best.t[2] > 0.0 && best.t[3] < 0.0, "copies look for nothing");
        }
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Up to 64 rays that are traced together: the unit of multi-level ray tracing.
//! Source: [RSH05]; structure of arrays after [SIP06], Figure 4.
//! Space: that of the original rays.
//! Invariant: a tile's lanes are plain arrays, so that the same tile serves every SIMD level; `active` tells
//! which lanes hold a ray that can hit something. The other lanes are undefined.
//! Tests: `tile_kernels::tests`.

use gnurt_simd::{Simd, f32x16, mask32x16, prelude::*};

use crate::aabb::Aabb;
use crate::bits::TILE;
use crate::direction_class::DirectionClass;
use crate::hit::INVALID_ID;
use crate::nearest::{NOWHERE, Nearest};
use crate::ray::Ray;
use crate::ray_batch::RayBatch;

/// Rays per SIMD step.
pub const LANES: usize = 16;

/// One value for each ray.
pub type PerRay = [f32; TILE];

/// Sixteen of them from `first` on.
#[inline(always)]
pub fn chunk<S: Simd>(simd: S, values: &PerRay, first: usize) -> f32x16<S> {
    f32x16::from_slice(simd, &values[first..first + LANES])
}

/// Rays.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct RayTile {
    pub org: [PerRay; 3],
    pub dir: [PerRay; 3],
    pub t_near: PerRay,
    /// Times; see [`Ray::time`].
    pub time: PerRay,
    /// Their common mask: rays of different masks go into different tiles.
    pub mask: u32,
    /// Whether they have times; if not, `time` is zero everywhere.
    pub is_timed: bool,
    /// Whether lanes that are not active hold rays without an extent (`t` is -inf): then the tile need not be
    /// copied if a few lanes are missing.
    pub is_full: bool,
    /// The common direction class of all rays, if known: then lanes after the first rays, up to a multiple of
    /// 16, hold rays without an extent, and no directions need to be compared.
    pub direction_class: Option<DirectionClass>,
}

/// Best hits of a tile's rays; see [`Nearest`].
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct NearestTile {
    pub t: PerRay,
    pub u: PerRay,
    pub v: PerRay,
    pub number: [u32; TILE],
    pub slot: [u32; TILE],
}

impl RayTile {
    pub const EMPTY: Self = Self {
        org: [[0.0; TILE]; 3],
        dir: [[0.0; TILE]; 3],
        t_near: [0.0; TILE],
        time: [0.0; TILE],
        mask: u32::MAX,
        is_timed: false,
        is_full: false,
        direction_class: None,
    };

    /// Loads rays `first..first + 64` of a batch as far as it goes; returns how many there are.
    pub fn load(&mut self, rays: &RayBatch, first: usize, nearest: &mut NearestTile) -> usize {
        let count = (rays.len() - first).min(TILE);
        self.direction_class = None;
        for k in 0..3 {
            self.org[k][..count].copy_from_slice(&rays.org[k][first..first + count]);
            self.dir[k][..count].copy_from_slice(&rays.dir[k][first..first + count]);
        }
        self.t_near[..count].copy_from_slice(&rays.t_near[first..first + count]);
        self.set_times(&rays.time, first, count);
        nearest.t[..count].copy_from_slice(&rays.t_far[first..first + count]);
        nearest.number = [INVALID_ID; TILE];
        nearest.slot = [INVALID_ID; TILE];
        count
    }

    /// Takes the times of a batch from `first` on, if it has any.
    #[inline(always)]
    pub(crate) fn set_times(&mut self, times: &[f32], first: usize, count: usize) {
        self.set_timed(!times.is_empty());
        if self.is_timed {
            self.time[..count].copy_from_slice(&times[first..first + count]);
        }
    }

    /// Sets whether its rays have times.
    #[inline(always)]
    fn set_timed(&mut self, is_timed: bool) {
        if self.is_timed && !is_timed {
            self.time = [0.0; TILE];
        }
        self.is_timed = is_timed;
    }

    /// Loads the rays of a batch with these numbers, 64 at most and one at least, which have this direction
    /// class, if any.
    pub fn pick(
        &mut self,
        rays: &RayBatch,
        numbers: &[u32],
        direction_class: Option<DirectionClass>,
        nearest: &mut NearestTile,
    ) {
        self.direction_class = direction_class;
        // Of one length, in which numbers are, so that the compiler checks neither.
        let count = rays.len();
        let ([x, y, z], [dx, dy, dz]) = (&rays.org, &rays.dir);
        let (x, y, z) = (&x[..count], &y[..count], &z[..count]);
        let (dx, dy, dz) = (&dx[..count], &dy[..count], &dz[..count]);
        let (t_near, t_far) = (&rays.t_near[..count], &rays.t_far[..count]);
        for (lane, &number) in numbers.iter().enumerate().take(TILE) {
            let from = (number as usize).min(count - 1);
            self.org[0][lane] = x[from];
            self.org[1][lane] = y[from];
            self.org[2][lane] = z[from];
            self.dir[0][lane] = dx[from];
            self.dir[1][lane] = dy[from];
            self.dir[2][lane] = dz[from];
            self.t_near[lane] = t_near[from];
            nearest.t[lane] = t_far[from];
        }
        self.set_timed(!rays.time.is_empty());
        if self.is_timed {
            let time = &rays.time[..count];
            for (to, &number) in self.time.iter_mut().zip(numbers) {
                *to = time[(number as usize).min(count - 1)];
            }
        }
        self.fill_up(numbers.len(), nearest);
        nearest.number = [INVALID_ID; TILE];
        nearest.slot = [INVALID_ID; TILE];
    }

    /// Marks the first `count` rays, one at least, as having this direction class.
    pub fn set_coherent(&mut self, count: usize, direction_class: DirectionClass, nearest: &mut NearestTile) {
        self.direction_class = Some(direction_class);
        self.fill_up(count, nearest);
    }

    /// Fills up to a multiple of 16 with copies of the first ray without an extent.
    fn fill_up(&mut self, count: usize, nearest: &mut NearestTile) {
        for lane in count..count.next_multiple_of(LANES).min(TILE) {
            self.repeat(lane);
            nearest.t[lane] = f32::NEG_INFINITY;
        }
    }

    /// The rays in `bits` side by side, with their best hits; fills up to a multiple of 16 with copies of the
    /// first without an extent. Returns how many there are.
    pub fn gather(
        &self,
        nearest: &NearestTile,
        mut bits: u64,
        rays: &mut Self,
        best: &mut NearestTile,
    ) -> usize {
        rays.mask = self.mask;
        rays.is_full = false;
        rays.direction_class = None;
        rays.set_timed(self.is_timed);
        let first = bits.trailing_zeros() as usize & (TILE - 1);
        let mut count = 0;
        while bits != 0 {
            rays.copy(count, self, bits.trailing_zeros() as usize);
            best.set(count, &nearest.get(bits.trailing_zeros() as usize));
            bits &= bits - 1;
            count += 1;
        }
        for lane in count..count.next_multiple_of(LANES) {
            rays.copy(lane, self, first);
            best.set(lane, &Nearest::none(f32::NEG_INFINITY));
        }
        count
    }

    /// Puts the first ray into another lane.
    #[inline(always)]
    fn repeat(&mut self, to: usize) {
        let to = to & (TILE - 1);
        for k in 0..3 {
            self.org[k][to] = self.org[k][0];
            self.dir[k][to] = self.dir[k][0];
        }
        self.t_near[to] = self.t_near[0];
    }

    #[inline(always)]
    fn copy(&mut self, to: usize, other: &Self, from: usize) {
        let (to, from) = (to & (TILE - 1), from & (TILE - 1));
        for k in 0..3 {
            self.org[k][to] = other.org[k][from];
            self.dir[k][to] = other.dir[k][from];
        }
        self.t_near[to] = other.t_near[from];
        if self.is_timed {
            self.time[to] = other.time[from];
        }
    }

    /// Origins of sixteen rays from `at` on, along three axes.
    #[inline(always)]
    pub fn org_lanes<S: Simd>(&self, simd: S, [x, y, z]: [usize; 3], at: usize) -> [f32x16<S>; 3] {
        [chunk(simd, &self.org[x], at), chunk(simd, &self.org[y], at), chunk(simd, &self.org[z], at)]
    }

    /// The same for directions.
    #[inline(always)]
    pub fn dir_lanes<S: Simd>(&self, simd: S, [x, y, z]: [usize; 3], at: usize) -> [f32x16<S>; 3] {
        [chunk(simd, &self.dir[x], at), chunk(simd, &self.dir[y], at), chunk(simd, &self.dir[z], at)]
    }

    /// Where the first `count` rays start, if that is one point, bit by bit.
    #[inline(always)]
    pub fn one_origin(&self, count: usize) -> Option<[f32; 3]> {
        let mut differ = 0;
        for org in &self.org {
            let first = org[0].to_bits();
            for x in &org[..count.next_multiple_of(LANES).min(TILE)] {
                differ |= x.to_bits() ^ first;
            }
        }
        (differ == 0).then_some([self.org[0][0], self.org[1][0], self.org[2][0]])
    }

    /// Whether neighbours among those in `active` start far from each other, seen from the size of `bounds`: by a sixteenth
    /// of its edges, in the mean. Rays in `active` are valid.
    #[inline(always)]
    pub fn origins_differ<S: Simd>(&self, simd: S, active: u64, bounds: &Aabb) -> bool {
        let edges: f32 = (0..3).map(|k| bounds.max[k] - bounds.min[k]).sum();
        let pairs = active & active >> LANES;
        let mut jumps = f32x16::splat(simd, 0.0);
        for at in (0..TILE - LANES).step_by(LANES) {
            let [x, y, z] = self.org_lanes(simd, [0, 1, 2], at);
            let [to_x, to_y, to_z] = self.org_lanes(simd, [0, 1, 2], at + LANES);
            let jump = (x - to_x).abs() + (y - to_y).abs() + (z - to_z).abs();
            let counts = mask32x16::from_bitmask(simd, pairs >> at & 0xffff);
            jumps += counts.select(jump, f32x16::splat(simd, 0.0));
        }
        let jumps: f32 = jumps.as_array().iter().sum();
        jumps > pairs.count_ones() as f32 * edges / 16.0
    }

    /// The origin of the first ray in `active`, which is not 0.
    #[inline(always)]
    pub fn origin(&self, active: u64) -> [f32; 3] {
        let i = active.trailing_zeros() as usize & (TILE - 1);
        [self.org[0][i], self.org[1][i], self.org[2][i]]
    }

    /// One of the rays, up to `t_far`.
    #[inline(always)]
    pub fn ray(&self, i: usize, t_far: f32) -> Ray {
        let at = |values: &PerRay| values[i & (TILE - 1)];
        Ray {
            org: [at(&self.org[0]), at(&self.org[1]), at(&self.org[2])],
            t_near: at(&self.t_near),
            dir: [at(&self.dir[0]), at(&self.dir[1]), at(&self.dir[2])],
            t_far,
            mask: self.mask,
            time: at(&self.time),
        }
    }
}

impl NearestTile {
    pub const EMPTY: Self = Self {
        t: [0.0; TILE],
        u: [0.0; TILE],
        v: [0.0; TILE],
        number: [INVALID_ID; TILE],
        slot: [INVALID_ID; TILE],
    };

    /// Bits of the unfinished rays.
    #[inline(always)]
    pub fn looking<S: Simd>(&self, simd: S) -> u64 {
        let done = f32x16::splat(simd, f32::NEG_INFINITY);
        let mut bits = 0;
        for first in (0..TILE).step_by(LANES) {
            let t = f32x16::from_slice(simd, &self.t[first..first + LANES]);
            bits |= t.simd_gt(done).to_bitmask() << first;
        }
        bits
    }

    #[inline(always)]
    pub fn get(&self, i: usize) -> Nearest {
        let i = i & (TILE - 1);
        Nearest {
            t: self.t[i],
            u: self.u[i],
            v: self.v[i],
            number: self.number[i],
            slot: self.slot[i],
            place: NOWHERE,
        }
    }

    /// Restores the lanes that [`RayTile::gather`] extracted.
    pub fn scatter(&mut self, mut bits: u64, best: &Self) {
        let mut from = 0;
        while bits != 0 {
            self.set(bits.trailing_zeros() as usize, &best.get(from));
            bits &= bits - 1;
            from += 1;
        }
    }

    #[inline(always)]
    pub fn set(&mut self, i: usize, nearest: &Nearest) {
        let i = i & (TILE - 1);
        self.t[i] = nearest.t;
        self.u[i] = nearest.u;
        self.v[i] = nearest.v;
        self.number[i] = nearest.number;
        self.slot[i] = nearest.slot;
    }
}

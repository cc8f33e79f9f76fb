// SPDX-License-Identifier: GPL-3.0-or-later
//! Up to 64 rays that are traced together: what multi-level ray tracing descends with.
//! Source: [RSH05]; structure of arrays after the paper's Figure 4.
//! Space: as the rays that went in.
//! Invariant: a tile's lanes are plain arrays, so that the same tile serves every SIMD level; `active` says which lanes
//! hold a ray that can hit something. The others hold nothing that may be looked at.
//! Proof: `tests::headings_part_a_tile`.

use gnurt_simd::{Simd, f32x16, mask32x16, prelude::*, u32x16};

use crate::nearest::{Best, Collect, Mode, Nearest};
use crate::packet::Heading;
use crate::{Aabb, INVALID_ID, Ray, RayBatch};

/// Rays per tile: one bit each in a word.
pub(crate) const TILE: usize = 64;

/// Rays per SIMD step.
pub(crate) const LANES: usize = 16;

/// Fewer rays of one heading go one by one.
const WORTH_A_TILE: u32 = 4;

/// One value for each ray.
pub(crate) type PerRay = [f32; TILE];

/// Sixteen of them from `first` on.
#[inline(always)]
pub(crate) fn chunk<S: Simd>(simd: S, values: &PerRay, first: usize) -> f32x16<S> {
    f32x16::from_slice(simd, &values[first..first + LANES])
}

/// Rays.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct RayTile {
    pub(crate) org: [PerRay; 3],
    pub(crate) dir: [PerRay; 3],
    pub(crate) t_near: PerRay,
    /// What all of them see: rays of different masks go into different tiles.
    pub(crate) mask: u32,
    /// Whether lanes that are not active hold rays all the same, which look for nothing (`t` is -inf): then the tile
    /// need not be copied where a few lanes are missing.
    pub(crate) is_full: bool,
}

/// Best hits of a tile's rays; see [`Nearest`].
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct NearestTile {
    pub(crate) t: PerRay,
    pub(crate) u: PerRay,
    pub(crate) v: PerRay,
    pub(crate) number: [u32; TILE],
    pub(crate) slot: [u32; TILE],
}

impl RayTile {
    pub(crate) const EMPTY: Self = Self {
        org: [[0.0; TILE]; 3],
        dir: [[0.0; TILE]; 3],
        t_near: [0.0; TILE],
        mask: u32::MAX,
        is_full: false,
    };

    /// Loads rays `first..first + 64` of a batch as far as it goes; bits of those that are sound.
    #[inline(always)]
    pub(crate) fn load<S: Simd>(
        &mut self,
        simd: S,
        rays: &RayBatch,
        first: usize,
        nearest: &mut NearestTile,
    ) -> u64 {
        let count = (rays.len() - first).min(TILE);
        for k in 0..3 {
            self.org[k][..count].copy_from_slice(&rays.org[k][first..first + count]);
            self.dir[k][..count].copy_from_slice(&rays.dir[k][first..first + count]);
        }
        self.t_near[..count].copy_from_slice(&rays.t_near[first..first + count]);
        nearest.t[..count].copy_from_slice(&rays.t_far[first..first + count]);
        nearest.number = [INVALID_ID; TILE];
        nearest.slot = [INVALID_ID; TILE];
        self.sound(simd, nearest) & all(count)
    }

    /// Loads the rays of a batch with these numbers, 64 at most.
    #[inline(always)]
    pub(crate) fn pick(&mut self, rays: &RayBatch, numbers: &[u32], nearest: &mut NearestTile) {
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
        nearest.number = [INVALID_ID; TILE];
        nearest.slot = [INVALID_ID; TILE];
    }

    /// Makes a tile of the rays of a pencil, whose directions are there; bits of those that are sound. Lanes of others get
    /// the direction of the first. `nearest` is empty.
    #[inline(always)]
    pub(crate) fn fill<S: Simd>(
        &mut self,
        simd: S,
        org: [f32; 3],
        t_far: &PerRay,
        mask: u32,
        nearest: &mut NearestTile,
    ) -> u64 {
        for (lanes, org) in self.org.iter_mut().zip(org) {
            *lanes = [org; TILE];
        }
        (self.mask, self.is_full) = (mask, true);
        nearest.t = *t_far;
        let sound = self.sound(simd, nearest);
        if sound != u64::MAX {
            let first = sound.trailing_zeros() as usize & (TILE - 1);
            let copied = [self.dir[0][first], self.dir[1][first], self.dir[2][first]];
            let none = f32x16::splat(simd, f32::NEG_INFINITY);
            for at in (0..TILE).step_by(LANES) {
                let keep = mask32x16::from_bitmask(simd, sound >> at & 0xffff);
                for (lanes, copied) in self.dir.iter_mut().zip(copied) {
                    let copied = f32x16::splat(simd, copied);
                    keep.select(chunk(simd, lanes, at), copied).store_slice(&mut lanes[at..at + LANES]);
                }
                let t = chunk(simd, &nearest.t, at);
                keep.select(t, none).store_slice(&mut nearest.t[at..at + LANES]);
            }
        }
        sound
    }

    /// Bits of the rays that can hit something: [`Ray::is_sound`] for each.
    #[inline(always)]
    pub(crate) fn sound<S: Simd>(&self, simd: S, nearest: &NearestTile) -> u64 {
        let (limit, most) = (f32x16::splat(simd, Ray::FARTHEST_ORIGIN), f32x16::splat(simd, f32::MAX));
        let zero = f32x16::splat(simd, 0.0);
        let mut bits = 0;
        for first in (0..TILE).step_by(LANES) {
            let mut sound = chunk(simd, &self.t_near, first).simd_le(chunk(simd, &nearest.t, first));
            let mut moves = mask32x16::splat(simd, false);
            for k in 0..3 {
                let dir = chunk(simd, &self.dir[k], first);
                sound &= chunk(simd, &self.org[k], first).abs().simd_le(limit) & dir.abs().simd_le(most);
                moves |= dir.simd_ne(zero);
            }
            bits |= (sound & moves).to_bitmask() << first;
        }
        bits
    }

    /// Which ways the rays go.
    #[inline(always)]
    pub(crate) fn headings<S: Simd>(&self, simd: S) -> Headings {
        let mut ways = Headings::default();
        let (short, long) = (f32x16::splat(simd, Ray::SHORTEST), f32x16::splat(simd, Ray::LONGEST));
        for first in (0..TILE).step_by(LANES) {
            let dir = self.dir_lanes(simd, [0, 1, 2], first);
            let [x, y, z] = [dir[0].abs(), dir[1].abs(), dir[2].abs()];
            let longest = x.max(y).max(z);
            let regular = longest.simd_ge(short) & longest.simd_le(long);
            ways.regular |= regular.to_bitmask() << first;
            ways.along_x |= (x.simd_ge(y) & x.simd_ge(z)).to_bitmask() << first;
            ways.along_y |= y.simd_ge(z).to_bitmask() << first;
            for (backwards, dir) in ways.backwards.iter_mut().zip(dir) {
                *backwards |= dir.is_sign_negative().to_bitmask() << first;
            }
        }
        ways
    }

    /// Parts the rays in `active`, which are sound, by heading: calls `sweep(rays, count, heading, their best hits)` for
    /// each heading that is worth it, and returns the bits of the rays that go one by one.
    #[inline(always)]
    pub(crate) fn part<S: Simd>(
        &self,
        simd: S,
        active: u64,
        nearest: &mut NearestTile,
        mut sweep: impl FnMut(&Self, usize, Heading, &mut NearestTile),
    ) -> u64 {
        let ways = self.headings(simd);
        let mut alone = active & !ways.regular;
        let mut left = active & ways.regular;
        while left != 0 {
            let (heading, bits) = ways.like(left.trailing_zeros() as usize, left);
            left &= !bits;
            if bits.count_ones() < WORTH_A_TILE {
                alone |= bits;
            } else if bits == u64::MAX || self.is_as_good_as_full(&ways, bits) {
                sweep(self, TILE, heading, nearest);
            } else {
                let (mut some, mut best) = (Self::EMPTY, NearestTile::EMPTY);
                let count = self.gather(nearest, bits, &mut some, &mut best);
                sweep(&some, count, heading, &mut best);
                nearest.scatter(bits, &best);
            }
        }
        alone
    }

    /// Whether the tile can be swept as it is for the rays in `bits`: no lanes would be saved without the others, all of
    /// which go the same way.
    #[inline(always)]
    fn is_as_good_as_full(&self, ways: &Headings, bits: u64) -> bool {
        self.is_full
            && bits.count_ones() as usize > TILE - LANES
            && ways.like(bits.trailing_zeros() as usize & (TILE - 1), ways.regular).1 == u64::MAX
    }

    /// The rays in `bits` side by side, with their best hits; fills up to a multiple of 16 with copies of the first
    /// that look for nothing. Returns how many there are.
    #[inline(always)]
    pub(crate) fn gather(
        &self,
        nearest: &NearestTile,
        mut bits: u64,
        rays: &mut Self,
        best: &mut NearestTile,
    ) -> usize {
        rays.mask = self.mask;
        rays.is_full = false;
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

    #[inline(always)]
    fn copy(&mut self, to: usize, other: &Self, from: usize) {
        let (to, from) = (to & (TILE - 1), from & (TILE - 1));
        for k in 0..3 {
            self.org[k][to] = other.org[k][from];
            self.dir[k][to] = other.dir[k][from];
        }
        self.t_near[to] = other.t_near[from];
    }

    /// Origins of sixteen rays from `at` on, along three axes.
    #[inline(always)]
    pub(crate) fn org_lanes<S: Simd>(&self, simd: S, [x, y, z]: [usize; 3], at: usize) -> [f32x16<S>; 3] {
        [chunk(simd, &self.org[x], at), chunk(simd, &self.org[y], at), chunk(simd, &self.org[z], at)]
    }

    /// The same for directions.
    #[inline(always)]
    pub(crate) fn dir_lanes<S: Simd>(&self, simd: S, [x, y, z]: [usize; 3], at: usize) -> [f32x16<S>; 3] {
        [chunk(simd, &self.dir[x], at), chunk(simd, &self.dir[y], at), chunk(simd, &self.dir[z], at)]
    }

    /// Where the first `count` rays start, if that is one point, bit by bit.
    #[inline(always)]
    pub(crate) fn one_origin(&self, count: usize) -> Option<[f32; 3]> {
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
    /// of its edges, in the mean. Rays in `active` are sound.
    #[inline(always)]
    pub(crate) fn start_apart<S: Simd>(&self, simd: S, active: u64, bounds: &Aabb) -> bool {
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

    /// One of the rays, up to `t_far`.
    #[inline(always)]
    pub(crate) fn ray(&self, i: usize, t_far: f32) -> Ray {
        let at = |values: &PerRay| values[i & (TILE - 1)];
        Ray {
            org: [at(&self.org[0]), at(&self.org[1]), at(&self.org[2])],
            t_near: at(&self.t_near),
            dir: [at(&self.dir[0]), at(&self.dir[1]), at(&self.dir[2])],
            t_far,
            mask: self.mask,
        }
    }
}

impl NearestTile {
    pub(crate) const EMPTY: Self = Self {
        t: [0.0; TILE],
        u: [0.0; TILE],
        v: [0.0; TILE],
        number: [INVALID_ID; TILE],
        slot: [INVALID_ID; TILE],
    };

    /// Bits of the rays that have hit something.
    #[inline(always)]
    pub(crate) fn hit<S: Simd>(&self, simd: S) -> u64 {
        let none = u32x16::splat(simd, INVALID_ID);
        let mut bits = 0;
        for first in (0..TILE).step_by(LANES) {
            let number = u32x16::from_slice(simd, &self.number[first..first + LANES]);
            bits |= (!number.simd_eq(none)).to_bitmask() << first;
        }
        bits
    }

    /// Bits of the rays that still look for something.
    #[inline(always)]
    pub(crate) fn looking<S: Simd>(&self, simd: S) -> u64 {
        let done = f32x16::splat(simd, f32::NEG_INFINITY);
        let mut bits = 0;
        for first in (0..TILE).step_by(LANES) {
            let t = f32x16::from_slice(simd, &self.t[first..first + LANES]);
            bits |= t.simd_gt(done).to_bitmask() << first;
        }
        bits
    }

    #[inline(always)]
    pub(crate) fn get(&self, i: usize) -> Nearest {
        let i = i & (TILE - 1);
        Nearest { t: self.t[i], u: self.u[i], v: self.v[i], number: self.number[i], slot: self.slot[i] }
    }

    /// Calls `search(ray, its best hit)` for each ray in `bits` that still looks for something, one after the other.
    #[inline(always)]
    pub(crate) fn one_by_one<M: Mode>(
        &mut self,
        rays: &RayTile,
        mut bits: u64,
        mut search: impl FnMut(&Ray, &mut Best<M>),
    ) {
        while bits != 0 {
            let i = bits.trailing_zeros() as usize;
            bits &= bits - 1;
            let mut best = Best::<M>::new(self.get(i));
            if best.reach() > f32::NEG_INFINITY {
                search(&rays.ray(i, best.reach()), &mut best);
                self.set(i, &best.0);
            }
        }
    }

    /// Puts back what [`RayTile::gather`] took out.
    #[inline(always)]
    pub(crate) fn scatter(&mut self, mut bits: u64, best: &Self) {
        let mut from = 0;
        while bits != 0 {
            self.set(bits.trailing_zeros() as usize, &best.get(from));
            bits &= bits - 1;
            from += 1;
        }
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, i: usize, nearest: &Nearest) {
        let i = i & (TILE - 1);
        self.t[i] = nearest.t;
        self.u[i] = nearest.u;
        self.v[i] = nearest.v;
        self.number[i] = nearest.number;
        self.slot[i] = nearest.slot;
    }
}

#[inline(always)]
fn lanes<S: Simd>(simd: S, code: usize) -> u32x16<S> {
    u32x16::splat(simd, code as u32)
}

/// `code` where the lowest sixteen bits say so.
#[inline(always)]
fn choose<S: Simd>(simd: S, bits: u64, code: usize, other: u32x16<S>) -> u32x16<S> {
    mask32x16::from_bitmask(simd, bits & 0xffff).select(lanes(simd, code), other)
}

/// The lowest `count` bits; `count` is at most 64.
#[inline(always)]
pub(crate) fn all(count: usize) -> u64 {
    if count == TILE { u64::MAX } else { (1 << count) - 1 }
}

/// Calls `f` with the place of every bit.
#[inline(always)]
pub(crate) fn each(mut bits: u64, mut f: impl FnMut(usize)) {
    while bits != 0 {
        f(bits.trailing_zeros() as usize);
        bits &= bits - 1;
    }
}

/// Which way each ray of a tile goes, as bits.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Headings {
    backwards: [u64; 3],
    along_x: u64,
    along_y: u64,
    /// Of a length that floats can divide by.
    pub(crate) regular: u64,
}

impl Headings {
    /// How many different headings there are, and one for rays of irregular length.
    pub(crate) const CODES: usize = 25;

    /// The heading of each ray as a number below [`CODES`](Self::CODES); that for those that are not `sound`.
    #[inline(always)]
    pub(crate) fn codes<S: Simd>(&self, simd: S, sound: u64) -> [u32; TILE] {
        let mut codes = [0; TILE];
        let [x, y, z] = self.backwards;
        for (at, codes) in codes.chunks_exact_mut(LANES).enumerate() {
            let at = at * LANES;
            let axis =
                choose(simd, self.along_x >> at, 0, choose(simd, self.along_y >> at, 8, lanes(simd, 16)));
            let signs = choose(simd, x >> at, 4, lanes(simd, 0))
                + choose(simd, y >> at, 2, lanes(simd, 0))
                + choose(simd, z >> at, 1, lanes(simd, 0));
            let code = choose(simd, !self.regular >> at, Self::CODES - 1, axis + signs);
            choose(simd, !sound >> at, Self::CODES, code).store_slice(codes);
        }
        codes
    }

    /// The heading of ray `i`.
    #[inline(always)]
    pub(crate) fn of(&self, i: usize) -> Heading {
        let has = |bits: u64| bits >> i & 1 == 1;
        let [x, y, z] = self.backwards;
        let longest_axis = if has(self.along_x) { 0 } else { 2 - usize::from(has(self.along_y)) };
        Heading { backwards: [has(x), has(y), has(z)], longest_axis }
    }

    /// The heading of ray `i`, and the rays of `among` that share it.
    #[inline(always)]
    pub(crate) fn like(&self, i: usize, among: u64) -> (Heading, u64) {
        let has = |bits: u64| bits >> i & 1 == 1;
        let same = |bits: u64| if has(bits) { bits } else { !bits };
        let [x, y, z] = self.backwards;
        let mut bits = among & same(x) & same(y) & same(z) & same(self.along_x);
        if !has(self.along_x) {
            bits &= same(self.along_y);
        }
        (self.of(i), bits)
    }
}

#[cfg(test)]
mod tests {
    use gnurt_simd::{Level, dispatch};

    use super::*;

    #[test]
    fn headings_part_a_tile() {
        let mut rays = RayBatch::default();
        for i in 0..64 {
            let sign = |bit: u32| if i >> bit & 1 == 1 { -1.0 } else { 1.0 };
            let mut dir = [0.5 * sign(0), 0.25 * sign(1), 0.0 * sign(2)];
            dir[i / 20 % 3] = 2.0 * sign(i as u32 / 20 % 3);
            rays.push(Ray::new([i as f32, 0.0, 0.0], if i == 63 { [0.0; 3] } else { dir }));
        }
        for level in Level::available() {
            let (mut tile, mut nearest) = (RayTile::EMPTY, NearestTile::EMPTY);
            let (sound, ways, codes) = dispatch!(level, simd => {
                let sound = tile.load(simd, &rays, 0, &mut nearest);
                let ways = tile.headings(simd);
                (sound, ways, ways.codes(simd, sound))
            });
            assert_eq!(sound, u64::MAX >> 1, "one ray does not move, at {level}");
            for (i, &code) in codes.iter().enumerate() {
                let Heading { backwards: [x, y, z], longest_axis } = ways.of(i);
                let own = 8 * longest_axis + 4 * usize::from(x) + 2 * usize::from(y) + usize::from(z);
                let own = if i == 63 { Headings::CODES } else { own };
                assert_eq!(code as usize, own, "code of ray {i} at {level}");
            }
            let mut left = sound;
            while left != 0 {
                let first = left.trailing_zeros() as usize;
                let (heading, bits) = ways.like(first, left);
                for i in (0..64).filter(|i| bits >> i & 1 == 1) {
                    let ray = rays.get(i);
                    let backwards = ray.dir.map(|x| x.is_sign_negative());
                    let own = Heading { backwards, longest_axis: ray.longest_axis() };
                    assert_eq!(own, heading, "ray {i} goes like ray {first}");
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

// SPDX-License-Identifier: GPL-3.0-or-later
//! Intervals of many rays: one test finds which of eight boxes any of them may hit.
//! Source: [RSH05] section 3 (inverse direction intervals), with an interval of origins as well, so that the rays need
//! not start in one point.
//! Parameters count steps along the axis on which all rays move most (the direction divided by its longest
//! component): then slopes are intervals as narrow as the rays allow, for directions of any length.
//! Invariant: a box that one of the rays meets within its reach is among the bits. Tests: `tests/brute_force.rs` of `gnurt-accel`.

use gnurt_simd::{Simd, f32x8, f32x16, prelude::*};

use crate::aabb::Aabb;
use crate::bits::TILE;
use crate::blocks::WIDTH;
use crate::direction_class::DirectionClass;
use crate::float::{FLATTEST, least, most};
use crate::slab::SLACK;
use crate::tile::{LANES, NearestTile, PerRay, RayTile, chunk};
use crate::triangle::{axes_from, shear};

/// Whether lanes are wide enough for planes through a tile's viewpoint and for interleaved rays: with four or
/// fewer that takes minutes to compile and gains nothing.
pub const fn has_wide_lanes<S: Simd>() -> bool {
    S::LANES >= WIDTH
}

/// Chunks of a tile.
pub const CHUNKS: usize = TILE / LANES;

/// A tile's rays prepared for triangle tests: per-ray slopes, in the sheared space's axes.
#[repr(C, align(64))]
pub struct Slopes {
    /// `dir / dir[z]` along x and y, and `1 / dir[z]`.
    pub shear: [PerRay; 3],
    /// Length of the longest component: parameters times this are steps.
    pub stride: PerRay,
}

/// Least and greatest values of one chunk's or a whole tile's rays.
#[derive(Clone, Copy, Debug)]
pub struct Ranges {
    org: [[f32; 2]; 3],
    /// Along x and y of the sheared space.
    slope: [[f32; 2]; 2],
    pub t_near: f32,
}

impl Ranges {
    pub const NONE: Self = {
        let none = [f32::INFINITY, f32::NEG_INFINITY];
        Self { org: [none; 3], slope: [none; 2], t_near: f32::INFINITY }
    };

    /// Least and greatest slopes along x and y of the sheared space.
    #[inline(always)]
    pub fn slope(&self) -> [[f32; 2]; 2] {
        self.slope
    }

    /// Least and greatest coordinates of origins.
    #[inline(always)]
    pub fn org(&self) -> [[f32; 2]; 3] {
        self.org
    }

    /// How wide the rays are together after `size` steps, along the widest axis.
    #[inline(always)]
    pub fn spread(&self, size: f32) -> f32 {
        let wide = |range: [f32; 2]| range[1] - range[0];
        let org = most(wide(self.org[0]), most(wide(self.org[1]), wide(self.org[2])));
        org + most(wide(self.slope[0]), wide(self.slope[1])) * size
    }

    #[inline(always)]
    pub fn union(&self, other: &Self) -> Self {
        let both = |a: [f32; 2], b: [f32; 2]| [least(a[0], b[0]), most(a[1], b[1])];
        Self {
            org: [
                both(self.org[0], other.org[0]),
                both(self.org[1], other.org[1]),
                both(self.org[2], other.org[2]),
            ],
            slope: [both(self.slope[0], other.slope[0]), both(self.slope[1], other.slope[1])],
            t_near: least(self.t_near, other.t_near),
        }
    }
}

impl Ranges {
    /// The same rays where `origin` is the origin of space.
    #[inline(always)]
    pub fn relative_to(&self, origin: [f32; 3]) -> Self {
        let [x, y, z] = self.org;
        let moved = |[low, high]: [f32; 2], by: f32| [low - by, high - by];
        Self { org: [moved(x, origin[0]), moved(y, origin[1]), moved(z, origin[2])], ..*self }
    }

    /// The greatest coordinate of any origin.
    #[must_use]
    pub fn away(&self) -> f32 {
        self.org.as_flattened().iter().fold(0.0, |most, x| x.abs().max(most))
    }
}

impl Slopes {
    pub const EMPTY: Self = Self { shear: [[0.0; TILE]; 3], stride: [0.0; TILE] };

    /// Prepares the first `count` rays, all of one direction class.
    #[inline(always)]
    pub fn prepare<S: Simd>(
        &mut self,
        simd: S,
        rays: &RayTile,
        count: usize,
        direction_class: DirectionClass,
    ) {
        let [x, y, z] = axes_from(direction_class.longest_axis);
        for at in (0..count).step_by(LANES) {
            let along = chunk(simd, &rays.dir[z], at);
            let dir = [chunk(simd, &rays.dir[x], at), chunk(simd, &rays.dir[y], at), along];
            for (lanes, value) in self.shear.iter_mut().zip(shear(dir, f32x16::splat(simd, 1.0))) {
                value.store_slice(&mut lanes[at..at + LANES]);
            }
            along.abs().store_slice(&mut self.stride[at..at + LANES]);
        }
    }

    /// Ranges of one chunk.
    #[inline(always)]
    pub fn ranges<S: Simd>(&self, simd: S, rays: &RayTile, which: usize) -> Ranges {
        let at = which * LANES;
        let [x, y, z] = rays.org_lanes(simd, [0, 1, 2], at);
        let slope = [range(chunk(simd, &self.shear[0], at)), range(chunk(simd, &self.shear[1], at))];
        let t_near = smallest(chunk(simd, &rays.t_near, at) * chunk(simd, &self.stride, at));
        Ranges { org: [range(x), range(y), range(z)], slope, t_near }
    }

    /// Ranges of the chunks of the first `count` rays, and of all together.
    #[inline(always)]
    pub fn ranges_of_chunks<S: Simd>(
        &self,
        simd: S,
        rays: &RayTile,
        count: usize,
        each: &mut [Ranges; CHUNKS],
    ) -> Ranges {
        let mut whole = Ranges::NONE;
        for (which, ranges) in each.iter_mut().enumerate().take(count.div_ceil(LANES)) {
            *ranges = self.ranges(simd, rays, which);
            whole = whole.union(ranges);
        }
        whole
    }

    /// Ranges of the first `count` rays together: faster than those of chunks, if lanes are wide.
    #[inline(always)]
    pub fn all_ranges<S: Simd>(&self, simd: S, rays: &RayTile, count: usize) -> Ranges {
        if const { !has_wide_lanes::<S>() } {
            return self.ranges_of_chunks(simd, rays, count, &mut [Ranges::NONE; CHUNKS]);
        }
        let mut t_near = chunk(simd, &rays.t_near, 0) * chunk(simd, &self.stride, 0);
        for at in (LANES..count).step_by(LANES) {
            t_near = t_near.min(chunk(simd, &rays.t_near, at) * chunk(simd, &self.stride, at));
        }
        let [x, y, z] = &rays.org;
        let org = [range_of(simd, x, count), range_of(simd, y, count), range_of(simd, z, count)];
        let slope = [range_of(simd, &self.shear[0], count), range_of(simd, &self.shear[1], count)];
        Ranges { org, slope, t_near: smallest(t_near) }
    }

    /// The greatest remaining extent of a chunk's rays, in steps.
    #[inline(always)]
    pub fn chunk_ahead<S: Simd>(&self, simd: S, nearest: &NearestTile, which: usize) -> f32 {
        let at = which * LANES;
        greatest(chunk(simd, &nearest.t, at) * chunk(simd, &self.stride, at))
    }

    /// The same for the first `count` rays.
    #[inline(always)]
    pub fn steps_ahead<S: Simd>(&self, simd: S, nearest: &NearestTile, count: usize) -> f32 {
        let mut farthest = f32::NEG_INFINITY;
        for which in 0..count.div_ceil(LANES) {
            farthest = most(farthest, self.chunk_ahead(simd, nearest, which));
        }
        farthest
    }
}

/// Least and greatest of the first `count` values: lane by lane first, because steps across lanes are slow.
#[inline(always)]
fn range_of<S: Simd>(simd: S, values: &PerRay, count: usize) -> [f32; 2] {
    let (mut low, mut high) = (chunk(simd, values, 0), chunk(simd, values, 0));
    for at in (LANES..count).step_by(LANES) {
        low = low.min(chunk(simd, values, at));
        high = high.max(chunk(simd, values, at));
    }
    [smallest(low), greatest(high)]
}

/// Least and greatest lane.
#[inline(always)]
fn range<S: Simd>(v: f32x16<S>) -> [f32; 2] {
    [smallest(v), greatest(v)]
}

#[inline(always)]
pub fn smallest<S: Simd>(v: f32x16<S>) -> f32 {
    -greatest(-v)
}

#[inline(always)]
pub fn greatest<S: Simd>(v: f32x16<S>) -> f32 {
    let (a, b) = v.split();
    let (a, b) = a.max(b).split();
    let quarter = a.max(b);
    most(most(quarter[0], quarter[1]), most(quarter[2], quarter[3]))
}

/// Ranges made ready for boxes. Plain numbers, not lanes: a test takes them from memory into all lanes for nothing.
#[derive(Clone, Copy)]
pub struct Beam {
    /// Bounds of the inverse slope along each axis.
    inv: [[f32; 2]; 3],
    /// The origin's bound nearer to planes ahead, and the farther one.
    near_org: [f32; 3],
    far_org: [f32; 3],
    pad: [f32; 3],
    rows: [usize; 3],
    t_near: f32,
}

/// [`Beam`] for one plane at a time. Arrays have four entries so that two bits of an axis need no check.
#[derive(Clone, Copy, Debug)]
pub struct PlaneBeam {
    inv: [[f32; 2]; 4],
    /// The origins' bounds nearer to planes ahead and farther from them.
    org: [[f32; 2]; 4],
    pad: [f32; 4],
    /// 1 where the rays go towards smaller coordinates.
    pub back: [u32; 4],
    t_near: f32,
}

impl PlaneBeam {
    /// Where the first of the rays may meet a plane, and where the last, in steps.
    #[inline(always)]
    pub fn meet(&self, axis: usize, plane: f32) -> [f32; 2] {
        let axis = axis & 3;
        let (near, far) = (plane - self.org[axis][0], plane - self.org[axis][1]);
        let [a, b] = self.inv[axis];
        [least(near * a, near * b) - self.pad[axis], most(far * a, far * b) + self.pad[axis]]
    }

    /// Where the first may enter a box, and where the last may leave it before `reach`.
    #[inline(always)]
    pub fn clip(&self, bounds: &Aabb, reach: f32) -> [f32; 2] {
        let (mut enter, mut leave) = (self.t_near, reach);
        for k in 0..3 {
            let faces = [bounds.min[k], bounds.max[k]];
            let back = self.back[k] as usize & 1;
            enter = most(enter, self.meet(k, faces[back])[0]);
            leave = least(leave, self.meet(k, faces[1 - back])[1]);
        }
        [enter, leave]
    }
}

impl Beam {
    /// No rays.
    pub const EMPTY: Self = Self {
        inv: [[0.0; 2]; 3],
        near_org: [0.0; 3],
        far_org: [0.0; 3],
        pad: [0.0; 3],
        rows: [0; 3],
        t_near: 0.0,
    };

    /// For a tree whose greatest coordinate is `greatest`.
    #[inline(always)]
    pub fn new(ranges: &Ranges, direction_class: DirectionClass, greatest: f32) -> Self {
        let mut away = 0.0f32;
        for k in 0..3 {
            away = most(away, most(ranges.org[k][0].abs(), ranges.org[k][1].abs()));
        }
        let slack = SLACK * (2.0 * greatest + away);
        let mut beam = Self { t_near: ranges.t_near, ..Self::EMPTY };
        let [_, y, z] = axes_from(direction_class.longest_axis);
        for k in 0..3 {
            let backwards = direction_class.backwards[k];
            // Magnitudes of the slopes, then the sign again: a slope of zero has one, too.
            let size = if k == z {
                [1.0, 1.0]
            } else {
                let [low, high] = ranges.slope[usize::from(k == y)];
                let (low, high) = (low.abs(), high.abs());
                [most(least(low, high), FLATTEST), most(most(low, high), FLATTEST)]
            };
            let sign = if backwards { -1.0 } else { 1.0 };
            beam.inv[k] = [sign / size[1], sign / size[0]];
            beam.pad[k] = slack / size[0];
            let [low, high] = ranges.org[k];
            beam.near_org[k] = if backwards { low } else { high };
            beam.far_org[k] = if backwards { high } else { low };
            beam.rows[k] = 2 * k + usize::from(backwards);
        }
        beam
    }

    /// The beam for planes that come one by one.
    #[inline(always)]
    pub fn planes(&self) -> PlaneBeam {
        let mut planes = PlaneBeam {
            inv: [[1.0; 2]; 4],
            org: [[0.0; 2]; 4],
            pad: [0.0; 4],
            back: [0; 4],
            t_near: self.t_near,
        };
        for k in 0..3 {
            planes.inv[k] = self.inv[k];
            planes.org[k] = [self.near_org[k], self.far_org[k]];
            planes.pad[k] = self.pad[k];
            planes.back[k] = self.rows[k] as u32 & 1;
        }
        planes
    }

    /// Where the first of the rays may enter slabs between two rows of planes, and the last may leave.
    #[inline(always)]
    fn slab<S: Simd>(&self, simd: S, k: usize, near: f32x8<S>, far: f32x8<S>) -> [f32x8<S>; 2] {
        let near = near - f32x8::splat(simd, self.near_org[k]);
        let far = far - f32x8::splat(simd, self.far_org[k]);
        let (a, b) = (f32x8::splat(simd, self.inv[k][0]), f32x8::splat(simd, self.inv[k][1]));
        let pad = f32x8::splat(simd, self.pad[k]);
        [(near * a).min(near * b) - pad, (far * a).max(far * b) + pad]
    }

    /// [`slab`](Self::slab) between the lower and the upper planes.
    #[inline(always)]
    fn ends<S: Simd>(&self, simd: S, k: usize, [low, high]: [f32x8<S>; 2]) -> [f32x8<S>; 2] {
        if self.rows[k] & 1 == 0 { self.slab(simd, k, low, high) } else { self.slab(simd, k, high, low) }
    }

    /// The boxes that some ray may meet before `reach` steps as bits, and where the first may enter them. Rows are lower and
    /// upper planes along x, y and z.
    #[inline(always)]
    pub fn meet<S: Simd>(&self, simd: S, rows: &[[f32; WIDTH]; 8], reach: f32) -> (u32, f32x8<S>) {
        let row = |i: usize| f32x8::from_slice(simd, &rows[i & (WIDTH - 1)]);
        let [x, y, z] = self.rows;
        let [nx, fx] = self.slab(simd, 0, row(x), row(x ^ 1));
        let [ny, fy] = self.slab(simd, 1, row(y), row(y ^ 1));
        let [nz, fz] = self.slab(simd, 2, row(z), row(z ^ 1));
        self.overlap(simd, [nx, ny, nz], [fx, fy, fz], reach)
    }

    /// The same for boxes given by their extents along each axis.
    #[inline(always)]
    pub fn meet_extents<S: Simd>(&self, simd: S, extents: &[[f32x8<S>; 2]; 3], reach: f32) -> u32 {
        let [nx, fx] = self.ends(simd, 0, extents[0]);
        let [ny, fy] = self.ends(simd, 1, extents[1]);
        let [nz, fz] = self.ends(simd, 2, extents[2]);
        self.overlap(simd, [nx, ny, nz], [fx, fy, fz], reach).0
    }

    #[inline(always)]
    fn overlap<S: Simd>(
        &self,
        simd: S,
        near: [f32x8<S>; 3],
        far: [f32x8<S>; 3],
        reach: f32,
    ) -> (u32, f32x8<S>) {
        let enter = near[0].max(near[1]).max(near[2].max(f32x8::splat(simd, self.t_near)));
        let leave = far[0].min(far[1]).min(far[2].min(f32x8::splat(simd, reach)));
        (enter.simd_le(leave).to_bitmask() as u32, enter)
    }
}

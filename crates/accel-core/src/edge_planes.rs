// SPDX-License-Identifier: GPL-3.0-or-later
//! Triangles seen from the common origin of a tile's rays: planes through it and the edges tell which
//! triangles the rays miss. [RSH05] and [WBS06] use that edge functions are linear in the slopes of rays from
//! one point.
//!
//! Take corners `a`, `b`, `c` relative to the point and the ray's slopes `sx`, `sy` along the longest axis.
//! The test of `triangle/lanes.rs` has `w0 = n.z + sx * n.x + sy * n.y` where `n = c x b`, and so for the
//! others: six fused operations decide for sixteen rays, or intervals of slopes for all.
//!
//! Invariant: the test would miss every skipped triangle. With `m` the greatest coordinate of the corners,
//! slopes of at most 1 and `u = 2^-24`, the errors are at most as follows. The test's own `w`: `40 u m^2`
//! (`px`, `py`: `3 u m` and at most `2 m`; products: `16 u m^2` for their roundings and `24 u m^2` for those
//! of their factors). `n`: `4 u m^2` in each component; the sum above: `28 u m^2` in all. `ROUNDING` is 128
//! `u`, and `UNDERFLOW` covers products that are too small for floats. A viewpoint is rejected where products
//! may overflow. Tests: `tests::bounds_hold`, `tests/brute_force.rs`.

use gnurt_simd::{Simd, f32x8, f32x16, prelude::*};

use crate::beam::{Ranges, Slopes};
use crate::blocks::{TriangleBlock, WIDTH};
use crate::direction_class::DirectionClass;
use crate::float::most;
use crate::tile::{LANES, chunk};
use crate::triangle::axes_from;

/// By how much edge functions may be off, as a part of the square of the greatest coordinate.
const ROUNDING: f32 = 128.0 / (1 << 24) as f32;
/// The same where floats lose all of it.
const UNDERFLOW: f32 = 1e-36;
/// Coordinates whose products do not overflow.
const FARTHEST: f32 = 1e18;
/// Triangles larger than this part of the rays' width are worth planes; for others their boxes suffice.
const LARGE: f32 = 0.6;
/// Depths of corners are taken to be this much smaller, for the roundings of `t`.
const NEARER: f32 = 1.0 - 8.0 / (1 << 24) as f32;

/// Where all rays of a tile start, and how they spread.
#[derive(Clone, Copy, Debug)]
pub struct Viewpoint {
    /// Along the axes of the sheared space, as all below.
    axes: [usize; 3],
    org: [f32; 3],
    /// Middle of the slopes along x and y, and half their width.
    middle: [f32; 2],
    half: [f32; 2],
    backwards: bool,
}

/// A block of triangles as the rays see it.
#[repr(C, align(64))]
pub struct EdgePlanes {
    /// Corners relative to the viewpoint, by corner and axis.
    corners: [[[f32; WIDTH]; 3]; 3],
    /// Normals of the planes through the viewpoint and each edge.
    normals: [[[f32; WIDTH]; 3]; 3],
    /// By how much edge functions may be off.
    margin: [f32; WIDTH],
    /// Steps to the nearest corner, or a bit fewer.
    nearest: [f32; WIDTH],
}

impl Viewpoint {
    /// For rays that start in `org`, in a tree whose greatest coordinate is `greatest`; none where products may overflow.
    #[inline(always)]
    pub fn new(
        ranges: &Ranges,
        org: [f32; 3],
        direction_class: DirectionClass,
        greatest: f32,
    ) -> Option<Self> {
        let away = most(org[0].abs(), most(org[1].abs(), org[2].abs()));
        if greatest + away > FARTHEST {
            return None;
        }
        let axes = axes_from(direction_class.longest_axis);
        let [x, y] = ranges.slope();
        // Half the width is rounded upwards, so that both ends lie within.
        let middle = |[low, high]: [f32; 2]| 0.5 * (low + high);
        let half = |[low, high]: [f32; 2]| 0.5 * (high - low) + 2.0 * f32::EPSILON;
        Some(Self {
            axes,
            org: axes.map(|k| org[k]),
            middle: [middle(x), middle(y)],
            half: [half(x), half(y)],
            backwards: direction_class.backwards[direction_class.longest_axis],
        })
    }
}

impl Viewpoint {
    /// Whether most of the triangles of a block that are in `among` are large relative to the tile's rays, so
    /// that planes exclude more than boxes. `extents` are the block's.
    #[inline(always)]
    pub fn is_worth_it<S: Simd>(
        &self,
        simd: S,
        block: &TriangleBlock,
        extents: &[[f32x8<S>; 2]; 3],
        among: u32,
    ) -> bool {
        let [x, y, z] = extents;
        let across = (x[1] - x[0]).max(y[1] - y[0]).max(z[1] - z[0]);
        let depth =
            f32x8::from_slice(simd, &block.corners[0][self.axes[2]]) - f32x8::splat(simd, self.org[2]);
        let wide = depth.abs() * f32x8::splat(simd, LARGE * 2.0 * most(self.half[0], self.half[1]));
        let large = across.simd_gt(wide).to_bitmask() as u32;
        2 * (large & among).count_ones() > among.count_ones()
    }
}

impl EdgePlanes {
    pub const EMPTY: Self = Self {
        corners: [[[0.0; WIDTH]; 3]; 3],
        normals: [[[0.0; WIDTH]; 3]; 3],
        margin: [0.0; WIDTH],
        nearest: [0.0; WIDTH],
    };

    /// Tests a block; returns the triangles that some ray of the tile may hit before `reach` steps.
    #[inline(always)]
    pub fn lanes_to_test<S: Simd>(
        &mut self,
        simd: S,
        view: &Viewpoint,
        block: &TriangleBlock,
        reach: f32,
    ) -> u32 {
        let org = [
            f32x8::splat(simd, view.org[0]),
            f32x8::splat(simd, view.org[1]),
            f32x8::splat(simd, view.org[2]),
        ];
        let [x, y, z] = view.axes;
        let zero = f32x8::splat(simd, 0.0);
        let mut corners = [[zero; 3]; 3];
        let mut greatest = zero;
        for (corner, (rows, own)) in corners.iter_mut().zip(block.corners.iter().zip(&mut self.corners)) {
            for (k, axis) in [(0, x), (1, y), (2, z)] {
                corner[k] = f32x8::from_slice(simd, &rows[axis]) - org[k];
                corner[k].store_slice(&mut own[k]);
                greatest = greatest.max(corner[k].abs());
            }
        }
        let margin = greatest * greatest * f32x8::splat(simd, ROUNDING) + f32x8::splat(simd, UNDERFLOW);
        margin.store_slice(&mut self.margin);

        let depth = [corners[0][2], corners[1][2], corners[2][2]];
        let nearest = if view.backwards {
            zero - depth[0].max(depth[1]).max(depth[2])
        } else {
            depth[0].min(depth[1]).min(depth[2])
        };
        let nearest = nearest * f32x8::splat(simd, NEARER);
        nearest.store_slice(&mut self.nearest);

        let (mut least, mut most) =
            (f32x8::splat(simd, f32::INFINITY), f32x8::splat(simd, f32::NEG_INFINITY));
        for edge in 0..3 {
            let (b, c) = (corners[(edge + 1) % 3], corners[(edge + 2) % 3]);
            let n = [
                c[1].mul_sub(b[2], c[2] * b[1]),
                c[2].mul_sub(b[0], c[0] * b[2]),
                c[0].mul_sub(b[1], c[1] * b[0]),
            ];
            for (row, n) in self.normals[edge].iter_mut().zip(n) {
                n.store_slice(row);
            }
            let middle = n[0].mul_add(
                f32x8::splat(simd, view.middle[0]),
                n[1].mul_add(f32x8::splat(simd, view.middle[1]), n[2]),
            );
            let half = n[0]
                .abs()
                .mul_add(f32x8::splat(simd, view.half[0]), n[1].abs() * f32x8::splat(simd, view.half[1]));
            least = least.min(middle + half);
            most = most.max(middle - half);
        }
        let below = (least + margin).simd_lt(zero);
        let passed_by = below & most.simd_gt(margin);
        (nearest.simd_le(f32x8::splat(simd, reach)) & !passed_by).to_bitmask() as u32
    }

    /// The triangles whose nearest corner is not beyond `reach` steps.
    #[inline(always)]
    pub fn within<S: Simd>(&self, simd: S, reach: f32) -> u32 {
        f32x8::from_slice(simd, &self.nearest).simd_le(f32x8::splat(simd, reach)).to_bitmask() as u32
    }

    /// Whether each of the sixteen rays of a chunk passes by the triangle at `lane`.
    #[inline(always)]
    pub fn all_pass<S: Simd>(&self, simd: S, lane: usize, slopes: &Slopes, which: usize) -> bool {
        let at = which * LANES;
        let (sx, sy) = (chunk(simd, &slopes.shear[0], at), chunk(simd, &slopes.shear[1], at));
        let mut w = [sx; 3];
        for (w, rows) in w.iter_mut().zip(&self.normals) {
            let [x, y, z] = corner_of(simd, rows, lane);
            *w = sx.mul_add(x, sy.mul_add(y, z));
        }
        let [a, b, c] = w;
        let margin = f32x16::splat(simd, self.margin[lane & 7]);
        let passed_by = a.min(b).min(c).simd_lt(-margin) & a.max(b).max(c).simd_gt(margin);
        passed_by.all_true()
    }

    /// Corners of the triangle at `lane`, in all lanes.
    #[inline(always)]
    pub fn corners<S: Simd>(&self, simd: S, lane: usize) -> [[f32x16<S>; 3]; 3] {
        let [a, b, c] = &self.corners;
        [corner_of(simd, a, lane), corner_of(simd, b, lane), corner_of(simd, c, lane)]
    }
}

/// The value of rows at `lane`, in all lanes.
#[inline(always)]
fn corner_of<S: Simd>(simd: S, [x, y, z]: &[[f32; WIDTH]; 3], lane: usize) -> [f32x16<S>; 3] {
    let lane = lane & (WIDTH - 1);
    [f32x16::splat(simd, x[lane]), f32x16::splat(simd, y[lane]), f32x16::splat(simd, z[lane])]
}

#[cfg(test)]
mod tests {
    use gnurt_simd::{Level, dispatch_wide};
    use gnurt_testkit::Random;

    use super::*;
    use crate::bits::TILE;
    use crate::ray::Ray;
    use crate::tile::RayTile;
    use crate::triangle::ShearedRay;

    /// The triangles that planes leave for a tile, and for its rays `which * 16..`, by bits.
    #[inline(always)]
    fn leave<S: Simd>(
        simd: S,
        rays: &RayTile,
        direction_class: DirectionClass,
        block: &TriangleBlock,
    ) -> Option<[u32; 5]> {
        let mut slopes = Slopes::EMPTY;
        slopes.prepare(simd, rays, TILE, direction_class);
        let ranges = slopes.all_ranges(simd, rays, TILE);
        let view = Viewpoint::new(&ranges, rays.one_origin(TILE)?, direction_class, 1e17)?;
        let mut faces = EdgePlanes::EMPTY;
        let mut left = [faces.lanes_to_test(simd, &view, block, f32::INFINITY), 0, 0, 0, 0];
        for which in 0..TILE / LANES {
            for lane in 0..WIDTH {
                left[1 + which] |= u32::from(!faces.all_pass(simd, lane, &slopes, which)) << lane;
            }
        }
        Some(left)
    }

    /// No plane skips a triangle that the test hits: rays are aimed at corners, at edges and past them by a
    /// few bits.
    #[test]
    fn bounds_hold() {
        let mut numbers = Random::new(11);
        let mut random = || numbers.between(-1.0, 1.0);
        for level in Level::available() {
            let (mut hits, mut left_out) = (0, 0);
            for round in 0..600 {
                // Triangles in the cone of rays along z; small ones, far ones, and ones of almost no width.
                let size = [1.0, 1e-3, 1e-6, 30.0][round % 4];
                let org = [random(), random(), random()].map(|x| x * [0.0, 1.0, 1e4, 1e-20][round / 4 % 4]);
                let mut block = TriangleBlock { corners: [[[0.0; WIDTH]; 3]; 3], numbers: [0; WIDTH] };
                for lane in 0..WIDTH {
                    let depth = 2.0 + random();
                    let middle = [random() * depth * 0.5, random() * depth * 0.5, depth];
                    for corner in &mut block.corners {
                        for (k, row) in corner.iter_mut().enumerate() {
                            let flat = if round % 3 == 0 && k == 1 { 1e-6 } else { 1.0 };
                            row[lane] = org[k] + middle[k] + size * flat * random();
                        }
                    }
                }
                let mut rays = RayTile::EMPTY;
                for i in 0..TILE {
                    let lane = (i + round) % WIDTH;
                    let (a, b) = (random().abs(), [0.0, 1.0, random().abs()][i % 3]);
                    let weights = [1.0 - b, b * (1.0 - a), b * a];
                    let mut dir = [0.0; 3];
                    for k in 0..3 {
                        rays.org[k][i] = org[k];
                        for (weight, corner) in weights.iter().zip(&block.corners) {
                            dir[k] += weight * (corner[k][lane] - org[k]);
                        }
                    }
                    // One direction class for all.
                    let bits = |x: f32| f32::from_bits(x.abs().max(1e-9).to_bits() + (i as u32 & 3));
                    let dir = [bits(dir[0]), bits(dir[1]), bits(dir[2])];
                    let longest = dir[0].max(dir[1]);
                    (rays.dir[0][i], rays.dir[1][i], rays.dir[2][i]) = (dir[0], dir[1], dir[2].max(longest));
                }
                let direction_class = DirectionClass { backwards: [false; 3], longest_axis: 2 };
                let left =
                    dispatch_wide!(level, simd => leave(simd, &rays, direction_class, &block), else None);
                let Some(left) = left else { continue };
                for lane in 0..WIDTH {
                    let corners = [0, 1, 2].map(|c: usize| [0, 1, 2].map(|k| block.corners[c][k][lane]));
                    for i in 0..TILE {
                        let dir = [0, 1, 2].map(|k| rays.dir[k][i]);
                        let ray = ShearedRay::new(&Ray::new(org, dir));
                        let hit = ray.meet(&corners, true, 0.0, f32::INFINITY).is_some();
                        hits += u32::from(hit);
                        let left_lanes = left[0] & left[1 + i / LANES];
                        assert!(!hit || left_lanes >> lane & 1 == 1, "ray {i} hits {corners:?} at {level}");
                    }
                    left_out += u32::from(left[1..].iter().any(|left| left >> lane & 1 == 0));
                }
            }
            assert!(hits == 0 || hits > 4_000 && left_out > 1_000, "{hits} hits, {left_out} left out");
        }
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! A tile in chunks of sixteen rays: the remaining extents of each of them, and of all together.
//! Source: [RSH05] (intervals); the second level of intervals is original. Invariant: `farthest` is the largest `ahead`.
//! Tests: `tests/brute_force.rs`.

use gnurt_simd::{Simd, f32x16};

use crate::beam::{Beam, CHUNKS, Ranges, Slopes, has_wide_lanes};
use crate::blocks::{TriangleBlock, WIDTH};
use crate::direction_class::DirectionClass;
use crate::edge_planes::{EdgePlanes, Viewpoint};
use crate::tile::{LANES, NearestTile, RayTile};
use crate::triangle::{axes_from, relative_to};

/// Chunks of one tile.
pub struct Chunks<'a> {
    pub slopes: Slopes,
    /// All rays as intervals.
    pub beam: Beam,
    /// The greatest remaining extent of any ray, in steps.
    pub farthest: f32,
    rays: &'a RayTile,
    direction_class: DirectionClass,
    /// The tree's greatest coordinate.
    greatest: f32,
    count: usize,
    /// The rays of each chunk as intervals; not known at first where all start in one point, for planes may do.
    parts: [Beam; CHUNKS],
    known: bool,
    /// The greatest remaining extent of each chunk, in steps.
    ahead: [f32; CHUNKS],
    /// Where all rays start, if that is one point.
    view: Option<Viewpoint>,
}

/// A triangle that a chunk's rays may meet.
pub struct Candidate<S: Simd> {
    pub lane: usize,
    pub chunk: usize,
    /// Corners relative to the rays' origins, along the axes of the sheared space.
    pub corners: [[f32x16<S>; 3]; 3],
}

impl<'a> Chunks<'a> {
    /// The first `count` rays of a tile, all of one direction class; `None` if `too_wide` is true of their
    /// intervals.
    #[inline(always)]
    pub fn new<S: Simd>(
        simd: S,
        rays: &'a RayTile,
        count: usize,
        direction_class: DirectionClass,
        greatest: f32,
        nearest: &NearestTile,
        too_wide: impl Fn(&Ranges) -> bool,
    ) -> Option<Self> {
        let mut slopes = Slopes::EMPTY;
        slopes.prepare(simd, rays, count, direction_class);
        let origin = if const { has_wide_lanes::<S>() } { rays.one_origin(count) } else { None };
        let mut each = [Ranges::NONE; CHUNKS];
        let whole = if origin.is_some() {
            slopes.all_ranges(simd, rays, count)
        } else {
            slopes.ranges_of_chunks(simd, rays, count, &mut each)
        };
        if too_wide(&whole) {
            return None;
        }
        let view = origin.and_then(|org| Viewpoint::new(&whole, org, direction_class, greatest));
        let chunks_of_rays = count.div_ceil(LANES);
        let mut parts = [Beam::EMPTY; CHUNKS];
        if origin.is_none() {
            for (part, ranges) in parts.iter_mut().zip(&each).take(chunks_of_rays) {
                *part = Beam::new(ranges, direction_class, greatest);
            }
        }
        let mut chunks = Self {
            slopes,
            beam: Beam::new(&whole, direction_class, greatest),
            farthest: f32::NEG_INFINITY,
            rays,
            direction_class,
            greatest,
            count: chunks_of_rays,
            parts,
            known: origin.is_none(),
            ahead: [f32::NEG_INFINITY; CHUNKS],
            view,
        };
        chunks.update_reach(simd, nearest, u32::MAX);
        Some(chunks)
    }

    /// After hits of the chunks in `touched`.
    #[inline(always)]
    pub fn update_reach<S: Simd>(&mut self, simd: S, nearest: &NearestTile, touched: u32) {
        for which in 0..self.count {
            if touched >> which & 1 == 1 {
                self.ahead[which] = self.slopes.chunk_ahead(simd, nearest, which);
            }
        }
        let [a, b, c, d] = self.ahead;
        self.farthest = a.max(b).max(c).max(d);
    }

    /// Calls `meet(candidate, slopes)` for each triangle of a block that rays in `bits` may hit; it returns
    /// whether one did.
    #[inline(always)]
    pub fn block<S: Simd>(
        &mut self,
        simd: S,
        block: &TriangleBlock,
        bits: u64,
        nearest: &mut NearestTile,
        mut meet: impl FnMut(Candidate<S>, &Slopes, &mut NearestTile) -> bool,
    ) {
        let extents = [block.extent(simd, 0), block.extent(simd, 1), block.extent(simd, 2)];
        let mut common = self.beam.meet_extents(simd, &extents, self.farthest);
        if common == 0 {
            return;
        }
        let mut touched = 0;
        // A loop for each case: with one call of the test for both, corners would go through memory.
        if const { has_wide_lanes::<S>() }
            && let Some(view) = &self.view
            && view.is_worth_it(simd, block, &extents, common)
        {
            let mut faces = EdgePlanes::EMPTY;
            common &= faces.lanes_to_test(simd, view, block, self.farthest);
            for which in 0..self.count {
                if common == 0 || bits >> (which * LANES) & 0xffff == 0 {
                    continue;
                }
                let mut lanes = common & faces.within(simd, self.ahead[which]);
                while lanes != 0 {
                    let lane = lanes.trailing_zeros() as usize & (WIDTH - 1);
                    lanes &= lanes - 1;
                    if !faces.all_pass(simd, lane, &self.slopes, which) {
                        let candidate = Candidate { lane, chunk: which, corners: faces.corners(simd, lane) };
                        touched |= u32::from(meet(candidate, &self.slopes, nearest)) << which;
                    }
                }
            }
        } else {
            if const { has_wide_lanes::<S>() } && !self.known {
                self.know_parts(simd);
            }
            let axes = axes_from(self.direction_class.longest_axis);
            for which in 0..self.count {
                if bits >> (which * LANES) & 0xffff == 0 {
                    continue;
                }
                let mut lanes = self.parts[which].meet_extents(simd, &extents, self.ahead[which]);
                while lanes != 0 {
                    let lane = lanes.trailing_zeros() as usize & (WIDTH - 1);
                    lanes &= lanes - 1;
                    let corners = [
                        block.corner(simd, lane, 0, axes),
                        block.corner(simd, lane, 1, axes),
                        block.corner(simd, lane, 2, axes),
                    ];
                    let corners = relative_to(corners, &self.rays.org_lanes(simd, axes, which * LANES));
                    let candidate = Candidate { lane, chunk: which, corners };
                    let met = meet(candidate, &self.slopes, nearest);
                    touched |= u32::from(met) << which;
                }
            }
        }
        if touched != 0 {
            self.update_reach(simd, nearest, touched);
        }
    }

    /// Prepares the chunks for boxes.
    #[inline(always)]
    fn know_parts<S: Simd>(&mut self, simd: S) {
        for which in 0..self.count {
            let ranges = self.slopes.ranges(simd, self.rays, which);
            self.parts[which] = Beam::new(&ranges, self.direction_class, self.greatest);
        }
        self.known = true;
    }
}

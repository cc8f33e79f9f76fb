// SPDX-License-Identifier: GPL-3.0-or-later
//! An object's triangles under an interval hierarchy. Space: object. Tests: `tests/brute_force.rs`,
//! `tests/intervals.rs` of `gnurt-accel`.

use gnurt_accel_core::bits::TILE;
use gnurt_accel_core::blocks::{BlockRay, TriangleBlock, WIDTH};
use gnurt_accel_core::chunks::Chunks;
use gnurt_accel_core::control::Watch;
use gnurt_accel_core::direction_class::DirectionClass;
use gnurt_accel_core::threads::extend;
use gnurt_accel_core::tile::LANES;
use gnurt_accel_core::tile_test::TileTest;
use gnurt_accel_core::traversal::{RayTraversal, TileTraversal};
use gnurt_accel_core::triangle::ShearedRay;
use gnurt_accel_core::valid_triangles::ValidTriangles;
use gnurt_accel_core::{Aabb, BuildError, INVALID_ID, Structure, Threads, TreeStats};
use gnurt_simd::Simd;

use super::clips::Laid;
use super::node::{BihNode, BkdNode, Layout, MOST_NODES};
use super::share::{Binary, LEAF, Reference, Rule};
use super::walk::{PlaneRay, walk};

/// Nodes and triangles.
#[derive(Clone, Debug, PartialEq)]
pub struct IntervalIndex {
    pub(super) nodes: Nodes,
    pub(super) blocks: Vec<TriangleBlock>,
    pub(super) bounds: Aabb,
    /// The greatest coordinate.
    pub(super) greatest: f32,
    pub(super) stats: TreeStats,
    /// The expected cost of a ray at the build.
    pub(super) built: f64,
}

/// Nodes of one layout.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Nodes {
    Bih(Vec<BihNode>),
    Bkd(Vec<BkdNode>),
}

/// Runs `$body` on the nodes, in any layout.
macro_rules! with_nodes {
    ($nodes:expr, $list:ident => $body:expr) => {
        match $nodes {
            Nodes::Bih($list) => $body,
            Nodes::Bkd($list) => $body,
        }
    };
}
pub(super) use with_nodes;

impl IntervalIndex {
    /// Builds over the good triangles, one or more. `structure` selects the nodes, and whether there are
    /// clips.
    ///
    /// # Errors
    /// That `watch` stopped it, or that there are too many nodes.
    pub fn build(
        valid_triangles: &ValidTriangles,
        structure: Structure,
        threads: Threads,
        watch: &Watch,
    ) -> Result<Self, BuildError> {
        let count = valid_triangles.good.len();
        let passing = count * size_of::<Reference>();
        watch.take(passing);
        watch.result()?;
        let (rule, clips) = match structure {
            Structure::PlainBih => (Rule::Halves, false),
            _ => (Rule::Cost, true),
        };
        let tree = threads.run(|parallel| {
            let mut references = Vec::new();
            extend(parallel, &mut references, count, |i| {
                let number = valid_triangles.good[i];
                Reference { bounds: Aabb::around(&valid_triangles.corners(number)), number }
            });
            Binary::build(&mut references, rule, parallel, watch)
        })?;
        let bounds = *tree.bounds();
        let (nodes, in_blocks) = match structure {
            Structure::BKd => {
                let Laid { nodes, blocks, .. } = Laid::new(tree, clips);
                (Nodes::Bkd(nodes), blocks)
            }
            _ => {
                let Laid { nodes, blocks, .. } = Laid::new(tree, clips);
                (Nodes::Bih(nodes), blocks)
            }
        };
        let node_count = with_nodes!(&nodes, nodes => nodes.len());
        if node_count > MOST_NODES {
            let (blocks, most) = (in_blocks.len() as u64, (MOST_NODES / 2) as u64);
            return Err(BuildError::TooManyBlocks { blocks, most });
        }
        watch.take(in_blocks.len() * size_of::<TriangleBlock>());
        watch.result()?;
        let block = |i: usize| {
            let mut numbers = [INVALID_ID; LEAF];
            numbers[..in_blocks[i].len()].copy_from_slice(&in_blocks[i]);
            TriangleBlock::new(|number| valid_triangles.corners(number), &numbers)
        };
        let mut blocks = Vec::with_capacity(in_blocks.len());
        threads.run(|parallel| extend(parallel, &mut blocks, in_blocks.len(), block));
        drop(in_blocks);
        watch.give(passing);
        let greatest = bounds.greatest();
        let mut index = Self { nodes, blocks, bounds, greatest, stats: TreeStats::default(), built: 0.0 };
        index.measure(count as u64);
        index.built = index.stats.sah_cost;
        Ok(index)
    }

    /// Box around all triangles.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Size and shape.
    #[must_use]
    pub fn stats(&self) -> TreeStats {
        self.stats
    }

    /// How much more a ray is expected to do than when the tree was built.
    #[must_use]
    pub fn decline(&self) -> f64 {
        self.stats.sah_cost / self.built
    }

    /// Offers the ray's hits; it is valid and regular.
    #[inline(always)]
    pub(crate) fn search<S: Simd>(&self, simd: S, traversal: &mut RayTraversal) {
        with_nodes!(&self.nodes, nodes => self.search_in(simd, nodes, traversal));
    }

    #[inline(always)]
    fn search_in<S: Simd, N: Layout>(&self, simd: S, nodes: &[N], traversal: &mut RayTraversal) {
        let RayTraversal { ray, slot, .. } = *traversal;
        let planes = PlaneRay::new(ray, self.greatest);
        let t_near = ray.t_near;
        let interval = planes.clip(&self.bounds, [t_near, traversal.reach()]);
        let (lanes, single) = (BlockRay::new(simd, ray), ShearedRay::new(ray));
        let mut tested = 0;
        let visited = walk(
            nodes,
            &planes,
            interval,
            #[inline(always)]
            |block| {
                tested += WIDTH as u64;
                if const { S::LANES == 1 } {
                    self.blocks[block].meet_in_turn(&single, t_near, slot, traversal);
                } else {
                    self.blocks[block].meet(simd, &lanes, slot, traversal);
                }
                traversal.reach()
            },
        );
        traversal.counters.nodes += visited;
        traversal.counters.triangles += tested;
    }

    /// The same for a tile's first rays, all of them active and of one direction class.
    #[inline(always)]
    pub(crate) fn search_tile<S: Simd>(
        &self,
        simd: S,
        direction_class: DirectionClass,
        traversal: &mut TileTraversal,
    ) {
        with_nodes!(&self.nodes, nodes => self.search_tile_in(simd, nodes, direction_class, traversal));
    }

    #[inline(always)]
    fn search_tile_in<S: Simd, N: Layout>(
        &self,
        simd: S,
        nodes: &[N],
        direction_class: DirectionClass,
        traversal: &mut TileTraversal,
    ) {
        let TileTraversal { rays, kind, slot, .. } = *traversal;
        let count = TILE - traversal.active.leading_zeros() as usize;
        let [x, y, z] = self.bounds.extent();
        let size = x.max(y).max(z) as f32;
        let chunks =
            Chunks::new(simd, rays, count, direction_class, self.greatest, traversal.nearest, |whole| {
                whole.spread(size) > FARTHEST_SPREAD * size
            });
        let Some(mut chunks) = chunks else {
            return traversal.one_by_one_outlined(
                simd,
                #[inline(always)]
                |traversal| self.search_in(simd, nodes, traversal),
            );
        };
        let test = TileTest { simd, rays, kind, slot, direction_class };
        let (planes, mut tested) = (chunks.beam.planes(), 0u64);
        let interval = planes.clip(&self.bounds, chunks.farthest);
        let visited = walk(
            nodes,
            &planes,
            interval,
            #[inline(always)]
            |block| {
                let block = &self.blocks[block];
                chunks.block(
                    simd,
                    block,
                    traversal.active,
                    traversal.nearest,
                    #[inline(always)]
                    |candidate, slopes, nearest| {
                        tested += LANES as u64;
                        test.meet(block, &candidate, slopes, nearest)
                    },
                );
                chunks.farthest
            },
        );
        traversal.counters.nodes += visited * count as u64;
        traversal.counters.triangles += tested;
    }
}

/// Tiles may be this wide, as a part of the tree's size; wider ones go ray by ray.
const FARTHEST_SPREAD: f32 = 1.0 / 16.0;

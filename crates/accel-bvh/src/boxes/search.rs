// SPDX-License-Identifier: GPL-3.0-or-later
//! One ray, or one point, through a top tree. Source: [WBB08] as `walk`, [RKV95] as `point`. Space: that of the boxes.
//! Each treelet is traversed by a separate function: nested scenes of few instances must not take the stack
//! of two traversals.
//! Tests: `tests/instances.rs`, `tests/closest_point.rs` and `tests/limits.rs` of `gnurt-accel`.

use gnurt_accel_core::Ray;
use gnurt_simd::{Simd, StackBuffer, prelude::*};

use super::BoxIndex;
use super::met::{Member, MetBlock};
use crate::node::Child;
use crate::node_ray::NodeRay;
use crate::point::{Around, square_of, walk_near};
use crate::tree::DEEPEST;
use crate::treelet::{DEEPEST_TREELET, NodesAtKeys, Treelet};
use crate::walk::{Nodes, walk_with};

impl BoxIndex {
    /// Calls `enter` with the blocks of boxes that `ray`, which is regular and relative to the origin, meets before `reach`,
    /// nearer ones first; it answers with the new reach. Returns the number of nodes visited. There are boxes.
    #[inline(always)]
    pub(crate) fn search<S: Simd>(&self, simd: S, ray: &Ray, reach: f32, enter: EnterBlock) -> u32 {
        let away = || ray.org.iter().fold(0.0f32, |most, x| most.max(x.abs()));
        let for_nodes = &NodeRay::new(simd, ray, self.greatest_for(away));
        match &self.treelets[..] {
            [only] => search_treelet(simd, (0, only), ROOT, for_nodes, ray.time, reach, enter).1,
            treelets => {
                let below = Below { treelets, time: ray.time };
                search_upper(simd, &self.upper, &below, ROOT, for_nodes, reach, enter)
            }
        }
    }

    /// Calls `enter` with the indices of boxes within `radius` of `point`, which is relative to the origin,
    /// nearer ones first; it returns the new radius. There are boxes.
    #[inline(always)]
    pub(crate) fn near<S: Simd>(
        &self,
        simd: S,
        point: &[f64; 3],
        radius: f64,
        enter: &mut dyn FnMut(usize) -> f64,
    ) {
        let around = &Around::new(simd, point);
        match &self.treelets[..] {
            [only] => near_treelet(simd, only, around, radius, enter),
            treelets => near_upper(simd, &self.upper, treelets, around, radius, enter),
        };
    }
}

/// The start of a single ray.
const ROOT: Child = Child::node(0);

/// Stacks for the upper treelet, which is built as any tree, and for those below: nested scenes hold one of
/// these each.
type Long = StackBuffer<u64, { 8 * DEEPEST }>;
type Short = StackBuffer<u64, { 8 * DEEPEST_TREELET }>;

/// Takes the members of a block that a ray meets, and answers with the new reach.
pub(super) type EnterBlock<'a> = &'a mut dyn FnMut(MetBlock) -> f32;

/// From `start` on, calls `enter` with the members of each block whose boxes the ray meets before `reach`, and with that; it
/// answers with the new one. Returns the last one, and the number of nodes visited. Blocks are counted with the nodes.
#[inline(always)]
fn search_nodes<S: Simd, const WAIT: usize>(
    simd: S,
    buffer: StackBuffer<u64, WAIT>,
    nodes: &(impl Nodes + ?Sized),
    start: Child,
    ray: &NodeRay<S>,
    mut reach: f32,
    mut enter: impl FnMut(MetBlock, f32) -> f32,
) -> (f32, u32) {
    let visited = walk_with(
        buffer,
        nodes,
        simd,
        start,
        ray,
        reach,
        #[inline(always)]
        |range| {
            for block in range {
                let (bits, near, members) = nodes.meet(simd, block, ray, reach);
                if bits != 0 {
                    let near = near.as_array();
                    reach = enter(MetBlock { treelet: 0, block, bits, near, members }, reach);
                }
            }
            reach
        },
    );
    (reach, visited)
}

/// The same at a moment, as a function of its own: for the treelets below the upper one.
#[inline(never)]
pub(super) fn search_treelet<S: Simd>(
    simd: S,
    (number, treelet): (usize, &Treelet),
    start: Child,
    ray: &NodeRay<S>,
    time: f32,
    reach: f32,
    enter: EnterBlock,
) -> (f32, u32) {
    let first_block = treelet.node_count();
    let enter =
        &mut |met: MetBlock| enter(MetBlock { treelet: number, block: met.block - first_block, ..met });
    match treelet.at_keys() {
        None => simd.vectorize(
            #[inline(always)]
            || search_nodes(simd, Short::new(), treelet.nodes(), start, ray, reach, |met, _| enter(met)),
        ),
        Some(keys) => search_keys(simd, keys, start, ray, time, reach, enter),
    }
}

/// The same where members move.
#[inline(never)]
fn search_keys<S: Simd>(
    simd: S,
    keys: &NodesAtKeys,
    start: Child,
    ray: &NodeRay<S>,
    time: f32,
    reach: f32,
    enter: EnterBlock,
) -> (f32, u32) {
    simd.vectorize(
        #[inline(always)]
        || {
            let nodes = &keys.interpolated(time);
            search_nodes(simd, Short::new(), nodes, start, ray, reach, |met, _| enter(met))
        },
    )
}

/// The same through the upper treelet into those below; returns the number of nodes visited.
pub(super) fn search_upper<S: Simd>(
    simd: S,
    upper: &Treelet,
    below: &Below,
    start: Child,
    ray: &NodeRay<S>,
    reach: f32,
    enter: EnterBlock,
) -> u32 {
    match upper.at_keys() {
        None => below.search(simd, upper.nodes(), start, ray, reach, enter),
        Some(keys) => below.search(simd, &keys.interpolated(below.time), start, ray, reach, enter),
    }
}

/// Treelets below the upper one, at one time.
pub(super) struct Below<'a> {
    pub(super) treelets: &'a [Treelet],
    pub(super) time: f32,
}

impl Below<'_> {
    #[inline(never)]
    fn search<S: Simd>(
        &self,
        simd: S,
        upper: &(impl Nodes + ?Sized),
        start: Child,
        ray: &NodeRay<S>,
        reach: f32,
        enter: EnterBlock,
    ) -> u32 {
        simd.vectorize(
            #[inline(always)]
            || {
                let mut visited = 0;
                let above = search_nodes(
                    simd,
                    Long::new(),
                    upper,
                    start,
                    ray,
                    reach,
                    #[inline(always)]
                    |mut met, mut reach| {
                        while let Some(Member { index, .. }) = met.next(reach) {
                            let treelet = (index, &self.treelets[index]);
                            let (nearer, count) =
                                search_treelet(simd, treelet, ROOT, ray, self.time, reach, enter);
                            visited += count;
                            reach = nearer;
                        }
                        reach
                    },
                );
                visited + above.1
            },
        )
    }
}

/// Calls `enter` with the members within `radius`, and with that; it answers with the new one. Returns the last one.
#[inline(always)]
fn near_nodes<S: Simd>(
    simd: S,
    treelet: &Treelet,
    around: &Around<S>,
    mut radius: f64,
    mut enter: impl FnMut(usize, f64) -> f64,
) -> f64 {
    let nodes = treelet.nodes();
    walk_near(
        simd,
        radius,
        #[inline(always)]
        |index| (around.squares(simd, &nodes[index]), nodes[index].children()),
        #[inline(always)]
        |range| {
            for block in &nodes[range] {
                let squares = around.squares(simd, block).to_array();
                for (lane, square) in squares.into_iter().enumerate() {
                    if square <= square_of(radius) && !block.bounds(lane).is_empty() {
                        radius = enter(block.child(lane).index(), radius);
                    }
                }
            }
            radius
        },
    );
    radius
}

/// The same, as a separate function: for the treelets below the upper one.
#[inline(never)]
fn near_treelet<S: Simd>(
    simd: S,
    treelet: &Treelet,
    around: &Around<S>,
    radius: f64,
    enter: &mut dyn FnMut(usize) -> f64,
) -> f64 {
    simd.vectorize(
        #[inline(always)]
        || near_nodes(simd, treelet, around, radius, |member_index, _| enter(member_index)),
    )
}

/// The same through the upper treelet into those below.
#[inline(never)]
fn near_upper<S: Simd>(
    simd: S,
    upper: &Treelet,
    treelets: &[Treelet],
    around: &Around<S>,
    radius: f64,
    enter: &mut dyn FnMut(usize) -> f64,
) -> f64 {
    simd.vectorize(
        #[inline(always)]
        || {
            near_nodes(
                simd,
                upper,
                around,
                radius,
                #[inline(always)]
                |number, radius| near_treelet(simd, &treelets[number], around, radius, enter),
            )
        },
    )
}

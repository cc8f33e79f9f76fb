// SPDX-License-Identifier: GPL-3.0-or-later
//! Everything that is not a triangle under a wide BVH: leaf blocks of eight primitives of one kind.
//! A kind is a type that implements [`BlockKind`], in a file of its own, and a line in `blocks.rs`;
//! docs/how-to/add-a-primitive.md leads through it. Space: object.
//! Invariant: a lane whose number is `INVALID_ID` is empty, and nothing meets it. Tests: `tests/mixed.rs` and
//! `tests/saved.rs` of `gnurt-accel`.

mod build;
mod store;

use std::fmt;
use std::io::{self, Read, Write};
use std::ops::Range;

use gnurt_accel_core::geometry::GeometryKind;
use gnurt_accel_core::point::{NearestPoint, Probe};
use gnurt_accel_core::primitive::Primitive;
use gnurt_accel_core::region::RegionFilter;
use gnurt_accel_core::store::{LoadError, Reader, StoredRecord, Writer};
use gnurt_accel_core::traversal::{RayKind, RayTraversal};
use gnurt_accel_core::{Aabb, BadPrimitives, INVALID_ID, Ray, TreeStats};
use gnurt_simd::Simd;

pub use build::Inputs;

use crate::node::{Child, WIDTH};
use crate::node_ray::NodeRay;
use crate::tree::Tree;
use crate::walk::{Ahead, walk, walk_any};

/// A kind of primitives: a block of eight of them.
pub trait BlockKind: StoredRecord + Clone + fmt::Debug + Send + Sync {
    /// The kind in files, with nodes of either form; or the reason why it cannot be saved.
    const IN_FILES: Result<[u64; 2], &'static str>;
    /// How many primitives a lane may hold: 1, or [`WIDTH`] with numbers of their own.
    const IN_LANE: usize = 1;
    /// Whether any hit is found sooner if nodes are visited in no order.
    const ANY_ORDER: bool = false;
    /// Whether closest hits are found sooner if children of a node behind the nearest two are not sorted: where rays pass most of
    /// what they come to.
    const TWO_FIRST: bool = false;
    /// One primitive, a piece of one, or several, on the way into a lane.
    type Item: Clone + Send + Sync;
    /// Data of one geometry that its primitives share; `()` for none.
    type Data: BlockData;
    /// Primitives whose tests wait; `()` where none do.
    type Waiting: Default;
    /// A ray made ready for blocks.
    type Ready<S: Simd>: Copy;

    /// Whether a leaf is tested when the next one is met, so that its memory has arrived by then. Worth it where rays visit much of
    /// a large tree; the end of the ray comes nearer a bit later.
    #[inline(always)]
    fn leaves_wait(_shared: &Shared<Self>) -> bool {
        false
    }

    /// Whether a geometry is of this kind.
    fn is_kind_of(kind: &GeometryKind) -> bool;

    /// Shared data of a geometry of this kind.
    fn data(kind: &GeometryKind) -> Self::Data;

    /// Calls `each` with all pieces of a primitive, most often one. None of one that cannot be traced, whose fault is counted.
    fn items(kind: &GeometryKind, prim_id: u32, bad: &mut BadPrimitives, each: &mut dyn FnMut(Self::Item));

    /// Calls `each` with all pieces of the first `count` primitives of a geometry, and the index of the first primitive in each.
    /// Returns how many primitives can be traced.
    fn all_items(
        kind: &GeometryKind,
        count: u32,
        bad: &mut BadPrimitives,
        each: &mut dyn FnMut(u32, Self::Item),
    ) -> u64 {
        let mut primitives = 0;
        for prim_id in 0..count {
            let mut pieces = 0;
            Self::items(kind, prim_id, bad, &mut |item| {
                pieces += 1;
                each(prim_id, item);
            });
            primitives += u64::from(pieces > 0);
        }
        primitives
    }

    /// The box around a piece.
    fn bounds(item: &Self::Item) -> Aabb;

    /// A block of empty lanes.
    fn empty() -> Self;

    /// Makes an empty block ready for these items, which are about to be set.
    fn frame(&mut self, _items: &[Option<&Self::Item>; WIDTH]) {}

    /// Fills a lane.
    fn set(&mut self, lane: usize, item: &Self::Item, number: u32);

    /// The piece of a lane where its primitive is now; `None` where that cannot be traced.
    fn moved(&self, _lane: usize, kind: &GeometryKind, prim_id: u32) -> Option<Self::Item> {
        let mut found = None;
        Self::items(kind, prim_id, &mut BadPrimitives::default(), &mut |item| found = Some(item));
        found
    }

    /// Numbers in the object: those of the first primitives in the lanes.
    fn numbers(&self) -> &[u32; WIDTH];

    /// The numbers of all primitives in a lane.
    fn numbers_in(&self, lane: usize) -> [u32; WIDTH] {
        let mut numbers = [INVALID_ID; WIDTH];
        numbers[0] = self.numbers()[lane];
        numbers
    }

    /// Makes a valid and regular ray ready for a tree whose greatest coordinate is `greatest`.
    fn ready<S: Simd>(simd: S, ray: &Ray, greatest: f32) -> Self::Ready<S>;

    /// Offers all hits within the ray's extent. Returns how many primitives were tested.
    fn meet<S: Simd>(
        &self,
        simd: S,
        ready: &Self::Ready<S>,
        shared: &Shared<Self>,
        traversal: &mut RayTraversal,
    ) -> u64;

    /// The same for the blocks of a leaf; some tests may wait until [`finish`](Self::finish).
    #[inline(always)]
    fn meet_leaf<S: Simd>(
        blocks: &[Self],
        leaf: Range<usize>,
        simd: S,
        ready: &Self::Ready<S>,
        shared: &Shared<Self>,
        _waiting: &mut Self::Waiting,
        traversal: &mut RayTraversal,
    ) -> u64 {
        let mut tested = 0;
        for block in &blocks[leaf] {
            tested += block.meet(simd, ready, shared, traversal);
        }
        tested
    }

    /// Makes the tests that wait.
    #[inline(always)]
    fn finish<S: Simd>(
        _blocks: &[Self],
        _simd: S,
        _ready: &Self::Ready<S>,
        _shared: &Shared<Self>,
        _waiting: &mut Self::Waiting,
        _traversal: &mut RayTraversal,
    ) -> u64 {
        0
    }

    /// Offers the nearest point of a lane, which is not empty.
    fn near(
        &self,
        lane: usize,
        shared: &Shared<Self>,
        probe: &Probe,
        slot: u32,
        nearest: &mut dyn NearestPoint,
    );

    /// A primitive in a lane, which has it: by its place in [`numbers_in`](Self::numbers_in).
    fn primitive<'a>(&'a self, lane: usize, which: usize, shared: &'a Shared<Self>) -> Primitive<'a>;

    /// Whether a lane of a file holds a primitive that could have been built, or nothing; there are `count` in all.
    fn is_sound(&self, lane: usize, shared: &Shared<Self>, count: u32) -> bool;
}

/// Data that primitives of one geometry share.
pub trait BlockData: Clone + fmt::Debug + Send + Sync {
    /// Bytes of it.
    fn memory_bytes(&self) -> usize {
        0
    }

    /// Writes it.
    fn save(&self, writer: &mut Writer<'_, impl Write>) -> io::Result<()>;

    /// Reads it.
    fn load(reader: &mut Reader<'_, impl Read>) -> Result<Self, LoadError>;
}

impl BlockData for () {
    fn save(&self, _: &mut Writer<'_, impl Write>) -> io::Result<()> {
        Ok(())
    }

    fn load(_: &mut Reader<'_, impl Read>) -> Result<Self, LoadError> {
        Ok(())
    }
}

/// Shared data of all geometries, with their first numbers, ascending.
#[derive(Clone, Debug)]
pub struct Shared<B: BlockKind>(Vec<(u32, B::Data)>);

impl<B: BlockKind> Shared<B> {
    /// The same with other data.
    pub(crate) fn map(&self, other: impl Fn(&B::Data) -> B::Data) -> Self {
        Self(self.0.iter().map(|(start, data)| (*start, other(data))).collect())
    }

    /// The data of a number's geometry, and its index there.
    pub(crate) fn of(&self, number: u32) -> (&B::Data, u32) {
        let at = self.0.partition_point(|(start, _)| *start <= number) - 1;
        let (start, data) = &self.0[at];
        (data, number - start)
    }

    /// Those of the first geometry.
    #[inline(always)]
    pub(crate) fn first(&self) -> Option<&B::Data> {
        self.0.first().map(|(_, data)| data)
    }

    /// The same where a file may have any number.
    pub(crate) fn get(&self, number: u32) -> Option<(&B::Data, u32)> {
        let at = self.0.partition_point(|(start, _)| *start <= number).checked_sub(1)?;
        self.0.get(at).map(|(start, data)| (data, number - start))
    }
}

/// Tree and blocks of one kind.
#[derive(Clone, Debug)]
pub struct Blocked<B: BlockKind> {
    pub(crate) tree: Tree,
    pub(crate) blocks: Vec<B>,
    pub(crate) shared: Shared<B>,
    /// The greatest coordinate of any plane.
    pub(crate) greatest: f32,
    stats: TreeStats,
}

impl<B: BlockKind> Blocked<B> {
    /// Of a tree over these blocks.
    pub(crate) fn of(tree: Tree, blocks: Vec<B>, shared: Shared<B>, stats: TreeStats) -> Self {
        Self { greatest: tree.greatest(), tree, blocks, shared, stats }
    }

    /// Box around everything.
    pub(crate) fn bounds(&self) -> Aabb {
        self.tree.bounds
    }

    /// Size and shape.
    pub(crate) fn stats(&self) -> TreeStats {
        let shared: usize = self.shared.0.iter().map(|(_, data)| data.memory_bytes()).sum();
        TreeStats {
            tree_bytes: self.tree.node_bytes() as u64,
            primitive_bytes: (size_of_val(&self.blocks[..]) + shared) as u64,
            ..self.stats
        }
    }

    /// Numbers of all leaf blocks, and how many there are. Each lane that holds several primitives counts as a block.
    pub(crate) fn numbers(&self, visit: &mut dyn FnMut(usize, &[u32; WIDTH])) -> usize {
        for (i, block) in self.blocks.iter().enumerate() {
            match B::IN_LANE {
                1 => visit(i, block.numbers()),
                _ => (0..WIDTH).for_each(|lane| visit(i * WIDTH + lane, &block.numbers_in(lane))),
            }
        }
        self.blocks.len() * B::IN_LANE
    }

    /// The primitive in a lane of these blocks.
    pub(crate) fn primitive(&self, block: usize, lane: usize) -> Primitive<'_> {
        match B::IN_LANE {
            1 => self.blocks[block].primitive(lane, 0, &self.shared),
            _ => self.blocks[block / WIDTH].primitive(block % WIDTH, lane, &self.shared),
        }
    }

    /// Offers the ray's hits; it is valid and regular, the tree not empty.
    #[inline(always)]
    pub(crate) fn search<S: Simd>(&self, simd: S, traversal: &mut RayTraversal) {
        let Self { tree, blocks, shared, greatest, .. } = self;
        let for_nodes = NodeRay::new(simd, traversal.ray, *greatest);
        let ready = B::ready(simd, traversal.ray, *greatest);
        let (mut tested, mut waiting) = (0, B::Waiting::default());
        let (nodes, start, reach) =
            (Ahead { tree, blocks, two_first: B::TWO_FIRST }, Child::node(0), traversal.reach());
        // The leaf before, if they wait.
        let mut pending = 0..0;
        let leaves_wait = B::leaves_wait(shared);
        // Two closures: one that both walks call could become a call.
        let visited = if B::ANY_ORDER && matches!(traversal.kind, RayKind::Any) {
            walk_any(
                &nodes,
                simd,
                start,
                &for_nodes,
                reach,
                #[inline(always)]
                |range| {
                    let range = if leaves_wait { std::mem::replace(&mut pending, range) } else { range };
                    tested += B::meet_leaf(blocks, range, simd, &ready, shared, &mut waiting, traversal);
                    traversal.reach() != f32::NEG_INFINITY
                },
            )
        } else {
            walk(
                &nodes,
                simd,
                start,
                &for_nodes,
                reach,
                #[inline(always)]
                |range| {
                    let range = if leaves_wait { std::mem::replace(&mut pending, range) } else { range };
                    tested += B::meet_leaf(blocks, range, simd, &ready, shared, &mut waiting, traversal);
                    traversal.reach()
                },
            )
        };
        if leaves_wait {
            tested += B::meet_leaf(blocks, pending, simd, &ready, shared, &mut waiting, traversal);
        }
        tested += B::finish(blocks, simd, &ready, shared, &mut waiting, traversal);
        traversal.counters.nodes += u64::from(visited);
        traversal.counters.triangles += tested;
    }

    /// Improves `nearest` by the primitives.
    #[inline(always)]
    pub(crate) fn nearest<S: Simd>(&self, simd: S, probe: &Probe, slot: u32, nearest: &mut dyn NearestPoint) {
        let Self { tree, blocks, shared, .. } = self;
        tree.near(simd, &probe.point, probe.radius_for(nearest.distance()), |range| {
            for block in &blocks[range] {
                lanes(block).for_each(|(lane, _)| block.near(lane, shared, probe, slot, nearest));
            }
            probe.radius_for(nearest.distance())
        });
    }

    /// Shows the primitives that may meet a region.
    pub(crate) fn filter_region(&self, region_filter: &RegionFilter, visit: &mut dyn FnMut(u32, Primitive)) {
        self.tree.filter_region(region_filter, &mut |range| {
            for block in &self.blocks[range] {
                for (lane, which, number) in primitives(block) {
                    visit(number, block.primitive(lane, which, &self.shared));
                }
            }
        });
    }
}

/// Lanes that are not empty, with their numbers.
pub(crate) fn lanes<B: BlockKind>(block: &B) -> impl Iterator<Item = (usize, u32)> + use<B> {
    let numbers = *block.numbers();
    (0..WIDTH).map(move |lane| (lane, numbers[lane])).filter(|&(_, number)| number != INVALID_ID)
}

/// All primitives of a block: their lanes, their places there, and their numbers.
pub(crate) fn primitives<B: BlockKind>(block: &B) -> impl Iterator<Item = (usize, usize, u32)> {
    let numbered = |lane| (0..).zip(block.numbers_in(lane)).map(move |(which, number)| (lane, which, number));
    (0..WIDTH).flat_map(numbered).filter(|&(_, _, number)| number != INVALID_ID)
}

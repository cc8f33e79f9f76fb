// SPDX-License-Identifier: GPL-3.0-or-later
//! Grids in leaf blocks of eight patches: two by two cells each, three by three of the vertices that all cells of a geometry share.
//! Lanes compare the ray with the boxes of patches first, then with the eight triangles of a patch that it may meet.
//! Space: object. Invariant: hits are those of the same cells as quads, bit for bit. Tests: `tests/grid_meshes.rs` of `gnurt-accel`.

mod store;

use std::sync::Arc;

use gnurt_accel_core::blocks::{BlockRay, TriangleBlock};
use gnurt_accel_core::collect::Collect;
use gnurt_accel_core::geometry::GeometryKind;
use gnurt_accel_core::grids::Grids;
use gnurt_accel_core::nearest::NOWHERE;
use gnurt_accel_core::patches::{CORNERS, OwnedVertices, Patch, Row, meet_patch};
use gnurt_accel_core::point::{NearestPoint, Probe};
use gnurt_accel_core::primitive::Primitive;
use gnurt_accel_core::traversal::RayTraversal;
use gnurt_accel_core::triangle::TriangleHit;
use gnurt_accel_core::{Aabb, BadPrimitives, INVALID_ID, Ray};
use gnurt_simd::{Simd, prelude::*};

use crate::blocked::{BlockKind, Shared};
use crate::compact::CompactNode;
use crate::node::{Child, Node8, WIDTH};
use crate::node_ray::NodeRay;

/// Eight patches, in three cache lines.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct GridBlock {
    boxes: CompactNode,
    /// Numbers of their first halves, as of quads.
    numbers: [u32; WIDTH],
    /// First vertices.
    vertices: [u32; WIDTH],
    /// From row to row of vertices.
    strides: [u32; WIDTH],
    /// Cells in a row of the whole grid.
    columns: [u16; WIDTH],
    /// By bits: the halves that can be traced. None in empty lanes.
    halves: [u8; WIDTH],
}

/// A ray for boxes and for triangles.
#[derive(Clone, Copy)]
pub struct ReadyRay<S: Simd> {
    for_boxes: NodeRay<S>,
    for_triangles: BlockRay<S>,
}

impl GridBlock {
    /// The vertices of a patch.
    #[inline(always)]
    fn rows<'a>(&self, lane: usize, shared: &'a Shared<Self>) -> [&'a Row; 3] {
        let lane = lane & (WIDTH - 1);
        let vertices = shared.get(self.numbers[lane]).map(|(vertices, _)| vertices);
        vertices.map_or([&[0.0; 16]; 3], |vertices| vertices.rows(self.vertices[lane], self.strides[lane]))
    }

    /// The triangles of a patch, one in each lane; in place of those that are left out one of the others.
    #[cold]
    #[inline(never)]
    fn triangles(&self, lane: usize, shared: &Shared<Self>) -> TriangleBlock {
        let lane = lane & (WIDTH - 1);
        let (first, columns, halves) = (self.numbers[lane], self.columns[lane], self.halves[lane]);
        let rows = self.rows(lane, shared);
        let corner = |i: usize| [0, 1, 2].map(|k| rows[i / 3][3 * (i % 3) + k]);
        let mut block = TriangleBlock::ZERO;
        let one = halves.trailing_zeros() as usize & (WIDTH - 1);
        for half in 0..WIDTH {
            let own = if halves >> half & 1 != 0 { half } else { one };
            block.put(half, &CORNERS[own].map(corner), Patch::number(first, columns, own));
        }
        block
    }
}

/// Offers the hits of halves, by bits.
#[inline(always)]
fn offer(
    mut bits: u64,
    [t, u, v]: &[[f32; WIDTH]; 3],
    first: u32,
    columns: u16,
    traversal: &mut RayTraversal,
) {
    while bits != 0 {
        let half = bits.trailing_zeros() as usize & (WIDTH - 1);
        bits &= bits - 1;
        if t[half] <= traversal.reach() {
            let hit = TriangleHit { t: t[half], u: u[half], v: v[half] };
            traversal.offer(hit, Patch::number(first, columns, half), traversal.slot);
        }
    }
}

fn grids<'a>(kind: &GeometryKind<'a>) -> Grids<'a> {
    match kind {
        GeometryKind::Grids(grids) => *grids,
        _ => Grids::default(),
    }
}

impl BlockKind for GridBlock {
    const IN_FILES: Result<[u64; 2], &'static str> = Ok([10, 11]);
    const IN_LANE: usize = WIDTH;
    type Item = Patch;
    type Data = Arc<OwnedVertices>;
    type Waiting = ();
    type Ready<S: Simd> = ReadyRay<S>;

    fn is_kind_of(kind: &GeometryKind) -> bool {
        matches!(kind, GeometryKind::Grids(_))
    }

    fn data(kind: &GeometryKind) -> Self::Data {
        Arc::new(OwnedVertices::new(grids(kind).positions))
    }

    /// A patch has several primitives, and is among all items.
    fn items(_: &GeometryKind, _: u32, _: &mut BadPrimitives, _: &mut dyn FnMut(Patch)) {}

    fn all_items(
        kind: &GeometryKind,
        numbers: u32,
        bad: &mut BadPrimitives,
        each: &mut dyn FnMut(u32, Patch),
    ) -> u64 {
        grids(kind).patches(numbers, bad, each)
    }

    fn bounds(patch: &Patch) -> Aabb {
        patch.bounds
    }

    fn empty() -> Self {
        Self {
            boxes: CompactNode::EMPTY,
            numbers: [INVALID_ID; WIDTH],
            vertices: [0; WIDTH],
            strides: [0; WIDTH],
            columns: [0; WIDTH],
            halves: [0; WIDTH],
        }
    }

    fn frame(&mut self, items: &[Option<&Patch>; WIDTH]) {
        let mut node = Node8::EMPTY;
        for (lane, patch) in items.iter().enumerate() {
            if let Some(patch) = patch {
                // Any child: one that is there.
                node.set(lane, &patch.bounds, Child::node(0));
            }
        }
        self.boxes = CompactNode::new(&node);
    }

    fn set(&mut self, lane: usize, patch: &Patch, number: u32) {
        (self.numbers[lane], self.vertices[lane]) = (number, patch.vertex);
        (self.strides[lane], self.columns[lane]) = (patch.stride, patch.columns);
        self.halves[lane] = patch.halves;
    }

    fn numbers(&self) -> &[u32; WIDTH] {
        &self.numbers
    }

    fn numbers_in(&self, lane: usize) -> [u32; WIDTH] {
        let mut numbers = [INVALID_ID; WIDTH];
        for (half, number) in numbers.iter_mut().enumerate() {
            if self.halves[lane] >> half & 1 != 0 {
                *number = Patch::number(self.numbers[lane], self.columns[lane], half);
            }
        }
        numbers
    }

    #[inline(always)]
    fn ready<S: Simd>(simd: S, ray: &Ray, greatest: f32) -> ReadyRay<S> {
        // Planes of these boxes lie farther out than those of nodes.
        let for_boxes = NodeRay::new(simd, ray, CompactNode::widened(greatest));
        ReadyRay { for_boxes, for_triangles: BlockRay::new(simd, ray) }
    }

    #[inline(always)]
    fn meet<S: Simd>(
        &self,
        simd: S,
        ready: &ReadyRay<S>,
        shared: &Shared<Self>,
        traversal: &mut RayTraversal,
    ) -> u64 {
        let (mut bits, near) = ready.for_boxes.meet(simd, &self.boxes, traversal.reach());
        let (near, slot, mut tested) = (near.to_array(), traversal.slot, 0);
        while bits != 0 {
            let lane = bits.trailing_zeros() as usize & (WIDTH - 1);
            bits &= bits - 1;
            // A ray from very far away meets boxes of empty lanes.
            if near[lane] <= traversal.reach() && self.halves[lane] != 0 {
                tested += WIDTH as u64;
                let (first, columns) = (self.numbers[lane], self.columns[lane]);
                let rows = self.rows(lane, shared);
                meet_patch(
                    simd,
                    rows,
                    self.halves[lane],
                    &ready.for_triangles,
                    traversal,
                    #[inline(always)]
                    |bits, hits, traversal| offer(bits, hits, first, columns, traversal),
                    #[inline(always)]
                    |bits, hits, single, traversal| {
                        self.triangles(lane, shared).meet_in_doubt(
                            bits,
                            hits,
                            single,
                            [slot, NOWHERE],
                            traversal,
                        );
                    },
                );
            }
        }
        tested
    }

    fn near(
        &self,
        lane: usize,
        shared: &Shared<Self>,
        probe: &Probe,
        slot: u32,
        nearest: &mut dyn NearestPoint,
    ) {
        self.triangles(lane, shared).nearest(probe, slot, nearest);
    }

    fn primitive<'a>(&'a self, lane: usize, which: usize, shared: &'a Shared<Self>) -> Primitive<'a> {
        Primitive::Triangle(self.triangles(lane, shared).corners_of(which, [0, 1, 2]))
    }

    fn is_sound(&self, lane: usize, shared: &Shared<Self>, count: u32) -> bool {
        let halves = self.halves[lane];
        if self.boxes.check().is_err() || (self.numbers[lane] == INVALID_ID) != (halves == 0) {
            return false;
        }
        let Some((vertices, _)) = shared.get(self.numbers[lane]).filter(|_| halves != 0) else {
            return halves == 0;
        };
        let last = u64::from(self.numbers[lane]) + 2 * u64::from(self.columns[lane]) + 3;
        if last >= u64::from(u32::MAX) {
            return false;
        }
        let own = self.numbers_in(lane);
        let are_numbers = own.iter().filter(|&&number| number != INVALID_ID).all(|&number| number < count);
        are_numbers && vertices.holds(self.vertices[lane], self.strides[lane], halves)
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! All primitives under a wide BVH that may meet a region.
//! Invariant: leaves show primitives by boxes of their own, so that few are looked at closely. A primitive may come several
//! times. Tests: `tests/surfaces/crossings.rs`, `tests/surfaces/overlaps.rs`.

use std::ops::Range;

use gnurt_accel_core::INVALID_ID;
use gnurt_accel_core::bits::each;
use gnurt_accel_core::primitive::Primitive;
use gnurt_accel_core::region::{Region, Rows, Sieve};
use gnurt_accel_core::sift::{NOTHING, sift_triangles};
use gnurt_simd::StackRoom;

use crate::blocked::Blocked;
use crate::boxes::BoxIndex;
use crate::index::BvhIndex;
use crate::node::{Child, Node8, WIDTH};
use crate::pools::Pools;
use crate::spheres::SphereIndex;
use crate::tree::{DEEPEST, Tree};
use crate::treelet::Treelet;
use crate::user::UserIndex;

impl Tree {
    /// Shows `leaf` the blocks of leaves that may meet it.
    pub(crate) fn sift(&self, sieve: &Sieve, leaf: &mut dyn FnMut(Range<usize>)) {
        if self.nodes.is_empty() && self.compact.is_empty() {
            return;
        }
        let mut room = StackRoom::<Child, { 8 * DEEPEST }>::new();
        let mut waiting = room.stack();
        waiting.push(Child::node(0));
        while let Some(child) = waiting.pop() {
            if child.is_leaf() {
                leaf(child.blocks());
                continue;
            }
            match self.nodes.get(child.index()) {
                Some(node) => meeting(node, sieve, |place| waiting.push(node.child(place))),
                None => {
                    let (node, children) = self.compact_node(child.index());
                    let mut rows = NOTHING;
                    let boxes: [_; WIDTH] = std::array::from_fn(|place| node.bounds(place));
                    for k in 0..3 {
                        rows[2 * k] = boxes.map(|bounds| bounds.min[k]);
                        rows[2 * k + 1] = boxes.map(|bounds| bounds.max[k]);
                    }
                    each(u64::from(sieve.meets(&rows)), |place| waiting.push(Child::at(children, place)));
                }
            }
        }
    }
}

/// Shows `visit` the places of boxes that may meet it.
fn meeting(node: &Node8, sieve: &Sieve, visit: impl FnMut(usize)) {
    let rows: &Rows = node.rows.first_chunk().unwrap_or(&NOTHING);
    each(u64::from(sieve.meets(rows)), visit);
}

impl Pools {
    /// The corners of one triangle of a block.
    pub(crate) fn triangle(&self, block: usize, lane: usize) -> [[f32; 3]; 3] {
        let block = &self.blocks[block];
        let pool = self.corners.get(block.pool as usize..).unwrap_or(&[]);
        // Behind the corners of a damaged file lie zeros, as for rays.
        let float = |i: usize| pool.get(i).copied().unwrap_or(0.0);
        [0, 1, 2].map(|corner: usize| [0, 1, 2].map(|k| float(usize::from(block.places[corner][lane]) + k)))
    }

    /// Shows those triangles of a block that may meet it.
    fn sift(&self, index: usize, sieve: &Sieve, visit: &mut dyn FnMut(u32, Primitive)) {
        let mut corners = [[[0.0; WIDTH]; 3]; 3];
        for lane in 0..WIDTH {
            for (rows, corner) in corners.iter_mut().zip(self.triangle(index, lane)) {
                (rows[0][lane], rows[1][lane], rows[2][lane]) = (corner[0], corner[1], corner[2]);
            }
        }
        sift_triangles(&corners, &self.blocks[index].numbers, sieve, visit);
    }
}

impl BvhIndex {
    /// Shows the triangles that may meet it.
    pub fn sift(&self, sieve: &Sieve, visit: &mut dyn FnMut(u32, Primitive)) {
        let Self { tree, leaves, .. } = self;
        tree.sift(sieve, &mut |range| {
            for index in range {
                match (leaves.blocks.get(index), &leaves.posed) {
                    (Some(block), _) => block.sift(sieve, visit),
                    (None, Some(posed)) => posed.sift(index, sieve, visit),
                    (None, None) => leaves.pools.sift(index, sieve, visit),
                }
            }
        });
    }
}

impl SphereIndex {
    /// Shows the spheres that may meet it.
    pub fn sift(&self, sieve: &Sieve, visit: &mut dyn FnMut(u32, Primitive)) {
        let Blocked { tree, blocks, .. } = &self.0;
        tree.sift(sieve, &mut |range| {
            for block in &blocks[range] {
                for i in (0..WIDTH).filter(|&i| block.numbers[i] != INVALID_ID) {
                    let center = [0, 1, 2].map(|k| block.center[k][i]);
                    visit(block.numbers[i], Primitive::Sphere(center, block.radius[i]));
                }
            }
        });
    }
}

impl UserIndex {
    /// Shows the primitives that may meet it.
    pub fn sift(&self, sieve: &Sieve, visit: &mut dyn FnMut(u32, Primitive)) {
        let Blocked { tree, blocks, .. } = &self.over;
        tree.sift(sieve, &mut |range| {
            for &number in blocks[range].iter().flatten().filter(|&&number| number != INVALID_ID) {
                let (user, prim_id) = self.primitive(number);
                visit(number, Primitive::User(user, prim_id));
            }
        });
    }
}

impl Treelet {
    /// Shows `visit` the members whose boxes may meet it.
    fn sift(&self, sieve: &Sieve, visit: &mut dyn FnMut(usize)) {
        let mut room = StackRoom::<Child, { 8 * DEEPEST }>::new();
        let mut waiting = room.stack();
        waiting.push(Child::node(0));
        while let Some(child) = waiting.pop() {
            if child.is_leaf() {
                for block in &self.nodes()[child.blocks()] {
                    meeting(block, sieve, |place| visit(block.child(place).index()));
                }
            } else {
                let node = &self.nodes()[child.index()];
                meeting(node, sieve, |place| waiting.push(node.child(place)));
            }
        }
    }
}

impl BoxIndex {
    /// Shows `enter` the places of boxes that may meet a region, which is not relative to their origin.
    pub fn sift(&self, region: &Region, enter: &mut dyn FnMut(usize)) {
        let sieve = region.moved(self.origin()).sieve(self.greatest());
        match self.treelets() {
            [] => {}
            [only] => only.sift(&sieve, enter),
            treelets => self.upper().sift(&sieve, &mut |number| treelets[number].sift(&sieve, enter)),
        }
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Members of a top tree that a ray meets, block by block, nearer ones first.
//! Callers keep data of their own for each member, in the order of the treelets: the whole block is shown, so that the
//! memory of all its members can be requested before the first one is entered.
//! Space: that of the boxes. Tests: `tests/instances.rs` of `gnurt-accel`.

use gnurt_accel_core::traversal::TileTraversal;

use super::BoxIndex;
use crate::node::{Child, WIDTH};

/// A member of a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Member {
    /// The number of its treelet.
    pub treelet: usize,
    /// Its place in the treelet, of [`BoxIndex::places`] ones.
    pub place: usize,
    /// Its place in the list of boxes.
    pub index: usize,
}

/// The members of one block of a treelet that a ray meets, those that were taken left out.
#[derive(Clone, Copy, Debug)]
pub struct MetBlock<'a> {
    pub(super) treelet: usize,
    /// Counted from the treelet's first block.
    pub(super) block: usize,
    /// By bits the members.
    pub(super) bits: u32,
    /// Where the ray enters each.
    pub(super) near: &'a [f32; WIDTH],
    pub(super) members: &'a [f32; WIDTH],
}

impl MetBlock<'_> {
    /// The number of the treelet.
    #[inline(always)]
    #[must_use]
    pub fn treelet(&self) -> usize {
        self.treelet
    }

    /// Calls `visit` with the place in the treelet of each.
    #[inline(always)]
    pub fn places(&self, mut visit: impl FnMut(usize)) {
        let mut bits = self.bits;
        while bits != 0 {
            visit(WIDTH * self.block + bits.trailing_zeros() as usize);
            bits &= bits - 1;
        }
    }

    /// Takes the member that the ray comes to first: a hit there may spare it the others. `None` if it comes to none before
    /// `reach`.
    #[inline(always)]
    pub fn next(&mut self, reach: f32) -> Option<Member> {
        if self.bits == 0 {
            return None;
        }
        let lane = nearest(self.bits, self.near);
        self.bits &= !(1 << lane);
        (self.near[lane & (WIDTH - 1)] <= reach).then(|| Member {
            treelet: self.treelet,
            place: WIDTH * self.block + lane,
            index: Child::at(self.members, lane).index(),
        })
    }
}

/// What is done with the members that a tile's rays meet.
pub trait EnterMembers {
    /// Some members of a block, by bits, are about to be entered.
    fn announce(&self, treelet: usize, block: usize, bits: u32);

    /// Enters one with the rays that may meet it and still look for something.
    fn enter(&mut self, member: Member, traversal: &mut TileTraversal);
}

/// Of the lanes in `bits`, which is not 0, the one that the ray comes to first.
#[inline(always)]
pub(super) fn nearest(mut bits: u32, near: &[f32; WIDTH]) -> usize {
    let mut nearest = bits.trailing_zeros() as usize;
    bits &= bits - 1;
    while bits != 0 {
        let lane = bits.trailing_zeros() as usize;
        bits &= bits - 1;
        if near[lane & (WIDTH - 1)] < near[nearest & (WIDTH - 1)] {
            nearest = lane;
        }
    }
    nearest
}

impl BoxIndex {
    /// How many treelets there are: members are numbered by treelet and place.
    #[must_use]
    pub fn treelet_count(&self) -> usize {
        self.treelets.len()
    }

    /// How many places a treelet has, eight for each block.
    #[must_use]
    pub fn places(&self, treelet: usize) -> usize {
        let treelet = &self.treelets[treelet];
        WIDTH * (treelet.nodes().len() - treelet.node_count())
    }

    /// The members of a treelet.
    pub fn members(&self, treelet: usize) -> impl Iterator<Item = Member> {
        let nodes = &self.treelets[treelet];
        let blocks = nodes.nodes()[nodes.node_count()..].iter().enumerate();
        let lanes =
            blocks.flat_map(|(at, block)| (0..WIDTH).map(move |lane| (WIDTH * at + lane, block.child(lane))));
        let taken = lanes.filter(|(_, child)| *child != Child::NONE);
        taken.map(move |(place, child)| Member { treelet, place, index: child.index() })
    }

    /// Whether a treelet is the same here as in another tree, which this one was made from or the other way round: then no
    /// box in it was edited between them.
    #[must_use]
    pub fn shares_treelet(&self, other: &Self, treelet: usize) -> bool {
        let both = self.treelets.get(treelet).zip(other.treelets.get(treelet));
        both.is_some_and(|(here, there)| std::ptr::eq(here.nodes(), there.nodes()))
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Nodes of interval hierarchies. Source: [WK06] section 3, [WMS06] section 3; layout original. Space: object.
//!
//! ```text
//!        split: a ray knows more along one axis                       clip: one child, and where it lies along one axis
//!
//!  BIH   ------ left ------]                                          [------ child ------]
//!                     [---------- right -------                       low              high
//!                 left ends where right begins
//!
//!  B-KD  [--- left ---]   [---- right ----]                           the same
//!
//!  BIH   | packed: u32 | 2 planes: f32 | = 12 bytes      packed: two lowest bits = axis, 3 = leaf; third bit: clip
//!  B-KD  | packed: u32 | 4 planes: f32 | = 20 bytes      the other 29: right child of a split, block of a leaf
//! ```
//!
//! The first child, or the only one, is the next node: a walk to it stays in the cache line. A leaf is one block of up to eight triangles.
//! Planes are those of boxes, as floats. Tests: `tests`.

use gnurt_accel_core::Aabb;

/// The kind of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Leaf { block: usize },
    Clip { axis: usize },
    Split { axis: usize, right: usize },
}

/// Most nodes, and most blocks: the limit of 29 bits.
pub(super) const MOST_NODES: usize = 1 << 29;

const LEAF: u32 = 3;
const CLIP: u32 = 4;

/// A node's first word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PackedChild(u32);

impl From<Kind> for PackedChild {
    fn from(kind: Kind) -> Self {
        Self(match kind {
            Kind::Leaf { block } => LEAF | (block as u32) << 3,
            Kind::Clip { axis } => CLIP | axis as u32,
            Kind::Split { axis, right } => axis as u32 | (right as u32) << 3,
        })
    }
}

impl PackedChild {
    #[inline(always)]
    pub(super) fn kind(self) -> Kind {
        let (axis, number) = ((self.0 & 3) as usize, (self.0 >> 3) as usize);
        if self.0 & 3 == LEAF {
            Kind::Leaf { block: number }
        } else if self.0 & CLIP != 0 {
            Kind::Clip { axis }
        } else {
            Kind::Split { axis, right: number }
        }
    }
}

/// Rays that meet planes, in their own measure.
pub(super) trait OverlapTest {
    /// When the first of them may.
    fn first(&self, axis: usize, plane: f32) -> f32;
    /// When the last of them may.
    fn last(&self, axis: usize, plane: f32) -> f32;
    /// 1 where they go towards smaller coordinates.
    fn back(&self, axis: usize) -> usize;
}

/// How nodes keep their planes.
pub(super) trait Layout: Copy + Send + Sync {
    fn new(kind: Kind) -> Self;
    fn kind(&self) -> Kind;
    /// Sets the planes of a split from its children's boxes.
    fn set_split(&mut self, axis: usize, left: &Aabb, right: &Aabb);
    /// Sets the planes of a clip from its child's box.
    fn set_clip(&mut self, axis: usize, child: &Aabb);
    /// Between which planes the child of a clip lies.
    fn ends(&self) -> [f32; 2];
    /// The regions of a split's children, given the `region` of their parent.
    fn regions(&self, axis: usize, region: &Aabb) -> [Aabb; 2];
    /// When rays may be in the nearer child of a split, and in the farther one.
    fn children<M: OverlapTest>(&self, rays: &M, axis: usize) -> [[f32; 2]; 2];
}

/// Two planes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub(super) struct BihNode {
    packed: PackedChild,
    /// Of a split: where the left child ends, and where the right one begins. Of a clip: where its child begins and ends.
    planes: [f32; 2],
}

impl Layout for BihNode {
    fn new(kind: Kind) -> Self {
        Self { packed: kind.into(), planes: [0.0; 2] }
    }

    #[inline(always)]
    fn kind(&self) -> Kind {
        self.packed.kind()
    }

    fn set_split(&mut self, axis: usize, left: &Aabb, right: &Aabb) {
        self.planes = [left.max[axis], right.min[axis]];
    }

    fn set_clip(&mut self, axis: usize, child: &Aabb) {
        self.planes = [child.min[axis], child.max[axis]];
    }

    #[inline(always)]
    fn ends(&self) -> [f32; 2] {
        self.planes
    }

    fn regions(&self, axis: usize, region: &Aabb) -> [Aabb; 2] {
        let mut regions = [*region; 2];
        regions[0].max[axis] = self.planes[0];
        regions[1].min[axis] = self.planes[1];
        regions
    }

    #[inline(always)]
    fn children<M: OverlapTest>(&self, rays: &M, axis: usize) -> [[f32; 2]; 2] {
        let back = rays.back(axis);
        let last = rays.last(axis, self.planes[back & 1]);
        let first = rays.first(axis, self.planes[1 - (back & 1)]);
        [[f32::NEG_INFINITY, last], [first, f32::INFINITY]]
    }
}

/// Four planes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub(super) struct BkdNode {
    packed: PackedChild,
    /// Of a split: where the left child begins and ends, and the right one. Of a clip: its child, twice.
    planes: [f32; 4],
}

impl Layout for BkdNode {
    fn new(kind: Kind) -> Self {
        Self { packed: kind.into(), planes: [0.0; 4] }
    }

    #[inline(always)]
    fn kind(&self) -> Kind {
        self.packed.kind()
    }

    fn set_split(&mut self, axis: usize, left: &Aabb, right: &Aabb) {
        self.planes = [left.min[axis], left.max[axis], right.min[axis], right.max[axis]];
    }

    fn set_clip(&mut self, axis: usize, child: &Aabb) {
        self.set_split(axis, child, child);
    }

    #[inline(always)]
    fn ends(&self) -> [f32; 2] {
        [self.planes[0], self.planes[1]]
    }

    fn regions(&self, axis: usize, region: &Aabb) -> [Aabb; 2] {
        let [a, b, c, d] = self.planes;
        [[a, b], [c, d]].map(|[low, high]| {
            let mut child = *region;
            (child.min[axis], child.max[axis]) = (low, high);
            child
        })
    }

    #[inline(always)]
    fn children<M: OverlapTest>(&self, rays: &M, axis: usize) -> [[f32; 2]; 2] {
        let back = rays.back(axis) & 1;
        let ends = |child: usize| {
            [
                rays.first(axis, self.planes[2 * child + back]),
                rays.last(axis, self.planes[2 * child + (1 - back)]),
            ]
        };
        [ends(back), ends(1 - back)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_are_small_and_say_what_they_are() {
        assert_eq!((size_of::<BihNode>(), size_of::<BkdNode>()), (12, 20), "see the head");
        let last = MOST_NODES - 1;
        for axis in 0..3 {
            for kind in [Kind::Leaf { block: last }, Kind::Clip { axis }, Kind::Split { axis, right: last }] {
                assert_eq!(BihNode::new(kind).kind(), kind, "what goes in comes out");
                assert_eq!(BkdNode::new(kind).kind(), kind, "what goes in comes out");
            }
        }
    }

    /// A ray along x from 0 that meets planes where they are.
    struct Along(usize);

    impl OverlapTest for Along {
        fn first(&self, _: usize, plane: f32) -> f32 {
            if self.0 == 0 { plane } else { -plane }
        }

        fn last(&self, axis: usize, plane: f32) -> f32 {
            self.first(axis, plane)
        }

        fn back(&self, _: usize) -> usize {
            self.0
        }
    }

    #[test]
    fn children_come_nearest_first() {
        let at = |low: f32, high: f32| Aabb { min: [low; 3], max: [high; 3] };
        let (left, right) = (at(1.0, 4.0), at(3.0, 6.0));
        let kind = Kind::Split { axis: 0, right: 9 };
        let (mut bih, mut bkd) = (BihNode::new(kind), BkdNode::new(kind));
        bih.set_split(0, &left, &right);
        bkd.set_split(0, &left, &right);
        let (none, all) = (f32::NEG_INFINITY, f32::INFINITY);
        assert_eq!(bih.children(&Along(0), 0), [[none, 4.0], [3.0, all]], "forwards");
        assert_eq!(bih.children(&Along(1), 0), [[none, -3.0], [-4.0, all]], "backwards");
        assert_eq!(bkd.children(&Along(0), 0), [[1.0, 4.0], [3.0, 6.0]], "forwards");
        assert_eq!(bkd.children(&Along(1), 0), [[-6.0, -3.0], [-4.0, -1.0]], "backwards");
        let whole = at(0.0, 9.0);
        let [a, b] = bih.regions(0, &whole);
        assert_eq!((a.min[0], a.max[0], b.min[0], b.max[0]), (0.0, 4.0, 3.0, 9.0), "half of it is open");
        let [a, b] = bkd.regions(0, &whole);
        assert_eq!((a.min[0], a.max[0], b.min[0], b.max[0]), (1.0, 4.0, 3.0, 6.0), "all is closed");
    }
}

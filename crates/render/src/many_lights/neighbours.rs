// SPDX-License-Identifier: GPL-3.0-or-later
//! An order of points in which neighbours lie near each other: as the leaves of a kd-tree follow each other.
//! Source: [Ben75], medians along the longest side. Space: any.
//! Invariant: a function of the points and their order alone. Tests: `tests`.

use glam::Vec3;

/// Points are not parted further.
const LEAF: usize = 8;

/// Numbers of the points in order, in groups of `block`, which is a power of two, as far as they are full.
pub(super) fn in_order(points: &[Vec3], block: usize) -> Vec<u32> {
    let mut order: Vec<u32> = (0..points.len() as u32).collect();
    part(points, &mut order, block.max(1));
    order
}

fn part(points: &[Vec3], order: &mut [u32], block: usize) {
    if order.len() <= LEAF {
        return;
    }
    let at = |i: u32| points[i as usize];
    let none = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let (low, high) = order.iter().fold(none, |(low, high), &i| (low.min(at(i)), high.max(at(i))));
    let size = high - low;
    let axis = if size.x >= size.y && size.x >= size.z { 0 } else { 2 - usize::from(size.y >= size.z) };
    // Blocks stay together; within one, rows of lanes.
    let unit = if order.len() > block { block } else { LEAF };
    let middle = (order.len() / 2).next_multiple_of(unit);
    if middle < order.len() {
        let key = |i: &u32| (points[*i as usize][axis], *i);
        order.select_nth_unstable_by(middle, |a, b| {
            let ((x, i), (y, j)) = (key(a), key(b));
            x.total_cmp(&y).then(i.cmp(&j))
        });
    }
    let (first, second) = order.split_at_mut(middle.min(order.len()));
    if !second.is_empty() {
        part(points, first, block);
        part(points, second, block);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid of points, mixed up.
    fn grid() -> Vec<Vec3> {
        let point = |i: u32| Vec3::new((i % 32) as f32, (i / 32) as f32, 0.0);
        (0..1000).map(|i| point(i * 371 % 1024)).collect()
    }

    #[test]
    fn each_point_is_there_once() {
        for count in [0, 1, 7, 8, 9, 63, 64, 65, 1000] {
            let mut order = in_order(&grid()[..count], 64);
            order.sort_unstable();
            assert_eq!(order, (0..count as u32).collect::<Vec<_>>(), "{count} points");
        }
        let same = vec![Vec3::ONE; 300];
        assert_eq!(in_order(&same, 64).len(), 300, "points may lie on one another");
    }

    #[test]
    fn blocks_are_compact() {
        let points = grid();
        let mut widest = 0.0_f32;
        for block in in_order(&points, 64).chunks_exact(64) {
            let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
            for &i in block {
                (low, high) = (low.min(points[i as usize]), high.max(points[i as usize]));
            }
            widest = widest.max((high - low).max_element());
        }
        // Of a whole grid they would be squares of 8 by 8.
        assert!(widest <= 11.0, "64 of a grid lie within {widest}");
    }
}

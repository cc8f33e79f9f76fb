// SPDX-License-Identifier: GPL-3.0-or-later
//! The box of the part of a triangle in a node ("perfect splits").
//! Source: [WH06] section 4.1; polygons are clipped plane by plane [SH74], in double precision.
//! Boxes are rounded to the nearest float: they may miss the polygon by half a unit in the last place, which the
//! traversal's slack covers (`slab.rs`). Tests: `tests::{parts_cover_the_whole, outside_is_nothing,
//! boxes_are_those_of_the_true_polygons}`, `tests/brute_force.rs` (`flat_but_for_one_bit`).

use crate::aabb::Aabb;

/// A triangle cut by seven planes has at most 3 + 7 corners; the rest is for polygons that rounding made concave.
const MOST_CORNERS: usize = 16;

#[derive(Clone, Copy)]
struct Polygon {
    corners: [[f64; 3]; MOST_CORNERS],
    count: usize,
}

impl Polygon {
    #[inline(always)]
    fn push(&mut self, corner: [f64; 3]) {
        if let Some(slot) = self.corners.get_mut(self.count) {
            *slot = corner;
            self.count += 1;
        }
    }

    /// Keeps the part where `sign * p[axis] <= sign * at`. Most cuts cut nothing and cost a comparison per corner.
    #[inline(always)]
    fn cut(&mut self, axis: usize, at: f64, sign: f64) {
        let outside = |p: &[f64; 3]| sign * (p[axis] - at) > 0.0;
        if !self.corners[..self.count].iter().any(outside) {
            return;
        }
        let mut clipped = Self { corners: [[0.0; 3]; MOST_CORNERS], count: 0 };
        self.walk(|from, to| {
            if !outside(from) {
                clipped.push(*from);
            }
            if outside(from) != outside(to) {
                clipped.push(crossing(from, to, axis, at));
            }
        });
        *self = clipped;
    }

    /// Calls `edge` with each corner and the next one.
    #[inline(always)]
    fn walk(&self, mut edge: impl FnMut(&[f64; 3], &[f64; 3])) {
        let corners = &self.corners[..self.count];
        if let [first, .., last] = corners {
            corners.windows(2).for_each(|pair| edge(&pair[0], &pair[1]));
            edge(last, first);
        }
    }

    /// The boxes of the parts on either side of a plane, kept inside `halves`; `None` for an empty part.
    #[inline(always)]
    fn boxes_of_halves(&self, axis: usize, at: f64, halves: [Aabb; 2]) -> [Option<Aabb>; 2] {
        let mut boxes = [([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]); 2];
        let mut grow = |half: usize, p: &[f64; 3]| {
            let (min, max) = &mut boxes[half];
            for k in 0..3 {
                min[k] = if p[k] < min[k] { p[k] } else { min[k] };
                max[k] = if p[k] > max[k] { p[k] } else { max[k] };
            }
        };
        self.walk(|from, to| {
            let (here, there) = (from[axis] - at, to[axis] - at);
            if here <= 0.0 {
                grow(0, from);
            }
            if here >= 0.0 {
                grow(1, from);
            }
            if (here < 0.0 && there > 0.0) || (here > 0.0 && there < 0.0) {
                let crossing_point = crossing(from, to, axis, at);
                grow(0, &crossing_point);
                grow(1, &crossing_point);
            }
        });
        let mut result = [None; 2];
        for (half, cell) in halves.iter().enumerate() {
            let (min, max) = boxes[half];
            if min[0] <= max[0] {
                let inside = |k: usize, x: f64| (x as f32).clamp(cell.min[k], cell.max[k]);
                result[half] = Some(Aabb {
                    min: [inside(0, min[0]), inside(1, min[1]), inside(2, min[2])],
                    max: [inside(0, max[0]), inside(1, max[1]), inside(2, max[2])],
                });
            }
        }
        result
    }
}

/// Where an edge meets the plane `p[axis] == at` between its ends.
#[inline(always)]
fn crossing(from: &[f64; 3], to: &[f64; 3], axis: usize, at: f64) -> [f64; 3] {
    let f = (at - from[axis]) / (to[axis] - from[axis]);
    let mut crossing_point =
        [from[0] + f * (to[0] - from[0]), from[1] + f * (to[1] - from[1]), from[2] + f * (to[2] - from[2])];
    crossing_point[axis] = at;
    crossing_point
}

/// The boxes of a triangle's parts in `cell`, left and right of the plane `p[axis] == at`.
pub fn split_boxes(triangle: &[[f32; 3]; 3], cell: &Aabb, axis: usize, at: f32) -> [Option<Aabb>; 2] {
    let mut polygon = Polygon { corners: [[0.0; 3]; MOST_CORNERS], count: 0 };
    triangle.iter().for_each(|corner| polygon.push(corner.map(f64::from)));
    for k in 0..3 {
        // A unit in the last place outwards: the cell's faces may be rounded ones of this very triangle, and
        // for a triangle nearly parallel to such a face half a unit is a large part.
        polygon.cut(k, f64::from(cell.min[k].next_down()), -1.0);
        polygon.cut(k, f64::from(cell.max[k].next_up()), 1.0);
    }
    polygon.boxes_of_halves(axis, f64::from(at), cell.split(axis, at))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_cover_the_whole() {
        let triangle = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 1.0]];
        let cell = Aabb { min: [0.0, 0.0, 0.0], max: [3.0, 3.0, 1.0] };
        let [left, right] = split_boxes(&triangle, &cell, 0, 2.0);
        let left = left.expect("the triangle reaches left");
        let right = right.expect("and right");
        let is = |found: Aabb, min: [f32; 3], max: [f32; 3]| {
            let close = |a: f32, b: f32| (a - b).abs() < 1e-6;
            (0..3).all(|k| close(found.min[k], min[k]) && close(found.max[k], max[k]))
        };
        assert!(is(left, [0.0; 3], [2.0, 3.0, 0.75]), "left part {left:?}");
        assert!(is(right, [2.0, 0.0, 0.0], [3.0, 2.0, 0.5]), "right part {right:?}, tighter than the box");
    }

    #[test]
    fn outside_is_nothing() {
        // Its box overlaps the cell's corner, the triangle itself does not.
        let triangle = [[0.0, 3.0, 0.0], [3.0, 0.0, 0.0], [3.0, 3.0, 0.0]];
        let cell = Aabb { min: [0.0, 0.0, -1.0], max: [1.0, 1.0, 1.0] };
        assert_eq!(split_boxes(&triangle, &cell, 0, 0.5), [None, None], "nothing is seen from this cell");
    }

    /// All points that can be a corner of the polygon "triangle in cell", found without clipping anything: corners of
    /// the triangle, its edges on the cell's planes, and the cell's edges on the triangle's plane.
    fn true_corners(triangle: &[[f64; 3]; 3], cell: &Aabb) -> Vec<[f64; 3]> {
        let [low, high] = [cell.min, cell.max].map(|p| p.map(f64::from));
        let in_cell = |p: &[f64; 3]| (0..3).all(|k| p[k] >= low[k] - 1e-12 && p[k] <= high[k] + 1e-12);
        let mut points: Vec<[f64; 3]> = triangle.to_vec();
        for (a, b) in [(0, 1), (1, 2), (2, 0)].map(|(i, j)| (triangle[i], triangle[j])) {
            for (k, at) in (0..3).flat_map(|k| [(k, low[k]), (k, high[k])]) {
                let f = (at - a[k]) / (b[k] - a[k]);
                if (0.0..=1.0).contains(&f) {
                    points.push([0, 1, 2].map(|j| a[j] + f * (b[j] - a[j])));
                }
            }
        }
        let [a, b, c] = *triangle;
        for k in 0..3 {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            for (pi, pj) in [(low[i], low[j]), (low[i], high[j]), (high[i], low[j]), (high[i], high[j])] {
                let det = (b[i] - a[i]) * (c[j] - a[j]) - (b[j] - a[j]) * (c[i] - a[i]);
                let u = ((pi - a[i]) * (c[j] - a[j]) - (pj - a[j]) * (c[i] - a[i])) / det;
                let v = ((b[i] - a[i]) * (pj - a[j]) - (b[j] - a[j]) * (pi - a[i])) / det;
                if u >= 0.0 && v >= 0.0 && u + v <= 1.0 {
                    let mut point = [0.0; 3];
                    (point[i], point[j]) = (pi, pj);
                    point[k] = a[k] + u * (b[k] - a[k]) + v * (c[k] - a[k]);
                    points.push(point);
                }
            }
        }
        points.retain(in_cell);
        points
    }

    #[test]
    fn boxes_are_those_of_the_true_polygons() {
        let mut random = gnurt_testkit::Random::new(1);
        let mut cut = 0;
        for _ in 0..20_000 {
            let size = random.pick(&[0.2f32, 1.0, 5.0]);
            let triangle = [0; 3].map(|_: i32| random.point().map(|x| size * x));
            let cell = Aabb::around(&[random.point(), random.point()]);
            let axis = random.below(3);
            let at = cell.min[axis] + random.unit() * (cell.max[axis] - cell.min[axis]);
            let boxes = split_boxes(&triangle, &cell, axis, at);
            for (found, half) in boxes.into_iter().zip(cell.split(axis, at)) {
                let points = true_corners(&triangle.map(|p| p.map(f64::from)), &half);
                if points.is_empty() {
                    assert!(found.is_none(), "{triangle:?} is not in {half:?}, but {found:?}");
                    continue;
                }
                let found = found.unwrap_or_else(|| panic!("{triangle:?} is in {half:?} at {points:?}"));
                cut += 1;
                // Cells are enlarged by a unit in the last place.
                let larger = Aabb { min: half.min.map(|x| x - 1.3e-7), max: half.max.map(|x| x + 1.3e-7) };
                let more = true_corners(&triangle.map(|p| p.map(f64::from)), &larger);
                for k in 0..3 {
                    let inside = found.min[k] >= half.min[k] && found.max[k] <= half.max[k];
                    assert!(inside, "{found:?} is in the cell {half:?}");
                    let range = |points: &[[f64; 3]]| {
                        let least = points.iter().fold(f64::INFINITY, |m, p| m.min(p[k]));
                        (least, points.iter().fold(f64::NEG_INFINITY, |m, p| m.max(p[k])))
                    };
                    // Half a unit in the last place of a coordinate below 1.
                    let half_unit = 3.1e-8;
                    let ((least, most), (low, high)) = (range(&points), range(&more));
                    let (min, max) = (f64::from(found.min[k]), f64::from(found.max[k]));
                    let holds = min < least + half_unit && max > most - half_unit;
                    let tight = min > low - half_unit && max < high + half_unit;
                    assert!(holds, "{found:?} holds {least} to {most} along {k}, {triangle:?}");
                    assert!(tight, "{found:?} is not beyond {low} to {high} along {k}, {triangle:?}");
                }
            }
        }
        assert!(cut > 5_000, "{cut} polygons are enough to tell");
    }
}

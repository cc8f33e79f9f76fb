// SPDX-License-Identifier: GPL-3.0-or-later
//! Solids of unit cubes on a grid: closed meshes, also with edges and vertices at which more than two sheets
//! meet; integer arithmetic gives the inside and the crossings of a line. Unit of queries: half a cube's
//! side, so that odd coordinates are centres and even ones corners, edges and faces.
//! Tests: `tests`.

use std::collections::BTreeMap;

use crate::{Random, Soup};

/// Cubes from (0, 0, 0) to (n, n, n), some of them filled.
#[derive(Clone, Debug)]
pub struct Voxels {
    n: i64,
    filled: Vec<bool>,
}

/// Where a point is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Where {
    /// In no filled cube.
    Outside,
    /// Between filled and empty ones.
    Surface,
    /// Only filled ones touch it.
    Inside,
}

/// A line is moved by this along the first axis across it, and by 1 along the second, of a side of `2 * UNIT`.
const STEP: i128 = 1 << 20;
const UNIT: i128 = STEP * STEP;

impl Voxels {
    /// About `share` of `n * n * n` cubes.
    #[must_use]
    pub fn random(seed: u64, n: u32, share: f32) -> Self {
        let mut random = Random::new(seed);
        let filled = (0..n * n * n).map(|_| random.unit() < share).collect();
        Self { n: i64::from(n), filled }
    }

    fn is_filled(&self, cube: [i64; 3]) -> bool {
        let is_in = cube.iter().all(|c| (0..self.n).contains(c));
        is_in && self.filled[((cube[2] * self.n + cube[1]) * self.n + cube[0]) as usize]
    }

    /// The surface, seen from outside counter-clockwise, in cubes of side `side` from `from` on. Faces share their corners, or
    /// have corners of their own.
    #[must_use]
    pub fn mesh(&self, shared: bool, from: [f32; 3], side: f32) -> Soup {
        let mut soup = Soup::default();
        let mut known = BTreeMap::new();
        for i in 0..self.n * self.n * self.n {
            let cube = [i % self.n, i / self.n % self.n, i / self.n / self.n];
            for face in 0..6usize {
                let (axis, up) = (face / 2, (face % 2) as i64);
                let mut other = cube;
                other[axis] += 2 * up - 1;
                if !self.is_filled(cube) || self.is_filled(other) {
                    continue;
                }
                let mut corner = |u: i64, v: i64| {
                    let mut at = cube;
                    at[axis] += up;
                    at[(axis + 1) % 3] += u;
                    at[(axis + 2) % 3] += v;
                    let mut add = || {
                        soup.positions.push([0, 1, 2].map(|k| from[k] + side * at[k] as f32));
                        soup.positions.len() as u32 - 1
                    };
                    if shared { *known.entry(at).or_insert_with(add) } else { add() }
                };
                let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                // Either diagonal.
                let halves = if (cube[0] + cube[1] + face as i64) % 2 == 0 {
                    [[a, b, c], [a, c, d]]
                } else {
                    [[a, b, d], [b, c, d]]
                };
                let turned = halves.map(|[p, q, r]| if up == 1 { [p, q, r] } else { [p, r, q] });
                soup.indices.extend(turned);
            }
        }
        soup
    }

    /// Where a point is, in half sides.
    #[must_use]
    pub fn locate(&self, point: [i64; 3]) -> Where {
        let cubes = point.map(|x| if x % 2 == 0 { [x / 2 - 1, x / 2] } else { [x.div_euclid(2); 2] });
        let touching: Vec<bool> =
            (0..8usize).map(|i| self.is_filled([0, 1, 2].map(|k| cubes[k][i >> k & 1]))).collect();
        match (touching.contains(&true), touching.contains(&false)) {
            (true, true) => Where::Surface,
            (true, false) => Where::Inside,
            _ => Where::Outside,
        }
    }

    /// How often a line, in half sides, goes in and out from its origin on, which is outside. It is moved a little along the
    /// axes across its longest component (the first of equals), more along the axis that follows that one than along the last.
    #[must_use]
    pub fn crossings(&self, org: [i64; 3], dir: [i64; 3]) -> u32 {
        let size = dir.map(i64::abs);
        let longest =
            if size[0] >= size[1] && size[0] >= size[2] { 0 } else { 2 - usize::from(size[1] >= size[2]) };
        let mut from = org.map(|x| i128::from(x) * UNIT);
        from[(longest + 1) % 3] += STEP;
        from[(longest + 2) % 3] += 1;
        // Where it passes planes of the grid: numerators and denominators.
        let mut passes: Vec<(i128, i128)> = vec![(0, 1)];
        for k in (0..3).filter(|&k| dir[k] != 0) {
            let planes = (0..=self.n)
                .map(|plane| (i128::from(2 * plane) * UNIT - from[k]) * i128::from(dir[k].signum()));
            passes.extend(planes.filter(|&steps| steps > 0).map(|steps| (steps, i128::from(size[k]))));
        }
        passes.sort_by(|a, b| (a.0 * b.1).cmp(&(b.0 * a.1)));
        let mut crossed = 0;
        let mut was_in = false;
        for pair in passes.windows(2) {
            let ((a, p), (b, q)) = (pair[0], pair[1]);
            let cube = [0, 1, 2].map(|k| {
                let twice = 2 * p * q;
                let at = from[k] * twice + (a * q + b * p) * i128::from(dir[k]);
                at.div_euclid(twice * 2 * UNIT) as i64
            });
            let is_in = self.is_filled(cube);
            crossed += u32::from(is_in != was_in);
            was_in = is_in;
        }
        crossed + u32::from(was_in)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cube_is_known() {
        let cube = Voxels { n: 1, filled: vec![true] };
        let mesh = cube.mesh(true, [0.0; 3], 1.0);
        assert_eq!((mesh.positions.len(), mesh.indices.len()), (8, 12), "a cube");
        assert_eq!(cube.mesh(false, [0.0; 3], 1.0).positions.len(), 24, "faces apart");
        assert_eq!(cube.locate([1, 1, 1]), Where::Inside, "the middle");
        assert_eq!(cube.locate([2, 1, 0]), Where::Surface, "an edge");
        assert_eq!(cube.locate([3, 1, 1]), Where::Outside, "beside");
        assert_eq!(cube.crossings([-3, -3, -3], [1, 1, 1]), 2, "through two corners");
        assert_eq!(cube.crossings([-4, 1, 0], [1, 0, 0]), 2, "in a face: moved into the cube");
        assert_eq!(cube.crossings([-4, 1, 2], [1, 0, 0]), 0, "in a face: moved out of it");
        assert_eq!(cube.crossings([4, 1, 1], [1, 0, 0]), 0, "away from it");
        let six_volumes: f64 = (0..12)
            .map(|i| {
                let [a, b, c] = mesh.corners(i).expect("a triangle").map(|p| p.map(f64::from));
                a[0] * (b[1] * c[2] - b[2] * c[1])
                    + a[1] * (b[2] * c[0] - b[0] * c[2])
                    + a[2] * (b[0] * c[1] - b[1] * c[0])
            })
            .sum();
        assert_eq!(six_volumes, 6.0, "normals point outwards");
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Lines and triangles with whole coordinates, below 2^20 or so, decided by whole numbers.
//! A line that meets an edge or a vertex is moved as that of `voxels.rs`: how the determinant changes with the first axis
//! across it decides, then how it changes with the second. Tests: `voxels.rs` (its own arithmetic), `tests`.

type P = [i64; 3];

fn minus(a: P, b: P) -> [i128; 3] {
    [0, 1, 2].map(|k| i128::from(a[k]) - i128::from(b[k]))
}

fn determinant([a, b, c]: [[i128; 3]; 3]) -> i128 {
    a[0] * (b[1] * c[2] - b[2] * c[1])
        + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
}

/// How many triangles the ray from `org` along `dir` crosses.
#[must_use]
pub fn crossings(triangles: impl Iterator<Item = [P; 3]>, org: P, dir: P) -> u32 {
    triangles.map(|triangle| u32::from(crosses(triangle, org, dir))).sum()
}

fn crosses(triangle: [P; 3], org: P, dir: P) -> bool {
    let size = dir.map(i64::abs);
    let longest = (0..3).rev().fold(2, |most, k| if size[k] >= size[most] { k } else { most });
    let d = dir.map(i128::from);
    let mut axes = [[0; 3]; 2];
    (axes[0][(longest + 1) % 3], axes[1][(longest + 2) % 3]) = (1, 1);
    let side = |p: P, q: P| {
        let (r, s) = (minus(p, org), minus(q, org));
        let along = [0, 1, 2].map(|k| s[k] - r[k]);
        // d . ((r - m) x (s - m)) = d . (r x s) - d . (m x (s - r)).
        [determinant([d, r, s]), -determinant([d, axes[0], along]), -determinant([d, axes[1], along])]
            .into_iter()
            .map(i128::signum)
            .find(|&sign| sign != 0)
            .unwrap_or(0)
    };
    let [a, b, c] = triangle;
    let sides = [side(a, b), side(b, c), side(c, a)];
    let is_crossed = sides[0] != 0 && sides.iter().all(|&s| s == sides[0]);
    let height = determinant([minus(b, a), minus(c, a), minus(a, org)]);
    is_crossed && height * sides[0] >= 0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_of_two_neighbours_is_crossed() {
        let square = [[[0, 0, 0], [4, 0, 0], [4, 4, 0]], [[0, 0, 0], [4, 4, 0], [0, 4, 0]]];
        for (org, expected) in [([2, 2, 9], 1), ([3, 1, 9], 1), ([5, 1, 9], 0), ([2, 2, -9], 0)] {
            assert_eq!(crossings(square.into_iter(), org, [0, 0, -1]), expected, "from {org:?}");
        }
        let rim: Vec<u32> =
            [[0, 2, 9], [4, 2, 9]].map(|org| crossings(square.into_iter(), org, [0, 0, -1])).into();
        assert_eq!(rim.iter().sum::<u32>(), 1, "one rim of two belongs to the square");
    }
}

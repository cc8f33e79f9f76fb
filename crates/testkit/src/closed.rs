// SPDX-License-Identifier: GPL-3.0-or-later
//! Closed meshes: whatever starts inside must hit them.
//! Tests: `tests::every_edge_has_two_sides`.

use std::f32::consts::{PI, TAU};

use crate::Soup;

/// Vertices on a grid of `columns` x `rows` that wraps around in columns and, if `tube`, in rows.
fn wrapped(columns: u32, rows: u32, tube: bool, point: impl Fn(f32, f32) -> [f32; 3]) -> Soup {
    let mut soup = Soup::default();
    for row in 0..rows {
        for column in 0..columns {
            soup.positions.push(point(column as f32 / columns as f32, row as f32 / rows as f32));
        }
    }
    let last = if tube { rows } else { rows - 1 };
    for row in 0..last {
        for column in 0..columns {
            let at = |c: u32, r: u32| (r % rows) * columns + c % columns;
            let [a, b] = [at(column, row), at(column + 1, row)];
            let [c, d] = [at(column + 1, row + 1), at(column, row + 1)];
            soup.indices.extend([[a, b, c], [a, c, d]]);
        }
    }
    soup
}

/// A sphere of radius 1 around the origin with `n >= 3` sectors.
#[must_use]
pub fn sphere(n: u32) -> Soup {
    let rings = n.max(3);
    let mut soup = wrapped(n, rings, false, |column, row| {
        let (theta, phi) = (PI * (row * rings as f32 + 1.0) / (rings + 1) as f32, TAU * column);
        [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()]
    });
    let [north, south] = [n * rings, n * rings + 1];
    soup.positions.extend([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]);
    for column in 0..n {
        let [a, b] = [column, (column + 1) % n];
        let below = n * (rings - 1);
        soup.indices.extend([[north, b, a], [south, below + a, below + b]]);
    }
    soup
}

/// A torus around the z axis, radii 1 and 0.4, with `n >= 3` sectors both ways.
#[must_use]
pub fn torus(n: u32) -> Soup {
    wrapped(n, n, true, |column, row| {
        let (phi, theta) = (TAU * column, TAU * row);
        let r = 1.0 + 0.4 * theta.cos();
        [r * phi.cos(), r * phi.sin(), 0.4 * theta.sin()]
    })
}

/// The cube `[-1, 1]^3`, each face of `n` x `n` squares; faces share their vertices.
#[must_use]
pub fn cube(n: u32) -> Soup {
    let mut soup = Soup::default();
    let mut numbers = std::collections::BTreeMap::new();
    let mut vertex = |soup: &mut Soup, lattice: [u32; 3]| {
        *numbers.entry(lattice).or_insert_with(|| {
            soup.positions.push(lattice.map(|i| 2.0 * i as f32 / n as f32 - 1.0));
            soup.positions.len() as u32 - 1
        })
    };
    for axis in 0..3 {
        for side in [0, n] {
            for i in 0..n {
                for j in 0..n {
                    let mut corner = |di: u32, dj: u32| {
                        let mut lattice = [0; 3];
                        lattice[axis] = side;
                        lattice[(axis + 1) % 3] = i + di;
                        lattice[(axis + 2) % 3] = j + dj;
                        vertex(&mut soup, lattice)
                    };
                    let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                    let quad = if side == 0 { [[a, c, b], [a, d, c]] } else { [[a, b, c], [a, c, d]] };
                    soup.indices.extend(quad);
                }
            }
        }
    }
    soup
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_edge_has_two_sides() {
        for (name, mesh) in [("sphere", sphere(9)), ("torus", torus(8)), ("cube", cube(3))] {
            let mut edges = std::collections::BTreeMap::new();
            for [a, b, c] in &mesh.indices {
                for (from, to) in [(a, b), (b, c), (c, a)] {
                    *edges.entry((from.min(to), from.max(to))).or_insert(0) += if from < to { 1 } else { -1 };
                }
            }
            assert!(edges.values().all(|&n| n == 0), "each edge of the {name} is walked once each way");
        }
    }
}

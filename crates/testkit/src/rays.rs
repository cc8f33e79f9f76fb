// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays as plain pairs of origin and direction: random ones and mean ones.

use crate::{Random, Soup};

/// Origin and direction.
pub type PlainRay = ([f32; 3], [f32; 3]);

/// Rays from and towards random points of the cube `[-1.5, 1.5]^3`, directions of many lengths.
#[must_use]
pub fn random(seed: u64, n: usize) -> Vec<PlainRay> {
    let mut random = Random::new(seed);
    (0..n)
        .map(|_| {
            let (from, to) = (random.point(), random.point());
            let length = random.pick(&[0.01, 1.0, 1.0, 300.0]);
            (from.map(|x| 1.5 * x), [0, 1, 2].map(|k| length * 1.5 * (to[k] - from[k])))
        })
        .collect()
}

/// Rays along an axis or in a plane of two, in all combinations of signs, zero and minus zero; origins on a grid of
/// quarters, where axis-aligned geometry has its planes, and next to it.
#[must_use]
pub fn axis_parallel(seed: u64, origins: usize) -> Vec<PlainRay> {
    let mut random = Random::new(seed);
    let components = [1.0, -1.0, 0.0, -0.0];
    let mut rays = Vec::new();
    for i in 0..origins {
        let origin: [f32; 3] = std::array::from_fn(|_| {
            let on_grid = random.below(13) as f32 / 4.0 - 1.5;
            if i % 2 == 0 { on_grid } else { on_grid + random.between(-0.1, 0.1) }
        });
        for (x, y, z) in (0..64).map(|c| (components[c % 4], components[c / 4 % 4], components[c / 16])) {
            if [x, y, z] != [0.0; 3] {
                rays.push((origin, [x, y, z]));
            }
        }
    }
    rays
}

/// Rays from `origin` at every vertex, at points of every edge, and at `inside` points of each triangle.
#[must_use]
pub fn aimed(soup: &Soup, origin: [f32; 3], inside: usize) -> Vec<PlainRay> {
    let mut random = Random::new(inside as u64);
    let mut rays = Vec::new();
    let mut aim = |at: [f32; 3]| rays.push((origin, [0, 1, 2].map(|k| at[k] - origin[k])));
    for i in 0..soup.indices.len() {
        let Some([a, b, c]) = soup.corners(i) else { continue };
        let mix = |a: [f32; 3], b: [f32; 3], f: f32| [0, 1, 2].map(|k| a[k] + f * (b[k] - a[k]));
        aim(a);
        for (from, to) in [(a, b), (b, c), (c, a)] {
            aim(mix(from, to, 0.5));
            aim(mix(from, to, random.unit()));
        }
        for _ in 0..inside {
            aim(mix(mix(a, b, random.unit()), c, random.unit()));
        }
    }
    rays
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Directional quadtrees over the square of the octahedron: built from samples, drawn from, evaluated.
//! Source: [MGN17], section 3.2. Differs: a leaf is divided while it has samples enough, so that few samples make a coarse
//! tree.
//! Invariant: the density integrates to 1 over the sphere. Tests: `tests::{density_*, samples_*}`.

use glam::{Vec2, Vec3};

use gnurt_shading::sampling::octahedron::{direction_of, square_of, stretch};

/// No tree is deeper: 128 times 128 parts.
const DEEPEST: u32 = 7;
/// A part is divided if it has this share of the light of all, and this many samples.
const SHARE: f64 = 0.01;
const FEWEST: usize = 30;

/// No node: a part that is not divided.
const NONE: u32 = u32::MAX;

/// A node: the shares of its four parts, the lower left one first, then the lower right one.
#[derive(Clone, Copy, Debug)]
struct Node {
    shares: [f32; 4],
    children: [u32; 4],
}

/// Light from a direction, for building.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    /// Within the part that is built.
    square: Vec2,
    /// Estimate of the light: radiance times scattering, over the density of the direction.
    light: f32,
}

impl Sample {
    /// Light that came from a unit direction, over the density of that.
    pub(super) fn new(dir: Vec3, light: f32) -> Self {
        Self { square: square_of(dir.into()).into(), light }
    }
}

/// Trees of many cells in one array.
#[derive(Clone, Debug, Default)]
pub(super) struct Trees {
    nodes: Vec<Node>,
}

impl Trees {
    pub(super) fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Bytes of memory.
    pub(super) fn bytes(&self) -> usize {
        self.nodes.len() * size_of::<Node>()
    }

    /// Builds a tree, and returns its root; `None` if the samples are dark.
    pub(super) fn build(&mut self, samples: &mut [Sample]) -> Option<u32> {
        let all: f64 = samples.iter().map(|sample| f64::from(sample.light)).sum();
        if !(all > 0.0 && all.is_finite()) {
            return None;
        }
        let root = self.nodes.len();
        let (weight, _) = self.divide(samples, all, 0);
        if !(weight > 0.0 && weight.is_finite()) {
            self.nodes.truncate(root);
            return None;
        }
        Some(root as u32)
    }

    /// Takes over the trees of others; roots of theirs move by what is returned.
    pub(super) fn append(&mut self, others: Self) -> u32 {
        let offset = self.nodes.len() as u32;
        self.nodes.extend(others.nodes.into_iter().map(|node| Node {
            children: node.children.map(|child| if child == NONE { NONE } else { child + offset }),
            ..node
        }));
        offset
    }

    /// The weight of a part and its node.
    fn divide(&mut self, samples: &mut [Sample], all: f64, depth: u32) -> (f32, u32) {
        let light: f64 = samples.iter().map(|sample| f64::from(sample.light)).sum();
        let is_divided = depth == 0 || (depth < DEEPEST && samples.len() >= FEWEST && light > SHARE * all);
        if !is_divided {
            return (light as f32, NONE);
        }
        let at = self.nodes.len();
        self.nodes.push(Node { shares: [0.25; 4], children: [NONE; 4] });
        samples.sort_by_key(|sample| quarter(sample.square));
        let (mut weights, mut children) = ([0.0; 4], [NONE; 4]);
        let mut rest = samples;
        for k in 0..4 {
            let count = rest.partition_point(|sample| quarter(sample.square) <= k);
            let (part, others) = rest.split_at_mut(count);
            rest = others;
            part.iter_mut().for_each(|sample| sample.square = within(sample.square, k));
            (weights[k], children[k]) = self.divide(part, all, depth + 1);
        }
        let sum: f32 = weights.iter().sum();
        if sum > 0.0 && sum.is_finite() {
            self.nodes[at] = Node { shares: weights.map(|weight| weight / sum), children };
        }
        (sum, at as u32)
    }

    /// A unit direction by two numbers in [0, 1).
    pub(super) fn sample(&self, root: u32, [mut x, mut y]: [f32; 2]) -> Vec3 {
        let (mut corner, mut size, mut at) = (Vec2::ZERO, 1.0, root);
        while let Some(Node { shares: [a, b, c, d], children }) = self.nodes.get(at as usize) {
            let left = (a + c) / (a + b + c + d);
            let right = x >= left;
            x = if right { (x - left) / (1.0 - left) } else { x / left };
            let (below, above) = if right { (b, d) } else { (a, c) };
            let low = below / (below + above);
            let upper = y >= low;
            y = if upper { (y - low) / (1.0 - low) } else { y / low };
            (x, y) = (x.clamp(0.0, 0.999_999_9), y.clamp(0.0, 0.999_999_9));
            size *= 0.5;
            corner += Vec2::new(f32::from(u8::from(right)), f32::from(u8::from(upper))) * size;
            at = children[usize::from(right) + 2 * usize::from(upper)];
        }
        direction_of((corner + Vec2::new(x, y) * size).into())
    }

    /// The density per solid angle with which [`sample`](Self::sample) chooses a unit direction.
    pub(super) fn pdf(&self, root: u32, dir: Vec3) -> f32 {
        let (mut square, mut density, mut at) = (Vec2::from(square_of(dir.into())), 1.0 / stretch(dir), root);
        while let Some(node) = self.nodes.get(at as usize) {
            let k = quarter(square);
            square = within(square, k);
            density *= 4.0 * node.shares[k];
            at = node.children[k];
        }
        density
    }
}

/// The part of the square that holds a point.
fn quarter(square: Vec2) -> usize {
    usize::from(square.x >= 0.5) + 2 * usize::from(square.y >= 0.5)
}

/// The point within that part.
fn within(square: Vec2, k: usize) -> Vec2 {
    let corner = Vec2::new(f32::from(u8::from(k % 2 == 1)), f32::from(u8::from(k >= 2)));
    square * 2.0 - corner
}

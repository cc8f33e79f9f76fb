// SPDX-License-Identifier: GPL-3.0-or-later
//! A binary tree over lights with a position: the choice of one by its possible contribution to a point, in
//! log n steps.
//! Source: [EK18] (bounds by box and cone, the surface area orientation heuristic); [PJH23] section 12.6.3
//! (importance of a node, traversal by one random number). Differs: the light itself estimates the
//! contribution of a single light.
//! Space: world. Importance of a node and contribution of a light have one unit: intensity times cosine over
//! distance squared. Invariants: `probability` is the probability of `choose`, bit for bit; a node whose
//! importance is 0 holds no light that reaches the point (except for rounding at grazing angles). A zero
//! normal has no horizon.
//! Tests: `tests`, and those of `light_set`.

use glam::Vec3;
use gnurt_accel::Threads;
use rayon::prelude::*;

use super::light_estimates::GroupBounds;
use crate::sampling::distribution::ALMOST_ONE;

/// Bounds, directions and power of a group of lights.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightBounds {
    pub(super) min: Vec3,
    pub(super) max: Vec3,
    /// Middle of the cone that holds all normals.
    pub(super) axis: Vec3,
    /// Cosine of the half angle of that cone; -1 = all directions.
    pub(super) cos_normals: f32,
    /// Cosine of the greatest angle of emission from its normal: 0 for surfaces.
    pub(super) cos_emission: f32,
    /// Largest intensity: area times radiance for surfaces, summed.
    pub(super) power: f32,
}

impl LightBounds {
    fn union(&self, other: &Self) -> Self {
        let (axis, cos_normals) = cone_union((self.axis, self.cos_normals), (other.axis, other.cos_normals));
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
            axis,
            cos_normals,
            cos_emission: self.cos_emission.min(other.cos_emission),
            power: self.power + other.power,
        }
    }

    pub(super) fn centre(&self) -> Vec3 {
        0.5 * (self.min + self.max)
    }

    /// The same as choices see it.
    pub(super) fn seen(&self) -> GroupBounds<f32> {
        let half = 0.5 * (self.max - self.min);
        GroupBounds {
            centre: self.centre().into(),
            half: half.into(),
            radius2: 0.25 * (self.max - self.min).length_squared(),
            axis: self.axis.into(),
            cos_normals: self.cos_normals,
            cos_emission: self.cos_emission,
            power: self.power,
        }
    }

    /// About the most that the group brings to a surface at `p`; a zero `normal` has no horizon.
    fn importance(&self, p: Vec3, normal: Vec3) -> f32 {
        self.seen().importance(p.into(), (normal != Vec3::ZERO).then(|| normal.into()))
    }
}

/// The smallest cone around two cones, each an axis and the cosine of its half angle.
fn cone_union(a: (Vec3, f32), b: (Vec3, f32)) -> (Vec3, f32) {
    let all = (a.0, -1.0);
    if a.1 <= -1.0 || b.1 <= -1.0 {
        return all;
    }
    let (half_a, half_b) = (a.1.clamp(-1.0, 1.0).acos(), b.1.clamp(-1.0, 1.0).acos());
    let axis_angle = a.0.dot(b.0).clamp(-1.0, 1.0).acos();
    if (axis_angle + half_b).min(std::f32::consts::PI) <= half_a {
        return a;
    }
    if (axis_angle + half_a).min(std::f32::consts::PI) <= half_b {
        return b;
    }
    let half = 0.5 * (half_a + axis_angle + half_b);
    let rotation = a.0.cross(b.0);
    if half >= std::f32::consts::PI || rotation.length_squared() < 1e-12 {
        return all;
    }
    // From a's axis towards b's until a's far side is reached.
    let angle = half - half_a;
    let side = rotation.normalize().cross(a.0);
    let axis = (a.0 * angle.cos() + side * angle.sin()).normalize();
    // Wider by the possible rounding error.
    (axis, (half + 1e-3).min(std::f32::consts::PI).cos())
}

/// A node: a few lights, or two children of which the first comes next.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    pub(super) bounds: LightBounds,
    /// The first light's index in `order`, or the second child.
    pub(super) index: u32,
    /// How many lights; 0 = inner node.
    pub(super) lights: u32,
}

/// The tree; empty if there is no light.
#[derive(Debug, Default)]
pub(super) struct LightTree {
    pub(super) nodes: Vec<Node>,
    /// Lights by leaf.
    pub(super) order: Vec<u32>,
    /// The path to each light: bit k = second child at depth k. `None` = it is not in the tree.
    branches: Vec<Option<u64>>,
}

/// Deeper than this halves are cut evenly, so that paths fit in 64 bits.
const UNEVEN_DEPTH: u32 = 30;
/// Tested cuts along each feature, plus one.
const BUCKETS: usize = 12;
/// Lights from which on threads share the work.
const MANY: usize = 2048;
/// Lights that are judged one by one.
pub(super) const LEAF: usize = 8;

/// Contribution of each light of a leaf to a point; the rest is zero.
type Contributions = [f32; LEAF];

impl LightTree {
    /// Lights without bounds or without power are left out: they are never chosen.
    pub(super) fn new(lights: &[Option<LightBounds>], threads: Threads) -> Self {
        let sound = |b: &LightBounds| b.power > 0.0 && b.power.is_finite() && (b.min + b.max).is_finite();
        let mut all: Vec<(u32, LightBounds)> = (0..)
            .zip(lights)
            .filter_map(|(i, bounds)| bounds.filter(sound).map(|bounds| (i, bounds)))
            .collect();
        let mut tree = Subtree::default();
        if !all.is_empty() {
            threads.run(|parallel| tree.build(&mut all, 0, 0, parallel));
        }
        let mut branches = vec![None; lights.len()];
        tree.order
            .iter()
            .zip(tree.branches)
            .for_each(|(&light, branch_bits)| branches[light as usize] = Some(branch_bits));
        Self { nodes: tree.nodes, order: tree.order, branches }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Contribution of each light of a leaf; the rest is zero.
    fn leaf(&self, node: &Node, exact: &impl Fn(u32) -> f32) -> Contributions {
        let mut contributions = [0.0; LEAF];
        let lights = &self.order[node.index as usize..(node.index + node.lights) as usize];
        contributions.iter_mut().zip(lights).for_each(|(contribution, &light)| *contribution = exact(light));
        contributions
    }

    /// About what all lights bring to a point; 0 only where none reaches it.
    pub(super) fn contribution(&self, p: Vec3, normal: Vec3, exact: impl Fn(u32) -> f32) -> f32 {
        let Some(root) = self.nodes.first() else { return 0.0 };
        if root.lights > 0 {
            return self.leaf(root, &exact).iter().sum();
        }
        let ([first, second], _) = self.children(0, p, normal, &exact);
        first + second
    }

    /// What the children of an inner node bring, and the contributions of their lights if both are leaves.
    fn children(
        &self,
        at: usize,
        p: Vec3,
        normal: Vec3,
        exact: &impl Fn(u32) -> f32,
    ) -> ([f32; 2], Option<[Contributions; 2]>) {
        let children = [at + 1, self.nodes[at].index as usize].map(|child| &self.nodes[child]);
        let leaves = children.iter().all(|child| child.lights > 0);
        let leaves = leaves.then(|| children.map(|child| self.leaf(child, exact)));
        let brought = match &leaves {
            Some(leaves) => leaves.each_ref().map(|contributions| contributions.iter().sum::<f32>()),
            None => children.map(|child| child.bounds.importance(p, normal)),
        };
        (brought, leaves)
    }

    /// The probability of the first child of an inner node, and the contributions of the lights of children
    /// that are leaves; `None` if neither child contributes.
    fn first_share(
        &self,
        at: usize,
        p: Vec3,
        normal: Vec3,
        exact: &impl Fn(u32) -> f32,
    ) -> Option<(f32, Option<[Contributions; 2]>)> {
        let ([first, second], leaves) = self.children(at, p, normal, exact);
        let sum = first + second;
        (sum > 0.0).then(|| (first / sum, leaves))
    }

    /// Chooses a light by a number in [0, 1): its number and the probability of that. `exact` returns the
    /// contribution of a light to the point, zero if there is none.
    pub(super) fn choose(
        &self,
        p: Vec3,
        normal: Vec3,
        mut u: f32,
        exact: impl Fn(u32) -> f32,
    ) -> Option<(u32, f32)> {
        let (mut at, mut probability) = (0, 1.0);
        let mut known = None;
        loop {
            let node = self.nodes.get(at)?;
            if node.lights > 0 {
                let contributions = known.unwrap_or_else(|| self.leaf(node, &exact));
                let sum: f32 = contributions.iter().sum();
                let last = contributions.iter().rposition(|&contribution| contribution > 0.0)?;
                let mut rest = u * sum;
                let chosen = (0..last).find(|&k| {
                    rest -= contributions[k];
                    rest < 0.0
                });
                let chosen = chosen.unwrap_or(last);
                let light = self.order[node.index as usize + chosen];
                return Some((light, probability * (contributions[chosen] / sum)));
            }
            let (share, leaves) = self.first_share(at, p, normal, &exact)?;
            known = leaves.map(|[first, second]| if u < share { first } else { second });
            if u < share {
                u = (u / share).min(ALMOST_ONE);
                probability *= share;
                at += 1;
            } else {
                u = ((u - share) / (1.0 - share)).min(ALMOST_ONE);
                probability *= 1.0 - share;
                at = node.index as usize;
            }
        }
    }

    /// The probability with which a light is chosen for a point.
    pub(super) fn probability(&self, light: u32, p: Vec3, normal: Vec3, exact: impl Fn(u32) -> f32) -> f32 {
        let Some(mut branch_bits) = self.branches[light as usize] else { return 0.0 };
        let (mut at, mut probability) = (0, 1.0);
        let mut known: Option<Contributions> = None;
        loop {
            let node = &self.nodes[at];
            if node.lights > 0 {
                let sum: f32 = known.unwrap_or_else(|| self.leaf(node, &exact)).iter().sum();
                let contribution = exact(light);
                return if contribution > 0.0 { probability * (contribution / sum) } else { 0.0 };
            }
            let Some((share, leaves)) = self.first_share(at, p, normal, &exact) else { return 0.0 };
            known = leaves.map(|[first, second]| if branch_bits & 1 == 0 { first } else { second });
            if branch_bits & 1 == 0 {
                probability *= share;
                at += 1;
            } else {
                probability *= 1.0 - share;
                at = node.index as usize;
            }
            branch_bits >>= 1;
        }
    }
}

/// A part of an unfinished tree; indices count from its own beginning.
#[derive(Default)]
struct Subtree {
    nodes: Vec<Node>,
    /// Lights by leaf.
    order: Vec<u32>,
    /// The path to each of them.
    branches: Vec<u64>,
}

impl Subtree {
    fn build(
        &mut self,
        lights: &mut [(u32, LightBounds)],
        depth: u32,
        branch_bits: u64,
        parallel: bool,
    ) -> LightBounds {
        let at = self.nodes.len();
        if lights.len() <= LEAF {
            let bounds = lights.iter().skip(1).fold(lights[0].1, |sum, light| sum.union(&light.1));
            self.nodes.push(Node { bounds, index: self.order.len() as u32, lights: lights.len() as u32 });
            for (light, _) in lights {
                self.order.push(*light);
                self.branches.push(branch_bits);
            }
            return bounds;
        }
        let parallel = parallel && lights.len() >= MANY;
        let middle = split(lights, depth, parallel);
        self.nodes.push(Node { bounds: lights[0].1, index: 0, lights: 0 });
        let (left, right) = lights.split_at_mut(middle);
        let other_branch = branch_bits | 1 << depth;
        let [first, second] = if parallel {
            let mut other = Self::default();
            let (first, second) = rayon::join(
                || self.build(left, depth + 1, branch_bits, true),
                || other.build(right, depth + 1, other_branch, true),
            );
            self.nodes[at].index = self.nodes.len() as u32;
            self.append(other);
            [first, second]
        } else {
            let first = self.build(left, depth + 1, branch_bits, false);
            self.nodes[at].index = self.nodes.len() as u32;
            [first, self.build(right, depth + 1, other_branch, false)]
        };
        self.nodes[at].bounds = first.union(&second);
        self.nodes[at].bounds
    }

    /// Puts another part behind this one.
    fn append(&mut self, other: Self) {
        let (nodes, lights) = (self.nodes.len() as u32, self.order.len() as u32);
        let moved =
            |node: Node| Node { index: node.index + if node.lights > 0 { lights } else { nodes }, ..node };
        self.nodes.extend(other.nodes.into_iter().map(moved));
        self.order.extend(other.order);
        self.branches.extend(other.branches);
    }
}

/// Sort keys of lights: three coordinates of the centre, three of the axis.
fn feature(bounds: &LightBounds, k: usize) -> f32 {
    if k < 3 { bounds.centre()[k] } else { bounds.axis[k - 3] }
}

/// A split of lights into two groups: those below bucket `cut` of a feature, and the rest.
struct Cut {
    feature: usize,
    low: f32,
    size: f32,
    cut: usize,
}

impl Cut {
    fn bucket(&self, bounds: &LightBounds) -> usize {
        let position = (feature(bounds, self.feature) - self.low) / self.size * BUCKETS as f32;
        (position as usize).min(BUCKETS - 1)
    }
}

/// Sorts lights into two groups that are not empty; where the second begins.
fn split(lights: &mut [(u32, LightBounds)], depth: u32, parallel: bool) -> usize {
    let range = |k: usize| {
        lights.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), light| {
            let x = feature(&light.1, k);
            (low.min(x), high.max(x))
        })
    };
    let ranges: [(f32, f32); 6] = std::array::from_fn(range);
    let size = |k: usize| ranges[k].1 - ranges[k].0;
    let widest = (0..3).fold(0, |widest, k| if size(k) > size(widest) { k } else { widest });
    let mut best: Option<(f32, Cut)> = None;
    if depth < UNEVEN_DEPTH {
        let along = |k: usize| Cut { feature: k, low: ranges[k].0, size: size(k), cut: 0 };
        let of_feature = |k: usize| if size(k) > 0.0 { costs(lights, &along(k)) } else { Vec::new() };
        let of_features: Vec<_> = if parallel {
            (0..6).into_par_iter().map(of_feature).collect()
        } else {
            (0..6).map(of_feature).collect()
        };
        for (k, costs) in of_features.into_iter().enumerate() {
            // Thin cuts through long boxes make bad groups.
            let shape = if k < 3 { size(widest) / size(k) } else { 1.0 };
            let cut = along(k);
            for (position, cost) in costs {
                if best.as_ref().is_none_or(|(least, ..)| shape * cost < *least) {
                    best = Some((shape * cost, Cut { cut: position, ..cut }));
                }
            }
        }
    }
    if let Some((_, cut)) = best {
        // Stable, so that the tree does not depend on how sorting is done.
        lights.sort_by_key(|light| cut.bucket(&light.1) >= cut.cut);
        let middle = lights.partition_point(|light| cut.bucket(&light.1) < cut.cut);
        if middle > 0 && middle < lights.len() {
            return middle;
        }
    }
    lights.sort_by(|a, b| a.1.centre()[widest].total_cmp(&b.1.centre()[widest]));
    lights.len() / 2
}

/// The cost of each cut along a feature that leaves lights on both sides.
fn costs(lights: &[(u32, LightBounds)], along: &Cut) -> Vec<(usize, f32)> {
    let mut buckets: [Option<LightBounds>; BUCKETS] = [None; BUCKETS];
    for (_, bounds) in lights {
        let slot = &mut buckets[along.bucket(bounds)];
        *slot = Some(slot.map_or(*bounds, |sum| sum.union(bounds)));
    }
    let join = |part: &[Option<LightBounds>]| part.iter().flatten().copied().reduce(|a, b| a.union(&b));
    (1..BUCKETS)
        .filter_map(|cut| {
            let (left, right) = (join(&buckets[..cut])?, join(&buckets[cut..])?);
            Some((cut, weight(&left) + weight(&right)))
        })
        .collect()
}

/// The surface area orientation heuristic: power times the size of the group and the emitted part of the
/// sphere.
fn weight(bounds: &LightBounds) -> f32 {
    use std::f32::consts::{FRAC_PI_2, PI};
    let normals = bounds.cos_normals.clamp(-1.0, 1.0).acos();
    let reach = (normals + bounds.cos_emission.clamp(-1.0, 1.0).acos()).min(PI);
    let (sin, cos) = (normals.sin(), normals.cos());
    let solid_angle = 2.0 * PI * (1.0 - cos)
        + FRAC_PI_2 * (2.0 * reach * sin - (normals - 2.0 * reach).cos() - 2.0 * normals * sin + cos);
    let d = bounds.max - bounds.min;
    let area = 2.0 * (d.x * d.y + d.y * d.z + d.z * d.x);
    // Lights in a line have no area: their length counts a little.
    bounds.power * solid_angle.max(1e-3) * (area + 1e-3 * d.length_squared())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> Vec<Option<LightBounds>> {
        (0..60)
            .map(|i| {
                let centre = Vec3::new((i % 5) as f32, (i / 5 % 4) as f32, (i / 20) as f32) * 2.0;
                let axis = [Vec3::Z, -Vec3::Z, Vec3::X, Vec3::new(0.6, 0.0, 0.8)][i % 4];
                (i != 7).then_some(LightBounds {
                    min: centre - 0.1,
                    max: centre + 0.1,
                    axis,
                    cos_normals: if i % 9 == 0 { -1.0 } else { 1.0 },
                    cos_emission: 0.0,
                    power: 1.0 + i as f32,
                })
            })
            .collect()
    }

    #[test]
    fn probabilities_are_those_of_choices_and_add_up() {
        let lights = grid();
        let tree = LightTree::new(&lights, Threads::Single);
        for (p, n) in [
            (Vec3::new(1.0, 3.0, -2.0), Vec3::Z),
            (Vec3::new(3.0, 3.0, 3.0), Vec3::ZERO),
            (Vec3::new(20.0, 0.0, 1.0), -Vec3::X),
        ] {
            let exact = |i: u32| lights[i as usize].map_or(0.0, |bounds| bounds.importance(p, n));
            let sum: f32 = (0..60).map(|i| tree.probability(i, p, n, exact)).sum();
            // Less than one where a group has importance but none of its lights contributes.
            assert!(sum > 0.9 && sum < 1.0 + 1e-5, "from {p}: {sum}");
            assert_eq!(tree.probability(7, p, n, exact), 0.0, "what is not there is not chosen");
            const N: u32 = 100_000;
            let mut counts = [0.0_f32; 60];
            for k in 0..N {
                let u = (k as f32 + 0.5) / N as f32;
                let Some((light, probability)) = tree.choose(p, n, u, exact) else { continue };
                assert_eq!(probability, tree.probability(light, p, n, exact), "the same bits");
                counts[light as usize] += 1.0 / N as f32;
            }
            for (i, count) in (0..).zip(counts) {
                let expected = tree.probability(i, p, n, exact);
                assert!(
                    (count - expected).abs() < 1e-3 * (1.0 + expected),
                    "light {i}: {count}, not {expected}"
                );
            }
        }
    }

    /// Brute force: no light may bring anything where the importance of a node above it is zero.
    #[test]
    fn dark_nodes_hold_nothing() {
        let lights = grid();
        let tree = LightTree::new(&lights, Threads::Single);
        for k in 0..2000_u32 {
            let part = |m: u32, s: f32| ((k.wrapping_mul(m) >> 7) % 1000) as f32 / 1000.0 * s - 2.0;
            let p = Vec3::new(part(2_654_435_761, 14.0), part(40_503, 11.0), part(2_246_822_519, 9.0));
            let n = [Vec3::Z, -Vec3::X, Vec3::new(0.0, 0.6, 0.8)][k as usize % 3];
            let exact = |i: u32| {
                let Some(light) = lights[i as usize] else { return 0.0 };
                let towards = (light.centre() - p).normalize();
                let lit = light.cos_normals < 0.0 || light.axis.dot(-towards) > 1e-3;
                if lit && n.dot(towards) > 1e-3 { 1.0 } else { 0.0 }
            };
            for i in (0..60).filter(|&i| exact(i) > 0.0) {
                assert!(tree.probability(i, p, n, exact) > 0.0, "light {i} reaches {p}");
            }
        }
    }

    /// More lights than one thread takes at a time, at random positions and directions.
    #[test]
    fn threads_do_not_show() {
        let number = |k: u32, m: u32| (k.wrapping_mul(m) >> 8) as f32 / (1 << 24) as f32;
        let light = |k: u32| {
            let [x, y, z] = [2_654_435_761, 40_503_001, 2_246_822_519].map(|m| number(k, m));
            let axis = Vec3::new(y - 0.5, z - 0.5, x - 0.5).normalize();
            let (min, max) = (Vec3::new(x, y, z), Vec3::new(x, y, z) + 0.01);
            Some(LightBounds { min, max, axis, cos_normals: 1.0, cos_emission: 0.0, power: 0.1 + x * y })
        };
        let lights: Vec<_> = (0..4 * MANY as u32).map(light).collect();
        let single = format!("{:?}", LightTree::new(&lights, Threads::Single));
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
            let shared = format!("{:?}", LightTree::new(&lights, Threads::Pool(&pool)));
            assert!(single == shared, "{threads} threads make the same tree");
        }
    }

    #[test]
    fn many_lights_at_one_place_still_make_a_tree() {
        let one = LightBounds {
            min: Vec3::ONE,
            max: Vec3::ONE,
            axis: Vec3::Z,
            cos_normals: 1.0,
            cos_emission: 0.0,
            power: 1.0,
        };
        let tree = LightTree::new(&vec![Some(one); 1000], Threads::Single);
        let chosen = tree.choose(Vec3::new(1.0, 1.0, 5.0), -Vec3::Z, 0.3, |_| 1.0).expect("a light");
        assert!((chosen.1 - 1e-3).abs() < 1e-4, "all alike: {}", chosen.1);
        assert!(LightTree::new(&[None], Threads::Single).is_empty(), "no light, no tree");
    }
}

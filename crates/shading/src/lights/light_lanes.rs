// SPDX-License-Identifier: GPL-3.0-or-later
//! Choosing lights for sixteen points at once: the walks of `light_tree` side by side, the triangles of a leaf side by side.
//! Source: as `light_tree` and `area`; the layout is original. Space: world.
//! A node, and a triangle, is a row of sixteen floats: sixteen points that are at different ones read sixteen rows and turn
//! them to columns, so that each costs a load and some shuffles. Two leaves with one parent are a block of sixteen triangles.
//! Invariant: the samples of [`LightSet::sample`](super::LightSet::sample), bit for bit.
//! Proof: `light_set_tests::lanes_choose_as_points_do`.

use glam::Vec3;
use gnurt_simd::{Simd, f32x16, prelude::*, u32x16};

use super::area::Shape;
use super::light_set::{LightParts, LightSample, LightSet};
use super::light_tree::{LEAF, LightTree, Node};
use crate::lanes::{Floats, LANES, Mask, Vec3x16, Words, each_lane, select3, transpose};
use crate::sampling::distribution::ALMOST_ONE;
use crate::sampling::triangle_x16;

/// Directions to lights from sixteen points: see [`LightSample`].
#[derive(Clone, Copy, Debug)]
pub struct LightSampleX16<S: Simd> {
    /// Unit, towards the light.
    pub dir: Vec3x16<S>,
    /// How far it is; infinite for lights without a place.
    pub dist: Floats<S>,
    /// Radiance against `dir`; irradiance for `delta` lights.
    pub radiance: Vec3x16<S>,
    /// Density per solid angle, the choice included; the probability of the choice for `delta` lights.
    pub pdf: Floats<S>,
    /// Lanes whose light no scattered ray could meet.
    pub delta: Mask<S>,
    /// Lanes that found a light; the others hold anything.
    pub found: Mask<S>,
}

/// Sixteen floats that are read at once.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Row([f32; LANES]);

/// The triangles of two leaves that have one parent, or of one leaf and nothing.
#[derive(Clone, Debug)]
struct Block {
    /// Three corners, normal, area, power; zero where there is no triangle.
    shape: [Row; 14],
    lights: [u32; LANES],
}

/// What a node's row ends with: where walks go on.
const INNER: u32 = 0;
/// A leaf: the first half of a block.
const SINGLE: u32 = 1;
/// A parent of two leaves, a block.
const PAIR: u32 = 2;

/// A light tree of triangles in rows.
#[derive(Debug)]
pub(super) struct LightLanes {
    /// By node: centre, half of the diagonal, square of the radius, axis, cosines of normals and emission, power; then as
    /// words the second child, the kind and the block.
    nodes: Vec<Row>,
    blocks: Vec<Block>,
    /// By triangle: three corners, normal, area, radiance.
    triangles: Vec<Row>,
    /// By triangle: whether its radiance depends on the place. Empty if none does.
    uneven: Vec<bool>,
}

/// Where a walk ends.
struct End<S: Simd> {
    block: Words<S>,
    kind: Words<S>,
    probability: Floats<S>,
    /// What is left of the random number.
    rest: Floats<S>,
    /// Lanes that came there.
    alive: Mask<S>,
}

impl LightLanes {
    /// `None` where the tree is empty or not all of triangles.
    pub(super) fn new(parts: &LightParts, tree: &LightTree) -> Option<Self> {
        let lights = parts.triangles.as_ref()?;
        if tree.is_empty() || !parts.points.is_empty() || !parts.spots.is_empty() {
            return None;
        }
        let mut lanes =
            Self { nodes: Vec::new(), blocks: Vec::new(), triangles: Vec::new(), uneven: Vec::new() };
        for (at, node) in tree.nodes.iter().enumerate() {
            let (kind, leaves) = if node.lights > 0 {
                (SINGLE, vec![node])
            } else {
                let children = [at + 1, node.index as usize].map(|child| &tree.nodes[child]);
                let pair = children.iter().all(|child| child.lights > 0);
                if pair { (PAIR, children.to_vec()) } else { (INNER, Vec::new()) }
            };
            let block = lanes.blocks.len() as u32;
            if kind != INNER {
                lanes.blocks.push(Block::new(&leaves, tree, &lights.shapes));
            }
            lanes.nodes.push(node_row(node, [node.index, kind, block]));
        }
        let even: Vec<_> = (0..lights.len()).map(|i| lights.even_radiance(i)).collect();
        for (shape, even) in lights.shapes.iter().zip(&even) {
            let mut row = [0.0; LANES];
            write3(&mut row, &[shape.p[0], shape.p[1], shape.p[2], shape.normal]);
            row[12] = shape.area;
            row[13..].copy_from_slice(&even.unwrap_or_default().to_array());
            lanes.triangles.push(Row(row));
        }
        if even.iter().any(Option::is_none) {
            lanes.uneven = even.iter().map(Option::is_none).collect();
        }
        Some(lanes)
    }

    /// Samples for the lanes in `active`, whose normals are unit.
    #[inline(always)]
    fn sample<S: Simd>(
        &self,
        parts: &LightParts,
        active: Mask<S>,
        [p, normal]: [Vec3x16<S>; 2],
        [choice, x, y]: [Floats<S>; 3],
        chance: Floats<S>,
    ) -> LightSampleX16<S> {
        let simd = choice.token();
        let end = self.walk(active, p, normal, choice);
        let (light, probability, found) = self.choose(&end, p, normal);
        let probability = chance * probability;
        // From here on as `LightSet::sample_near`.
        let light: [u32; LANES] = light.into();
        let row = columns(simd, &self.triangles, &light);
        let corners = [0, 3, 6].map(|k| Vec3x16::new(row[k], row[k + 1], row[k + 2]));
        let towards = Vec3x16::new(row[9], row[10], row[11]);
        let (area, place) = (row[12], triangle_x16([x, y]));
        let [b1, b2] = place;
        let point = corners[0] + (corners[1] - corners[0]) * b1 + (corners[2] - corners[0]) * b2;
        let largest = |v: Vec3x16<S>| v.map(|x| x.abs()).max_element();
        let reach = corners.iter().fold(largest(p), |most, &corner| most.max(largest(corner)));
        let way = point + towards * (reach * (16.0 * f32::EPSILON)) - p;
        let dist = way.length_squared().sqrt();
        let dir = way.over(dist);
        let cos = -towards.dot(dir);
        let zero = f32x16::splat(simd, 0.0);
        let density = cos.simd_gt(zero).select(dist * dist / (cos * area), zero);
        let mut radiance = Vec3x16::new(row[13], row[14], row[15]);
        if let (false, Some(triangles)) = (self.uneven.is_empty(), &parts.triangles) {
            each_lane(found.to_bitmask(), |i| {
                if self.uneven[light[i] as usize] {
                    let here = triangles.radiance(light[i] as usize, [b1[i], b2[i]]);
                    (radiance.x[i], radiance.y[i], radiance.z[i]) = here.into();
                }
            });
        }
        let pdf = probability * density;
        let sound = dist.simd_gt(zero) & pdf.simd_gt(zero) & pdf.is_finite() & radiance.is_finite();
        let none = mask_none(simd);
        LightSampleX16 { dir, dist, radiance, pdf, delta: none, found: found & sound }
    }

    /// From the root to a leaf or two; `choice` is in [0, 1).
    #[inline(always)]
    fn walk<S: Simd>(&self, active: Mask<S>, p: Vec3x16<S>, normal: Vec3x16<S>, choice: Floats<S>) -> End<S> {
        let simd = choice.token();
        let word = |x: f32| u32x16::splat(simd, x.to_bits());
        let root = &self.nodes[0].0;
        let (mut second, mut kind, mut block) = (word(root[13]), word(root[14]), word(root[15]));
        let mut at = u32x16::splat(simd, 0);
        let mut end = End { block, kind, probability: f32x16::splat(simd, 1.0), rest: choice, alive: active };
        let inner = u32x16::splat(simd, INNER);
        let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
        loop {
            let walking = end.alive & kind.simd_eq(inner);
            if !walking.any_true() {
                (end.block, end.kind) = (block, kind);
                return end;
            }
            let rows = [at + 1, second].map(|child| {
                // Those that do not walk look at the root.
                let child: [u32; LANES] = walking.select(child, u32x16::splat(simd, 0)).into();
                columns(simd, &self.nodes, &child)
            });
            let [first, other] = rows.map(|row| importance(&row, p, normal));
            let sum = first + other;
            let lost = walking & !sum.simd_gt(zero);
            end.alive &= !lost;
            let share = first / sum;
            let (rest, to_first) = descend(end.rest, share);
            let chance = to_first.select(share, one - share);
            end.rest = walking.select(rest, end.rest);
            end.probability = walking.select(end.probability * chance, end.probability);
            let from_rows = |k: usize| -> Words<S> { to_first.select(rows[0][k], rows[1][k]).bitcast() };
            at = walking.select(to_first.select(at + 1, second), at);
            second = walking.select(from_rows(13), second);
            kind = walking.select(from_rows(14), kind);
            block = walking.select(from_rows(15), block);
        }
    }

    /// Chooses among the lights of leaves: the light, its probability and the lanes that found one.
    #[inline(always)]
    fn choose<S: Simd>(
        &self,
        end: &End<S>,
        p: Vec3x16<S>,
        normal: Vec3x16<S>,
    ) -> (Words<S>, Floats<S>, Mask<S>) {
        let simd = end.rest.token();
        let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
        let slots = self.promises(end, p, normal);
        let sum = |half: &[Floats<S>]| half.iter().skip(1).fold(half[0], |sum, &promise| sum + promise);
        let (first, other) = (sum(&slots[..LEAF]), sum(&slots[LEAF..]));
        // The last inner node, where there is one, as in `walk`.
        let pair = end.kind.simd_eq(u32x16::splat(simd, PAIR));
        let both = first + other;
        let share = first / both;
        let (rest, to_first) = descend(end.rest, share);
        let chance = to_first.select(share, one - share);
        let rest = pair.select(rest, end.rest);
        let probability = pair.select(end.probability * chance, end.probability);
        let in_other = pair & !to_first;
        let sum = in_other.select(other, first);
        // The leaf.
        let mut left = rest * sum;
        let mut chosen = u32x16::splat(simd, 0);
        let mut promised = zero;
        let half: [Floats<S>; LEAF] = std::array::from_fn(|k| in_other.select(slots[k + LEAF], slots[k]));
        let mut last = chosen;
        for (k, &promise) in half.iter().enumerate() {
            let some = promise.simd_gt(zero);
            last = some.select(u32x16::splat(simd, k as u32), last);
            promised = some.select(promise, promised);
        }
        chosen = last;
        let mut open = sum.simd_gt(zero);
        for (k, &promise) in half.iter().enumerate() {
            let place = u32x16::splat(simd, k as u32);
            left -= promise;
            let here = open & left.simd_lt(zero) & place.simd_lt(last);
            chosen = here.select(place, chosen);
            promised = here.select(promise, promised);
            open &= !here;
        }
        let probability = probability * (promised / sum);
        let found = end.alive & promised.simd_gt(zero) & (!pair | both.simd_gt(zero));
        let place = chosen + in_other.select(u32x16::splat(simd, LEAF as u32), u32x16::splat(simd, 0));
        let (place, block): ([u32; LANES], [u32; LANES]) = (place.into(), end.block.into());
        let mut light = [0; LANES];
        each_lane(found.to_bitmask(), |i| {
            light[i] = self.blocks[block[i] as usize].lights[place[i] as usize % LANES];
        });
        (u32x16::simd_from(simd, light), probability, found)
    }

    /// What each triangle of each lane's block promises to it.
    #[inline(always)]
    fn promises<S: Simd>(&self, end: &End<S>, p: Vec3x16<S>, normal: Vec3x16<S>) -> [Floats<S>; LANES] {
        let simd = end.rest.token();
        let zero = f32x16::splat(simd, 0.0);
        let mut promises = [zero; LANES];
        if let [block] = &self.blocks[..] {
            // All are here: points side by side.
            for (k, promise) in promises.iter_mut().enumerate() {
                if block.shape[13].0[k] > 0.0 {
                    let shape = std::array::from_fn(|c| f32x16::splat(simd, block.shape[c].0[k]));
                    *promise = promise_of(&shape, p, normal);
                }
            }
            return promises;
        }
        let block: [u32; LANES] = end.block.into();
        each_lane(end.alive.to_bitmask(), |i| {
            let rows = &self.blocks[block[i] as usize].shape;
            let shape = std::array::from_fn(|c| f32x16::from_slice(simd, &rows[c].0));
            let one = |v: Vec3x16<S>| v.map(|x| f32x16::splat(simd, x[i]));
            promises[i] = promise_of(&shape, one(p), one(normal));
        });
        transpose(promises)
    }
}

impl Block {
    fn new(leaves: &[&Node], tree: &LightTree, shapes: &[Shape]) -> Self {
        let mut block = Self { shape: [Row([0.0; LANES]); 14], lights: [0; LANES] };
        for (half, leaf) in leaves.iter().enumerate() {
            let lights = &tree.order[leaf.index as usize..(leaf.index + leaf.lights) as usize];
            for (place, &light) in (half * LEAF..).zip(lights) {
                let shape = &shapes[light as usize];
                let mut row = [0.0; 14];
                write3(&mut row, &[shape.p[0], shape.p[1], shape.p[2], shape.normal]);
                (row[12], row[13]) = (shape.area, shape.power);
                block.shape.iter_mut().zip(row).for_each(|(column, x)| column.0[place] = x);
                block.lights[place] = light;
            }
        }
        block
    }
}

/// Vectors one after the other.
fn write3(row: &mut [f32], vectors: &[Vec3]) {
    row.chunks_exact_mut(3).zip(vectors).for_each(|(out, v)| out.copy_from_slice(&v.to_array()));
}

fn node_row(node: &Node, words: [u32; 3]) -> Row {
    let bounds = &node.bounds;
    let size = bounds.max - bounds.min;
    let mut row = [0.0; LANES];
    write3(&mut row, &[bounds.centre(), 0.5 * size]);
    row[6] = 0.25 * size.length_squared();
    write3(&mut row[7..], &[bounds.axis]);
    row[10..13].copy_from_slice(&[bounds.cos_normals, bounds.cos_emission, bounds.power]);
    row[13..].copy_from_slice(&words.map(f32::from_bits));
    Row(row)
}

/// Row `at[i]` as lane `i` of each column.
#[inline(always)]
fn columns<S: Simd>(simd: S, rows: &[Row], at: &[u32; LANES]) -> [Floats<S>; LANES] {
    if at.iter().all(|&i| i == at[0]) {
        let row = &rows[at[0] as usize].0;
        return std::array::from_fn(|k| f32x16::splat(simd, row[k]));
    }
    transpose(at.map(|i| f32x16::from_slice(simd, &rows[i as usize].0)))
}

/// What is left of a random number after a choice between a share and the rest, and whether it is the former.
#[inline(always)]
fn descend<S: Simd>(u: Floats<S>, share: Floats<S>) -> (Floats<S>, Mask<S>) {
    let simd = u.token();
    let to_first = u.simd_lt(share);
    let left = (u - share) / (f32x16::splat(simd, 1.0) - share);
    let rest = to_first.select(u / share, left).min(f32x16::splat(simd, ALMOST_ONE));
    (rest, to_first)
}

#[inline(always)]
fn mask_none<S: Simd>(simd: S) -> Mask<S> {
    Mask::from_bitmask(simd, 0)
}

/// `LightBounds::importance` of a node's row.
#[inline(always)]
fn importance<S: Simd>(row: &[Floats<S>; LANES], p: Vec3x16<S>, normal: Vec3x16<S>) -> Floats<S> {
    let simd = p.x.token();
    let constant = |x: f32| f32x16::splat(simd, x);
    let (zero, one) = (constant(0.0), constant(1.0));
    let vector = |k: usize| Vec3x16::new(row[k], row[k + 1], row[k + 2]);
    let (way, half, radius2, axis) = (vector(0) - p, vector(3), row[6], vector(7));
    let (cos_normals, cos_emission, power) = (row[10], row[11], row[12]);
    let distance2 = way.length_squared();
    let towards = way.over(distance2.sqrt());
    let at_centre = !towards.is_finite();
    let below = (normal.dot(way) + normal.map(|x| x.abs()).dot(half)).simd_le(zero);
    let outside = distance2.simd_gt(radius2);
    let cos_size = outside.select((one - radius2 / distance2).max(zero).sqrt(), -one);
    let from_normal = angle_less(-axis.dot(towards), cos_normals);
    let cos_light = angle_less(from_normal, cos_size);
    let cos_surface = angle_less(normal.dot(towards), cos_size);
    let dark = cos_light.simd_lt(cos_emission - constant(1e-4)) | cos_surface.simd_lt(constant(-1e-4));
    let least = constant(1e-4);
    let seen = power * cos_light.max(least) * cos_surface.max(least) / distance2.max(radius2);
    let seen = seen.is_finite().select(seen, constant(f32::MAX.sqrt()));
    let lit = (below | dark).select(zero, seen);
    at_centre.select(power / radius2.max(constant(f32::MIN_POSITIVE)), lit)
}

/// As the function of that name in `light_tree`.
#[inline(always)]
fn angle_less<S: Simd>(cos_a: Floats<S>, cos_b: Floats<S>) -> Floats<S> {
    let simd = cos_a.token();
    let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
    let sin = |cos: Floats<S>| (one - cos * cos).max(zero).sqrt();
    cos_a.simd_ge(cos_b).select(one, cos_a * cos_b + sin(cos_a) * sin(cos_b))
}

/// `Shape::promise` for a unit normal.
#[inline(always)]
fn promise_of<S: Simd>(shape: &[Floats<S>; 14], p: Vec3x16<S>, normal: Vec3x16<S>) -> Floats<S> {
    let simd = p.x.token();
    let constant = |x: f32| f32x16::splat(simd, x);
    let zero = constant(0.0);
    let vector = |k: usize| Vec3x16::new(shape[k], shape[k + 1], shape[k + 2]);
    let ways = [0, 3, 6].map(|k| vector(k) - p);
    let before = -vector(9).dot(ways[0]);
    let above = ways.map(|way| normal.dot(way).max(zero));
    let above = (above[0] + above[1] + above[2]) / 3.0;
    let centre = (ways[0] + ways[1] + ways[2]).over(constant(3.0));
    let nearest = ways.iter().fold(centre.length_squared(), |least, way| least.min(way.length_squared()));
    let distance2 = nearest.max(shape[12] * 0.25);
    let promise = (before / distance2) * (above / distance2) * shape[13];
    let promise =
        promise.is_finite().select(promise.max(constant(f32::MIN_POSITIVE)), constant(f32::MAX.sqrt()));
    (before.simd_gt(zero) & above.simd_gt(zero)).select(promise, zero)
}

impl LightSet {
    /// [`sample`](Self::sample) for the lanes in `active`; their normals are unit.
    #[inline(always)]
    #[must_use]
    pub fn sample_x16<S: Simd>(
        &self,
        active: Mask<S>,
        p: Vec3x16<S>,
        ns: Vec3x16<S>,
        u: [Floats<S>; 3],
    ) -> LightSampleX16<S> {
        let simd = u[0].token();
        match (&self.lanes, &self.choice) {
            // One group: its choice takes nothing of the number.
            (Some(lanes), Some(choice)) if choice.len() == 1 => {
                lanes.sample(&self.parts, active, [p, ns], u, f32x16::splat(simd, 1.0))
            }
            (Some(lanes), Some(choice)) => {
                let (mut rest, mut chance, mut near, mut far) = (u[0], u[0], 0, LightSampleX16::none(simd));
                each_lane(active.to_bitmask(), |i| {
                    let group = choice.sample(u[0][i]);
                    if group.index == 0 {
                        near |= 1 << i;
                        (rest[i], chance[i]) = (group.rest, group.probability);
                    } else {
                        let place = [u[1][i], u[2][i]];
                        let sample = self.sample_far(group.index - 1, ns.get(i), place, group.probability);
                        far.put(i, sample.filter(is_sound));
                    }
                });
                let near = Mask::from_bitmask(simd, near);
                lanes.sample(&self.parts, near, [p, ns], [rest, u[1], u[2]], chance).or(near, far)
            }
            _ => {
                let mut out = LightSampleX16::none(simd);
                each_lane(active.to_bitmask(), |i| {
                    out.put(i, self.sample(p.get(i), ns.get(i), u.map(|u| u[i])));
                });
                out
            }
        }
    }
}

/// Whether a sample can count.
pub(super) fn is_sound(sample: &LightSample) -> bool {
    sample.pdf > 0.0 && sample.pdf.is_finite() && sample.radiance.is_finite()
}

impl<S: Simd> LightSampleX16<S> {
    #[inline(always)]
    fn none(simd: S) -> Self {
        let (none, zero) = (mask_none(simd), Vec3x16::splat(simd, Vec3::ZERO));
        Self { dir: zero, dist: zero.x, radiance: zero, pdf: zero.x, delta: none, found: none }
    }

    #[inline(always)]
    fn put(&mut self, i: usize, sample: Option<LightSample>) {
        let Some(sample) = sample else { return };
        for (lanes, v) in [(&mut self.dir, sample.dir), (&mut self.radiance, sample.radiance)] {
            (lanes.x[i], lanes.y[i], lanes.z[i]) = v.into();
        }
        (self.dist[i], self.pdf[i]) = (sample.dist, sample.pdf);
        self.delta.set(i, sample.delta);
        self.found.set(i, true);
    }

    /// Its own lanes where `mask` says so, else the other's.
    #[inline(always)]
    fn or(self, mask: Mask<S>, other: Self) -> Self {
        Self {
            dir: select3(mask, self.dir, other.dir),
            dist: mask.select(self.dist, other.dist),
            radiance: select3(mask, self.radiance, other.radiance),
            pdf: mask.select(self.pdf, other.pdf),
            delta: mask.select(self.delta, other.delta),
            found: mask.select(self.found, other.found),
        }
    }
}

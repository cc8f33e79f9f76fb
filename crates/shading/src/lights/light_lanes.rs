// SPDX-License-Identifier: GPL-3.0-or-later
//! Choosing lights for sixteen points at once: the walks of `light_tree` side by side, the lights of a leaf side by side.
//! Source: as `light_tree`, `area` and `disc`; the layout is original. Space: world.
//! A node, and a light, is a row of sixteen floats: sixteen points at different ones read sixteen rows and
//! transpose them to columns, so that each costs a load and some shuffles. Two leaves with one parent are a
//! block of sixteen lights.
//! Invariant: the samples of [`LightSet::sample`](super::LightSet::sample), bit for bit.
//! Tests: `light_set_tests::lanes_choose_as_points_do`.

use glam::Vec3;
use gnurt_simd::{Simd, f32x16, prelude::*, u32x16};

use std::sync::Arc;

use super::area::EmitterPoint;
use super::beam::Beam;
use super::disc::{self, DiscAt, Seen};
use super::light_estimates::{Aim, GroupBounds};
use super::light_parts::{LightParts, LightSample};
use super::light_tree::{LEAF, LightTree, Node};
use super::shape::ShapeAt;
use crate::lanes::{Floats, LANES, LanesOf, Mask, UInts, Vec3x16, transpose};
use crate::real::{Real, Vector};
use crate::sampling::distribution::ALMOST_ONE;

/// Directions to lights from many points: see [`LightSample`].
#[derive(Clone, Copy)]
pub struct LightSamples<R: Real> {
    /// Unit, towards the light.
    pub dir: Vector<R>,
    /// Its distance; infinite for lights without a position.
    pub dist: R,
    /// Radiance against `dir`; irradiance for `delta` lights.
    pub radiance: Vector<R>,
    /// Density per solid angle, the choice included; the probability of the choice for `delta` lights.
    pub pdf: R,
    /// Points whose light no scattered ray could meet.
    pub delta: R::Mask,
    /// Points that found a light; the others hold anything.
    pub found: R::Mask,
}

/// The same of sixteen.
pub type LightSampleX16<S> = LightSamples<f32x16<S>>;

impl<R: Real> LightSamples<R> {
    /// No light for any point of `zero`.
    #[inline(always)]
    pub(super) fn none(zero: R) -> Self {
        let (none, black) = (zero.points(0), Vector::grey(zero));
        Self { dir: black, dist: zero, radiance: black, pdf: zero, delta: none, found: none }
    }
}

impl From<Option<LightSample>> for LightSamples<f32> {
    fn from(sample: Option<LightSample>) -> Self {
        sample.map_or(Self::none(0.0), |LightSample { dir, dist, radiance, pdf, delta, .. }| Self {
            dir: dir.into(),
            dist,
            radiance: radiance.into(),
            pdf,
            delta,
            found: true,
        })
    }
}

/// Sixteen floats that are read at once.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Row([f32; LANES]);

/// The lights of two leaves that have one parent, or of one leaf and nothing.
#[derive(Clone, Debug)]
struct Block {
    /// Thirteen numbers of a light as its row in [`LightLanes`] has them, and its power; zero where there is none.
    columns: [Row; 14],
    lights: [u32; LANES],
    /// Bits of those that are points, and of those that are shapes.
    points: u64,
    shapes: u64,
}

/// The last entry of a node's row: the kind of the next step.
const INNER: u32 = 0;
/// A leaf: the first half of a block.
const SINGLE: u32 = 1;
/// A parent of two leaves, a block.
const PAIR: u32 = 2;

/// A light tree in rows.
#[derive(Debug)]
pub(super) struct LightLanes {
    /// By node: centre, half of the diagonal, square of the radius, axis, cosines of normals and emission, power; then as
    /// words the second child, the kind and the block.
    nodes: Vec<Row>,
    blocks: Vec<Block>,
    /// By light: three corners of a shape, normal, extent, radiance; a point's numbers as [`DiscAt::row`] has them, and after
    /// thirteen its intensity.
    lights: Vec<Row>,
    /// Lights from this on are points.
    first_point: u32,
    /// By shape: whether its radiance depends on the position. Empty if none does.
    uneven: Vec<bool>,
    /// By shape: where its light goes. Empty if all go everywhere.
    beams: Vec<Option<Arc<Beam>>>,
}

/// Where a walk ends.
struct End<S: Simd> {
    block: UInts<S>,
    kind: UInts<S>,
    probability: Floats<S>,
    /// The remainder of the random number.
    rest: Floats<S>,
    /// Lanes that came there.
    alive: Mask<S>,
}

impl LightLanes {
    /// `None` where the tree is empty.
    pub(super) fn new(parts: &LightParts, tree: &LightTree) -> Option<Self> {
        if tree.is_empty() {
            return None;
        }
        let of_shapes = parts.shapes.as_ref();
        let even: Vec<_> =
            of_shapes.iter().flat_map(|all| (0..all.len()).map(|i| all.even_radiance(i))).collect();
        let is_uneven = even.iter().any(Option::is_none);
        let mut lanes = Self {
            nodes: Vec::new(),
            blocks: Vec::new(),
            lights: Vec::new(),
            first_point: parts.shape_count() as u32,
            uneven: if is_uneven { even.iter().map(Option::is_none).collect() } else { Vec::new() },
            beams: of_shapes.map_or(Vec::new(), |all| all.beams()),
        };
        for (shape, even) in of_shapes.iter().flat_map(|all| &all.shapes).zip(&even) {
            let mut row = [0.0; LANES];
            row[..13].copy_from_slice(&shape.row());
            row[13..].copy_from_slice(&even.unwrap_or_default().to_array());
            lanes.lights.push(Row(row));
        }
        for point in &parts.points {
            let mut row = [0.0; LANES];
            row[..disc::NUMBERS].copy_from_slice(&point.at().row());
            row[13..].copy_from_slice(&point.intensity.to_array());
            lanes.lights.push(Row(row));
        }
        let power = |light: u32| match of_shapes.and_then(|all| all.shapes.get(light as usize)) {
            Some(shape) => shape.power,
            None => parts.points[(light - lanes.first_point) as usize].power(),
        };
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
                lanes.blocks.push(Block::new(&leaves, tree, (&lanes.lights, lanes.first_point, &power)));
            }
            lanes.nodes.push(node_row(node, [node.index, kind, block]));
        }
        Some(lanes)
    }

    /// Samples for the lanes in `active`, whose normals are unit; without them for all sides.
    #[inline(always)]
    pub(super) fn sample<S: Simd>(
        &self,
        parts: &LightParts,
        active: Mask<S>,
        (p, normal): (Vec3x16<S>, Option<Vec3x16<S>>),
        [choice, x, y]: [Floats<S>; 3],
        lane_probability: Floats<S>,
    ) -> LightSampleX16<S> {
        let simd = choice.token();
        let end = self.walk(active, p, normal, choice);
        let (light, probability, found) = self.choose(&end, p, normal);
        let probability = lane_probability * probability;
        let light: [u32; LANES] = light.into();
        let row = columns(simd, &self.lights, &light);
        let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
        let points = found & u32x16::simd_from(simd, light).simd_ge(u32x16::splat(simd, self.first_point));
        let of_shapes = found & !points;
        let position = [zero; 2];
        let mut aim = Aim { position, dir: Vec3x16::grey(zero), dist: zero, density: one };
        if of_shapes.any_true() {
            // Chosen already, so that its power counts no more.
            aim = shape_at(&row, zero).aim(p, [x, y], of_shapes);
        }
        let mut radiance = Vec3x16::new(row[13], row[14], row[15]);
        if points.any_true() {
            let Seen { dir, dist, share, there } = DiscAt::of(&row).seen_from(p, [x, y]);
            let dist = there.select(dist, zero);
            aim = Aim { position, dir, dist, density: one }.or(points, aim);
            radiance = Vec3x16::pick(points, radiance * share, radiance);
        }
        let Aim { position: [b1, b2], dir, dist, density } = aim;
        if let (false, Some(lights)) = (self.uneven.is_empty(), &parts.shapes) {
            let (mut requests, mut of) = ([EmitterPoint::default(); LANES], [0; LANES]);
            let mut count = 0;
            for i in LanesOf(of_shapes.to_bitmask()).filter(|&i| self.uneven[light[i] as usize]) {
                let (shape, position, dir) = (light[i], [b1[i], b2[i]], dir.get(i));
                let request = EmitterPoint { shape, position, dir, distance: dist[i] };
                (requests[count], of[count]) = (request, i);
                count += 1;
            }
            let mut here = [Vec3::ZERO; LANES];
            lights.radiances(&requests[..count], &mut here);
            for (&i, here) in of[..count].iter().zip(here) {
                (radiance.x[i], radiance.y[i], radiance.z[i]) = here.into();
            }
        }
        let pdf = probability * density;
        let sound = dist.simd_gt(zero) & pdf.simd_gt(zero) & pdf.is_finite() & radiance.is_finite();
        LightSampleX16 { dir, dist, radiance, pdf, delta: points, found: found & sound }
    }

    /// From the root to a leaf or two; `choice` is in [0, 1).
    #[inline(always)]
    fn walk<S: Simd>(
        &self,
        active: Mask<S>,
        p: Vec3x16<S>,
        normal: Option<Vec3x16<S>>,
        choice: Floats<S>,
    ) -> End<S> {
        let simd = choice.token();
        let [.., second, kind, block] = self.nodes[0].0;
        let mut second = u32x16::splat(simd, second.to_bits());
        let mut kind = u32x16::splat(simd, kind.to_bits());
        let mut block = u32x16::splat(simd, block.to_bits());
        let nothing = u32x16::splat(simd, 0);
        let mut at = nothing;
        let mut end = End { block, kind, probability: f32x16::splat(simd, 1.0), rest: choice, alive: active };
        let inner = u32x16::splat(simd, INNER);
        let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
        loop {
            let walking = end.alive & kind.simd_eq(inner);
            if !walking.any_true() {
                (end.block, end.kind) = (block, kind);
                return end;
            }
            // Lanes without a traversal read the root.
            let children = [walking.select(at + 1, nothing), walking.select(second, nothing)];
            let one_row = columns(simd, &self.nodes, &children[0].into());
            let other_row = columns(simd, &self.nodes, &children[1].into());
            let first = group(&one_row).importance(p, normal);
            let other = group(&other_row).importance(p, normal);
            let sum = first + other;
            let lost = walking & !sum.simd_gt(zero);
            end.alive &= !lost;
            let share = first / sum;
            let (rest, to_first) = descend(end.rest, share);
            let lane_probability = to_first.select(share, one - share);
            end.rest = walking.select(rest, end.rest);
            end.probability = walking.select(end.probability * lane_probability, end.probability);
            at = walking.select(to_first.select(at + 1, second), at);
            second = walking.select(to_first.select(one_row[13], other_row[13]).bitcast(), second);
            kind = walking.select(to_first.select(one_row[14], other_row[14]).bitcast(), kind);
            block = walking.select(to_first.select(one_row[15], other_row[15]).bitcast(), block);
        }
    }

    /// Chooses among the lights of leaves: the light, its probability and the lanes that found one.
    #[inline(always)]
    fn choose<S: Simd>(
        &self,
        end: &End<S>,
        p: Vec3x16<S>,
        normal: Option<Vec3x16<S>>,
    ) -> (UInts<S>, Floats<S>, Mask<S>) {
        let simd = end.rest.token();
        let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
        let slots = self.contributions(end, p, normal);
        let (mut first, mut other) = (slots[0], slots[LEAF]);
        for k in 1..LEAF {
            (first, other) = (first + slots[k], other + slots[LEAF + k]);
        }
        // The last inner node, where there is one, as in `walk`.
        let pair = end.kind.simd_eq(u32x16::splat(simd, PAIR));
        let both = first + other;
        let share = first / both;
        let (rest, to_first) = descend(end.rest, share);
        let lane_probability = to_first.select(share, one - share);
        let rest = pair.select(rest, end.rest);
        let probability = pair.select(end.probability * lane_probability, end.probability);
        let in_other = pair & !to_first;
        let sum = in_other.select(other, first);
        // The leaf.
        let mut left = rest * sum;
        let mut chosen = u32x16::splat(simd, 0);
        let mut total_contribution = zero;
        let mut half = [zero; LEAF];
        let mut last = chosen;
        for (k, half) in half.iter_mut().enumerate() {
            let contribution = in_other.select(slots[k + LEAF], slots[k]);
            *half = contribution;
            let some = contribution.simd_gt(zero);
            last = some.select(u32x16::splat(simd, k as u32), last);
            total_contribution = some.select(contribution, total_contribution);
        }
        chosen = last;
        let mut open = sum.simd_gt(zero);
        for (k, &contribution) in half.iter().enumerate() {
            let slot_index = u32x16::splat(simd, k as u32);
            left -= contribution;
            let here = open & left.simd_lt(zero) & slot_index.simd_lt(last);
            chosen = here.select(slot_index, chosen);
            total_contribution = here.select(contribution, total_contribution);
            open &= !here;
        }
        let probability = probability * (total_contribution / sum);
        let found = end.alive & total_contribution.simd_gt(zero) & (!pair | both.simd_gt(zero));
        let slot_index = chosen + in_other.select(u32x16::splat(simd, LEAF as u32), u32x16::splat(simd, 0));
        let (slot_index, block): ([u32; LANES], [u32; LANES]) = (slot_index.into(), end.block.into());
        let mut light = [0; LANES];
        for i in LanesOf(found.to_bitmask()) {
            light[i] = self.blocks[block[i] as usize].lights[slot_index[i] as usize % LANES];
        }
        (u32x16::simd_from(simd, light), probability, found)
    }

    /// Contribution of each light of each lane's block.
    #[inline(always)]
    fn contributions<S: Simd>(
        &self,
        end: &End<S>,
        p: Vec3x16<S>,
        normal: Option<Vec3x16<S>>,
    ) -> [Floats<S>; LANES] {
        let simd = end.rest.token();
        let zero = f32x16::splat(simd, 0.0);
        let mut contributions = [zero; LANES];
        if let [block] = &self.blocks[..] {
            // All lights are here: lit places side by side.
            for (k, contribution) in contributions.iter_mut().enumerate() {
                if block.columns[13].0[k] > 0.0 {
                    let mut light = [zero; 14];
                    for (x, row) in light.iter_mut().zip(&block.columns) {
                        *x = f32x16::splat(simd, row.0[k]);
                    }
                    if block.points >> k & 1 != 0 {
                        *contribution = DiscAt::of(&light).contribution(light[13], p, normal);
                        continue;
                    }
                    let shape = shape_at(&light, light[13]);
                    *contribution = shape.contribution(p, normal);
                    if let Some(beam) = self.beam(block.lights[k]) {
                        *contribution *= beam.share(shape.cells(p));
                    }
                }
            }
            return contributions;
        }
        let block: [u32; LANES] = end.block.into();
        for i in LanesOf(end.alive.to_bitmask()) {
            let Block { columns, lights, points, shapes } = &self.blocks[block[i] as usize];
            let mut light = [zero; 14];
            for (x, row) in light.iter_mut().zip(columns) {
                *x = f32x16::from_slice(simd, &row.0);
            }
            let (p, normal) = (p.spread(i), normal.map(|normal| normal.spread(i)));
            if *shapes != 0 {
                let shape = shape_at(&light, light[13]);
                contributions[i] = shape.contribution(p, normal);
                if !self.beams.is_empty() {
                    let cells = shape.cells(p);
                    for (k, &light) in lights.iter().enumerate() {
                        let Some(beam) = self.beam(light) else { continue };
                        let [a, b, c, d] = [cells[0][k], cells[1][k], cells[2][k], cells[3][k]];
                        contributions[i][k] *= beam.share([a, b, c, d]);
                    }
                }
            }
            if *points != 0 {
                let of_points = DiscAt::of(&light).contribution(light[13], p, normal);
                contributions[i] = Mask::from_bitmask(simd, *points).select(of_points, contributions[i]);
            }
        }
        transpose(contributions)
    }

    #[inline(always)]
    fn beam(&self, light: u32) -> Option<&Beam> {
        self.beams.get(light as usize)?.as_deref()
    }
}

impl Block {
    fn new(
        leaves: &[&Node],
        tree: &LightTree,
        (rows, first_point, power): (&[Row], u32, &impl Fn(u32) -> f32),
    ) -> Self {
        let mut block = Self { columns: [Row([0.0; LANES]); 14], lights: [0; LANES], points: 0, shapes: 0 };
        for (half, leaf) in leaves.iter().enumerate() {
            let lights = &tree.order[leaf.index as usize..(leaf.index + leaf.lights) as usize];
            for (slot_index, &light) in (half * LEAF..).zip(lights) {
                let numbers = rows[light as usize].0[..13].iter().copied().chain([power(light)]);
                block.columns.iter_mut().zip(numbers).for_each(|(column, x)| column.0[slot_index] = x);
                block.lights[slot_index] = light;
                let bits = if light < first_point { &mut block.shapes } else { &mut block.points };
                *bits |= 1 << slot_index;
            }
        }
        block
    }
}

/// Vectors one after the other.
fn write3(row: &mut [f32], vectors: &[Vec3]) {
    row.chunks_exact_mut(3).zip(vectors).for_each(|(out, v)| out.copy_from_slice(&v.to_array()));
}

fn node_row(node: &Node, values: [u32; 3]) -> Row {
    let group = node.bounds.seen();
    let mut row = [0.0; LANES];
    write3(&mut row, &[group.centre.into(), group.half.into()]);
    row[6] = group.radius2;
    write3(&mut row[7..], &[group.axis.into()]);
    row[10..13].copy_from_slice(&[group.cos_normals, group.cos_emission, group.power]);
    row[13..].copy_from_slice(&values.map(f32::from_bits));
    Row(row)
}

/// Row `at[i]` as lane `i` of each column.
#[inline(always)]
fn columns<S: Simd>(simd: S, rows: &[Row], at: &[u32; LANES]) -> [Floats<S>; LANES] {
    let mut columns = [f32x16::splat(simd, 0.0); LANES];
    if *at == [at[0]; LANES] {
        let row = &rows[at[0] as usize].0;
        for (column, &x) in columns.iter_mut().zip(row) {
            *column = f32x16::splat(simd, x);
        }
        return columns;
    }
    for (column, &i) in columns.iter_mut().zip(at) {
        *column = f32x16::from_slice(simd, &rows[i as usize].0);
    }
    transpose(columns)
}

/// Three columns.
#[inline(always)]
fn vector<S: Simd>(columns: &[Floats<S>], k: usize) -> Vec3x16<S> {
    Vec3x16::new(columns[k], columns[k + 1], columns[k + 2])
}

/// The remainder of a random number after a choice with probability `share`, and whether the first
/// alternative was chosen.
#[inline(always)]
fn descend<S: Simd>(u: Floats<S>, share: Floats<S>) -> (Floats<S>, Mask<S>) {
    let simd = u.token();
    let to_first = u.simd_lt(share);
    let left = (u - share) / (f32x16::splat(simd, 1.0) - share);
    let rest = to_first.select(u / share, left).min(f32x16::splat(simd, ALMOST_ONE));
    (rest, to_first)
}

/// A node of these columns.
#[inline(always)]
fn group<S: Simd>(row: &[Floats<S>; LANES]) -> GroupBounds<f32x16<S>> {
    let (centre, half, radius2, axis) = (vector(row, 0), vector(row, 3), row[6], vector(row, 7));
    GroupBounds { centre, half, radius2, axis, cos_normals: row[10], cos_emission: row[11], power: row[12] }
}

/// A shape of these columns.
#[inline(always)]
fn shape_at<S: Simd>(row: &[Floats<S>], power: Floats<S>) -> ShapeAt<f32x16<S>> {
    let corners = [vector(row, 0), vector(row, 3), vector(row, 6)];
    ShapeAt { corners, normal: vector(row, 9), extent: row[12], power }
}

impl<S: Simd> LightSampleX16<S> {
    #[inline(always)]
    pub(super) fn put(&mut self, i: usize, sample: Option<LightSample>) {
        let Some(sample) = sample else { return };
        (self.dir.x[i], self.dir.y[i], self.dir.z[i]) = sample.dir.into();
        (self.radiance.x[i], self.radiance.y[i], self.radiance.z[i]) = sample.radiance.into();
        (self.dist[i], self.pdf[i]) = (sample.dist, sample.pdf);
        self.delta.set(i, sample.delta);
        self.found.set(i, true);
    }

    /// Its own lanes in `mask`, else the other's.
    #[inline(always)]
    pub(super) fn or(self, mask: Mask<S>, other: Self) -> Self {
        Self {
            dir: Vec3x16::pick(mask, self.dir, other.dir),
            dist: mask.select(self.dist, other.dist),
            radiance: Vec3x16::pick(mask, self.radiance, other.radiance),
            pdf: mask.select(self.pdf, other.pdf),
            delta: mask.select(self.delta, other.delta),
            found: mask.select(self.found, other.found),
        }
    }
}

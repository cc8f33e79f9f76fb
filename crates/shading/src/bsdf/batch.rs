// SPDX-License-Identifier: GPL-3.0-or-later
//! Closures of many points: the only output of a surface, and all that integrators read. Shaped by [SIP06],
//! section 8; shading languages, too, produce a list of weighted lobes for each point. Layout: blocks of
//! sixteen points; in a block each number of each list position is a row, aligned, so that sixteen points are
//! read at once. Points beyond the last one have no lobes.
//! Tests: `tests`.

use glam::Vec3;
use gnurt_simd::{Simd, f32x16, prelude::*};

use super::film::Film;
use super::lobe::{Kind, Lobe, POLISHED};
use super::lobes::{Lobes, MOST};
use super::lobes_at::{LobesAt, Rarities};
use super::medium::Medium;
use super::prepared::Prepared;
use super::{Bsdf, Scattering};
use crate::batch::SurfaceBatch;
use crate::lanes::{LANES, Vec3x16};
use crate::real::Vector;

/// A number of sixteen points.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub(super) struct Row<T>(pub(super) [T; LANES]);

/// One position of sixteen points' lists: see [`Lobe`].
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LobeRows {
    /// [`Kind`] as a number.
    pub(super) kind: Row<f32>,
    /// Weight, normal, a, b, c; alpha, eta, cover.
    pub(super) numbers: [Row<f32>; 20],
    pub(super) layers_above: Row<u32>,
    /// Tangent, width across it; share, index and thickness of the film; spread of indices: meant where
    /// `rare` is not 0.
    rarities: [Row<f32>; 8],
    pub(super) rare: u32,
    /// Kinds that are there, and bits of all lobes that lie above some.
    pub(super) kinds: u32,
    pub(super) any_layer_above: u32,
    pub(super) covers: bool,
    /// Whether some is below the surface.
    pub(super) any_subsurface: bool,
}

/// Sixteen points.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Block {
    pub(super) normal: [Row<f32>; 3],
    emission: [Row<f32>; 3],
    coverage: Row<f32>,
    /// Positions in use.
    pub(super) count: u32,
    pub(super) lobes: [LobeRows; MOST],
}

/// Closures of many points.
#[derive(Clone, Debug, Default)]
pub struct ClosureBatch {
    len: usize,
    pub(super) blocks: Vec<Block>,
    emits: bool,
    is_partly_transparent: bool,
    /// The media beside the points; empty if there are none.
    media: Vec<Medium>,
    /// The points' shares of a hole; empty if there is none.
    held_out: Vec<f32>,
    /// The factors of light that passes the points; empty if none has another than 1.
    passing: Vec<Vec3>,
}

/// Those of [`LobeRows`].
#[inline(always)]
pub(super) fn numbers(lobe: &Lobe) -> [f32; 20] {
    let Lobe { weight: w, normal: n, a, b, c, alpha, eta, cover: v, .. } = lobe;
    [w.x, w.y, w.z, n.x, n.y, n.z, a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z, *alpha, *eta, v.x, v.y, v.z]
}

impl LobeRows {
    pub(super) fn clear(&mut self) {
        (self.kind, self.layers_above) = (Row::default(), Row::default());
        (self.kinds, self.any_layer_above, self.covers, self.rare) = (0, 0, false, 0);
        self.any_subsurface = false;
    }

    /// The first `count` points' are like this one, which has nothing rare and lies below none; there are no
    /// others.
    #[inline]
    fn fill(&mut self, count: usize, lobe: &Lobe) {
        self.clear();
        self.kind.0[..count].fill(lobe.kind as u32 as f32);
        self.numbers.iter_mut().zip(numbers(lobe)).for_each(|(row, x)| row.0 = [x; LANES]);
        (self.kinds, self.covers) = (lobe.kind.bit(), lobe.covers());
    }

    #[inline]
    pub(super) fn set(&mut self, i: usize, lobe: &Lobe) {
        self.kind.0[i] = lobe.kind as u32 as f32;
        self.numbers.iter_mut().zip(numbers(lobe)).for_each(|(row, x)| row.0[i] = x);
        self.layers_above.0[i] = lobe.layers_above;
        self.kinds |= lobe.kind.bit();
        self.any_layer_above |= lobe.layers_above;
        self.covers |= lobe.covers();
        self.any_subsurface |= lobe.is_subsurface();
        let rare = lobe.rare();
        if rare != 0 {
            if self.rare == 0 {
                self.rarities = Default::default();
            }
            self.rare |= rare;
            let Lobe { tangent, across, film: Film { share, ior, thickness }, spread, .. } = *lobe;
            let numbers = [tangent.x, tangent.y, tangent.z, across, share, ior, thickness, spread];
            self.rarities.iter_mut().zip(numbers).for_each(|(row, x)| row.0[i] = x);
        }
    }

    pub(super) fn get(&self, i: usize) -> Lobe {
        let v =
            |k: usize| Vec3::new(self.numbers[k].0[i], self.numbers[k + 1].0[i], self.numbers[k + 2].0[i]);
        let rarities = if self.rare == 0 { [0.0; 8] } else { self.rarities.each_ref().map(|row| row.0[i]) };
        let [x, y, z, across, share, ior, thickness, spread] = rarities;
        let kind = Kind::ALL.into_iter().find(|&kind| kind as u32 as f32 == self.kind.0[i]);
        Lobe {
            kind: kind.unwrap_or_default(),
            weight: v(0),
            normal: v(3),
            a: v(6),
            b: v(9),
            c: v(12),
            alpha: self.numbers[15].0[i],
            eta: self.numbers[16].0[i],
            cover: v(17),
            layers_above: self.layers_above.0[i],
            tangent: Vec3::new(x, y, z),
            across,
            film: Film { share, ior, thickness },
            spread,
        }
    }

    #[inline(always)]
    fn row<S: Simd>(&self, simd: S, k: usize) -> f32x16<S> {
        f32x16::from_slice(simd, &self.numbers[k].0)
    }

    #[inline(always)]
    fn vector<S: Simd>(&self, simd: S, k: usize) -> Vec3x16<S> {
        Vec3x16::new(self.row(simd, k), self.row(simd, k + 1), self.row(simd, k + 2))
    }

    #[inline(always)]
    fn lanes<S: Simd>(&self, simd: S) -> LobesAt<'_, f32x16<S>> {
        LobesAt {
            kind: f32x16::from_slice(simd, &self.kind.0),
            kinds: self.kinds,
            weight: self.vector(simd, 0),
            normal: self.vector(simd, 3),
            a: self.vector(simd, 6),
            b: self.vector(simd, 9),
            c: self.vector(simd, 12),
            alpha: self.row(simd, 15),
            eta: self.row(simd, 16),
            cover: self.vector(simd, 17),
            layers_above: &self.layers_above.0,
            any_layer_above: self.any_layer_above,
            covers: self.covers,
            rare: self.rare,
            rarities: self.rare_lanes(simd),
        }
    }

    #[inline(always)]
    fn rare_lanes<S: Simd>(&self, simd: S) -> Rarities<f32x16<S>> {
        let none = Rarities::all(f32x16::splat(simd, 0.0));
        if self.rare == 0 {
            return none;
        }
        let row = |k: usize| f32x16::from_slice(simd, &self.rarities[k].0);
        Rarities {
            tangent: Vec3x16::new(row(0), row(1), row(2)),
            across: row(3),
            film: [row(4), row(5), row(6)],
            spread: row(7),
            ..none
        }
    }
}

impl ClosureBatch {
    /// Makes it `n` points that are there, scatter nothing and give off nothing, and keeps the memory.
    pub fn reset(&mut self, n: usize) {
        self.len = n;
        (self.emits, self.is_partly_transparent) = (false, false);
        self.media.clear();
        self.held_out.clear();
        self.passing.clear();
        let blocks = n.div_ceil(LANES);
        if self.blocks.len() < blocks {
            self.blocks.resize(blocks, Block::default());
        }
        for block in &mut self.blocks[..blocks] {
            block.count = 0;
            (block.emission, block.coverage) = (Default::default(), Row([1.0; LANES]));
            block.normal = [Row([0.0; LANES]), Row([0.0; LANES]), Row([1.0; LANES])];
        }
    }

    /// Number of points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Sets the scattering of point `i`: these lobes around the unit shading normal `ns`, which is on the
    /// side of the first ray. Once for each point.
    #[inline]
    pub fn set(&mut self, i: usize, ns: Vec3, lobes: &[Lobe]) {
        let (block, i) = (&mut self.blocks[i / LANES], i % LANES);
        for (row, x) in block.normal.iter_mut().zip(ns.to_array()) {
            row.0[i] = x;
        }
        for (k, lobe) in lobes.iter().take(MOST).enumerate() {
            if k as u32 == block.count {
                block.count += 1;
                block.lobes[k].clear();
            }
            block.lobes[k].set(i, lobe);
        }
    }

    /// Makes all points Lambertian with these albedos around the shading normals on the sides of the rays, as
    /// [`set`](Self::set) does for each.
    pub fn set_lambertian(&mut self, hits: &SurfaceBatch, albedo: impl Fn(usize) -> Vec3) {
        let black = Lobe::lambert(Vec3::ZERO);
        for (block, first) in self.blocks.iter_mut().zip((0..self.len).step_by(LANES)) {
            let count = LANES.min(self.len - first);
            for (row, from) in block.normal.iter_mut().zip(hits.facing_rows(first).ns) {
                row.0[..count].copy_from_slice(&from[..count]);
            }
            block.count = 1;
            let lobe = &mut block.lobes[0];
            lobe.fill(count, &black);
            let [_, _, _, _, _, _, r, g, b, ..] = &mut lobe.numbers;
            for i in 0..count {
                (r.0[i], g.0[i], b.0[i]) = albedo(first + i).into();
            }
        }
    }

    /// Radiance that point `i` sends against its ray, whatever share of light it stops.
    #[must_use]
    pub fn emission(&self, i: usize) -> Vec3 {
        let [x, y, z] = &self.blocks[i / LANES].emission;
        Vec3::new(x.0[i % LANES], y.0[i % LANES], z.0[i % LANES])
    }

    /// Whether some point may give off light.
    #[must_use]
    pub fn emits(&self) -> bool {
        self.emits
    }

    /// Whether some point may have transparency.
    #[must_use]
    pub fn is_partly_transparent(&self) -> bool {
        self.is_partly_transparent
    }

    /// Adds to it.
    pub fn emit(&mut self, i: usize, radiance: Vec3) {
        self.emits = true;
        for (row, x) in self.blocks[i / LANES].emission.iter_mut().zip(radiance.to_array()) {
            row.0[i % LANES] += x;
        }
    }

    /// Share of paths that point `i` stops, in [0, 1]; the rest goes straight on as if nothing were there, with its light times
    /// [`passing`](Self::passing).
    #[must_use]
    pub fn coverage(&self, i: usize) -> f32 {
        self.blocks[i / LANES].coverage.0[i % LANES]
    }

    /// Makes point `i` stop no more than this share of the light that it would have stopped.
    pub fn cover(&mut self, i: usize, share: f32) {
        self.is_partly_transparent |= share < 1.0;
        self.blocks[i / LANES].coverage.0[i % LANES] *= share;
    }

    /// Multiplies light that passes point `i`. Its lobes and its emission stay as they are.
    pub fn tint(&mut self, i: usize, factor: Vec3) {
        self.is_partly_transparent = true;
        self.passing.resize(self.len, Vec3::ONE);
        self.passing[i] *= factor;
    }

    /// The factor of light that passes point `i`: 1 unless the transparent part has a colour, or stops paths less often than light.
    #[must_use]
    pub fn passing(&self, i: usize) -> Vec3 {
        self.passing.get(i).copied().unwrap_or(Vec3::ONE)
    }

    /// The share of light that point `i` stops, in [0, 1]: the mean of the channels.
    #[must_use]
    pub fn stopped(&self, i: usize) -> f32 {
        let coverage = self.coverage(i);
        let Some(passing) = self.passing.get(i) else { return coverage.clamp(0.0, 1.0) };
        (1.0 - (1.0 - coverage) * passing.element_sum() / 3.0).clamp(0.0, 1.0)
    }

    /// The same for a surface that is there in this share only: it emits no more than that either.
    pub fn fade(&mut self, i: usize, share: f32) {
        if share < 1.0 {
            self.cover(i, share);
            for row in &mut self.blocks[i / LANES].emission {
                row.0[i % LANES] *= share;
            }
        }
    }

    /// Makes this share, in [0, 1], of what point `i` stops a hole in the picture: camera rays count it as not covered.
    pub fn hold_out(&mut self, i: usize, share: f32) {
        self.held_out.resize(self.len, 0.0);
        self.held_out[i] = share.clamp(0.0, 1.0);
    }

    /// Whether some point may be a hole.
    #[must_use]
    pub fn has_holes(&self) -> bool {
        !self.held_out.is_empty()
    }

    /// The share of point `i` that is a hole.
    #[must_use]
    pub fn held_out(&self, i: usize) -> f32 {
        self.held_out.get(i).copied().unwrap_or(0.0)
    }

    /// Sets the media beside point `i`.
    pub fn fill(&mut self, i: usize, medium: Medium) {
        self.media.resize(self.len, Medium::default());
        self.media[i] = medium;
    }

    /// Whether some point may have a medium.
    #[must_use]
    pub fn has_media(&self) -> bool {
        !self.media.is_empty()
    }

    /// The media beside point `i`.
    #[inline]
    #[must_use]
    pub fn medium(&self, i: usize) -> Medium {
        self.media.get(i).copied().unwrap_or_default()
    }

    /// Point `i` as a single value.
    #[must_use]
    pub fn point(&self, i: usize) -> Scattering {
        let (block, lane) = (&self.blocks[i / LANES], i % LANES);
        let [x, y, z] = &block.normal;
        let mut lobes = Lobes::default();
        block.lobes[..block.count as usize].iter().for_each(|rows| lobes.push(rows.get(lane)));
        let bsdf = Bsdf::new(Vec3::new(x.0[lane], y.0[lane], z.0[lane]), lobes).neighbours(self.medium(i));
        Scattering { bsdf, emission: self.emission(i), coverage: self.coverage(i), passing: self.passing(i) }
    }

    /// Kinds of the lobes of point `i` that scatter any light, and the widths of their microfacets' slopes.
    pub fn widths(&self, i: usize) -> impl Iterator<Item = (Kind, f32)> {
        let (block, lane) = (&self.blocks[i / LANES], i % LANES);
        block.lobes[..block.count as usize].iter().filter_map(move |rows| {
            let weighs = (0..3).any(|k| rows.numbers[k].0[lane] != 0.0);
            let kind = Kind::ALL.get(rows.kind.0[lane] as usize).copied().unwrap_or_default();
            (weighs && kind != Kind::None).then_some((kind, rows.numbers[15].0[lane]))
        })
    }

    /// Whether microfacets of a mirror are all that point `i` scatters light by.
    #[must_use]
    pub fn is_polished(&self, i: usize) -> bool {
        let mut lobes = self.widths(i);
        let (Some((_, alpha)), None) = (lobes.next(), lobes.next()) else { return false };
        let is_polished = |lobe: &Lobe| lobe.is_black() || lobe.is_polished();
        alpha <= POLISHED && self.point(i).bsdf.lobes().as_slice().iter().all(is_polished)
    }

    /// Whether glass of point `i` bends colours into different directions.
    #[must_use]
    pub fn is_dispersed(&self, i: usize) -> bool {
        let (block, lane) = (&self.blocks[i / LANES], i % LANES);
        let lobes = &block.lobes[..block.count as usize];
        lobes.iter().any(|rows| rows.rare != 0 && rows.get(lane).is_dispersed())
    }

    /// Kinds that the sixteen points from `first` on have, as bits by [`Kind`].
    #[must_use]
    pub fn kinds(&self, first: usize) -> u32 {
        let block = &self.blocks[first / LANES];
        block.lobes[..block.count as usize].iter().fold(0, |kinds, rows| kinds | rows.kinds)
    }

    /// Normals of the sixteen points from `first` on, a multiple of sixteen.
    #[inline(always)]
    pub fn normals<S: Simd>(&self, simd: S, first: usize) -> Vec3x16<S> {
        let [x, y, z] = &self.blocks[first / LANES].normal;
        Vector::load(f32x16::splat(simd, 0.0), [&x.0, &y.0, &z.0], 0)
    }

    /// Prepares the sixteen points from `first` on, a multiple of sixteen, for the unit directions `wo`;
    /// `light` is the weight of the scattered light by colour (ones if unknown): see [`Bsdf::prepared_for`].
    /// `prepared` must be [`Prepared::none`].
    #[inline(always)]
    pub fn prepare<S: Simd>(
        &self,
        simd: S,
        first: usize,
        (wo, light): (Vec3x16<S>, Vec3x16<S>),
        prepared: &mut Prepared<f32x16<S>>,
    ) {
        let block = &self.blocks[first / LANES];
        prepared.prepare(
            block.count as usize,
            #[inline(always)]
            |k| block.lobes[k].lanes(simd),
            self.normals(simd, first),
            wo,
            light,
        );
    }
}

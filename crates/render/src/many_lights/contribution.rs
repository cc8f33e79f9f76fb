// SPDX-License-Identifier: GPL-3.0-or-later
//! Unoccluded contributions of virtual lights to points, by lanes, and a choice of lights in proportion.
//! Source: resampling [TCE05], of all virtual lights. Space: world.
//! Invariant: a light is chosen in proportion to the difference of two stored sums and weighted by one over that, so rounding
//! does not change the mean. Tests: `tests`, crates/render/tests/many_lights.rs.

use glam::Vec3;
use gnurt_image::srgb::luminance;
use gnurt_simd::{Level, dispatch};

use super::bound::Bound;
use super::eye::EyePoint;
use super::lanes::{BLOCK, Block, Color, Lanes, Light, Source};
use super::vpl::Vpl;

/// Unoccluded contributions of virtual lights to a block of points.
pub(super) struct Contributions<'a> {
    sources: &'a [Source],
    bound: Bound,
    max_edges: u32,
    /// Prefix sums over the lights, and the unoccluded contribution of each.
    sums: Vec<Lanes>,
    brought: Vec<Color>,
    light: Box<Light>,
}

impl<'a> Contributions<'a> {
    /// `sources` are made for this bound.
    pub(super) fn new(sources: &'a [Source], bound: Bound, max_edges: u32) -> Self {
        let (sums, brought) = (Vec::with_capacity(sources.len()), Vec::with_capacity(sources.len()));
        Self { sources, bound, max_edges, sums, brought, light: Box::default() }
    }

    /// Computes the contributions of all lights to these points, `BLOCK` at most.
    pub(super) fn query(&mut self, level: Level, points: &[&EyePoint]) {
        let Self { sources, bound, max_edges, sums, brought, light } = self;
        let block = Block::new(points, *max_edges);
        let mut sum = [0.0; BLOCK];
        sums.clear();
        brought.clear();
        each_contribution(
            level,
            (&block, points),
            sources,
            (&*bound, *max_edges),
            light,
            |_, contribution, color| {
                (0..BLOCK).for_each(|i| sum[i] += contribution[i]);
                sums.push(sum);
                brought.push(*color);
            },
        );
    }

    /// Chooses `count` lights for a point, evenly along the sum of their contributions; calls `with` for each
    /// with its unoccluded contribution times its weight.
    pub(super) fn choose(&self, lane: usize, count: u32, u: f32, mut with: impl FnMut(&Vpl, Vec3)) {
        let total = self.sums.last().map_or(0.0, |sum| sum[lane]);
        if !(total > 0.0 && total < f32::INFINITY) {
            return;
        }
        let position = |n: u32| {
            let at = total * ((n as f32 + u) / count as f32);
            self.sums.partition_point(|sum| sum[lane] <= at)
        };
        let mut n = 0;
        while n < count {
            let (i, first) = (position(n), n);
            while n < count && position(n) == i {
                n += 1;
            }
            if let Some(source) = self.sources.get(i) {
                let before = if i > 0 { self.sums[i - 1][lane] } else { 0.0 };
                let times = (n - first) as f32 * total / (count as f32 * (self.sums[i][lane] - before));
                with(&source.vpl, self.brought[i].get(lane) * times);
            }
        }
    }
}

/// Calls `with(position in the list, contribution to each point, the same in colour)` for each light: the
/// unoccluded contribution to the points of a block, as luminance and as colour. Colours of points without a
/// contribution are undefined.
pub(super) fn each_contribution(
    level: Level,
    (block, points): (&Block, &[&EyePoint]),
    sources: &[Source],
    (bound, max_edges): (&Bound, u32),
    light: &mut Light,
    mut with: impl FnMut(usize, &Lanes, &Color),
) {
    for (n, source) in sources.iter().enumerate() {
        let mut contribution = [0.0; BLOCK];
        let known = if block.may_get(source) { block.light(level, source, light) } else { Some(0) };
        if known.is_some_and(|lit| lit > 0) {
            dispatch!(level, _simd => luminances(light, &mut contribution));
        }
        let mut one_by_one = |i: usize| {
            let brought = source.vpl.brings(points[i], bound, max_edges).unwrap_or(Vec3::ZERO);
            contribution[i] = finite(luminance(brought.into()));
            light.color.set(i, brought);
        };
        match known {
            Some(_) => block.other.iter().copied().for_each(one_by_one),
            None => (0..points.len()).for_each(&mut one_by_one),
        }
        with(n, &contribution, &light.color);
    }
}

#[inline(always)]
fn finite(contribution: f32) -> f32 {
    if contribution < f32::INFINITY { contribution } else { 0.0 }
}

/// Luminances of a light's contribution, lane by lane.
#[inline(always)]
fn luminances(light: &Light, out: &mut Lanes) {
    let [r, g, b] = &light.color.0;
    for i in 0..BLOCK {
        out[i] = finite(0.2126 * r[i] + 0.7152 * g[i] + 0.0722 * b[i]);
    }
}

#[cfg(test)]
mod tests {
    use gnurt_shading::SurfacePoint;
    use gnurt_shading::bsdf::Bsdf;

    use super::super::test_points;
    use super::*;

    fn surface(n: u32) -> (SurfacePoint, Bsdf) {
        test_points::surface(7, n)
    }

    #[test]
    fn few_stand_for_all() {
        let bound = Bound::on_geometry_term(3.0);
        let light = |n: u32| {
            let (point, bsdf) = surface(n);
            Source::new(&Vpl::new(point, bsdf, point.ng, Vec3::new(3.0, 2.0, 1.0), 1), &bound)
        };
        let sources: Vec<Source> = (1000..1100).map(light).collect();
        let eye = |n: u32| {
            let (point, bsdf) = surface(n);
            EyePoint { point, wo: point.ng, bsdf, throughput: Vec3::ONE, edges: 1, lane: n }
        };
        let eyes: Vec<EyePoint> = (0..5).map(eye).collect();
        let mut contributions = Contributions::new(&sources, bound, 6);
        contributions.query(Level::default(), &eyes.iter().collect::<Vec<_>>());
        for (lane, eye) in eyes.iter().enumerate() {
            let brings = |vpl: &Vpl| vpl.brings(eye, &bound, 6).unwrap_or(Vec3::ZERO);
            let requested: Vec3 = sources.iter().map(|source| brings(&source.vpl)).sum();
            let (mut mean, mut chosen) = (Vec3::ZERO, 0);
            const TIMES: u32 = 200;
            for n in 0..TIMES {
                contributions.choose(lane, 4, (n as f32 + 0.5) / TIMES as f32, |_, brought| {
                    mean += brought / TIMES as f32;
                    chosen += 1;
                });
            }
            assert!(requested == Vec3::ZERO || (1..=4 * TIMES).contains(&chosen), "few are chosen: {chosen}");
            let off = (mean - requested).length();
            assert!(off <= 0.03 * requested.length(), "point {lane}: {mean} instead of {requested}");
        }
    }
}

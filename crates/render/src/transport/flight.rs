// SPDX-License-Identifier: GPL-3.0-or-later
//! Light through media along one ray: where it is scattered, and how much passes.
//! Source: [WMHL65] (null collisions), [SKTM11] (local majorants), [NSJ14] (ratio tracking), [KHLN17]
//! (spectral tracking); colours by one-sample MIS over the channels [WND*14].
//! A distance is drawn for one channel, chosen by the path's throughput, and weighted by the mean density of all
//! channels: weights stay bounded whatever the coefficients. Where density is even every collision is
//! real, and distances are exact. Space: world. Tests: `tests`, crates/render/tests/media.rs.

use glam::Vec3;
use gnurt_shading::SampleKey;
use gnurt_shading::sampling::{Draws, hash_combine, purpose};

use crate::world::{GridRay, Inside, Media, MediumEntry};

/// Numbers of a walk that are stratified: those of its first four events.
const STRATIFIED: u32 = 16;

/// Random numbers of one flight, or walk: the first are stratified over the samples of a pixel. Nothing is hashed before it is needed:
/// light that passes even media needs no number.
pub(crate) struct Random {
    source: Source,
    /// The purpose of the first pair, and how many numbers there are.
    purpose: u32,
    stratified: u32,
    count: u32,
    pair: [f32; 2],
    /// The beginning of the others.
    state: Option<u32>,
}

/// Where numbers come from.
#[derive(Clone, Copy)]
enum Source {
    /// Seed, sample and edges, not hashed; a layer and a role of them.
    Key(u64, SampleKey, u32, [u32; 2]),
    /// The same, hashed.
    Draws(Draws, [u32; 2]),
}

impl Source {
    fn hashed(self) -> (Draws, [u32; 2]) {
        match self {
            Self::Key(seed, key, edges, more) => (Draws::new(seed, key, edges), more),
            Self::Draws(draws, more) => (draws, more),
        }
    }
}

impl Random {
    fn new(source: Source, purpose: u32, stratified: u32) -> Self {
        Self { source, purpose, stratified, count: 0, pair: [0.0; 2], state: None }
    }

    fn hashed(seed: u64, key: SampleKey, edges: u32, role: u32) -> Source {
        Source::Draws(Draws::new(seed, key, edges), [0, role])
    }

    /// Those of the flight along an edge.
    pub(crate) fn of_edge(seed: u64, key: SampleKey, edges: u32) -> Self {
        Self::new(Self::hashed(seed, key, edges, 1), purpose::FLIGHT, 2)
    }

    /// Those of one stretch of a shadow ray.
    pub(crate) fn of_shadow(seed: u64, key: SampleKey, [edges, layer]: [u32; 2]) -> Self {
        Self::new(Source::Key(seed, key, edges, [layer, 2]), 0, 0)
    }

    /// Those of a further purpose along the same edge.
    pub(super) fn beside(&self, more: u32) -> Self {
        let (draws, [layer, role]) = self.source.hashed();
        Self::new(Source::Draws(draws, [hash_combine(layer, more), role]), 0, 0)
    }

    /// A pair of this purpose along the same edge, stratified over the samples of a pixel.
    pub(super) fn pair_of(&self, purpose: u32) -> [f32; 2] {
        self.source.hashed().0.pair(purpose)
    }

    /// Those of a walk below the surface at the end of an edge.
    pub(super) fn of_walk(seed: u64, key: SampleKey, edges: u32) -> Self {
        Self::new(Self::hashed(seed, key, edges, 3), purpose::WALK, STRATIFIED)
    }

    /// Those of the search for a lamp behind smooth surfaces, from the end of an edge.
    pub(super) fn of_caustic(seed: u64, key: SampleKey, edges: u32) -> Self {
        Self::new(Source::Key(seed, key, edges, [0, 5]), 0, 0)
    }

    pub(super) fn next(&mut self) -> f32 {
        let count = self.count;
        self.count += 1;
        if count < self.stratified {
            if count.is_multiple_of(2) {
                self.pair = self.pair_of(self.purpose + count / 2);
            }
            return self.pair[count as usize % 2];
        }
        let source = self.source;
        let state = *self.state.get_or_insert_with(|| {
            let (draws, more) = source.hashed();
            draws.hash(more)
        });
        (hash_combine(state, count) >> 8) as f32 * (1.0 / 16_777_216.0)
    }
}

/// A medium along a ray.
struct Part<'w> {
    number: u16,
    medium: &'w MediumEntry,
    grid: Option<GridRay>,
    /// The parameters between which it is there.
    span: [f32; 2],
}

/// All media along a ray.
#[derive(Default)]
pub(crate) struct Parts<'w>(Vec<Part<'w>>);

/// A light path's flight along a ray.
pub(crate) struct Flight {
    /// Weight of what follows.
    pub(crate) throughput: Vec3,
    /// Light of the media, at the beginning of the path.
    pub(crate) emitted: Vec3,
    /// Where it is scattered, and the medium that scatters it; `None` = at the end of the ray.
    pub(crate) scattered: Option<(f32, u16)>,
}

impl Media {
    /// Collects the media along a ray that begins in some bodies.
    pub(crate) fn parts<'w>(&'w self, inside: Inside, org: Vec3, dir: Vec3, parts: &mut Parts<'w>) {
        parts.0.clear();
        for number in self.at(inside) {
            let medium = self.get(number);
            let grid = match &medium.grid {
                Some(grid) => match grid.ray(org, dir) {
                    Some(ray) => Some(ray),
                    None => continue,
                },
                None => None,
            };
            let Some(span) = medium.ball.map_or(Some([0.0, f32::INFINITY]), |ball| within(ball, org, dir))
            else {
                continue;
            };
            parts.0.push(Part { number, medium, grid, span });
        }
    }
}

/// The parameters between which a ray is in a ball.
fn within((centre, radius): (Vec3, f32), org: Vec3, dir: Vec3) -> Option<[f32; 2]> {
    let offset = centre - org;
    let middle = offset.dot(dir);
    let half2 = radius * radius - (offset - dir * middle).length_squared();
    let half = half2.max(0.0).sqrt();
    (half2 > 0.0 && middle + half > 0.0).then(|| [(middle - half).max(0.0), middle + half])
}

/// Exponential of minus an optical thickness.
fn left(coefficient: Vec3, distance: f32) -> Vec3 {
    let one = |c: f32| if c > 0.0 { (-c * distance).exp() } else { 1.0 };
    Vec3::new(one(coefficient.x), one(coefficient.y), one(coefficient.z))
}

/// A channel by a number in [0, 1), in proportion to the light of the channels.
pub(super) fn channel_by(light: Vec3, u: f32) -> usize {
    let mut rest = u * light.element_sum();
    let mut channel = 0;
    while channel < 2 && rest >= light[channel] {
        rest -= light[channel];
        channel += 1;
    }
    channel
}

/// Exponentially distributed, mean 1.
fn distance(u: f32) -> f32 {
    -(1.0 - u).max(f32::MIN_POSITIVE).ln()
}

impl Part<'_> {
    /// A bound of the density from `t` on, and up to where it holds.
    fn bound(&self, t: f32) -> (f32, f32) {
        let [begin, end] = self.span;
        if t < begin {
            return (0.0, begin);
        }
        if t >= end {
            return (0.0, f32::INFINITY);
        }
        match (&self.grid, &self.medium.grid) {
            (Some(ray), Some(grid)) => {
                let (bound, upto) = grid.bound(ray, t);
                (bound, upto.min(end))
            }
            _ => (1.0, end),
        }
    }

    /// Density and factor of emission at `t`, within the bound.
    fn at(&self, t: f32) -> (f32, Vec3) {
        match (&self.grid, &self.medium.grid) {
            (Some(ray), Some(grid)) => grid.at(ray, t),
            _ => (1.0, Vec3::ONE),
        }
    }
}

impl Parts<'_> {
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// A bound of the extinction from `t` on, up to where it holds, and whether it is exact.
    fn stretch(&self, t: f32) -> (Vec3, f32, bool) {
        let (mut most, mut end, mut is_even) = (Vec3::ZERO, f32::INFINITY, true);
        for part in &self.0 {
            let (bound, upto) = part.bound(t);
            most += part.medium.extinction * bound;
            end = end.min(upto);
            is_even &= part.grid.is_none() || bound == 0.0;
        }
        (most, end, is_even)
    }

    /// Transmittance over a distance from the origin: exact where density is even, else its expectation.
    pub(crate) fn transmittance(&self, length: f32, random: &mut Random) -> Vec3 {
        let (mut all, mut t) = (Vec3::ONE, 0.0);
        while t < length && all != Vec3::ZERO {
            let (most, end, is_even) = self.stretch(t);
            let end = end.min(length);
            let densest = most.max_element();
            if is_even || densest == 0.0 {
                all *= left(most, end - t);
                t = end;
                continue;
            }
            t += distance(random.next()) / densest;
            if t >= end {
                t = end;
                continue;
            }
            let extinction = |part: &Part| {
                let there = part.bound(t).0 > 0.0;
                if there { part.medium.extinction * part.at(t).0 } else { Vec3::ZERO }
            };
            let here: Vec3 = self.0.iter().map(extinction).sum();
            all *= (Vec3::ONE - here / densest).max(Vec3::ZERO);
            if all.max_element() < 0.1 {
                // Little is left: a few rays carry it.
                if random.next() >= 0.25 {
                    return Vec3::ZERO;
                }
                all *= 4.0;
            }
        }
        all
    }

    /// Scattering coefficients, and light of each unit of length, where density is even.
    fn even(&self, t: f32) -> (Vec3, Vec3) {
        let there = self.0.iter().filter(|part| part.bound(t).0 > 0.0).map(|part| part.medium);
        there.fold((Vec3::ZERO, Vec3::ZERO), |(scattering, radiance), medium| {
            (scattering + medium.scattering, radiance + medium.absorption * medium.emission)
        })
    }

    /// The medium that scatters light of this weight at `t`.
    fn scatterer(&self, t: f32, weight: Vec3, random: &mut Random) -> u16 {
        if let [part] = &self.0[..] {
            return part.number;
        }
        let share = |part: &Part| {
            let there = part.bound(t).0 > 0.0;
            if there { (part.medium.scattering * part.at(t).0).dot(weight) } else { 0.0 }
        };
        let mut u = random.next() * self.0.iter().map(share).sum::<f32>();
        let mut chosen = 0;
        for part in &self.0 {
            let share = share(part);
            if share > 0.0 {
                chosen = part.number;
                u -= share;
                if u < 0.0 {
                    break;
                }
            }
        }
        chosen
    }

    /// The parameters up to `length` between which light is scattered; `None` if it is nowhere. The end may be infinite.
    pub(super) fn scattering_span(&self, length: f32) -> Option<[f32; 2]> {
        let scattering = self.0.iter().filter(|part| part.medium.scattering != Vec3::ZERO);
        let spans = scattering.map(|part| {
            let [begin, end] = part.grid.as_ref().map_or(part.span, |ray| ray.span());
            [begin.max(part.span[0]), end.min(part.span[1]).min(length)]
        });
        let all = spans.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)]);
        all.filter(|[begin, end]| begin < end)
    }

    /// The mean distance of flights where density is even, world units; infinite where it is nowhere.
    pub(super) fn mean_distance(&self) -> f32 {
        let even = self.0.iter().filter(|part| part.grid.is_none()).map(|part| part.medium.extinction);
        1.0 / (even.sum::<Vec3>().element_sum() / 3.0)
    }

    /// The extinction up to `length`, if it is even, and all that is there scatters.
    pub(super) fn even_extinction(&self, length: f32) -> Option<Vec3> {
        let (extinction, end, is_even) = self.stretch(0.0);
        let scatters = self.even(0.0).0 != Vec3::ZERO;
        (is_even && scatters && end >= length && extinction.min_element() > 0.0).then_some(extinction)
    }

    /// Extinction and scattering coefficients at `t`.
    fn coefficients(&self, t: f32) -> [Vec3; 2] {
        self.0.iter().fold([Vec3::ZERO; 2], |[extinction, scattering], part| {
            let density = if part.bound(t).0 > 0.0 { part.at(t).0 } else { 0.0 };
            [extinction + part.medium.extinction * density, scattering + part.medium.scattering * density]
        })
    }

    /// The density of flights that end at `t`, per length, of light of this weight. Where density is not even it is a guess
    /// without noise, from the bounds.
    pub(super) fn density(&self, t: f32, throughput: Vec3) -> f32 {
        // Grids are about half as dense as their bounds.
        const FILLED: f32 = 0.5;
        let (mut passed, mut at) = (throughput / throughput.element_sum(), 0.0);
        while at < t {
            let (most, end, is_even) = self.stretch(at);
            let end = end.min(t);
            passed *= left(if is_even { most } else { most * FILLED }, end - at);
            at = end;
        }
        passed.dot(self.coefficients(t)[0])
    }

    /// Goes to `t` with the light of a path: its weight there, per length, and the medium that scatters it.
    pub(super) fn goes_to(&self, t: f32, throughput: Vec3, random: &mut Random) -> Option<(Vec3, u16)> {
        let scattering = self.coefficients(t)[1];
        if scattering == Vec3::ZERO {
            return None;
        }
        let weight = throughput * self.transmittance(t, random);
        (weight != Vec3::ZERO).then(|| (weight * scattering, self.scatterer(t, weight, random)))
    }

    /// Flies from the origin up to `length` with the light of a path.
    pub(crate) fn fly(&self, length: f32, throughput: Vec3, random: &mut Random) -> Flight {
        let (mut weight, mut emitted, mut t) = (throughput, Vec3::ZERO, 0.0);
        let ended = |throughput, emitted| Flight { throughput, emitted, scattered: None };
        while t < length {
            let (most, end, is_even) = self.stretch(t);
            let end = end.min(length);
            if most == Vec3::ZERO {
                t = end;
                continue;
            }
            let (scattering, radiance) = self.even(t);
            if is_even && scattering == Vec3::ZERO {
                // Nothing is drawn where light goes straight on.
                let passed = left(most, end - t);
                emitted +=
                    weight * radiance * (Vec3::ONE - passed) / most.max(Vec3::splat(f32::MIN_POSITIVE));
                weight *= passed;
                t = end;
                continue;
            }
            let total = weight.element_sum();
            if !(total > 0.0 && total.is_finite()) {
                return ended(Vec3::ZERO, emitted);
            }
            let shares = weight / total;
            let u = random.next();
            let channel = random.next();
            let k = if channel < shares.x {
                0
            } else if channel < shares.x + shares.y || shares.z == 0.0 {
                1
            } else {
                2
            };
            let step = if most[k] > 0.0 { distance(u) / most[k] } else { f32::INFINITY };
            if t + step >= end {
                let passed = left(most, end - t);
                weight = weight * passed / shares.dot(passed);
                t = end;
                continue;
            }
            t += step;
            let passed = left(most, step);
            weight = weight * passed / shares.dot(passed * most);
            let (mut scattering, mut extinction, mut radiance) = (Vec3::ZERO, Vec3::ZERO, Vec3::ZERO);
            for part in &self.0 {
                if part.bound(t).0 == 0.0 {
                    continue;
                }
                let (density, factor) = part.at(t);
                scattering += part.medium.scattering * density;
                extinction += part.medium.extinction * density;
                radiance += part.medium.absorption * part.medium.emission * factor * density;
            }
            emitted += weight * radiance;
            let null = if is_even { Vec3::ZERO } else { (most - extinction).max(Vec3::ZERO) };
            let (real, null_weight) = (weight.dot(scattering), weight.dot(null));
            let both = real + null_weight;
            if both <= 0.0 || both.is_nan() {
                return ended(Vec3::ZERO, emitted);
            }
            let probability = real / both;
            let u = if probability >= 1.0 { 0.0 } else { random.next() };
            if u >= probability {
                weight = weight * null / (1.0 - probability);
                continue;
            }
            let throughput = weight * scattering / probability;
            let scattered = Some((t, self.scatterer(t, weight, random)));
            return Flight { throughput, emitted, scattered };
        }
        ended(weight, emitted)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_steps_of_walks_are_stratified_over_samples() {
        let numbers = |sample| {
            let mut random = Random::of_walk(7, SampleKey { pixel: 3, sample, branch: 0 }, 2);
            [(); STRATIFIED as usize + 1].map(|()| random.next())
        };
        let samples: Vec<_> = (0..16).map(numbers).collect();
        for k in 0..STRATIFIED as usize {
            let parts = samples.iter().fold(0u32, |parts, numbers| parts | 1 << (numbers[k] * 16.0) as u32);
            assert_eq!(parts, 0xffff, "number {k}: a sample in each sixteenth");
        }
        let later = samples.iter().map(|numbers| numbers[STRATIFIED as usize]);
        assert!(later.clone().all(|u| (0.0..1.0).contains(&u)));
    }
}

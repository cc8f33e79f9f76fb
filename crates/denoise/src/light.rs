// SPDX-License-Identifier: GPL-3.0-or-later
//! Decomposition of a picture's colours: directly visible light of lights and environment, which needs no
//! filter, direct light of surfaces, with the edges of shadows, and smooth indirect light with its rare samples; both
//! are divided by the albedo. Division by albedo as in \[BRM*16\]'s successors,
//! softened so that gloss on dark surfaces stays gloss.
//! Invariant: `(direct + rest) * divisor + unscattered` is the picture, except for stray light that moved within a few
//! pixels; nothing here is negative. Tests: `tests`, crates/denoise/tests/filter.rs.

use crate::noisy::{Noisy, Seen, Triple};

/// Added to albedos before light is divided by them.
const SOFTENING: f32 = 0.5;
/// A pixel that hits a light with one of its samples has a variance of about the square of its value; with
/// two, of half that. Above this fraction its coverage by the light is unknown.
const HARDLY_SEEN: f32 = 0.8;
/// The ratio to all other light of the pixel above which it matters.
const MATTERS: f32 = 1.5;
/// Pixels to each side among which such light is shared out.
const SHARED: usize = 3;

/// The parts of a picture's light.
pub(crate) struct Light {
    /// Directly visible.
    pub(crate) unscattered: Vec<Triple>,
    /// The divisor of scattered light.
    pub(crate) divisor: Vec<Triple>,
    /// Direct light, black if it is not known, and all other scattered light.
    pub(crate) parts: [Part; 2],
}

/// A part of the scattered light, divided.
pub(crate) struct Part {
    pub(crate) color: Vec<Triple>,
    pub(crate) variance: Vec<Triple>,
}

impl Part {
    fn black(pixels: usize) -> Self {
        Self { color: vec![[0.0; 3]; pixels], variance: vec![[0.0; 3]; pixels] }
    }

    pub(crate) fn is_black(&self) -> bool {
        self.color.iter().all(|color| *color == [0.0; 3])
    }
}

impl Light {
    pub(crate) fn of(noisy: &Noisy) -> Self {
        let pixels = noisy.color.len();
        let mut light = Self {
            unscattered: Vec::with_capacity(pixels),
            divisor: noisy.albedo.iter().map(divisor).collect(),
            parts: [0, 1].map(|_| Part::black(pixels)),
        };
        if let Some(seen) = &noisy.seen {
            light.take_seen(noisy, seen);
            return light;
        }
        for p in 0..pixels {
            let color = noisy.color[p];
            let scattered = [0, 1, 2].map(|k| (color[k].max(0.0) - noisy.emission[p][k].max(0.0)).max(0.0));
            light.unscattered.push([0, 1, 2].map(|k| color[k].max(0.0) - scattered[k]));
            light.set(1, p, scattered, noisy.variance[p]);
        }
        if noisy.emission.iter().any(|e| mean(e) > 0.0) {
            light.take_variance_from_beside(noisy);
            light.share_stray_light(noisy, &noisy.emission);
        }
        light
    }

    /// Sets pixel `p` of a part.
    fn set(&mut self, part: usize, p: usize, color: Triple, variance: Triple) {
        let by = self.divisor[p];
        self.parts[part].color[p] = [0, 1, 2].map(|k| color[k] / by[k]);
        self.parts[part].variance[p] = [0, 1, 2].map(|k| variance[k].max(0.0) / (by[k] * by[k]));
    }

    /// The parts where it is known what mirrors and glass show.
    fn take_seen(&mut self, noisy: &Noisy, seen: &Seen) {
        for (p, color) in noisy.color.iter().enumerate() {
            let direct = seen.direct[p];
            let rest = [0, 1, 2].map(|k| (color[k] - seen.light[p][k] - direct[k]).max(0.0));
            self.unscattered.push(seen.split[p].map(|x| x.max(0.0)));
            self.set(0, p, direct.map(|x| x.max(0.0)), seen.variances[0][p]);
            self.set(1, p, rest, seen.variances[1][p]);
        }
        self.share_stray_light(noisy, &seen.split);
    }

    /// Where lights are visible, the variance is mostly that of their visible share: scattered light has that
    /// of neighbouring pixels.
    fn take_variance_from_beside(&mut self, noisy: &Noisy) {
        let Part { color, variance } = &mut self.parts[1];
        let before = variance.clone();
        for p in (0..before.len()).filter(|&p| mean(&noisy.emission[p]) > 0.0) {
            let (mut sum, mut count) = ([0.0; 3], 0.0);
            for q in around(noisy, p, 2).filter(|&q| mean(&noisy.emission[q]) <= 0.0) {
                (0..3).for_each(|k| sum[k] += before[q][k]);
                count += 1.0;
            }
            variance[p] = if count > 0.0 {
                sum.map(|x| x / count)
            } else {
                [0, 1, 2].map(|k| before[p][k].min(color[p][k] * color[p][k]))
            };
        }
    }

    /// The neighbours along a light's edge see as much of a light that a single sample of a pixel hit: light
    /// is shared.
    fn share_stray_light(&mut self, noisy: &Noisy, emission: &[Triple]) {
        let emission_at = |q: usize| mean(&emission[q]);
        let stray = |p: usize| {
            let emission = emission_at(p);
            if emission <= 0.0 {
                return None;
            }
            let unsure = (mean(&noisy.variance[p]) / (emission * emission).max(1e-30) - HARDLY_SEEN) / 0.3;
            let rest = (mean(&noisy.color[p]) - emission).max(emission * 1e-6);
            let share = unsure.clamp(0.0, 1.0) * (emission / rest - MATTERS).clamp(0.0, 1.0);
            (share > 0.0).then(|| (p, self.unscattered[p].map(|x| x * share)))
        };
        let stray: Vec<(usize, Triple)> = (0..self.unscattered.len()).filter_map(stray).collect();
        for (p, taken) in &stray {
            (0..3).for_each(|k| self.unscattered[*p][k] -= taken[k]);
        }
        let mut shares = Vec::new();
        for (p, taken) in &stray {
            // On which sides the light is: the edge continues where it is on one of those, too.
            let is_emitter = |q: usize| {
                sides(noisy, q).map(|side| side.is_some_and(|r| emission_at(r) > 2.0 * mean(taken)))
            };
            let of_edge = is_emitter(*p);
            shares.clear();
            for q in around(noisy, *p, SHARED) {
                let is_known = emission_at(q) > 0.0
                    && mean(&noisy.variance[q]) < HARDLY_SEEN * emission_at(q) * emission_at(q);
                let goes_on = || is_emitter(q).iter().zip(of_edge).any(|(&a, b)| a && b);
                if q == *p || (!is_known && goes_on()) {
                    let dx = (q % noisy.width).abs_diff(*p % noisy.width);
                    let dy = (q / noisy.width).abs_diff(*p / noisy.width);
                    shares.push((q, 1.0 / (1 + dx * dx + dy * dy) as f32));
                }
            }
            let all: f32 = shares.iter().map(|(_, share)| share).sum();
            for (q, share) in &shares {
                (0..3).for_each(|k| self.unscattered[*q][k] += taken[k] * (share / all));
            }
        }
    }
}

/// Pixels at most `reach` columns and rows away, and the one itself, row by row.
fn around(noisy: &Noisy, p: usize, reach: usize) -> impl Iterator<Item = usize> + use<> {
    let (width, height) = (noisy.width, noisy.height);
    let (x, y) = (p % width, p / width);
    let columns = x.saturating_sub(reach)..(x + reach + 1).min(width);
    let rows = y.saturating_sub(reach)..(y + reach + 1).min(height);
    rows.flat_map(move |y| columns.clone().map(move |x| y * width + x))
}

/// The pixels above, below, left and right.
fn sides(noisy: &Noisy, p: usize) -> [Option<usize>; 4] {
    let (x, y) = (p % noisy.width, p / noisy.width);
    [
        (y > 0).then(|| p - noisy.width),
        (y + 1 < noisy.height).then(|| p + noisy.width),
        (x > 0).then(|| p - 1),
        (x + 1 < noisy.width).then(|| p + 1),
    ]
}

/// The divisor of light: the albedo if there is one.
pub(crate) fn divisor(albedo: &Triple) -> Triple {
    if albedo.iter().all(|&a| a < 1e-3) { [1.0; 3] } else { albedo.map(|a| a.max(0.0) + SOFTENING) }
}

/// The mean of three colours.
pub(crate) fn mean(color: &Triple) -> f32 {
    (color[0] + color[1] + color[2]) * (1.0 / 3.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A dim wall next to a light of radiance 17, from column 5 on; in column 4 every third pixel hit it by
    /// one sample of 16.
    fn is_emitter() -> Noisy {
        let (width, height) = (10, 12);
        let pixels = || (0..width * height).map(|p| [p % width, p / width]);
        let emission_at = |[x, y]: [usize; 2]| -> f32 {
            match x {
                0..4 => 0.0,
                4 if y % 3 == 0 => 17.0 / 16.0,
                4 => 0.0,
                _ => 17.0,
            }
        };
        let rest = |[x, _]: [usize; 2]| if x < 5 { 0.2 } else { 0.0 };
        // Of the mean of sixteen samples, of which one is 17 and the others are none.
        let variance = |p: [usize; 2]| if p[0] == 4 { emission_at(p).powi(2) } else { 1e-3 };
        Noisy {
            width,
            height,
            color: pixels().map(|p| [emission_at(p) + rest(p); 3]).collect(),
            variance: pixels().map(|p| [variance(p).max(1e-3); 3]).collect(),
            albedo: pixels().map(|p| [if p[0] < 5 { 0.7 } else { 0.0 }; 3]).collect(),
            normal: vec![[0.0, 0.0, 1.0]; width * height],
            emission: pixels().map(|p| [emission_at(p); 3]).collect(),
            seen: None,
        }
    }

    #[test]
    fn parts_make_up_the_picture() {
        let noisy = is_emitter();
        let light = Light::of(&noisy);
        let whole = |p: usize| light.parts[1].color[p][1] * light.divisor[p][1] + light.unscattered[p][1];
        let [mut before, mut after] = [0.0, 0.0];
        for (p, color) in noisy.color.iter().enumerate() {
            before += color[1];
            after += whole(p);
            if p % noisy.width != 4 && (p % noisy.width > 4 || p % noisy.width == 0) {
                assert!((whole(p) - color[1]).abs() < 1e-4 * color[1], "pixel {p}: {}", whole(p));
            }
        }
        assert!((after / before - 1.0).abs() < 1e-5, "light is shared, not made: {before}, {after}");
    }

    #[test]
    fn a_lamp_met_by_chance_is_shared_along_its_edge() {
        let noisy = is_emitter();
        let light = Light::of(&noisy);
        let edge: Vec<f32> = (0..noisy.height).map(|y| light.unscattered[y * noisy.width + 4][0]).collect();
        let most = edge.iter().fold(0.0f32, |a, &b| a.max(b));
        assert!(most < 0.75 * 17.0 / 16.0, "no pixel keeps most of it: {edge:?}");
        assert!(edge[2..10].iter().all(|&x| x > 0.1), "those between get their share: {edge:?}");
    }

    #[test]
    fn lamps_do_not_spread_their_variance() {
        let noisy = is_emitter();
        let light = Light::of(&noisy);
        let surface = (light.divisor[0][0]).powi(2);
        for y in 0..noisy.height {
            let of_edge = light.parts[1].variance[y * noisy.width + 4][0] * surface;
            assert!(of_edge < 2e-3 || y % 3 != 0, "row {y}: {of_edge} where the wall beside has 0.001");
        }
    }
}

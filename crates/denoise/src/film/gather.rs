// SPDX-License-Identifier: GPL-3.0-or-later
//! A frame with the light of its window: the weighted mean of the light of its points in other frames, and
//! the variance of that. Light is without albedo, so that textures stay sharp. Where a pixel's points do not move,
//! albedo, normal and directly visible light are means, too: edges stand still.
//! Tests: `tests/film.rs`.

use gnurt_image::{Layer, Picture};
use rayon::prelude::*;

use super::change::{Pair, weights};
use super::frame::FilmFrame;
use super::track::{Tracks, begin, follow};
use crate::noisy::Triple;

/// Points that move by less than this many pixels stand still.
const STILL: f32 = 0.02;
/// Surfaces whose motions differ by less move together.
const TOGETHER: f32 = 0.1;
/// Less of a pixel is too little to borrow from.
const LEAST: f32 = 0.25;

/// A part of the light, and its variance.
#[derive(Clone, Copy, Default)]
struct Measured {
    light: Triple,
    variance: Triple,
}

impl Measured {
    fn over(&self, weight: f32) -> Self {
        Self { light: self.light.map(|x| x / weight), variance: self.variance.map(|x| x / (weight * weight)) }
    }
}

/// What a pixel borrows from another frame.
#[derive(Clone, Copy, Default)]
struct Tap {
    parts: [Measured; 2],
    /// The pixel there if the point has not moved.
    still: Option<usize>,
    is_found: bool,
}

/// Sums of a pixel.
#[derive(Clone, Copy)]
struct Sum {
    parts: [Measured; 2],
    weights: [f32; 2],
    unscattered: Triple,
    albedo: Triple,
    normal: Triple,
    count: f32,
}

/// Frame `at` of the window as a picture that can be filtered.
pub(super) fn gather(window: &[&FilmFrame], at: usize) -> Picture {
    let own = window[at];
    let mut sums: Vec<Sum> = (0..own.id.len())
        .map(|p| Sum {
            parts: measured(own, p),
            weights: [1.0; 2],
            unscattered: own.light.unscattered[p],
            albedo: own.noisy.albedo[p],
            normal: own.noisy.normal[p],
            count: 1.0,
        })
        .collect();
    for way in [0, 1] {
        let mut tracks = begin(own);
        let mut from = at;
        loop {
            let to = if way == 0 { from.checked_sub(1) } else { Some(from + 1) };
            let Some((to, other)) = to.and_then(|to| Some((to, *window.get(to)?))) else { break };
            follow(&mut tracks, window[from], way);
            borrow(&mut sums, own, other, &tracks);
            from = to;
        }
    }
    picture(own, &sums)
}

fn borrow(sums: &mut [Sum], own: &FilmFrame, other: &FilmFrame, tracks: &Tracks) {
    let taps: Vec<Tap> = (0..sums.len()).into_par_iter().map(|p| tap(p, own, other, tracks)).collect();
    let weights = [0, 1].map(|part| {
        let pair = |(p, tap): (usize, &Tap)| {
            if !tap.is_found {
                return Pair::default();
            }
            let (here, there) = (measured(own, p)[part], tap.parts[part]);
            Pair {
                difference: [0, 1, 2].map(|k| there.light[k] - here.light[k]),
                variance: [0, 1, 2].map(|k| there.variance[k] + here.variance[k]),
                own: here.variance,
                count: 1.0,
            }
        };
        let pairs: Vec<Pair> = taps.iter().enumerate().map(pair).collect();
        weights(&pairs, own.width)
    });
    sums.par_iter_mut().enumerate().for_each(|(p, sum)| {
        let tap = &taps[p];
        if !tap.is_found {
            return;
        }
        for part in [0, 1] {
            let weight = weights[part][p];
            add(&mut sum.parts[part], &tap.parts[part], weight);
            sum.weights[part] += weight;
        }
        let Some(q) = tap.still.filter(|_| is_unchanged(own, other, p)) else { return };
        for k in 0..3 {
            sum.unscattered[k] += other.light.unscattered[q][k];
            sum.albedo[k] += other.noisy.albedo[q][k];
            sum.normal[k] += other.noisy.normal[q][k];
        }
        sum.count += 1.0;
    });
}

fn measured(frame: &FilmFrame, p: usize) -> [Measured; 2] {
    frame.light.parts.each_ref().map(|part| Measured { light: part.color[p], variance: part.variance[p] })
}

fn add(sum: &mut Measured, other: &Measured, weight: f32) {
    for k in 0..3 {
        sum.light[k] += weight * other.light[k];
        sum.variance[k] += weight * weight * other.variance[k];
    }
}

/// Light of pixel `p` in another frame.
fn tap(p: usize, own: &FilmFrame, other: &FilmFrame, tracks: &Tracks) -> Tap {
    let Some(track) = &tracks[p] else { return Tap::default() };
    let (width, height) = (own.width, own.height);
    let [px, py] = [(p % width) as f32, (p / width) as f32];
    let by = [track.at[0] - px, track.at[1] - py];
    let is_still = by[0].abs() < STILL && by[1].abs() < STILL;
    let [x, y] = if is_still { [px, py] } else { track.at };
    let [x0, y0] = [x.floor(), y.floor()];
    let [fx, fy] = [x - x0, y - y0];
    let mut found = Tap { still: is_still.then_some(p), ..Tap::default() };
    let mut all = 0.0;
    for (dx, dy, share) in [
        (0.0, 0.0, (1.0 - fx) * (1.0 - fy)),
        (1.0, 0.0, fx * (1.0 - fy)),
        (0.0, 1.0, (1.0 - fx) * fy),
        (1.0, 1.0, fx * fy),
    ] {
        let (x, y) = (x0 + dx, y0 + dy);
        if share <= 0.0 || x < 0.0 || y < 0.0 || x >= width as f32 || y >= height as f32 {
            continue;
        }
        let q = y as usize * width + x as usize;
        let shows = other.shows(q, own.id[p], &track.normal, track.distance);
        if !shows && !moves_along(p, by, other.id[q], own, tracks) {
            continue;
        }
        all += share;
        for (sum, part) in found.parts.iter_mut().zip(&measured(other, q)) {
            add(sum, part, share);
        }
    }
    if all < LEAST {
        return Tap::default();
    }
    found.parts = found.parts.map(|part| part.over(all));
    found.is_found = true;
    found
}

/// Whether a pixel beside shows the surface `id`, and moves along with pixel `p`: on an edge, a pixel's first hit is
/// either surface.
fn moves_along(p: usize, by: [f32; 2], id: u32, own: &FilmFrame, tracks: &Tracks) -> bool {
    around(p, own.width, own.height).any(|q| {
        let Some(track) = tracks[q].as_ref().filter(|_| q != p && own.id[q] == id) else { return false };
        let [x, y] = [(q % own.width) as f32, (q / own.width) as f32];
        (track.at[0] - x - by[0]).abs() < TOGETHER && (track.at[1] - y - by[1]).abs() < TOGETHER
    })
}

/// Whether albedo, normal and directly visible light around a pixel that stands still are the same, but for coverage of pixels by chance.
fn is_unchanged(own: &FilmFrame, other: &FilmFrame, p: usize) -> bool {
    // Of the span of values around: means over nine pixels differ by less by chance.
    const SPAN: f32 = 0.12;
    let same = |a: &[Triple], b: &[Triple]| {
        (0..3).all(|k| {
            let (mut here, mut there, mut count) = (0.0, 0.0, 0.0);
            let (mut least, mut most) = (f32::INFINITY, f32::NEG_INFINITY);
            for q in around(p, own.width, own.height) {
                let (x, y) = (a[q][k], b[q][k]);
                (here, there, count) = (here + x, there + y, count + 1.0);
                (least, most) = (least.min(x.min(y)), most.max(x.max(y)));
            }
            let floor = 0.01 * most.abs().max(least.abs());
            ((here - there) / count).abs() <= floor + SPAN * (most - least)
        })
    };
    same(&own.light.unscattered, &other.light.unscattered)
        && same(&own.noisy.albedo, &other.noisy.albedo)
        && same(&own.noisy.normal, &other.noisy.normal)
}

fn around(p: usize, width: usize, height: usize) -> impl Iterator<Item = usize> {
    let near = |at: usize, length: usize| at.saturating_sub(1)..(at + 2).min(length);
    near(p / width, height).flat_map(move |y| near(p % width, width).map(move |x| y * width + x))
}

fn picture(own: &FilmFrame, sums: &[Sum]) -> Picture {
    let mut picture = Picture::new(own.width as u32, own.height as u32);
    let planes = || [0, 1, 2].map(|_| Vec::with_capacity(sums.len()));
    let [mut albedo, mut normal, mut unscattered, mut direct] = [(); 4].map(|()| planes());
    let (mut variance, mut variances) = (planes(), [planes(), planes()]);
    for (p, sum) in sums.iter().enumerate() {
        let by = |x: &Triple| x.map(|x| x / sum.count);
        let (a, n, u) = (by(&sum.albedo), by(&sum.normal), by(&sum.unscattered));
        let divisor = crate::light::divisor(&a);
        let parts = [0, 1].map(|part| sum.parts[part].over(sum.weights[part]));
        for k in 0..3 {
            albedo[k].push(a[k]);
            normal[k].push(n[k]);
            unscattered[k].push(u[k]);
            let light = parts.map(|part| part.light[k] * divisor[k]);
            let noise = parts.map(|part| part.variance[k] * divisor[k] * divisor[k]);
            direct[k].push(light[0]);
            picture.color[p][k] = u[k] + light[0] + light[1];
            variance[k].push(noise[0] + noise[1]);
            variances.iter_mut().zip(noise).for_each(|(planes, noise)| planes[k].push(noise));
        }
    }
    let layer = |name: &str, channels: [&str; 3], planes: [Vec<f32>; 3]| {
        Layer::floats(name, channels.into_iter().zip(planes))
    };
    let (rgb, xyz) = (["R", "G", "B"], ["X", "Y", "Z"]);
    let [of_direct, of_indirect] = variances;
    picture.layers = vec![
        layer("albedo", rgb, albedo),
        layer("N", xyz, normal),
        layer("seen_light", rgb, unscattered.clone()),
        layer("seen_split", rgb, unscattered),
        layer("seen_direct", rgb, direct),
        layer("seen_direct_variance", rgb, of_direct),
        layer("seen_indirect_variance", rgb, of_indirect),
        layer("variance", rgb, variance),
    ];
    picture
}

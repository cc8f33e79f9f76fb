// SPDX-License-Identifier: GPL-3.0-or-later
//! Metropolis instant radiosity: Markov chains over complete paths from lights to the camera, in proportion
//! to their contribution there; the vertex before the first visible one becomes a virtual light. All virtual
//! lights bring the same light to the pilot points.
//! Source: [SIP07]; multiple-try proposals that all count: [Cal14], after [LLW00]; small and large mutations
//! of a path's random numbers [KSKAC02]. Chains start at paths resampled from those that estimate the total,
//! so that no start-up bias remains [Vea97] section 11.3.1. Differs: a state's light is summed over all
//! pilots and over all virtual lights on its path. A step draws an intermediate point from the numbers of the
//! state, without evaluating it, and the tries from that point, separately for the light's and the camera's
//! side [VG97]. So the state and its tries are exchangeable, and the next state is chosen from all pairs of
//! sides in proportion to light. The virtual lights of all pairs represent the chain, in the same proportion.
//! Invariant: the mean over passes is that of instant radiosity. Chains are independent of each other and of
//! threads.
//! Tests: crates/render/tests/many_lights.rs.

use std::sync::Arc;

use gnurt_shading::SampleKey;
use gnurt_shading::sampling::{Distribution, hash_combine, sample_pair};

use super::bidirectional::{Candidates, RESAMPLING, spread};
use super::bound::Bound;
use super::candidates::{
    Candidate, EYE_EDGE, EYE_PAIRS, EyeSide, LightSide, eye_sides, joined, light_sides, total,
};
use super::chunks::in_chunks_of;
use super::light_path;
use super::pilots::Pilots;
use super::vpl::Vpl;
use crate::job::Job;
use crate::stats::RenderStats;
use crate::tracer::BatchTracer;

/// Smallest and largest change of a number by a small step.
const SMALL: [f32; 2] = [1.0 / 1024.0, 1.0 / 32.0];
/// The number of edges whose numbers mutate; later edges keep the numbers of the chain's start.
const EDGES: u32 = 24;
/// Pairs of each edge of a light path.
const PAIRS: u32 = light_path::pair::POSITION + 1;
/// Pairs of the camera's side.
const OF_EYE: usize = (EYE_PAIRS.end - EYE_PAIRS.start) as usize;
/// Marks numbers for chains.
const CHAINS: u32 = 0x3e70_5c00;

/// Virtual lights of a chain's step: few, so that there are many chains and their starts spread.
const LIGHTS_PER_STEP: u32 = 2;
/// Steps of a chain: more of them in place of chains made pictures worse.
const STEPS: u32 = 1;
/// Tries of a step for each side of the path.
const TRIES: usize = 2;
/// Sides that are joined each to each: those of the state and of the tries.
const SIDES: usize = TRIES + 1;
/// Share of steps whose tries may be anywhere: for the lamp's side, for the camera's.
const LARGE: [f32; 2] = [0.1, 0.3];
/// Chains that go on together, in one thread.
const TOGETHER: u32 = 64;

/// The light's part of a path: its random numbers, and its vertices.
#[derive(Clone)]
struct OfLight {
    numbers: Vec<[f32; 2]>,
    side: Arc<LightSide>,
}

/// A path's part from the camera.
#[derive(Clone)]
struct OfEye {
    numbers: [[f32; 2]; OF_EYE],
    side: Arc<EyeSide>,
}

/// A chain's state.
struct Chain {
    number: u32,
    /// Path of the set whose numbers it started with.
    seed: u32,
    light: OfLight,
    eye: OfEye,
}

/// Random decisions of a chain.
struct Dice {
    seed: u64,
    pixel: u32,
}

impl Dice {
    fn pair(&self, chain: u32, step: u32, purpose: u32) -> [f32; 2] {
        let key = SampleKey { pixel: hash_combine(self.pixel, chain), sample: step, branch: CHAINS };
        sample_pair(self.seed, key, purpose, CHAINS)
    }
}

/// The virtual lights of a pass.
pub(super) fn virtual_lights(job: &Job, sample: u32, bound: Bound, stats: &mut RenderStats) -> Vec<Vpl> {
    let all = Candidates::new(job, sample, bound, stats);
    // Contribution and weight of each pair.
    let lights: Vec<f32> = all.light.iter().map(|side| total(&side.own)).collect();
    let eyes: Vec<f32> = all.eye.iter().map(|side| total(&side.own)).collect();
    let mut weights = Vec::new();
    let mut pairs = Vec::new();
    let mut joined = all.joined.iter().peekable();
    for i in 0..all.paths {
        for k in all.crowd_of(i) {
            let mut light = lights[i as usize] + eyes[k as usize];
            while let Some((_, own)) = joined.next_if(|(pair, _)| *pair == [i, k]) {
                light += own.importance;
            }
            pairs.push([i, k]);
            weights.push(f64::from(light) * f64::from(all.share_of_pair(i)));
        }
    }
    let Some(choice) = Distribution::new(weights) else { return Vec::new() };
    // The mean contribution of all paths together: the total, which chains only distribute.
    let mean = choice.total() / f64::from(all.paths);
    let count = job.options.vpls.div_ceil(STEPS * LIGHTS_PER_STEP);
    let seed = job.options.seed_of_lights();
    let dice = Dice { seed, pixel: hash_combine(CHAINS, sample) };
    let fresh = light_path::numbers(seed, sample);
    let key = SampleKey { pixel: hash_combine(RESAMPLING, sample), sample: 0, branch: RESAMPLING };
    let [start, _] = sample_pair(seed, key, 0, 1);
    let share = (mean / f64::from(count * STEPS)) as f32;
    // The last one's numbers decide about an end that comes anyway.
    let edges = job.options.max_depth.saturating_sub(1).min(EDGES);
    let pass = Pass { pilots: &all.pilots, dice: &dice, fresh: &fresh, share };
    let run = |tracer: &mut BatchTracer, range: std::ops::Range<u32>| {
        let begin = |number: u32| {
            let at = (f64::from(number) + f64::from(start)) / f64::from(count);
            let [i, k] = pairs[choice.sample(at).index];
            let of_eye: Vec<[f32; 2]> = EYE_PAIRS.map(|pair| fresh(k, EYE_EDGE, pair)).collect();
            let numbers = (0..edges * PAIRS).map(|n| fresh(i, n / PAIRS, n % PAIRS)).collect();
            let light = OfLight { numbers, side: Arc::new(all.light[i as usize].clone()) };
            let side = Arc::new(all.eye[k as usize].clone());
            let eye = OfEye { numbers: std::array::from_fn(|n| of_eye[n]), side };
            Chain { number, seed: i, light, eye }
        };
        let mut chains: Vec<Chain> = range.map(begin).collect();
        let mut out = Vec::new();
        for step in 0..STEPS {
            advance(tracer, &pass, &mut chains, step, &mut out);
        }
        out
    };
    let pools: Vec<Vec<(Candidate, f32)>> = in_chunks_of(TOGETHER, job, count, stats, run);
    let all: Vec<(Candidate, f32)> = pools.into_iter().flatten().collect();
    let [u, _] = sample_pair(seed, key, 0, 2);
    let chosen = spread(&all, job.options.vpls as usize, u);
    chosen.into_iter().map(|(i, weight)| all[i].0.vpl.scaled(weight)).collect()
}

/// Purposes of the numbers of a chain's step; those of tries are separate.
mod purpose {
    pub(super) const NEXT: u32 = 0;
    pub(super) const KINDS: u32 = 1;
    pub(super) const LIGHT: u32 = 1000;
    pub(super) const EYE: u32 = 2000;
    pub(super) const OF_TRY: u32 = 10_000;
}

/// Numbers around some others: all anywhere, or all a little off.
fn changed(
    dice: &Dice,
    chain: u32,
    step: u32,
    purpose: u32,
    is_large: bool,
    from: &[[f32; 2]],
) -> Vec<[f32; 2]> {
    let change = |(i, &old): (u32, &[f32; 2])| {
        let new = dice.pair(chain, step, purpose + i);
        if is_large { new } else { [0, 1].map(|k| small_step(old[k], new[k])) }
    };
    (0..).zip(from).map(change).collect()
}

/// The sides of all chains in this step: those of the states first, then untraced tries.
fn sides(chains: &[Chain], step: u32, dice: &Dice) -> (Vec<[OfLight; SIDES]>, Vec<[OfEye; SIDES]>) {
    let (dark, nowhere) = (Arc::new(LightSide::default()), Arc::new(EyeSide::default()));
    let of_chain = |chain: &Chain| {
        let kinds = dice.pair(chain.number, step, purpose::KINDS);
        let [large_light, large_eye] = [0, 1].map(|k| kinds[k] < LARGE[k]);
        // Around a point that is not evaluated, so that the state and its tries are exchangeable.
        let around = |purpose: u32, is_large: bool, from: &[[f32; 2]], attempt: usize| {
            let middle = changed(dice, chain.number, step, purpose, is_large, from);
            let purpose = purpose + attempt as u32 * purpose::OF_TRY;
            changed(dice, chain.number, step, purpose, is_large, &middle)
        };
        let light = |attempt: usize| match attempt {
            0 => chain.light.clone(),
            _ => {
                let numbers = around(purpose::LIGHT, large_light, &chain.light.numbers, attempt);
                OfLight { numbers, side: dark.clone() }
            }
        };
        let eye = |attempt: usize| match attempt {
            0 => chain.eye.clone(),
            _ => {
                let numbers = around(purpose::EYE, large_eye, &chain.eye.numbers, attempt);
                OfEye { numbers: std::array::from_fn(|i| numbers[i]), side: nowhere.clone() }
            }
        };
        (std::array::from_fn(light), std::array::from_fn(eye))
    };
    chains.iter().map(of_chain).unzip()
}

/// The pass, as a step needs it.
struct Pass<'a, F> {
    pilots: &'a Pilots,
    dice: &'a Dice,
    fresh: &'a F,
    /// Light that a step represents.
    share: f32,
}

/// One step of all chains: tries around them, from both sides, and one of all pairs that are joined. Adds the virtual lights
/// of all pairs, and how often each counts.
fn advance<F: Fn(u32, u32, u32) -> [f32; 2] + Sync>(
    tracer: &mut BatchTracer,
    pass: &Pass<F>,
    chains: &mut [Chain],
    step: u32,
    out: &mut Vec<(Candidate, f32)>,
) {
    let Pass { pilots, dice, fresh, share } = pass;
    let (mut lights, mut eyes) = sides(chains, step, dice);
    let count = (chains.len() * TRIES) as u32;
    let of = |path: u32| (path as usize / TRIES, path as usize % TRIES + 1);
    let numbers = |path: u32, edge: u32, pair: u32| {
        let (chain, attempt) = of(path);
        let known = lights[chain][attempt].numbers.get((edge * PAIRS + pair) as usize);
        known.copied().unwrap_or_else(|| fresh(chains[chain].seed, edge, pair))
    };
    let found = light_sides(tracer, pilots, 0..count, &numbers);
    for ((chain, attempt), side) in (0..count).map(of).zip(found) {
        lights[chain][attempt].side = Arc::new(side);
    }
    let numbers = |path: u32, _: u32, pair: u32| {
        let (chain, attempt) = of(path);
        eyes[chain][attempt].numbers[(pair - EYE_PAIRS.start) as usize]
    };
    let found = eye_sides(tracer, pilots, 0..count, &numbers);
    for ((chain, attempt), side) in (0..count).map(of).zip(found) {
        eyes[chain][attempt].side = Arc::new(side);
    }
    const PAIRED: usize = SIDES * SIDES;
    let pairs = (0..chains.len() * PAIRED).map(|pair| {
        let (chain, pair) = (pair / PAIRED, pair % PAIRED);
        (&*lights[chain][pair / SIDES].side, &*eyes[chain][pair % SIDES].side)
    });
    let mut joined = joined(tracer, pilots, pairs).into_iter().peekable();
    for (n, chain) in chains.iter_mut().enumerate() {
        let (lights, eyes) = (&lights[n], &eyes[n]);
        // Those of one side by itself are on all its pairs.
        let own = lights
            .iter()
            .flat_map(|light| &light.side.own)
            .chain(eyes.iter().filter_map(|eye| eye.side.own.as_ref()));
        let mut pool: Vec<(Candidate, f32)> = own.map(|own| (own.clone(), SIDES as f32)).collect();
        let light = |pair: usize| {
            let mut sum = total(&lights[pair / SIDES].side.own) + total(&eyes[pair % SIDES].side.own);
            while let Some((_, own)) = joined.next_if(|(of, _)| *of == n * PAIRED + pair) {
                sum += own.importance;
                pool.push((own, 1.0));
            }
            f64::from(sum)
        };
        let Some(choice) = Distribution::new((0..PAIRED).map(light)) else { continue };
        let scale = share / choice.total() as f32;
        out.extend(pool.into_iter().map(|(own, times)| (own, scale * times)));
        let next = choice.sample(dice.pair(chain.number, step, purpose::NEXT)[0]).index;
        chain.light = lights[next / SIDES].clone();
        chain.eye = eyes[next % SIDES].clone();
    }
}

/// A number near `old`, by a symmetric change whose size is spread evenly over orders of magnitude.
fn small_step(old: f32, u: f32) -> f32 {
    let [least, most] = SMALL;
    let (sign, u) = if u < 0.5 { (1.0, 2.0 * u) } else { (-1.0, 2.0 * u - 1.0) };
    let new = old + sign * most * (-(most / least).ln() * u).exp();
    let new = new - new.floor();
    if new < 1.0 { new } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_steps_are_symmetric_and_stay_inside() {
        let mut sum = 0.0;
        for i in 0..10_000 {
            let new = small_step(0.001, (i as f32 + 0.5) / 10_000.0);
            assert!((0.0..1.0).contains(&new), "inside: {new}");
            let change = if new > 0.5 { new - 1.001 } else { new - 0.001 };
            assert!(
                change.abs() <= SMALL[1] * 1.01 && change.abs() > SMALL[0] * 0.9,
                "a small one: {change}"
            );
            sum += change;
        }
        assert!((sum / 10_000.0).abs() < 1e-5, "up as often as down: {sum}");
    }
}

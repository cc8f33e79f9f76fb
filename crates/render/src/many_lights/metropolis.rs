// SPDX-License-Identifier: GPL-3.0-or-later
//! Metropolis instant radiosity: Markov chains over complete paths from lamps to the camera, in proportion to the light
//! that they bring there; the vertex before the first one that the camera sees becomes a virtual light. All virtual
//! lights bring the same light to the pilots.
//! Source: [SIP07]; multiple tries [LLW00]; mutations of the numbers that a path is made of, small and large [KSKAC02];
//! chains start at paths resampled from those that estimate the total, so that no start-up bias is left [Vea97] section
//! 11.3.1. Differs: a state's light is summed over all pilots and over all virtual lights on its path, of which one is
//! chosen in proportion afterwards; both ways of making a path share a state.
//! Invariant: the mean over passes is that of instant radiosity. Chains know nothing of each other and of threads.
//! Proof: crates/render/tests/many_lights.rs.

use gnurt_shading::SampleKey;
use gnurt_shading::sampling::{Distribution, hash_combine, sample_pair};

use super::bidirectional::{RESAMPLING, all_candidates};
use super::bound::Bound;
use super::candidates::{Candidate, candidates};
use super::instant;
use super::pass::in_chunks_of;
use super::pilots::Pilots;
use super::vpl::Vpl;
use crate::stats::RenderStats;
use crate::tile::Job;
use crate::tracer::BatchTracer;

/// Steps of a chain, each with a virtual light.
const STEPS: u32 = 16;
/// Tries of a step.
const TRIES: u32 = 3;
/// Share of steps that forget where they were.
const LARGE: f32 = 0.2;
/// Smallest and largest change of a number by a small step.
const SMALL: [f32; 2] = [1.0 / 1024.0, 1.0 / 32.0];
/// Chains that go on together, in one thread.
const TOGETHER: u32 = 16;
/// Edges whose numbers are changed; those beyond keep what the chain started with.
const EDGES: u32 = 24;
/// Pairs of each edge.
const PAIRS: u32 = 8;
/// Says that a number is for chains.
const CHAINS: u32 = 0x3e70_5c00;

/// The numbers that a path is made of.
type State = Vec<[f32; 2]>;

/// A chain: numbers, the virtual lights that they make, the light these bring to the pilots.
struct Chain {
    number: u32,
    /// Path of the set whose numbers it started with.
    seed: u32,
    state: State,
    found: Vec<Candidate>,
    light: f32,
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
    let (pilots, paths, found) = all_candidates(job, sample, bound, stats);
    let light: Vec<f64> = found.iter().map(|of_path| f64::from(total(of_path))).collect();
    let Some(choice) = Distribution::new(light) else { return Vec::new() };
    // What all of them together bring, on average: the total that chains only share out.
    let mean = choice.total() / f64::from(paths);
    let chains = job.options.vpls.div_ceil(STEPS);
    let seed = job.options.seed;
    let dice = Dice { seed, pixel: hash_combine(CHAINS, sample) };
    let fresh = instant::numbers(seed, sample);
    let key = SampleKey { pixel: hash_combine(RESAMPLING, sample), sample: 0, branch: RESAMPLING };
    let [start, _] = sample_pair(seed, key, 0, 1);
    let share = (mean / f64::from(chains * STEPS)) as f32;
    let run = |tracer: &mut BatchTracer, range: std::ops::Range<u32>| {
        let begin = |number: u32| {
            let at = (f64::from(number) + f64::from(start)) / f64::from(chains);
            let path = choice.sample(at).index as u32;
            let state = (0..EDGES * PAIRS).map(|i| fresh(path, i / PAIRS, i % PAIRS)).collect();
            let found = found[path as usize].clone();
            Chain { number, seed: path, state, light: total(&found), found }
        };
        let mut chains: Vec<Chain> = range.map(begin).collect();
        let mut out = Vec::new();
        for step in 0..STEPS {
            advance(tracer, &pilots, &mut chains, step, &dice, &fresh);
            out.extend(chains.iter().filter_map(|chain| chain.virtual_light(step, &dice, share)));
        }
        out
    };
    in_chunks_of(TOGETHER, job, chains, stats, run).into_iter().flatten().collect()
}

/// Light that a path brings to the pilots.
fn total(found: &[Candidate]) -> f32 {
    found.iter().map(|candidate| candidate.importance).sum()
}

impl Chain {
    /// One of its virtual lights, such that all of all chains bring the same light to the pilots.
    fn virtual_light(&self, step: u32, dice: &Dice, share: f32) -> Option<Vpl> {
        let choice = Distribution::new(self.found.iter().map(|c| f64::from(c.importance)))?;
        let chosen = &self.found[choice.sample(dice.pair(self.number, step, 0)[0]).index];
        Some(chosen.vpl.scaled(share / chosen.importance))
    }
}

/// One step of all chains: several tries each, one of them chosen, as many tries back, and the decision [LLW00].
fn advance(
    tracer: &mut BatchTracer,
    pilots: &Pilots,
    chains: &mut [Chain],
    step: u32,
    dice: &Dice,
    fresh: &(impl Fn(u32, u32, u32) -> [f32; 2] + Sync),
) {
    let is_large = |chain: u32| dice.pair(chain, step, 1)[0] < LARGE;
    let mutate = |chain: &Chain, from: &State, attempt: u32| -> State {
        let large = is_large(chain.number);
        let changed = |(i, &old): (usize, &[f32; 2])| {
            let purpose = 16 + attempt * EDGES * PAIRS + i as u32;
            let new = dice.pair(chain.number, step, purpose);
            if large { new } else { [0, 1].map(|k| small_step(old[k], new[k])) }
        };
        from.iter().enumerate().map(changed).collect()
    };
    let tries: Vec<State> = chains
        .iter()
        .flat_map(|chain| (0..TRIES).map(|attempt| mutate(chain, &chain.state, attempt)).collect::<Vec<_>>())
        .collect();
    let seeds: Vec<u32> = chains.iter().map(|chain| chain.seed).collect();
    let mut tried = evaluate(tracer, pilots, &tries, &seeds, TRIES, fresh);
    let lights: Vec<f32> = tried.iter().map(|found| total(found)).collect();
    // Which of the tries each chain may go to.
    let chosen: Vec<Option<usize>> = chains
        .iter()
        .enumerate()
        .map(|(n, chain)| {
            let of_chain = &lights[n * TRIES as usize..(n + 1) * TRIES as usize];
            let choice = Distribution::new(of_chain.iter().map(|&light| f64::from(light)))?;
            Some(n * TRIES as usize + choice.sample(dice.pair(chain.number, step, 2)[0]).index)
        })
        .collect();
    let back: Vec<State> = chains
        .iter()
        .zip(&chosen)
        .flat_map(|(chain, chosen)| {
            let from = chosen.map_or(&chain.state, |chosen| &tries[chosen]);
            (1..TRIES).map(|attempt| mutate(chain, from, TRIES + attempt)).collect::<Vec<_>>()
        })
        .collect();
    let backward = evaluate(tracer, pilots, &back, &seeds, TRIES - 1, fresh);
    for (n, chain) in chains.iter_mut().enumerate() {
        let Some(chosen) = chosen[n] else { continue };
        let forward: f32 = lights[n * TRIES as usize..(n + 1) * TRIES as usize].iter().sum();
        let references = &backward[n * (TRIES as usize - 1)..(n + 1) * (TRIES as usize - 1)];
        let backward: f32 = chain.light + references.iter().map(|found| total(found)).sum::<f32>();
        if dice.pair(chain.number, step, 3)[0] * backward < forward {
            chain.light = lights[chosen];
            chain.state.clone_from(&tries[chosen]);
            chain.found = std::mem::take(&mut tried[chosen]);
        }
    }
}

/// Virtual lights of some states; `each` consecutive states belong to one chain.
fn evaluate(
    tracer: &mut BatchTracer,
    pilots: &Pilots,
    states: &[State],
    seeds: &[u32],
    each: u32,
    fresh: &(impl Fn(u32, u32, u32) -> [f32; 2] + Sync),
) -> Vec<Vec<Candidate>> {
    let numbers = |path: u32, edge: u32, pair: u32| {
        if edge < EDGES {
            states[path as usize][(edge * PAIRS + pair) as usize]
        } else {
            fresh(seeds[(path / each) as usize], edge, pair)
        }
    };
    candidates(tracer, pilots, 0..states.len() as u32, &numbers)
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

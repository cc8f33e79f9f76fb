// SPDX-License-Identifier: GPL-3.0-or-later
//! Metropolis instant radiosity: Markov chains over complete paths from lamps to the camera, in proportion to the light
//! that they bring there; the vertex before the first one that the camera sees becomes a virtual light. All virtual
//! lights bring the same light to the pilots.
//! Source: [SIP07]; multiple tries [LLW00]; mutations of the numbers that a path is made of, small and large [KSKAC02];
//! chains start at paths resampled from those that estimate the total, so that no start-up bias is left [Vea97] section
//! 11.3.1. Differs: a state's light is summed over all pilots and over all virtual lights on its path, of which one is
//! chosen in proportion afterwards; both ways of making a path share a state. Mutations of the camera's side alone,
//! small (as lens mutations of [VG97]) or whole (as their bidirectional ones), keep the path from the lamp, which then is
//! not traced again.
//! Invariant: the mean over passes is that of instant radiosity. Chains know nothing of each other and of threads.
//! Proof: crates/render/tests/many_lights.rs.

use std::sync::Arc;

use gnurt_shading::SampleKey;
use gnurt_shading::sampling::{Distribution, hash_combine, sample_pair};

use super::bidirectional::{RESAMPLING, all_candidates};
use super::bound::Bound;
use super::candidates::{Candidate, EYE_EDGE, EYE_PAIRS, LightSide, joined, light_sides};
use super::instant;
use super::light_path;
use super::pass::in_chunks_of;
use super::pilots::Pilots;
use super::vpl::Vpl;
use crate::stats::RenderStats;
use crate::tile::Job;
use crate::tracer::BatchTracer;

/// Steps of a chain, each with a virtual light: few, so that there are many chains and their starts spread.
const STEPS: u32 = 4;
/// Tries of a step.
const TRIES: u32 = 3;
/// Smallest and largest change of a number by a small step.
const SMALL: [f32; 2] = [1.0 / 1024.0, 1.0 / 32.0];
/// Chains that go on together, in one thread.
const TOGETHER: u32 = 16;
/// Edges whose numbers are changed, at most; those beyond keep what the chain started with.
const EDGES: u32 = 24;
/// Pairs of each edge of a light path.
const PAIRS: u32 = light_path::pair::PLACE + 1;
/// Pairs of the camera's side: a state begins with them.
const OF_EYE: usize = (EYE_PAIRS.end - EYE_PAIRS.start) as usize;
/// Says that a number is for chains.
const CHAINS: u32 = 0x3e70_5c00;

/// The numbers that a path is made of: the camera's side, then the edges from the lamp on.
type State = Vec<[f32; 2]>;

/// Where a state has a pair; the place may lie beyond its end.
fn place(edge: u32, pair: u32) -> usize {
    if edge == EYE_EDGE && EYE_PAIRS.contains(&pair) {
        (pair - EYE_PAIRS.start) as usize
    } else {
        OF_EYE + (edge * PAIRS + pair) as usize
    }
}

/// A chain: numbers, the virtual lights that they make, the light these bring to the pilots.
struct Chain {
    number: u32,
    /// Path of the set whose numbers it started with.
    seed: u32,
    state: State,
    /// Its path from the lamp, once somebody has traced it.
    side: Option<Arc<LightSide>>,
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
    // The last one's numbers decide about an end that comes anyway.
    let edges = job.options.max_depth.saturating_sub(1).min(EDGES);
    let run = |tracer: &mut BatchTracer, range: std::ops::Range<u32>| {
        let begin = |number: u32| {
            let at = (f64::from(number) + f64::from(start)) / f64::from(chains);
            let path = choice.sample(at).index as u32;
            let of_eye = EYE_PAIRS.map(|pair| fresh(path, EYE_EDGE, pair));
            let of_light = (0..edges * PAIRS).map(|i| fresh(path, i / PAIRS, i % PAIRS));
            let state = of_eye.chain(of_light).collect();
            let found = found[path as usize].clone();
            Chain { number, seed: path, state, side: None, light: total(&found), found }
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

/// What a step changes: chosen without a look at the state, so that steps can be taken back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mutation {
    /// All numbers, to any value.
    Large,
    /// All numbers, a little.
    Small,
    /// The numbers on the camera's side, a little.
    Lens,
    /// The numbers on the camera's side, to any value.
    Eye,
}

impl Mutation {
    /// By a number in [0, 1).
    fn of(u: f32) -> Self {
        match u {
            u if u < 0.1 => Self::Large,
            u if u < 0.45 => Self::Lens,
            u if u < 0.65 => Self::Eye,
            _ => Self::Small,
        }
    }

    /// Whether the path from the lamp stays as it is.
    fn keeps_light(self) -> bool {
        matches!(self, Self::Lens | Self::Eye)
    }

    /// A number's next value, given a fresh one.
    fn change(self, old: f32, fresh: f32) -> f32 {
        match self {
            Self::Large | Self::Eye => fresh,
            Self::Small | Self::Lens => small_step(old, fresh),
        }
    }
}

/// A state that was tried, and what it brings.
struct Tried {
    state: State,
    side: Arc<LightSide>,
    found: Vec<Candidate>,
    light: f32,
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
    let kinds: Vec<Mutation> =
        chains.iter().map(|chain| Mutation::of(dice.pair(chain.number, step, 1)[0])).collect();
    let mutate = |chain: &Chain, kind: Mutation, from: &State, attempt: u32| -> State {
        let changed = |(i, &old): (usize, &[f32; 2])| {
            if kind.keeps_light() && i >= OF_EYE {
                return old;
            }
            let purpose = 16 + attempt * 4 * EDGES + i as u32;
            let new = dice.pair(chain.number, step, purpose);
            [0, 1].map(|k| kind.change(old[k], new[k]))
        };
        from.iter().enumerate().map(changed).collect()
    };
    // A chain's own light path, where one is kept that nobody has traced yet.
    let missing: Vec<usize> =
        (0..chains.len()).filter(|&n| kinds[n].keeps_light() && chains[n].side.is_none()).collect();
    let states: Vec<(&State, u32)> = missing.iter().map(|&n| (&chains[n].state, chains[n].seed)).collect();
    let sides = trace(tracer, pilots, &states, fresh);
    missing.into_iter().zip(sides).for_each(|(n, side)| chains[n].side = Some(side));
    let kept = |n: usize, chains: &[Chain]| chains[n].side.clone().filter(|_| kinds[n].keeps_light());

    let asks: Vec<Ask> = chains
        .iter()
        .enumerate()
        .flat_map(|(n, chain)| (0..TRIES).map(move |attempt| (n, chain, attempt)))
        .map(|(n, chain, attempt)| Ask {
            state: mutate(chain, kinds[n], &chain.state, attempt),
            seed: chain.seed,
            side: kept(n, chains),
        })
        .collect();
    let mut tried: Vec<Option<Tried>> = evaluate(tracer, pilots, asks, fresh).into_iter().map(Some).collect();
    let tries_of = |n: usize| n * TRIES as usize..(n + 1) * TRIES as usize;
    let lights: Vec<f32> = tried.iter().flatten().map(|tried| tried.light).collect();
    // Which of the tries each chain may go to.
    let chosen: Vec<Option<usize>> = chains
        .iter()
        .enumerate()
        .map(|(n, chain)| {
            let choice = Distribution::new(lights[tries_of(n)].iter().map(|&light| f64::from(light)))?;
            Some(n * TRIES as usize + choice.sample(dice.pair(chain.number, step, 2)[0]).index)
        })
        .collect();
    let moving: Vec<(usize, usize)> =
        chosen.iter().enumerate().filter_map(|(n, chosen)| Some((n, (*chosen)?))).collect();
    let asks: Vec<Ask> = moving
        .iter()
        .flat_map(|&(n, chosen)| (1..TRIES).map(move |attempt| (n, chosen, attempt)))
        .map(|(n, chosen, attempt)| {
            let from = tried[chosen].as_ref().map_or(&chains[n].state, |tried| &tried.state);
            Ask {
                state: mutate(&chains[n], kinds[n], from, TRIES + attempt),
                seed: chains[n].seed,
                side: kept(n, chains),
            }
        })
        .collect();
    let backward = evaluate(tracer, pilots, asks, fresh);
    for (references, (n, chosen)) in backward.chunks(TRIES as usize - 1).zip(moving) {
        let chain = &mut chains[n];
        let forward: f32 = lights[tries_of(n)].iter().sum();
        let backward: f32 = chain.light + references.iter().map(|tried| tried.light).sum::<f32>();
        if dice.pair(chain.number, step, 3)[0] * backward < forward
            && let Some(tried) = tried[chosen].take()
        {
            chain.light = tried.light;
            chain.state = tried.state;
            chain.found = tried.found;
            chain.side = Some(tried.side);
        }
    }
}

/// A state that is to be evaluated.
struct Ask {
    state: State,
    seed: u32,
    /// Its path from the lamp, if that is known.
    side: Option<Arc<LightSide>>,
}

/// Virtual lights of some states.
fn evaluate(
    tracer: &mut BatchTracer,
    pilots: &Pilots,
    mut asks: Vec<Ask>,
    fresh: &(impl Fn(u32, u32, u32) -> [f32; 2] + Sync),
) -> Vec<Tried> {
    let unknown: Vec<usize> = (0..asks.len()).filter(|&i| asks[i].side.is_none()).collect();
    let states: Vec<(&State, u32)> = unknown.iter().map(|&i| (&asks[i].state, asks[i].seed)).collect();
    let sides = trace(tracer, pilots, &states, fresh);
    unknown.into_iter().zip(sides).for_each(|(i, side)| asks[i].side = Some(side));
    let light: Vec<&LightSide> = asks.iter().filter_map(|ask| ask.side.as_deref()).collect();
    let numbers = |path: u32, edge: u32, pair: u32| {
        let ask = &asks[path as usize];
        number(&ask.state, ask.seed, fresh, [edge, pair])
    };
    let found = joined(tracer, pilots, &light, &numbers);
    let tried = |(ask, found): (Ask, Vec<Candidate>)| {
        Some(Tried { state: ask.state, side: ask.side?, light: total(&found), found })
    };
    asks.into_iter().zip(found).filter_map(tried).collect()
}

/// Paths from lamps of some states, each with the path whose numbers its chain started with.
fn trace(
    tracer: &mut BatchTracer,
    pilots: &Pilots,
    states: &[(&State, u32)],
    fresh: &(impl Fn(u32, u32, u32) -> [f32; 2] + Sync),
) -> Vec<Arc<LightSide>> {
    let numbers = |path: u32, edge: u32, pair: u32| {
        let (state, seed) = states[path as usize];
        number(state, seed, fresh, [edge, pair])
    };
    light_sides(tracer, pilots, 0..states.len() as u32, &numbers).into_iter().map(Arc::new).collect()
}

/// A number of a state; those beyond its edges are what the chain started with.
fn number(
    state: &State,
    seed: u32,
    fresh: &(impl Fn(u32, u32, u32) -> [f32; 2] + Sync),
    [edge, pair]: [u32; 2],
) -> [f32; 2] {
    state.get(place(edge, pair)).copied().unwrap_or_else(|| fresh(seed, edge, pair))
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

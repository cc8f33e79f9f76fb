// SPDX-License-Identifier: GPL-3.0-or-later
//! The search for a lamp from a rough point: walks from chosen surfaces, the light of the first that arrives, and the count of
//! walks until one arrives there again.
//! Source: [ZGJ20] sections 4.1 (seeds), 4.3 (unbiased counts); the light of a solution by the generalized geometry term
//! [JM12], which the derivatives of rays give directly. Space: world.
//! Invariant: a search depends on its path's key only. Tests: crates/render/tests/caustics.rs.

use glam::Vec3;
use gnurt_accel::Ray;
use gnurt_shading::bsdf::{Bsdf, ClosureBatch, left_after};
use gnurt_shading::lights::{LampPoint, LightId, Place};
use gnurt_shading::{SampleKey, SurfaceBatch, SurfacePoint};

use super::chain::{self, area_of};
use super::known::Caustics;
use super::smooth::SmoothPoint;
use super::trace::{Goes, Last, MOST, Trace, Turns};
use super::trials::Trials;
use super::walk::{Miss, Newton, Next, Solution};
use crate::options::RenderOptions;
use crate::transport::flight::Random;
use crate::transport::opacity;
use crate::world::World;

/// Square of the difference of a directional lamp's direction before and after glass up to which `transport::panes` finds it.
const AS_PANES: f32 = 1e-6;

/// The chance that a walk begins straight towards the lamp: panes and globes bend light little.
const STRAIGHT: f32 = 0.25;

/// World, options and surfaces of all searches.
#[derive(Clone, Copy)]
pub(super) struct Around<'a> {
    pub(super) world: &'a World,
    pub(super) options: &'a RenderOptions,
    pub(super) caustics: &'a Caustics,
}

/// The rough point, where a path from the camera ends.
#[derive(Clone, Debug)]
pub(crate) struct Rough {
    /// Its number among the points of its owner.
    pub(crate) number: usize,
    /// Of the path: its key, its edges, the factor of its light.
    pub(crate) key: SampleKey,
    pub(crate) edges: u32,
    pub(crate) throughput: Vec3,
    pub(crate) point: SurfacePoint,
    pub(crate) bsdf: Bsdf,
    /// Unit, to where the path came from.
    pub(crate) wo: Vec3,
    /// How many scattered rays leave it, on average.
    pub(crate) rays: f32,
    /// The chance of the search.
    pub(crate) chance: f32,
}

/// Light that a search found, unless it is blocked before the last surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Found {
    pub(super) light: Vec3,
    /// The second moment of that light by scattered rays alone, for a path of throughput 1.
    pub(super) by_chance: f32,
    pub(super) turns: Turns,
    pub(super) materials: [u32; MOST],
    /// Unit, where the chain begins.
    pub(crate) dir: Vec3,
    pub(super) last: Last,
    pub(super) lamp: LightId,
    /// To the lamp.
    pub(super) ray: Ray,
    solution: Solution,
}

/// The next event of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Waits {
    /// The hit of its ray.
    Hit,
    /// Whether its light is blocked.
    Shadow,
    Nothing,
}

/// A search.
pub(super) struct Search {
    pub(super) rough: Rough,
    pub(super) lamp: LampPoint,
    /// Of its choice.
    probability: f32,
    random: Random,
    pub(super) trace: Trace,
    newton: Newton,
    pub(super) found: Option<Found>,
    trials: Trials,
    pub(super) waits: Waits,
}

impl Search {
    pub(super) fn new(around: Around, rough: Rough, (lamp, probability): (LampPoint, f32)) -> Self {
        let Rough { key, edges, .. } = rough;
        let random = Random::of_caustic(around.options.seed, key, edges);
        let nowhere = Ray::new([0.0; 3], [0.0; 3]);
        let trace = Trace::new(nowhere, key, Vec3::ZERO, None, 0);
        let (newton, trials) = (Newton::new(), Trials::new());
        let (found, waits) = (None, Waits::Nothing);
        let mut search = Self { rough, lamp, probability, random, trace, newton, found, trials, waits };
        search.begin(around);
        search
    }

    /// How often the light counts.
    pub(super) fn count(&self) -> f32 {
        self.trials.count
    }

    /// Begins walks until one has a ray to send.
    pub(super) fn begin(&mut self, around: Around) {
        loop {
            let p = self.rough.point.p;
            let straight = self.random.next() < STRAIGHT;
            let dir = match self.lamp.place {
                Place::At(lamp) if straight => (lamp - p).try_normalize(),
                Place::Towards(dir) if straight => Some(dir),
                place => {
                    let start = around.caustics.start(around.world, (p, place), &mut self.random);
                    start.and_then(|start| (start - p).try_normalize())
                }
            };
            self.newton = Newton::new();
            if dir.is_some_and(|dir| self.follow(around, dir, None)) {
                return;
            }
            if !self.is_repeated() {
                return;
            }
        }
    }

    /// After a walk failed: whether to make another one.
    fn is_repeated(&mut self) -> bool {
        let random = &mut self.random;
        let again = self.found.is_some() && self.trials.fails(|| random.next());
        if !again {
            self.waits = Waits::Nothing;
        }
        again
    }

    fn fails(&mut self, around: Around) {
        if self.is_repeated() {
            self.begin(around);
        }
    }

    /// Follows a chain in a direction, if light may come from there.
    fn follow(&mut self, around: Around, dir: Vec3, planned: Option<Turns>) -> bool {
        let Rough { point, bsdf, key, edges, .. } = &self.rough;
        let transmitted = bsdf.is_transmitted(dir);
        if transmitted && !bsdf.is_translucent() {
            return false;
        }
        let Some(ray) = point.scatter_ray(dir, transmitted, f32::INFINITY) else { return false };
        let most = (around.options.max_depth - edges - 1).min(MOST as u32) as usize;
        self.trace = Trace::new(ray, *key, bsdf.absorption(dir), planned, most);
        self.waits = Waits::Hit;
        true
    }

    /// The ray met nothing.
    pub(super) fn misses(&mut self, around: Around) {
        let goes = self.trace.leaves();
        self.goes(around, goes);
    }

    /// The ray met point `k`.
    pub(super) fn meets(
        &mut self,
        around: Around,
        (points, closures): (&SurfaceBatch, &ClosureBatch),
        k: usize,
    ) {
        let edges = self.rough.edges + 1 + self.trace.turns.count as u32;
        if closures.is_partly_transparent()
            && !opacity::is_met(around.options.seed, self.trace.key, edges, closures.coverage(k))
        {
            self.trace.layers += 1;
            self.trace.key = opacity::key_beyond(self.trace.key);
            self.trace.light *= closures.passing(k);
            self.trace.ray = points.spawn(k, points.ray_dir.get(k), f32::INFINITY);
            if self.trace.layers > opacity::MOST_LAYERS {
                self.goes(around, Goes::Lost);
            }
            return;
        }
        let at = SmoothPoint::of((around.world, around.caustics), (points, closures), k);
        let goes = match at {
            None => self.trace.leaves(),
            Some(at) => {
                let material = around.world.material_of(points.leaf_id[k], points.geom_id[k]);
                let met = [points.leaf_id[k], points.geom_id[k], points.prim_id[k]];
                self.trace.turn(&at, (points.inst_id[k], material, met, points.front(k)), &mut self.random)
            }
        };
        self.goes(around, goes);
    }

    fn goes(&mut self, around: Around, goes: Goes) {
        if self.trace.is_new()
            && let Some(found) = &self.found
        {
            // Others cannot arrive where it did.
            let is_ended = goes == Goes::Ended;
            let turns = self.trace.turns;
            if !turns.begin(found.turns) || (is_ended && turns != found.turns) {
                return self.fails(around);
            }
        }
        let next = match goes {
            Goes::On => return,
            Goes::Lost if self.trace.is_new() => Next::Failed,
            Goes::Lost => self.newton.failed(),
            Goes::Ended => match Miss::of(&self.trace, self.lamp.place) {
                None => Next::Failed,
                Some(miss) => match self.newton.ended(&self.trace, &miss) {
                    Next::Arrived => return self.arrives(around, &miss),
                    next => next,
                },
            },
        };
        self.proceeds(around, next);
    }

    fn proceeds(&mut self, around: Around, mut next: Next) {
        let turns = self.trace.planned_or_made();
        while let Next::Follow(dir) = next {
            if self.follow(around, dir, Some(turns)) {
                return;
            }
            next = self.newton.failed();
        }
        self.fails(around);
    }

    /// A chain ends at the lamp.
    fn arrives(&mut self, around: Around, miss: &Miss) {
        match &self.found {
            Some(found) if found.solution.is(&self.trace) => self.waits = Waits::Nothing,
            Some(_) => self.fails(around),
            None => {
                self.found = self.light(around, miss);
                self.waits = if self.found.is_some() { Waits::Shadow } else { Waits::Nothing };
            }
        }
    }

    /// The light along the chain, but for what blocks it from the lamp.
    fn light(&self, around: Around, miss: &Miss) -> Option<Found> {
        let (trace, rough, probability) = (&self.trace, &self.rough, self.probability);
        let last = trace.last?;
        if self.is_of_panes() {
            return None;
        }
        let lamp = around.world.light_set().intensity(&self.lamp, trace.heading, miss.dist);
        let (value, density) = rough.bsdf.eval_pdf(rough.wo, trace.dir);
        let spread = area_of(&trace.change, trace.heading, miss.dist).recip();
        let (mut weight, mut of_chance) = (spread / (rough.chance * probability), f32::INFINITY);
        let on_lamp = match self.lamp.place {
            Place::At(p) => around.world.light_set().area_across(self.lamp.light, p, trace.heading),
            Place::Towards(_) => None,
        };
        if let Some(area) = on_lamp {
            // Scattered rays find it, too.
            let scattered = rough.rays * density;
            let searched = probability / (area * spread);
            of_chance = (weight * rough.chance).powi(2) * searched / scattered;
            weight *= chain::weight(scattered / rough.chance, searched);
        }
        let left = left_after(miss.dist, [last.absorption, Vec3::ZERO]);
        let scattered = value * trace.light * lamp * left;
        let light = rough.throughput * scattered * weight;
        let by_chance = scattered.max_element().powi(2) * of_chance;
        if light == Vec3::ZERO || !light.is_finite() {
            return None;
        }
        let ray = last.point.shadow_ray(trace.heading, miss.dist, last.transmitted)?;
        Some(Found {
            light,
            by_chance,
            turns: trace.turns,
            materials: trace.materials,
            dir: trace.dir,
            last,
            lamp: self.lamp.light,
            ray,
            solution: Solution::new(trace, miss),
        })
    }

    /// Whether light samples find the light through glass (`transport::panes`).
    fn is_of_panes(&self) -> bool {
        let (trace, rough) = (&self.trace, &self.rough);
        let goes_through = trace.turns.through == (1 << trace.turns.count) - 1;
        if !self.lamp.delta || !goes_through || rough.bsdf.absorption(trace.dir) != Vec3::ZERO {
            return false;
        }
        match self.lamp.place {
            Place::At(_) => trace.is_straight,
            Place::Towards(dir) => trace.dir.distance_squared(dir) <= AS_PANES,
        }
    }
}

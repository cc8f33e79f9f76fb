// SPDX-License-Identifier: GPL-3.0-or-later
//! Searches of all points of one shader, side by side: the rays of each round are traced together.
//! Searches of paths that were scattered before are made by chance, and count more: their noise is seen less.
//! Space: world. Tests: crates/render/tests/caustics.rs.

use glam::Vec3;
use gnurt_accel::{Coherence, HitBatch, RayBatch};
use gnurt_scene::RayMask;
use gnurt_shading::bsdf::ClosureBatch;
use gnurt_shading::sampling::{purpose, sample_pair};
use gnurt_shading::{RayRequest, SampleKey, Vec3s};

use super::search::{Around, Rough, Search, Waits};
use crate::cone::Cones;
use crate::expressions::{Lobe, Scatter};
use crate::tracer::{AttributeRequests, BatchTracer};
use crate::transport::add;
use crate::transport::step::{Met, Onward};
use crate::world::HitLanes;

/// Adds the light of lamps behind smooth surfaces to points that paths met.
pub(crate) fn connect(tracer: &mut BatchTracer, met: &Met, onward: &mut Onward) {
    let Some(caustics) = met.caustics.filter(|_| !met.is_final) else { return };
    let around = Around { world: met.world, options: met.options, caustics };
    let mut searches = searches(met, around);
    let mut waiting: Vec<u32> = (0..searches.len() as u32).collect();
    let mut round = Round::default();
    loop {
        waiting.retain(|&i| searches[i as usize].waits == Waits::Hit);
        if waiting.is_empty() {
            break;
        }
        round.follow(tracer, around, &waiting, &mut searches);
        round.blocked(tracer, around, &waiting, &mut searches);
    }
    for search in &searches {
        deposit(met, search, onward);
    }
}

/// The searches of all points that make one.
fn searches(met: &Met, around: Around) -> Vec<Search> {
    let (options, lights) = (met.options, met.world.light_set());
    let mut searches = Vec::new();
    for k in 0..met.numbers.len() {
        let path = met.path(k);
        if path.edges + 2 > options.max_depth || !met.is_there(k, &path) || met.is_hidden(k, &path) {
            continue;
        }
        let chance = path.chain.chance(path.throughput);
        let [choice, by_chance] = sample_pair(options.seed, path.key, path.edges, purpose::CAUSTIC);
        if by_chance >= chance {
            continue;
        }
        let bsdf = met.closures.point(k).bsdf;
        if !bsdf.is_smooth() {
            continue;
        }
        let u = sample_pair(options.seed, path.key, path.edges, purpose::CAUSTIC_POSITION);
        let Some((lamp, probability)) = around.caustics.lamp(lights, choice, u) else { continue };
        let rough = Rough {
            k,
            path,
            point: met.points.point(k),
            bsdf,
            wo: -met.points.ray_dir.get(k),
            chance,
            probability,
        };
        searches.push(Search::new(around, rough, lamp));
    }
    searches
}

/// The rays of one round.
#[derive(Default)]
struct Round {
    rays: RayBatch,
    keys: Vec<SampleKey>,
    hits: HitBatch,
    order: Vec<u64>,
    closures: ClosureBatch,
    through: Vec3s,
}

impl Round {
    /// Traces the rays of the searches that wait for hits.
    fn follow(&mut self, tracer: &mut BatchTracer, around: Around, waiting: &[u32], searches: &mut [Search]) {
        let Self { rays, keys, hits, order, closures, .. } = self;
        rays.clear();
        keys.clear();
        for search in waiting.iter().map(|&i| &searches[i as usize]) {
            rays.push(search.trace.ray);
            keys.push(search.trace.key);
        }
        tracer.stats.secondary_rays += rays.len() as u64;
        tracer.intersect_into(RayMask::OTHER, rays, keys, Coherence::Incoherent, hits);
        for (lane, &i) in waiting.iter().enumerate() {
            if hits.get(lane).is_none() {
                searches[i as usize].misses(around);
            }
        }
        around.world.sort_by_material(hits, 0..rays.len(), order);
        // Others only end chains.
        order.retain(|&entry| {
            let (material, lane) = ((entry >> 32) as u32, entry as u32 as usize);
            let is_one = around.caustics.is_smooth(material)
                || !around.world.materials().get(material as usize).is_solid;
            if !is_one {
                searches[waiting[lane] as usize].misses(around);
            }
            is_one
        });
        let no_width = Cones::default();
        let from = HitLanes { rays, keys, hits, cones: Some(&no_width), depth: 1 };
        tracer.for_each_surface_of(order, from, AttributeRequests::Light, |tracer, shader, lanes, points| {
            tracer.closures_of(shader, points, closures);
            for (k, &lane) in lanes.iter().enumerate() {
                searches[waiting[lane as usize] as usize].meets(around, (points, closures), k);
            }
        });
    }

    /// Finds out whether the light of searches that arrived is blocked, and lets the others count.
    fn blocked(
        &mut self,
        tracer: &mut BatchTracer,
        around: Around,
        waiting: &[u32],
        searches: &mut [Search],
    ) {
        let mut request = RayRequest::default();
        for &i in waiting {
            let search = &searches[i as usize];
            if let Some(found) = search.found.filter(|_| search.waits == Waits::Shadow) {
                request.rays.push(found.ray);
                request.parent.push(i);
                request.key.push(search.rough.path.key);
            }
        }
        tracer.passed(&request, (None, None), &mut self.through);
        for (k, &i) in request.parent.iter().enumerate() {
            let search = &mut searches[i as usize];
            let Some(found) = &mut search.found else { continue };
            found.light *= self.through.get(k);
            if found.light == Vec3::ZERO {
                search.waits = Waits::Nothing;
            } else {
                search.begin(around);
            }
        }
    }
}

/// Adds the light that a search found.
fn deposit(met: &Met, search: &Search, onward: &mut Onward) {
    let Some(found) = search.found else { return };
    let (rough, k) = (&search.rough, search.rough.k);
    let path = &rough.path;
    if let Some(linked) = &onward.linked
        && !linked.links.reaches(search.lamp.light, found.last.inst_id)
    {
        return;
    }
    let edges = path.edges + found.turns.count as u32 + 1;
    let light = add(onward.radiance, path.lane, found.light * search.count(), edges, met.options.clamp);
    if let Some(recorder) = &mut onward.recorder {
        recorder.found(path.trail, light);
    }
    if let Some(seen) = &mut onward.seen {
        seen.add(path.lane, light, (path.scattered + 1, edges));
    }
    if let Some(ledger) = &mut onward.ledger {
        let end = ledger.paths.classes.light(search.lamp.light, met.world.light_set());
        let how = (rough.bsdf.is_transmitted(found.dir), false);
        let here = met.events(ledger, k, [rough.wo, found.dir], how);
        let turn = |at: usize| -> [(Scatter, Vec3); 1] {
            let is_through = found.turns.through >> at & 1 != 0;
            [(ledger.paths.classes.scatter(found.materials[at], is_through, Lobe::Singular), Vec3::ONE)]
        };
        let turns: Vec<_> = (0..found.turns.count).map(turn).collect();
        let events: Vec<&[(Scatter, Vec3)]> =
            std::iter::once(&here[..]).chain(turns.iter().map(|turn| &turn[..])).collect();
        ledger.found_beyond(met.numbers[k] as usize, &events, (path.lane, light), end);
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Searches of many points, side by side: the rays of each round are traced together.
//! Space: world. Tests: crates/render/tests/caustics.rs.

use glam::Vec3;
use gnurt_accel::{Coherence, HitBatch, RayBatch};
use gnurt_scene::RayMask;
use gnurt_shading::bsdf::ClosureBatch;
use gnurt_shading::sampling::{purpose, sample_pair};
use gnurt_shading::{RayRequest, SampleKey, SurfacePoint, Vec3s};

use super::chain::Chain;
use super::known::Caustics;
use super::places::Searched;
use super::search::{Around, Found, Rough, Search, Waits};
use crate::cone::Cones;
use crate::options::RenderOptions;
use crate::space_tree::class_of;
use crate::tracer::{AttributeRequests, BatchTracer};
use crate::world::HitLanes;

/// The chance of a search from a point that a path ends at, by its chain, key, edges and factor of light; `None` if it makes none.
pub(crate) fn chance_of(
    (options, caustics): (&RenderOptions, &Caustics),
    (chain, key, edges, throughput): (&Chain, SampleKey, u32, Vec3),
    point: &SurfacePoint,
) -> Option<f32> {
    let chance = chain.chance(caustics, throughput, point);
    let [_, by_chance] = sample_pair(options.seed, key, edges, purpose::CAUSTIC);
    (edges + 2 <= options.max_depth && by_chance < chance).then_some(chance)
}

/// Searches from these points; calls `with` for each that found light, with the light.
pub(crate) fn search(
    tracer: &mut BatchTracer,
    caustics: &Caustics,
    points: impl Iterator<Item = Rough>,
    mut with: impl FnMut(&Rough, &Found, Vec3),
) {
    let around = Around { world: tracer.world, options: tracer.options, caustics };
    let lights = around.world.light_set();
    let mut searches: Vec<Search> = points
        .filter_map(|rough| {
            let [choice, _] = sample_pair(around.options.seed, rough.key, rough.edges, purpose::CAUSTIC);
            let u = sample_pair(around.options.seed, rough.key, rough.edges, purpose::CAUSTIC_POSITION);
            Some(Search::new(around, rough, caustics.lamp(lights, choice, u)?))
        })
        .collect();
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
        let light = search.found.as_ref().map_or(Vec3::ZERO, |found| found.light * search.count());
        if let Some(found) = &search.found {
            with(&search.rough, found, light);
        }
        if let Some(searched) = &mut tracer.searched {
            let Rough { point, throughput, chance, .. } = &search.rough;
            let throughput = throughput.max_element();
            let light = light.max_element() * chance / throughput;
            let by_chance = search.found.as_ref().map_or(0.0, |found| found.by_chance * search.count());
            let spared = by_chance * throughput * throughput / chance;
            if light.is_finite() {
                searched.push(Searched { p: point.p, class: class_of(point.ng), light, spared });
            }
        }
    }
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
                request.key.push(search.rough.key);
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

// SPDX-License-Identifier: GPL-3.0-or-later
//! Light of lamps behind smooth surfaces at the stops of walks from the eye: searches, and their weight beside scattered rays.
//! Virtual lights bring such light on from where it falls; of that a stop adds what they leave to rays.
//! Source: as `transport::manifold`. Space: world. Tests: crates/render/tests/caustics.rs.

use gnurt_shading::Vec3s;
use gnurt_shading::bsdf::BsdfSample;

use super::walk::{Stop, Walk};
use crate::tracer::BatchTracer;
use crate::transport::Vertex;
use crate::transport::manifold::{self, Caustics, Chain, Rough};
use crate::transport::step::is_hole;

/// Adds the light that searches find.
pub(super) fn search(tracer: &mut BatchTracer, stops: &[Stop], radiance: &mut Vec3s) {
    let Some(caustics) = tracer.caustics else { return };
    let (world, options) = (tracer.world, tracer.options);
    let points = stops.iter().enumerate().filter_map(|(number, stop)| {
        let Stop { walk, eye, instance, .. } = stop;
        if is_hole(world, walk.edges, *instance) || !eye.bsdf.is_smooth() {
            return None;
        }
        let of_walk = (&walk.chain, walk.key, walk.edges, walk.throughput);
        let chance = manifold::chance_of((options, caustics), of_walk, &eye.point)?;
        Some(Rough {
            number,
            key: walk.key,
            edges: walk.edges,
            throughput: walk.throughput,
            point: eye.point,
            bsdf: eye.bsdf.clone(),
            wo: eye.wo,
            rays: stop.mean_rays(),
            chance,
        })
    });
    manifold::search(tracer, caustics, points, |rough, found, light| {
        let stop = &stops[rough.number];
        radiance.add(stop.walk.lane as usize, light * stop.rest(found.dir));
    });
}

/// The smooth surfaces behind a walk that goes on from a stop.
pub(super) fn chain(caustics: Option<&Caustics>, stop: &Stop, sample: &BsdfSample) -> Chain {
    let Some(caustics) = caustics else { return Chain::default() };
    let Walk { chain, start, throughput, .. } = stop.walk;
    if sample.delta {
        let turn = (sample.wi, sample.transmitted);
        return manifold::turned(stop.smooth.as_deref(), (start, -stop.eye.wo), turn, chain);
    }
    chain.rough(stop.mean_rays() * sample.pdf, chain.chance(caustics, throughput, &stop.eye.point))
}

/// The weight of a surface that a walk met, if it is a lamp that searches may find, too.
pub(super) fn beside_searches(tracer: &BatchTracer, walk: &Walk, vertex: &Vertex) -> f32 {
    let Some(caustics) = tracer.caustics else { return 1.0 };
    let edge = (walk.start, vertex.point.p, -vertex.wo);
    walk.chain.beside_searches((tracer.world.light_set(), caustics), vertex.ids, edge)
}

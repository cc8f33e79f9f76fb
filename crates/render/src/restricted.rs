// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays and lights that shaders restrict by name: sets of objects that rays may hit, categories of lights.
//! Other objects are passed one by one along the same ray. The light of many triangles is sampled as a whole, and
//! triangles of other categories bring nothing, so the mean is that of the category.
//! Tests: crates/render/tests/restricted.rs.

use gnurt_accel::{Coherence, Hit, HitBatch, INVALID_ID, RayBatch};
use gnurt_scene::RayMask;
use gnurt_shading::sampling::purpose;
use gnurt_shading::{LightBatch, RayRequest, SampleKey, SurfaceBatch, Tracer, Vec3s};

use crate::tracer::BatchTracer;
use crate::world::{LightPart, Names, World, are_called};

/// Surfaces of other sets that a ray passes; behind more it hits nothing.
const MOST_PASSED: usize = 4096;

const MISS: Hit = Hit {
    t: f32::INFINITY,
    u: 0.0,
    v: 0.0,
    prim_id: INVALID_ID,
    geom_id: INVALID_ID,
    inst_id: INVALID_ID,
    leaf_id: INVALID_ID,
};

/// Closest hits of the rays of a request with the objects that they may hit.
pub(crate) fn closest_hits(tracer: &mut BatchTracer, kind: RayMask, request: &RayRequest) -> HitBatch {
    let mut hits = tracer.intersect(kind, &request.rays, &request.key, Coherence::Incoherent);
    let Some(set) = request.set.as_deref().filter(|set| !set.is_empty()) else { return hits };
    let mut open: Vec<usize> = (0..request.rays.len()).collect();
    let mut rays = RayBatch::default();
    let mut keys: Vec<SampleKey> = Vec::new();
    for passed in 0.. {
        let passes = |lane: &usize| hits.get(*lane).is_some_and(|hit| !may_hit(tracer.world, set, &hit));
        open.retain(passes);
        if open.is_empty() {
            break;
        }
        if passed == MOST_PASSED {
            open.iter().for_each(|&lane| hits.set(lane, MISS));
            break;
        }
        rays.clear();
        keys.clear();
        for &lane in &open {
            // The next float: the same hit is not found again.
            let ray = request.rays.get(lane);
            rays.push(ray.within(hits.t[lane].next_up(), ray.t_far));
            keys.push(request.key[lane]);
        }
        let behind = tracer.intersect(kind, &rays, &keys, Coherence::Incoherent);
        for (i, &lane) in open.iter().enumerate() {
            match behind.get(i) {
                Some(hit) => hits.set(lane, hit),
                None => hits.set(lane, MISS),
            }
        }
    }
    hits
}

fn may_hit(world: &World, set: &str, hit: &Hit) -> bool {
    let object = world.leaf(hit.leaf_id).1.0;
    match world.names() {
        Some(names) => names.may_hit(set, hit.inst_id, object),
        None => set.starts_with('-'),
    }
}

/// Light of the light `light`, as far as it is of a category.
pub(crate) fn illuminate_in(
    tracer: &mut BatchTracer,
    category: &str,
    light: usize,
    hits: &SurfaceBatch,
    out: &mut LightBatch,
) {
    out.reset(hits.len());
    let world = tracer.world;
    let (label, is_negated) = match category.strip_prefix('-') {
        Some(label) => (label, true),
        None => (category, false),
    };
    let has_category = |names: &[&Names]| are_called(label, names) != is_negated;
    let known = world.labels();
    // Virtual lights bring the light of all lights.
    if light >= world.lights().shaders.len() {
        return;
    }
    let counts = match world.lights().part(light) {
        LightPart::Shapes(shapes) => {
            let mut normal = Vec3s::default();
            (0..hits.len()).for_each(|i| normal.push(hits.facing_ns(i)));
            let purpose = purpose::LIGHT + light as u32;
            let random: Vec<_> =
                hits.key.iter().map(|&key| tracer.random(key, hits.depth, purpose)).collect();
            let nothing = Names::default();
            let counts = |shape: u32| {
                let [leaf, mesh, _] = world.lights().shape_ids()[shape as usize];
                let material = known.materials.get(world.material_of(leaf, mesh) as usize);
                let instance = world.tree().instance_at(leaf).and_then(|(id, _)| known.instances.get(&id));
                has_category(&[instance.unwrap_or(&nothing), material.unwrap_or(&nothing)])
            };
            shapes.illuminate_some((&hits.p, &normal), &random, counts, out);
            return;
        }
        LightPart::WithoutExtent(number) => {
            let names = known.lights_of_scene.get(number).and_then(|&number| known.lights.get(number));
            has_category(&names.into_iter().collect::<Vec<_>>())
        }
        LightPart::Plugin => has_category(&[]),
        LightPart::Environment => has_category(&[&known.environment]),
    };
    if counts {
        tracer.illuminate(light, hits, out);
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Delta lights through smooth glass. A blocked shadow ray is refracted in and out along the only path from
//! the light. Directional light counts if it leaves all glass in its original direction, as after panes with
//! two faces; point and spot lights only through glass without refraction. A path is a function of the
//! sample's point and direction, and no other technique finds that light, so it counts in full times the
//! transmittance of the glass. Lights that scattered rays can hit are left to scattered rays: to find them
//! here, too, costs more than it gains (bench/record/light-2026-11-24.md). The same holds for dispersive
//! glass, glass with several directions, and reflections.
//! Space: world. Invariant: the result depends on the sample and its key only.
//! Tests: crates/render/tests/panes.rs.

use glam::Vec3;
use gnurt_accel::{Coherence, HitBatch, INVALID_ID, Ray, RayBatch};
use gnurt_scene::RayMask;
use gnurt_shading::bsdf::{ClosureBatch, left_after};
use gnurt_shading::{RayRequest, SampleKey, SurfaceBatch, Vec3s};

use super::flight::{Parts, Random};
use super::{Known, opacity};
use crate::cone::Cones;
use crate::tracer::{AttributeRequests, BatchTracer};
use crate::world::{HitLanes, Inside, Media};

/// Square of how far a unit direction may be off that still counts as unbent.
const UNBENT: f32 = 1e-10;
/// The same of light from one direction after all glass: a sixteenth of a degree.
const SAME: f32 = 1e-6;

/// A path that is followed.
#[derive(Clone, Copy)]
struct StraightPath {
    /// Which ray of the request it is of.
    ray: usize,
    /// Edges up to the light so far.
    edges: u32,
    /// Where the light comes from, if that is a direction.
    towards: Option<Vec3>,
    /// Transmittance so far.
    left: Vec3,
    /// Start of its last segment, and the absorption there.
    start: Vec3,
    absorption: Vec3,
    /// The bodies with media that it is in.
    inside: Inside,
    /// Whether it has passed glass yet; and the number of transparent parts.
    is_through: bool,
    layers: u32,
}

/// Paths that take a step together.
#[derive(Default)]
struct Ways {
    rays: RayBatch,
    keys: Vec<SampleKey>,
    straight_paths: Vec<StraightPath>,
}

impl Ways {
    fn push(&mut self, ray: Ray, key: SampleKey, straight_path: StraightPath) {
        self.rays.push(ray);
        self.keys.push(key);
        self.straight_paths.push(straight_path);
    }
}

/// Adds light through glass to the light that reaches the lights directly, by ray of the request. `emitters`
///
/// are the rays to delta lights that begin outside of absorbing media, with the edges up to these lights, and
/// the bodies with media that paths fly through in which they begin.
pub(crate) fn trace_through(
    tracer: &mut BatchTracer,
    request: &RayRequest,
    media: Option<&Media>,
    emitters: impl Iterator<Item = (usize, u32, Inside)>,
    through: &mut Vec3s,
) {
    let world = tracer.world;
    if !world.materials().has_panes() {
        return;
    }
    let mut these = Ways::default();
    for (ray, edges, inside) in emitters.filter(|&(ray, ..)| through.get(ray) != Vec3::ONE) {
        let shadow = request.rays.get(ray);
        let towards = (!shadow.t_far.is_finite()).then_some(Vec3::from(shadow.dir));
        let (left, start, absorption) = (Vec3::ONE, shadow.org.into(), Vec3::ZERO);
        let straight_path = StraightPath {
            ray,
            edges,
            towards,
            left,
            start,
            absorption,
            inside,
            is_through: false,
            layers: 0,
        };
        these.push(shadow, request.key[ray], straight_path);
    }
    let (mut hits, mut order, no_width) = Default::default();
    let mut closures = std::mem::take(&mut tracer.closures);
    while !these.straight_paths.is_empty() {
        let Ways { rays, keys, .. } = &these;
        tracer.stats.shadow_rays += rays.len() as u64;
        tracer.intersect_into(RayMask::SHADOW, rays, keys, Coherence::Incoherent, &mut hits);
        if let Some(media) = media {
            these.dim((media, tracer.options.seed), &hits);
        }
        let Ways { rays, keys, straight_paths } = &these;
        for (i, straight_path) in straight_paths
            .iter()
            .enumerate()
            .filter(|&(i, straight_path)| is_free(hits.prim_id[i], straight_path))
        {
            through
                .set(straight_path.ray, through.get(straight_path.ray) + beyond(straight_path, &rays.get(i)));
        }
        world.sort_by_material(&hits, 0..rays.len(), &mut order);
        order.retain(|&entry| {
            let material = world.materials().get((entry >> 32) as usize);
            material.is_clear || !material.is_solid
        });
        let cones: &Cones = &no_width;
        let from = HitLanes { rays, keys, hits: &hits, cones: Some(cones), depth: 1 };
        let mut next = Ways::default();
        tracer.for_each_surface_of(
            &order,
            from,
            AttributeRequests::Light,
            |tracer, shader, lanes, points| {
                if tracer.closures_of(shader, points, &mut closures) != Known::Closures {
                    return;
                }
                for (k, &lane) in lanes.iter().enumerate() {
                    let (straight_path, lane) = (&straight_paths[lane as usize], lane as usize);
                    let (ray, key) = (rays.get(lane), keys[lane]);
                    if let Some((ray, key, straight_path)) =
                        ahead((tracer, media), (straight_path, &ray, key), (points, &closures, k))
                    {
                        next.push(ray, key, straight_path);
                    }
                }
            },
        );
        these = next;
    }
    tracer.closures = closures;
}

impl Ways {
    /// Applies media up to the hits of paths.
    fn dim(&mut self, (media, seed): (&Media, u64), hits: &HitBatch) {
        let mut parts = Parts::default();
        for (i, path) in self.straight_paths.iter_mut().enumerate() {
            let ray = self.rays.get(i);
            let length = if hits.prim_id[i] == INVALID_ID { ray.t_far } else { hits.t[i] };
            media.parts(path.inside, ray.org.into(), ray.dir.into(), &mut parts);
            // Apart from the numbers of shadow rays along the same edges.
            let number = [path.edges, 0x8000_0000 | path.layers];
            let mut random = Random::of_shadow(seed, self.keys[i], number);
            path.left *= parts.transmittance(length, &mut random);
        }
    }
}

/// Whether a path through glass has no further hit; a path without glass is covered by the shadow ray.
fn is_free(prim_id: u32, straight_path: &StraightPath) -> bool {
    prim_id == INVALID_ID && straight_path.is_through
}

/// Transmittance of a path without a further hit.
fn beyond(straight_path: &StraightPath, ray: &Ray) -> Vec3 {
    if straight_path.towards.is_some_and(|towards| towards.distance_squared(ray.dir.into()) > SAME) {
        return Vec3::ZERO;
    }
    straight_path.left * left_after(ray.t_far, [straight_path.absorption, Vec3::ZERO])
}

/// The continuation from point `k`, if there is one.
fn ahead(
    (tracer, media): (&BatchTracer, Option<&Media>),
    (straight_path, ray, key): (&StraightPath, &Ray, SampleKey),
    (points, closures, k): (&SurfaceBatch, &ClosureBatch, usize),
) -> Option<(Ray, SampleKey, StraightPath)> {
    let (p, dir) = (points.p.get(k), Vec3::from(ray.dir));
    let medium = media.map_or(0, |media| media.of_points(tracer.world, points));
    let behind = if medium == 0 {
        straight_path.inside
    } else {
        straight_path.inside.crossing(medium, points.front(k))
    };
    if closures.is_partly_transparent()
        && !opacity::is_met(tracer.options.seed, key, straight_path.edges, closures.coverage(k))
    {
        let onward = opacity::rest(ray, points.spawn(k, dir, f32::INFINITY));
        let left = straight_path.left * closures.passing(k);
        let next = StraightPath { layers: straight_path.layers + 1, inside: behind, left, ..*straight_path };
        return (straight_path.layers < opacity::MOST_LAYERS).then_some((
            onward,
            opacity::key_beyond(key),
            next,
        ));
    }
    if straight_path.edges >= tracer.options.max_depth {
        return None;
    }
    let bsdf = closures.point(k).bsdf;
    let (wi, share) = bsdf.straight(-dir)?;
    if straight_path.towards.is_none() && wi.distance_squared(dir) > UNBENT {
        return None;
    }
    let onward = points.point(k).scatter_ray(wi, true, f32::INFINITY)?;
    let onward = if straight_path.towards.is_none() { opacity::rest(ray, onward) } else { onward };
    let (gone, absorption) = if media.is_none() {
        let ends = [straight_path.absorption, closures.medium(k).on(true)];
        (left_after((p - straight_path.start).length(), ends), bsdf.absorption(wi))
    } else {
        (Vec3::ONE, Vec3::ZERO)
    };
    let left = straight_path.left * gone * share;
    Some((
        onward,
        key,
        StraightPath {
            edges: straight_path.edges + 1,
            left,
            start: p,
            absorption,
            inside: behind,
            is_through: true,
            ..*straight_path
        },
    ))
}

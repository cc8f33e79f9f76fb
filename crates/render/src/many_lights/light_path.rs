// SPDX-License-Identifier: GPL-3.0-or-later
//! Paths that start at lights, many at a time: every surface that they meet is a virtual light.
//! Source: [Kel97] (quasi-random walks); particles under shading normals [Vea97] section 5.3. Space: world.
//! Invariant: a path is a function of its numbers, not of the paths beside it.
//! Proof: crates/render/tests/many_lights.rs.

use glam::Vec3;
use gnurt_accel::{Coherence, RayBatch};
use gnurt_shading::SampleKey;
use gnurt_shading::lights::LightKind;

use super::vpl::{Vpl, is_open};
use crate::tracer::BatchTracer;

/// Where a path's random numbers come from: path, edge (0 = the lamp), and which pair of that edge.
pub(crate) type Numbers<'a> = dyn Fn(u32, u32, u32) -> [f32; 2] + 'a;

/// A vertex of a light path.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightVertex {
    /// Which path.
    pub(crate) path: u32,
    pub(crate) vpl: Vpl,
    /// Density per area with which the path's last vertex chose this one; infinite behind mirrors and smooth glass.
    /// For the first vertex that of start and direction.
    pub(crate) pdf: f32,
    /// Whether other ways of making the same path can: its lamp has an extent, no mirror sent it here.
    pub(crate) connectable: bool,
    /// Density with which a lamp's sampling would have chosen the path's start, seen from here; 1 after the first edge.
    pub(crate) reverse: f32,
    /// Probability that the path goes on from here.
    pub(crate) survival: f32,
}

/// Random numbers of an edge: pairs 0 and 1 choose a direction, 2 a place on a lamp and the lamp, 3 decides about the end.
pub(crate) mod pair {
    pub(crate) const DIRECTION: u32 = 0;
    pub(crate) const LOBE: u32 = 1;
    pub(crate) const PLACE: u32 = 2;
}

struct Walk {
    path: u32,
    power: Vec3,
    edges: u32,
    pdf: f32,
    smooth: bool,
    origin: Vec3,
    is_far: bool,
    /// The lamp's triangle and normal, on the first edge.
    lamp: Option<(u32, Vec3)>,
}

/// Follows `paths` (numbers of paths) up to `max_edges`; vertices come edge by edge, in the order of the paths.
pub(crate) fn trace(
    tracer: &mut BatchTracer,
    paths: std::ops::Range<u32>,
    numbers: &Numbers,
    max_edges: u32,
) -> Vec<LightVertex> {
    let world = tracer.world;
    let lights = world.light_set();
    let (mut rays, mut keys, mut walks) = (RayBatch::default(), Vec::new(), Vec::new());
    if max_edges == 0 {
        return Vec::new();
    }
    for path in paths {
        let [choice, _] = numbers(path, 0, pair::LOBE);
        let Some(ray) = lights.emit(choice, numbers(path, 0, pair::PLACE), numbers(path, 0, pair::DIRECTION))
        else {
            continue;
        };
        rays.push(ray.point.spawn(ray.dir, f32::INFINITY));
        keys.push(key(path));
        walks.push(Walk {
            path,
            power: ray.radiance_over_pdf,
            edges: 1,
            pdf: ray.pdf_pos * ray.pdf_dir,
            smooth: ray.is_surface,
            origin: ray.point.p,
            is_far: !ray.is_surface,
            lamp: match ray.kind {
                LightKind::Triangle(triangle) => Some((triangle, ray.normal)),
                _ => None,
            },
        });
    }
    let mut out = Vec::new();
    while !rays.is_empty() {
        let coherence = Coherence::Incoherent;
        let found = tracer.follow(&rays, &keys, walks[0].edges, coherence);
        let (mut next_rays, mut next_keys, mut next_walks) = (RayBatch::default(), Vec::new(), Vec::new());
        for (walk, vertex) in walks.iter().zip(found) {
            let Some(vertex) = vertex.filter(|vertex| !vertex.is_final) else { continue };
            let (point, bsdf, from) = (vertex.point, vertex.scattering.bsdf, vertex.wo);
            if !(is_open(&point, from) && point.ng.dot(from) > 0.0) {
                continue;
            }
            let per_area = if walk.is_far {
                // A point light's density of place is a probability, a directional one's of direction.
                f32::INFINITY
            } else {
                walk.pdf * point.ng.dot(from).abs() / (point.p - walk.origin).length_squared()
            };
            let vpl = Vpl::new(point, bsdf, from, walk.power, walk.edges);
            let [lobe, end] = numbers(walk.path, walk.edges, pair::LOBE);
            let direction = numbers(walk.path, walk.edges, pair::DIRECTION);
            let survival = survival(bsdf.albedo(from), walk.edges);
            out.push(LightVertex {
                path: walk.path,
                vpl,
                pdf: per_area,
                connectable: walk.smooth && per_area.is_finite(),
                reverse: walk.lamp.map_or(1.0, |(triangle, normal)| {
                    let dist = (walk.origin - point.p).length();
                    let seen = lights.pdf_triangle(point.p, Vec3::ZERO, triangle, from, dist);
                    seen * normal.dot(from).abs() / (dist * dist)
                }),
                survival,
            });
            if walk.edges >= max_edges || end >= survival {
                continue;
            }
            let Some(sample) = bsdf.sample(from, [lobe, direction[0], direction[1]]) else { continue };
            if (point.ng.dot(sample.wi) > 0.0) == sample.transmitted {
                continue;
            }
            let adjoint = bsdf.adjoint_correction(from, sample.wi, point.ng);
            let power = walk.power * sample.weight * (adjoint / survival);
            if power == Vec3::ZERO || !power.is_finite() {
                continue;
            }
            next_rays.push(point.spawn(sample.wi, f32::INFINITY));
            next_keys.push(key(walk.path).fork(walk.edges));
            next_walks.push(Walk {
                path: walk.path,
                power,
                edges: walk.edges + 1,
                pdf: if sample.delta { f32::INFINITY } else { sample.pdf * survival },
                smooth: !sample.delta,
                origin: point.p,
                is_far: false,
                lamp: None,
            });
        }
        (rays, keys, walks) = (next_rays, next_keys, next_walks);
    }
    out
}

/// Probability that a path goes on: not below its albedo, and surely for the first bounces.
fn survival(albedo: Vec3, edges: u32) -> f32 {
    if edges < 3 { 1.0 } else { albedo.max_element().clamp(0.1, 0.95) }
}

fn key(path: u32) -> SampleKey {
    SampleKey { pixel: path, sample: 0, branch: 0x5eed }
}

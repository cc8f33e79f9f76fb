// SPDX-License-Identifier: GPL-3.0-or-later
//! Finds smooth surfaces and lamps: materials by their closures at some points, lamps by their size.
//! Space: world. Invariant: a function of the world and of options that do not depend on pieces or threads.
//! Tests: crates/render/tests/caustics.rs.

use glam::Vec3;
use gnurt_accel::{HitBatch, Ray, RayBatch};
use gnurt_shading::bsdf::ClosureBatch;
use gnurt_shading::lights::{LightId, LightKind, LightSet};
use gnurt_shading::{Detail, SampleKey, SurfaceBatch};

use super::known::{Caustics, Part};
use crate::options::{Caustics as Choice, Integrator};
use crate::tracer::BatchTracer;
use crate::transport::Known;
use crate::world::{HitLanes, PlacedMesh};

/// Points of a material that are tried, and meshes that they are on.
const TRIED: usize = 16;
/// `auto`: an area that is this share of the squared distance to the farthest smooth surface is a small lamp.
const SMALL: f32 = 0.01;

/// What searches know of the tracer's world; `None` where its options want none, or they would find nothing.
pub(crate) fn find(tracer: &mut BatchTracer) -> Option<Caustics> {
    let (world, options) = (tracer.world, tracer.options);
    let integrator = options.integrator;
    let searches = integrator == Integrator::Path || integrator.has_virtual_lights();
    if !searches || options.caustics == Choice::Off {
        return None;
    }
    let lights = world.light_set();
    let has_lamps = (0..lights.len() as u32).any(|i| lights.kind(LightId(i)) != LightKind::Environment);
    // Media between surfaces are left to scattered rays.
    if !has_lamps || !world.media().is_empty() {
        return None;
    }
    let smooth = smooth_materials(tracer);
    let meshes = world.meshes_of(|material| smooth.get(material).copied().unwrap_or(false));
    let is_lamp = |shapes: std::ops::Range<usize>, parts: &[Part]| {
        options.caustics == Choice::On || is_small(lights, shapes, parts)
    };
    Caustics::new(lights, (smooth, meshes), is_lamp)
}

/// Materials with a mirror or smooth glass at one of some points.
fn smooth_materials(tracer: &mut BatchTracer) -> Vec<bool> {
    let world = tracer.world;
    let mut of_material: Vec<Vec<PlacedMesh>> = Vec::new();
    for mesh in world.meshes_of(|_| true) {
        let material = mesh.material as usize;
        if of_material.len() <= material {
            of_material.resize_with(material + 1, Vec::new);
        }
        if of_material[material].len() < TRIED {
            of_material[material].push(mesh);
        }
    }
    let (mut points, mut closures) = (SurfaceBatch::default(), ClosureBatch::default());
    let mut is_smooth = |(material, meshes): (usize, &Vec<PlacedMesh>)| {
        let (mut rays, mut hits) = (RayBatch::default(), HitBatch::default());
        hits.reset(if meshes.is_empty() { 0 } else { TRIED });
        let keys: Vec<SampleKey> =
            (0..TRIED as u32).map(|sample| SampleKey { pixel: 0, sample, branch: 0 }).collect();
        for i in 0..hits.len() {
            let mesh = &meshes[i % meshes.len()];
            let number = |by: f64| ((i as f64 + 0.5) * by).fract() as f32;
            let Some(point) = world.point_on(mesh, [number(0.618_034), number(0.754_877), number(0.569_840)])
            else {
                return false;
            };
            let away = mesh.radius.max(f32::MIN_POSITIVE);
            rays.push(Ray::new((point.p + point.normal * away).into(), (-point.normal).into()));
            (hits.t[i], hits.u[i], hits.v[i]) = (away, point.uv[0], point.uv[1]);
            (hits.prim_id[i], hits.geom_id[i]) = (point.prim_id, mesh.geom_id);
            (hits.inst_id[i], hits.leaf_id[i]) = (mesh.inst_id, mesh.leaf_id);
        }
        let lanes: Vec<u32> = (0..hits.len() as u32).collect();
        let shader = world.shader(material);
        if lanes.is_empty() || shader.radiance().is_some() {
            return false;
        }
        let from = HitLanes { rays: &rays, keys: &keys, hits: &hits, cones: None, depth: 1 };
        let setup = (tracer.options.level, tracer.options.ray_epsilon);
        world.surface_points().surface_points(
            setup,
            from,
            &lanes,
            Detail::Full,
            shader.attributes(),
            &mut points,
        );
        points.camera = tracer.properties;
        tracer.closures_of(shader, &points, &mut closures) == Known::Closures
            && (0..lanes.len()).any(|k| closures.point(k).bsdf.has_deltas())
    };
    of_material.iter().enumerate().map(&mut is_smooth).collect()
}

/// Whether emissive shapes of one mesh are a small lamp as smooth surfaces see it.
fn is_small(lights: &LightSet, shapes: std::ops::Range<usize>, parts: &[Part]) -> bool {
    let (mut area, mut center, mut count) = (0.0, Vec3::ZERO, 0.0);
    for (of_shape, middle) in shapes.filter_map(|i| lights.extent(i as u32)) {
        area += of_shape;
        center += middle;
        count += 1.0;
    }
    let center = center / count;
    let farthest = parts.iter().map(|part| part.square_distance(center)).fold(0.0, f32::max);
    area < SMALL * farthest
}

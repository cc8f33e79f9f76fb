// SPDX-License-Identifier: GPL-3.0-or-later
//! Colours of visible surfaces by the kind of their scattering: the light 1 from all sides, without shadows.
//! They replace the light of some layers. A surface that is there in part covers that share of a ray; the rest goes
//! straight on. Media cover nothing. Space: world. Tests: crates/render/tests/light_layers.rs.

use glam::Vec3;
use gnurt_accel::{Coherence, RayBatch};
use gnurt_scene::RayMask;
use gnurt_shading::bsdf::ClosureBatch;
use gnurt_shading::{SampleKey, Vec3s};

use crate::cone::Cones;
use crate::expressions::LightLayer;
use crate::tracer::{AttributeRequests, BatchTracer};
use crate::transport::opacity::MOST_LAYERS;
use crate::world::HitLanes;

/// Less of a ray is not followed.
const LEAST: f32 = 1e-4;

/// Rays behind surfaces that are there in part.
#[derive(Default)]
struct Rest {
    rays: RayBatch,
    keys: Vec<SampleKey>,
    /// The camera ray of each, and its share.
    lanes: Vec<(usize, f32)>,
}

/// Replaces the light of those layers that are colours.
pub(crate) fn fill(tracer: &mut BatchTracer, layers: &[LightLayer], camera: HitLanes, light: &mut [Vec3s]) {
    let wanted: Vec<(usize, [bool; 4])> =
        layers.iter().enumerate().filter_map(|(layer, of)| Some((layer, of.color()?))).collect();
    if wanted.is_empty() {
        return;
    }
    wanted.iter().for_each(|&(layer, _)| light[layer].reset(camera.keys.len(), Vec3::ZERO));
    let mut add = |lane: usize, share: f32, parts: [Vec3; 4]| {
        for (layer, counts) in &wanted {
            let color: Vec3 =
                parts.iter().zip(counts).filter(|(_, counts)| **counts).map(|(part, _)| *part).sum();
            light[*layer].add(lane, color * share);
        }
    };
    let mut rest = gather(tracer, camera, |lane| (lane, 1.0), &mut add);
    // Opacity textures are read without filtering.
    let cones = Cones::default();
    for _ in 0..MOST_LAYERS {
        if rest.keys.is_empty() {
            break;
        }
        let Rest { rays, keys, lanes } = &rest;
        tracer.stats.secondary_rays += keys.len() as u64;
        let hits = tracer.intersect(RayMask::OTHER, rays, keys, Coherence::Coherent);
        let from = HitLanes { rays, keys, hits: &hits, cones: Some(&cones), depth: 1 };
        rest = gather(tracer, from, |lane| lanes[lane], &mut add);
    }
}

/// Adds the colours of some hits; `of` gives the camera ray of a lane and its share. Returns the rest.
fn gather(
    tracer: &mut BatchTracer,
    from: HitLanes,
    of: impl Fn(usize) -> (usize, f32),
    add: &mut impl FnMut(usize, f32, [Vec3; 4]),
) -> Rest {
    let (mut rest, mut closures) = (Rest::default(), ClosureBatch::default());
    tracer.for_each_surface(from, AttributeRequests::Light, |_, shader, lanes, points| {
        closures.reset(points.len());
        shader.evaluate(points, &mut closures);
        for (k, &lane) in lanes.iter().enumerate() {
            let (pixel, share) = of(lane as usize);
            let scattering = closures.point(k);
            let coverage = scattering.coverage.clamp(0.0, 1.0);
            let parts = scattering.bsdf.albedo_parts(-points.ray_dir.get(k));
            if coverage > 0.0 && parts.iter().all(|part| part.is_finite()) {
                add(pixel, share * coverage, parts);
            }
            let left = share * (1.0 - coverage);
            if left > LEAST {
                rest.rays.push(points.spawn(k, points.ray_dir.get(k), f32::INFINITY));
                rest.keys.push(from.keys[lane as usize]);
                rest.lanes.push((pixel, left));
            }
        }
    });
    rest
}

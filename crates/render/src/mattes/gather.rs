// SPDX-License-Identifier: GPL-3.0-or-later
//! The things that camera rays meet, and the share of each ray that they cover.
//! A surface that is there in part covers that share, and the rest goes straight on. Samples are placed by the
//! picture's filter, through its lens and at the time of the ray: mattes are filtered and blurred as the picture is.
//! Media cover nothing. Source: [FJ16]. Space: world. Tests: crates/render/tests/mattes.rs.

use std::ops::Range;

use gnurt_accel::{Coherence, RayBatch};
use gnurt_scene::RayMask;
use gnurt_shading::SampleKey;
use gnurt_shading::bsdf::ClosureBatch;

use super::kinds::MatteKind;
use super::tile::TileMattes;
use crate::cone::Cones;
use crate::tracer::{AttributeRequests, BatchTracer};
use crate::world::HitLanes;

/// Surfaces that are there in part, along one ray.
const MOST_LAYERS: u32 = 256;
/// Less of a ray is not followed.
const LEAST: f32 = 1e-4;

/// Rays behind surfaces that are there in part.
#[derive(Default)]
struct Rest {
    rays: RayBatch,
    keys: Vec<SampleKey>,
    pixels: Vec<usize>,
    /// What is left of each.
    shares: Vec<f32>,
}

/// Adds the hits of one sample of each pixel: of the lanes in `range`.
pub(crate) fn gather(
    tracer: &mut BatchTracer,
    kinds: &[MatteKind],
    camera: HitLanes,
    range: Range<usize>,
    mattes: &mut TileMattes,
) {
    let first = range.start;
    let mut rest = cover(tracer, kinds, (camera, range), |lane| (lane - first, 1.0), mattes);
    // Opacity textures are read without filtering.
    let cones = Cones::default();
    for _ in 0..MOST_LAYERS {
        if rest.keys.is_empty() {
            break;
        }
        let Rest { rays, keys, pixels, shares } = &rest;
        tracer.stats.secondary_rays += keys.len() as u64;
        let hits = tracer.intersect(RayMask::CAMERA, rays, keys, Coherence::Coherent);
        let from = HitLanes { rays, keys, hits: &hits, cones: Some(&cones), depth: 1 };
        let of = |lane: usize| (pixels[lane], shares[lane]);
        rest = cover(tracer, kinds, (from, 0..keys.len()), of, mattes);
    }
}

/// Adds hits; `of` gives the pixel of a lane and the share of its ray. Returns the rest.
fn cover(
    tracer: &mut BatchTracer,
    kinds: &[MatteKind],
    (from, range): (HitLanes, Range<usize>),
    of: impl Fn(usize) -> (usize, f32),
    mattes: &mut TileMattes,
) -> Rest {
    let (mut rest, mut closures) = (Rest::default(), ClosureBatch::default());
    tracer.for_each_surface_in(range, from, AttributeRequests::Light, |tracer, shader, lanes, points| {
        let world = tracer.world;
        let material = world.material_of(points.leaf_id[0], points.geom_id[0]);
        let is_solid = world.materials().get(material as usize).is_solid;
        if !is_solid {
            closures.reset(points.len());
            shader.evaluate_traced(tracer, points, &mut closures);
        }
        for (k, &lane) in lanes.iter().enumerate() {
            let (pixel, share) = of(lane as usize);
            let coverage = if is_solid { 1.0 } else { closures.stopped(k) };
            if coverage > 0.0 {
                let ids = world.matte_ids(points.inst_id[k], material);
                for (kind, which) in kinds.iter().enumerate() {
                    mattes.add(kind, pixel, ids[*which as usize], share * coverage);
                }
            }
            let left = share * (1.0 - coverage);
            if left > LEAST {
                rest.rays.push(points.spawn(k, points.ray_dir.get(k), f32::INFINITY));
                rest.keys.push(from.keys[lane as usize]);
                rest.pixels.push(pixel);
                rest.shares.push(left);
            }
        }
    });
    rest
}

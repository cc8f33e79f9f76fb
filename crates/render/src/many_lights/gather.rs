// SPDX-License-Identifier: GPL-3.0-or-later
//! All virtual lights on all points that a tile of camera rays sees.
//! Source: [Kel97]; rays that share the virtual light and neighbouring ends are traced together, as [WKB*02] and the paper's
//! section 7 want it. Space: world.
//! Flow: points become arrays once; for each virtual light one pass over them in lanes (`lanes.rs`), one by one where lanes do
//! not know a BSDF; one batch of shadow rays; sums.
//! Proof: crates/render/tests/many_lights.rs.

use glam::Vec3;
use gnurt_accel::RayBatch;
use gnurt_shading::sampling::sample_pair;
use gnurt_shading::{RayRequest, SampleKey, Tracer, Vec3s};
use gnurt_simd::dispatch;

use super::bound::Bound;
use super::cut::{MOST, cut};
use super::eye::EyePoint;
use super::lanes::{BLOCK, Block, END, Light, Source, Work};
use super::vpl::{self, Vpl};
use crate::tracer::BatchTracer;

/// Purpose of the number that chooses virtual lights for a tile.
const CUT: u32 = 0x6000;

/// Gathers; adds to `radiance` by lane.
pub(crate) fn gather(
    tracer: &mut BatchTracer,
    points: &[EyePoint],
    keys: &[SampleKey],
    vpls: &[Vpl],
    bound: &Bound,
    radiance: &mut Vec3s,
) {
    if points.is_empty() || vpls.is_empty() {
        return;
    }
    let max_edges = tracer.options.max_depth;
    let [u, _] = sample_pair(tracer.options.seed, keys[points[0].lane as usize], 0, CUT);
    let fewer = cut(points, vpls, MOST, u);
    let vpls = fewer.as_deref().unwrap_or(vpls);
    let with_facets = vpls.iter().any(|vpl| vpl.diffuse.is_none());
    let new_block = |chunk| Block::new(chunk, max_edges, with_facets);
    let blocks: Vec<Block> = points.chunks(BLOCK).map(new_block).collect();
    let mut sums = vec![Vec3::ZERO; points.len()];
    let mut lights: Vec<Light> = blocks.iter().map(Light::on).collect();
    let mut work = Box::<Work>::default();
    // Origins of blocks that a light may reach follow each other here.
    let mut request = RayRequest { rays: RayBatch::with_capacity(points.len()), ..RayRequest::default() };
    let mut lit_blocks = Vec::with_capacity(blocks.len());
    let mut blocked = Vec::new();
    let mut through = Vec3s::default();
    let level = tracer.options.level;
    for vpl in vpls {
        let source = Source::new(vpl, bound);
        lit_blocks.clear();
        request.rays.clear();
        request.key.clear();
        for (n, (block, light)) in blocks.iter().zip(&mut lights).enumerate() {
            let first = n * BLOCK;
            let by_lanes = dispatch!(level, _simd => block.light(&source, &mut work, light));
            let lit = match by_lanes {
                Some(lit) => {
                    let others = block.other.iter().copied();
                    one_by_one(others, vpl, &points[first..], bound, max_edges, light) | lit
                }
                None => {
                    light.clear();
                    one_by_one(0..block.used, vpl, &points[first..], bound, max_edges, light)
                }
            };
            if lit {
                lit_blocks.push(n);
                let used = block.used;
                for k in 0..3 {
                    request.rays.org[k].extend_from_slice(&light.org[k][..used]);
                    request.rays.dir[k].extend_from_slice(&light.way[k][..used]);
                }
                request.rays.t_near.resize(request.rays.t_near.len() + used, 0.0);
                request.rays.t_far.extend_from_slice(&light.far[..used]);
            }
        }
        if lit_blocks.is_empty() {
            continue;
        }
        let rays = &request.rays;
        tracer.stats.shadow_rays += rays.t_far.iter().filter(|&&far| far > 0.0).count() as u64;
        if tracer.world.shading().all_solid {
            let cost_keys = if tracer.costs.is_some() { keys } else { &[] };
            tracer.occluded_batch(rays, &cost_keys_of(cost_keys, points, &lit_blocks), &mut blocked);
            let mut at = 0;
            for &n in &lit_blocks {
                let (block, light) = (&blocks[n], &lights[n]);
                let sums = &mut sums[n * BLOCK..n * BLOCK + block.used];
                for (i, sum) in sums.iter_mut().enumerate() {
                    if !blocked[at + i] {
                        *sum += Vec3::new(light.color[0][i], light.color[1][i], light.color[2][i]);
                    }
                }
                at += block.used;
            }
        } else {
            for &n in &lit_blocks {
                request
                    .key
                    .extend(points[n * BLOCK..][..blocks[n].used].iter().map(|p| keys[p.lane as usize]));
            }
            // Counted above, lanes without light left out.
            let counted = tracer.stats.shadow_rays;
            tracer.occluded(&request, &mut through);
            tracer.stats.shadow_rays = counted;
            let mut at = 0;
            for &n in &lit_blocks {
                let (block, light) = (&blocks[n], &lights[n]);
                for i in 0..block.used {
                    let color = Vec3::new(light.color[0][i], light.color[1][i], light.color[2][i]);
                    sums[n * BLOCK + i] += color * through.get(at + i);
                }
                at += block.used;
            }
        }
    }
    for (point, sum) in points.iter().zip(sums) {
        radiance.add(point.lane as usize, sum);
    }
}

/// Keys of the rays' pixels, if costs are counted.
fn cost_keys_of(keys: &[SampleKey], points: &[EyePoint], lit_blocks: &[usize]) -> Vec<SampleKey> {
    if keys.is_empty() {
        return Vec::new();
    }
    let of_block = |&n: &usize| points.chunks(BLOCK).nth(n).unwrap_or_default();
    lit_blocks.iter().flat_map(of_block).map(|point| keys[point.lane as usize]).collect()
}

/// The points where lanes do not know what a BSDF does.
fn one_by_one(
    which: impl Iterator<Item = usize>,
    vpl: &Vpl,
    points: &[EyePoint],
    bound: &Bound,
    max_edges: u32,
    light: &mut Light,
) -> bool {
    let mut lit = false;
    for i in which {
        light.far[i] = -1.0;
        let brought = vpl.brings(&points[i], bound, max_edges).filter(|brought| brought.is_finite());
        let color = brought.unwrap_or(Vec3::ZERO);
        for k in 0..3 {
            light.color[k][i] = color[k];
        }
        if brought.is_some() {
            lit = true;
            light.far[i] = END;
            let way = vpl.point.p - points[i].point.p;
            let start = vpl::start(&points[i].point, way).unwrap_or(points[i].point.p);
            let way = vpl::end(&vpl.point, -way) - start;
            for k in 0..3 {
                light.org[k][i] = start[k];
                light.way[k][i] = way[k];
            }
        }
    }
    lit
}

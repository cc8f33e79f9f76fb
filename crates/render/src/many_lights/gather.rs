// SPDX-License-Identifier: GPL-3.0-or-later
//! All virtual lights on all points that a tile of camera rays sees.
//! Source: [Kel97]; rays that share the virtual light and neighbouring ends are traced together, as [WKB*02] and the paper's
//! section 7 want it. Space: world.
//! Flow: points become arrays once; for each virtual light one pass over them in lanes (geometry, bound, Lambertian ends),
//! one by one where a BSDF is not Lambertian; one batch of shadow rays; sums.
//! Invariant: the lanes compute what `Vpl::brings` computes, up to rounding; every CPU level gives the same bits.
//! Proof: `tests::lanes_agree_with_single_points`, crates/render/tests/many_lights.rs.

use glam::Vec3;
use gnurt_accel::RayBatch;
use gnurt_shading::sampling::sample_pair;
use gnurt_shading::{RayRequest, SampleKey, Tracer, Vec3s};
use gnurt_simd::dispatch;

use super::bound::Bound;
use super::cut::{MOST, cut};
use super::eye::EyePoint;
use super::vpl::{self, Vpl};
use crate::tracer::BatchTracer;

/// Points per block: as many as rays that the tree takes at a time.
const BLOCK: usize = 64;

/// Purpose of the number that chooses virtual lights for a tile.
const CUT: u32 = 0x6000;

type Lanes = [f32; BLOCK];

/// Points as lanes.
struct Block {
    p: [Lanes; 3],
    /// Where rays start on the side of the normals.
    org: [Lanes; 3],
    /// Shading normals of the BSDFs, those of the mesh, geometric ones; where a point is lifted to the curved surface that
    /// the mesh stands for, the latter do not count.
    bent: [Lanes; 3],
    ns: [Lanes; 3],
    ng: [Lanes; 3],
    lifted: Lanes,
    /// Albedo / pi times throughput where the point is Lambertian.
    diffuse: [Lanes; 3],
    /// Most edges that a virtual light's path may have.
    most_edges: Lanes,
    /// Lanes that are not Lambertian.
    other: Vec<usize>,
    used: usize,
}

/// What one virtual light brings to a block.
struct Light {
    /// Where its rays start.
    org: [Lanes; 3],
    way: [Lanes; 3],
    /// 1 where there is light to be tested for shadow, -1 elsewhere: the ray's far end.
    far: Lanes,
    color: [Lanes; 3],
}

/// The virtual light as lanes see it.
#[derive(Clone, Copy)]
struct Source {
    p: Vec3,
    /// Where rays end on the side of the normals.
    end: Vec3,
    bent: Vec3,
    ng: Vec3,
    diffuse: Vec3,
    edges: f32,
    bound: f32,
}

impl Source {
    fn new(vpl: &Vpl, bound: &Bound) -> Self {
        Self {
            p: vpl.point.p,
            end: vpl::end(&vpl.point, vpl.point.ng),
            bent: vpl.bsdf.normal(),
            ng: vpl.point.ng,
            diffuse: vpl.diffuse.unwrap_or(Vec3::ZERO),
            edges: vpl.edges as f32,
            bound: bound.geometry_term(),
        }
    }
}

impl Block {
    fn new(points: &[EyePoint], max_edges: u32) -> Self {
        let zero = [[0.0; BLOCK]; 3];
        let mut block = Self {
            p: zero,
            org: zero,
            bent: zero,
            ns: zero,
            ng: zero,
            lifted: [0.0; BLOCK],
            diffuse: zero,
            most_edges: [-1.0; BLOCK],
            other: Vec::new(),
            used: points.len(),
        };
        for (i, eye) in points.iter().enumerate() {
            let point = &eye.point;
            // Lights below the horizon are left out later.
            let org = vpl::start(point, point.ns).unwrap_or(point.p);
            let lambertian = eye.bsdf.lambertian();
            let diffuse = lambertian.unwrap_or(Vec3::ZERO) * eye.throughput * std::f32::consts::FRAC_1_PI;
            for k in 0..3 {
                block.p[k][i] = point.p[k];
                block.org[k][i] = org[k];
                block.bent[k][i] = eye.bsdf.normal()[k];
                block.ns[k][i] = point.ns[k];
                block.ng[k][i] = point.ng[k];
                block.diffuse[k][i] = diffuse[k];
            }
            block.lifted[i] = f32::from(u8::from(point.lift != Vec3::ZERO));
            block.most_edges[i] = max_edges as f32 - 1.0 - eye.edges as f32;
            if lambertian.is_none() {
                block.other.push(i);
            }
        }
        block
    }
}

/// Rays end this share short of the far end: rounding of their own numbers.
pub(crate) const END: f32 = 1.0 - 8.0 * f32::EPSILON;

/// Lambertian virtual light on a block: a plain loop that becomes lanes. So there is no sum of floats in it, whose order would
/// keep the compiler from that.
#[inline(always)]
fn lambertian(block: &Block, source: &Source, light: &mut Light) -> bool {
    let mut lit = 0;
    let [px, py, pz] = &block.p;
    let [ox, oy, oz] = &block.org;
    let [bx, by, bz] = &block.bent;
    let [sx, sy, sz] = &block.ns;
    let [gx, gy, gz] = &block.ng;
    let [wx, wy, wz] = &mut light.way;
    let [r, g, b] = &mut light.color;
    for i in 0..BLOCK {
        let (x, y, z) = (source.p.x - px[i], source.p.y - py[i], source.p.z - pz[i]);
        let distance2 = x * x + y * y + z * z;
        let eye_b = bx[i] * x + by[i] * y + bz[i] * z;
        let eye_s = sx[i] * x + sy[i] * y + sz[i] * z;
        let eye_g = gx[i] * x + gy[i] * y + gz[i] * z;
        let vpl_b = -(source.bent.x * x + source.bent.y * y + source.bent.z * z);
        let vpl_g = -(source.ng.x * x + source.ng.y * y + source.ng.z * z);
        let over = 1.0 / (distance2 * distance2);
        // Both ways to choose the edge, as cosines over distance squared.
        let largest = (eye_b * vpl_g).max(vpl_b * eye_g.abs()) * over;
        let share = if largest > source.bound { source.bound / largest } else { 1.0 };
        let above = (eye_s > 0.0) & ((eye_g > 0.0) | (block.lifted[i] > 0.0));
        let sees = above & (eye_b > 0.0) & (vpl_g > 0.0);
        let lit_here = sees & (source.edges <= block.most_edges[i]) & (over < f32::INFINITY);
        let value = if lit_here { eye_b * vpl_g * over * share } else { 0.0 };
        light.far[i] = if lit_here { END } else { -1.0 };
        lit |= u32::from(value > 0.0);
        r[i] = value * block.diffuse[0][i] * source.diffuse.x;
        g[i] = value * block.diffuse[1][i] * source.diffuse.y;
        b[i] = value * block.diffuse[2][i] * source.diffuse.z;
        wx[i] = source.end.x - ox[i];
        wy[i] = source.end.y - oy[i];
        wz[i] = source.end.z - oz[i];
    }
    lit > 0
}

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
    let blocks: Vec<Block> = points.chunks(BLOCK).map(|chunk| Block::new(chunk, max_edges)).collect();
    let mut sums = vec![Vec3::ZERO; points.len()];
    let zero = [[0.0; BLOCK]; 3];
    let mut lights: Vec<Light> = blocks
        .iter()
        .map(|block| Light { org: block.org, way: zero, far: [-1.0; BLOCK], color: zero })
        .collect();
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
            let mut lit = false;
            if vpl.diffuse.is_some() {
                lit = dispatch!(level, _simd => lambertian(block, &source, light));
            } else {
                light.far = [-1.0; BLOCK];
                light.color = zero;
            }
            let first = n * BLOCK;
            if vpl.diffuse.is_none() {
                lit |= one_by_one(0..block.used, vpl, &points[first..], bound, max_edges, light);
            } else if !block.other.is_empty() {
                lit |=
                    one_by_one(block.other.iter().copied(), vpl, &points[first..], bound, max_edges, light);
            }
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

#[cfg(test)]
mod tests {
    use gnurt_shading::SurfacePoint;
    use gnurt_shading::bsdf::{Bsdf, Model};
    use gnurt_shading::sampling::{Basis, sample_pair, uniform_sphere};

    use super::*;

    fn random(n: u32, purpose: u32) -> [f32; 2] {
        sample_pair(5, SampleKey { pixel: n, sample: 0, branch: 0 }, 0, purpose)
    }

    /// A point somewhere in a cube, with a shading normal that is a little off.
    fn point(n: u32) -> SurfacePoint {
        let ([x, y], [z, tilt]) = (random(n, 0), random(n, 1));
        let ng = uniform_sphere(random(n, 2));
        let ns = (ng + Basis::around(ng).tangent * 0.3 * tilt).normalize();
        SurfacePoint { p: Vec3::new(x, y, z), error: 1e-6, ng, ns, lift: Vec3::ZERO }
    }

    fn lambert(n: u32, ns: Vec3) -> Bsdf {
        let [r, g] = random(n, 3);
        Bsdf::new(ns, Model::Lambert { albedo: Vec3::new(r, g, 0.5) })
    }

    #[test]
    fn lanes_agree_with_single_points() {
        let eyes: Vec<EyePoint> = (0..BLOCK as u32)
            .map(|n| {
                let point = point(n);
                let (wo, throughput) = (point.ns, Vec3::new(1.0, 0.5, 0.25));
                let bsdf = lambert(n, point.ns);
                EyePoint { point, wo, bsdf, throughput, edges: 1 + n % 3, lane: n }
            })
            .collect();
        let (max_edges, bound) = (6, Bound::on_geometry_term(3.0));
        let block = Block::new(&eyes, max_edges);
        let zero = [[0.0; BLOCK]; 3];
        let (mut lit, mut bounded) = (0, 0);
        for n in 1000..1100 {
            let point = point(n);
            let vpl = Vpl::new(point, lambert(n, point.ns), point.ns, Vec3::new(3.0, 2.0, 1.0), 2 + n % 3);
            let source = Source::new(&vpl, &bound);
            let mut light = Light { org: block.org, way: zero, far: [0.0; BLOCK], color: zero };
            lambertian(&block, &source, &mut light);
            for (i, eye) in eyes.iter().enumerate() {
                let wanted = vpl.brings(eye, &bound, max_edges).unwrap_or(Vec3::ZERO);
                let found = Vec3::new(light.color[0][i], light.color[1][i], light.color[2][i]);
                let off = (found - wanted).length() / wanted.length().max(1e-2);
                assert!(off < 1e-4, "light {n}, point {i}: {found} instead of {wanted}");
                assert_eq!(light.far[i] > 0.0, wanted != Vec3::ZERO, "light {n}, point {i}: asks for shadow");
                let free = vpl.brings(eye, &Bound::on_geometry_term(f32::INFINITY), max_edges);
                lit += u32::from(wanted != Vec3::ZERO);
                bounded += u32::from(free.is_some_and(|free| free.x > wanted.x * 1.01));
            }
        }
        assert!(lit > 200 && bounded > 20, "the test has something to test: {lit}, {bounded}");
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Walks of paths below surfaces, from where they enter to where they leave, many at a time.
//! Source: [CKB16], guided outwards as in [KD14]. Scattering below is even within a body; its albedo is that of a thick body's colour by [KC17]. A walk
//! meets only the surfaces of the object that it entered, whatever lies in it, and leaves by a white Lambertian
//! reflector. `below` has the steps of walks.
//! Space: world. Invariant: the result of a path depends on its ray and key only. Entry and exit are one vertex: walks
//! add no edges. Tests: crates/render/tests/subsurface.rs.

use glam::Vec3;
use gnurt_accel::{Coherence, INVALID_ID, Ray};
use gnurt_scene::RayMask;
use gnurt_scene::medium::single_albedo;
use gnurt_shading::SurfaceBatch;
use gnurt_shading::bsdf::{ClosureBatch, Entry, Lobe};
use gnurt_shading::phase::Phase;
use gnurt_shading::sampling::{Basis, cosine_hemisphere, purpose, sample_pair};

use super::below::{Walk, Walks};
use super::flight::Random;
use super::half_space::HalfSpace;
use super::opacity;
use super::paths::Paths;
use super::step::is_hole;
use crate::options::RenderOptions;
use crate::tracer::{AttributeRequests, BatchTracer};
use crate::world::{HitLanes, World};

/// Mean free paths that are not longer than this multiple of a point's rounding error have no walk.
const SHORTEST: f32 = 16.0;
/// Branch of a path's key: the choice to enter.
const ENTERING: u32 = 8;

impl Walks {
    /// Takes light below the surface out of the closures of one shader's points, and begins the walks of the paths that enter.
    /// Paths that are not scattered here do not enter.
    pub(crate) fn enter(
        &mut self,
        (world, options): (&World, &RenderOptions),
        (paths, from): (&Paths, HitLanes),
        (numbers, points): (&[u32], &SurfaceBatch),
        closures: &mut ClosureBatch,
    ) {
        self.shares.clear();
        for (k, &number) in numbers.iter().enumerate() {
            let key = from.keys[number as usize];
            let path = paths.get(number as usize, key);
            let wo = -points.ray_dir.get(k);
            let own = key.fork(ENTERING);
            let [u, _] = sample_pair(options.seed, own, path.edges, purpose::CHOICE);
            let shortest = SHORTEST * points.error.get(k).copied().unwrap_or(0.0);
            let (entry, share) = closures.enter(k, wo, u, shortest);
            self.shares.push(share);
            let Some(entry) = entry else { continue };
            let is_met = opacity::is_met(options.seed, key, path.edges, closures.coverage(k));
            let is_held = is_hole(world, path.edges, points.inst_id[k]);
            if !is_met || path.edges >= options.max_depth || is_held {
                continue;
            }
            let [x, y] = sample_pair(options.seed, own, path.edges, purpose::DIRECTION);
            let Some(dir) = inward(&entry, points.facing_ng(k), wo, [x, y]) else { continue };
            let ray = points.spawn(k, dir, f32::INFINITY);
            let phase = Phase { anisotropy: [entry.anisotropy, 0.0], second_share: 0.0 };
            let albedo = entry.albedo.to_array().map(|color| single_albedo(color, entry.anisotropy));
            let albedo = Vec3::from(albedo);
            let mut walk = Walk {
                number,
                leaf: points.leaf_id[k],
                key,
                org: ray.org.into(),
                dir,
                span: [0.0; 2],
                throughput: path.throughput * entry.weight,
                albedo,
                extinction: entry.radius.recip(),
                phase,
                events: 0,
                space: HalfSpace::new(points.facing_ng(k), albedo),
                outward_share: outward_share(entry.anisotropy),
                ratio: Vec3::ONE,
            };
            let mut random = Random::of_walk(options.seed, key, path.edges);
            walk.begin(&mut random);
            self.has_begun = true;
            self.list.push((walk, random));
        }
    }

    /// Follows all walks to where they leave, and calls `scatter(paths, rays and hits, numbers, points, closures)` for the points of each material there.
    pub(crate) fn leave(
        &mut self,
        tracer: &mut BatchTracer,
        paths: &mut Paths,
        from: HitLanes,
        mut scatter: impl FnMut(&Paths, HitLanes, &[u32], &SurfaceBatch, &ClosureBatch),
    ) {
        let Self { list, rays, keys, hits, leaving, white, .. } = self;
        leaving.begin(from);
        while !list.is_empty() {
            rays.clear();
            keys.clear();
            for (walk, _) in list.iter() {
                let [near, far] = walk.span;
                rays.push(Ray::new(walk.org.into(), walk.dir.into()).within(near, far));
                keys.push(walk.key);
            }
            tracer.stats.secondary_rays += rays.len() as u64;
            tracer.intersect_into(RayMask::ALL, rays, keys, Coherence::Incoherent, hits);
            let mut i = 0;
            list.retain_mut(|(walk, random)| {
                let lane = i;
                i += 1;
                if hits.prim_id[lane] == INVALID_ID {
                    return walk.is_scattered(random);
                }
                if hits.leaf_id[lane] != walk.leaf {
                    walk.span[0] = hits.t[lane].next_up();
                    return true;
                }
                walk.pass(hits.t[lane]);
                leaving.push(walk, (hits, lane));
                paths.set_throughput(walk.number as usize, walk.throughput);
                false
            });
        }
        let from = HitLanes {
            rays: &leaving.rays,
            keys: &leaving.keys,
            hits: &leaving.hits,
            cones: None,
            depth: from.depth + 1,
        };
        let count = leaving.hits.len();
        tracer.world.sort_by_material(&leaving.hits, 0..count, &mut leaving.order);
        let mut own = std::mem::take(&mut tracer.closures);
        tracer.for_each_surface_of(
            &leaving.order,
            from,
            AttributeRequests::Light,
            |_, shader, numbers, points| {
                own.reset(points.len());
                shader.evaluate(points, &mut own);
                white.reset(points.len());
                for k in 0..points.len() {
                    let normal = points.point(k).bent_normal(own.leaving_normal(k), -points.ray_dir.get(k));
                    white.set(k, normal, &[Lobe::lambert(Vec3::ONE)]);
                }
                scatter(paths, from, numbers, points, white);
            },
        );
        tracer.closures = own;
    }
}

/// The share of steps that are drawn outwards: as noisy with three quarters where scattering is even. Where light is
/// scattered forwards, few, for directions of the half space fit less.
fn outward_share(anisotropy: f32) -> f32 {
    let even = 1.0 - anisotropy.abs();
    0.5 * even * even
}

/// A direction into the body: with the density of the cosine, or bent by the index of refraction.
fn inward(entry: &Entry, ng: Vec3, wo: Vec3, u: [f32; 2]) -> Option<Vec3> {
    let n = entry.normal;
    let dir = if entry.ior > 1.0 {
        let cos = wo.dot(n).clamp(1e-3, 1.0);
        let along = (n * wo.dot(n) - wo) / entry.ior;
        let sin2 = (1.0 - cos * cos) / (entry.ior * entry.ior);
        along.normalize_or_zero() * sin2.sqrt() - n * (1.0 - sin2).sqrt()
    } else {
        -Basis::around(n).to_world(cosine_hemisphere(u))
    };
    // A bent normal may send it outwards: it is mirrored back.
    let outward = dir.dot(ng).max(0.0);
    (dir - ng * (2.0 * outward)).try_normalize()
}

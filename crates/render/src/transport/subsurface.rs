// SPDX-License-Identifier: GPL-3.0-or-later
//! Walks of paths below surfaces, from where they enter to where they leave, many at a time.
//! Source: [CKB16]. Scattering below is even within a body; its albedo is that of a thick body's colour by [KC17]. A walk
//! meets only the surfaces of the object that it entered, whatever lies in it, and leaves by a white Lambertian
//! reflector. Distances are drawn for one channel, weighted by the mean density of all channels [WND*14].
//! Space: world. Invariant: the result of a path depends on its ray and key only. Entry and exit are one vertex: walks
//! add no edges. Tests: crates/render/tests/subsurface.rs.

use glam::Vec3;
use gnurt_accel::{Coherence, HitBatch, INVALID_ID, Ray, RayBatch};
use gnurt_scene::RayMask;
use gnurt_scene::medium::single_albedo;
use gnurt_shading::bsdf::{ClosureBatch, Entry, Lobe};
use gnurt_shading::phase::Phase;
use gnurt_shading::sampling::{Basis, cosine_hemisphere, purpose, sample_pair};
use gnurt_shading::{SampleKey, SurfaceBatch};

use super::flight::Random;
use super::opacity;
use super::paths::Paths;
use crate::options::RenderOptions;
use crate::tracer::{AttributeRequests, BatchTracer};
use crate::world::{HitLanes, World};

/// Scattering events of one walk, at most: further light is lost. Of a white body that is 1 %.
const MOST_EVENTS: u32 = 4096;
/// Events after which walks end by chance.
const CERTAIN_EVENTS: u32 = 16;
/// Mean free paths that are not longer than this multiple of a point's rounding error have no walk.
const SHORTEST: f32 = 16.0;
/// Branches of a path's key: the choice to enter, and the path from where it leaves.
const ENTERING: u32 = 8;
const LEAVING: u32 = 9;

/// A walk.
#[derive(Clone, Copy)]
struct Walk {
    /// The number of its path.
    number: u32,
    /// The object that it is in.
    leaf: u32,
    key: SampleKey,
    org: Vec3,
    dir: Vec3,
    /// The part of the ray up to the next event that it has yet to go; an empty one begins at 0.
    span: [f32; 2],
    throughput: Vec3,
    albedo: Vec3,
    extinction: Vec3,
    phase: Phase<f32>,
    events: u32,
}

/// The walks of one step.
#[derive(Default)]
pub(crate) struct Walks {
    list: Vec<(Walk, Random)>,
    /// By point of the last shader: the factor of paths that other lobes scatter.
    pub(crate) shares: Vec<f32>,
    rays: RayBatch,
    keys: Vec<SampleKey>,
    hits: HitBatch,
    /// Where walks left: rays from outside that end there, in place of the paths' rays.
    leaving: Leaving,
    white: ClosureBatch,
}

/// Rays and hits of all paths of a step; those of walks that left have new ones.
#[derive(Default)]
struct Leaving {
    rays: RayBatch,
    keys: Vec<SampleKey>,
    hits: HitBatch,
    order: Vec<u64>,
}

impl Walks {
    /// Forgets all.
    pub(crate) fn begin(&mut self) {
        self.list.clear();
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Takes light below the surface out of the closures of one shader's points, and begins the walks of the paths that enter.
    /// Paths that are not scattered here do not enter.
    pub(crate) fn enter(
        &mut self,
        options: &RenderOptions,
        (paths, from): (&Paths, HitLanes),
        (numbers, points): (&[u32], &SurfaceBatch),
        closures: &mut ClosureBatch,
        is_held: impl Fn(usize) -> bool,
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
            if !is_met || path.edges >= options.max_depth || is_held(k) {
                continue;
            }
            let [x, y] = sample_pair(options.seed, own, path.edges, purpose::DIRECTION);
            let Some(dir) = inward(&entry, points.facing_ng(k), wo, [x, y]) else { continue };
            let ray = points.spawn(k, dir, f32::INFINITY);
            let phase = Phase { anisotropy: [entry.anisotropy, 0.0], second_share: 0.0 };
            let albedo = entry.albedo.to_array().map(|color| single_albedo(color, entry.anisotropy));
            let walk = Walk {
                number,
                leaf: points.leaf_id[k],
                key,
                org: ray.org.into(),
                dir,
                span: [0.0; 2],
                throughput: path.throughput * entry.weight,
                albedo: albedo.into(),
                extinction: entry.radius.recip(),
                phase,
                events: 0,
            };
            self.list.push((walk, Random::of_walk(options.seed, key, path.edges)));
        }
    }

    /// Follows all walks to where they leave, and calls `scatter(tracer, paths, rays and hits, numbers, points,
    /// closures)` for the points of each material there.
    pub(crate) fn leave(
        &mut self,
        tracer: &mut BatchTracer,
        paths: &mut Paths,
        from: HitLanes,
        mut scatter: impl FnMut(&mut BatchTracer, &Paths, HitLanes, &[u32], &SurfaceBatch, &ClosureBatch),
    ) {
        let Self { list, rays, keys, hits, leaving, white, .. } = self;
        leaving.begin(from);
        while !list.is_empty() {
            (rays.clear(), keys.clear());
            for (walk, random) in list.iter_mut() {
                if walk.span[0] >= walk.span[1] {
                    walk.span = [0.0, walk.distance(random)];
                }
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
        sort(tracer.world, &leaving.hits, &mut leaving.order);
        let mut own = std::mem::take(&mut tracer.closures);
        tracer.for_each_surface_of(
            &leaving.order,
            from,
            AttributeRequests::Light,
            |tracer, shader, numbers, points| {
                own.reset(points.len());
                shader.evaluate(points, &mut own);
                white.reset(points.len());
                for k in 0..points.len() {
                    let normal = points.point(k).bent_normal(own.leaving_normal(k), -points.ray_dir.get(k));
                    white.set(k, normal, &[Lobe::lambert(Vec3::ONE)]);
                }
                scatter(tracer, paths, from, numbers, points, white);
            },
        );
        tracer.closures = own;
    }
}

/// Sorts lanes by the materials of their hits.
fn sort(world: &World, hits: &HitBatch, order: &mut [u64]) {
    for lane in order.iter_mut() {
        let i = *lane as u32 as usize;
        *lane = u64::from(world.material_of(hits.leaf_id[i], hits.geom_id[i])) << 32 | i as u64;
    }
    order.sort_unstable();
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

impl Walk {
    /// Sum of the light of all channels.
    fn light(&self) -> f32 {
        self.throughput.element_sum()
    }

    /// The distance to the next event, drawn for a channel that is chosen by its light.
    fn distance(&self, random: &mut Random) -> f32 {
        let mut rest = random.next() * self.light();
        let mut channel = 0;
        while channel < 2 && rest >= self.throughput[channel] {
            rest -= self.throughput[channel];
            channel += 1;
        }
        let distance = -(1.0 - random.next()).ln() / self.extinction[channel];
        // A ray of no length would miss a surface that is there.
        distance.clamp(f32::MIN_POSITIVE, f32::MAX)
    }

    /// Accounts for a way of `t` without an event.
    fn pass(&mut self, t: f32) {
        let passed = self.throughput * (-self.extinction * t).exp();
        self.throughput = passed * (self.light() / passed.element_sum().max(f32::MIN_POSITIVE));
    }

    /// Goes to the next event and is scattered there; returns whether the walk goes on.
    fn is_scattered(&mut self, random: &mut Random) -> bool {
        let t = self.span[1];
        let met = self.throughput * self.extinction * (-self.extinction * t).exp();
        self.throughput = met * self.albedo * (self.light() / met.element_sum().max(f32::MIN_POSITIVE));
        self.events += 1;
        if self.events >= CERTAIN_EVENTS {
            let keep = self.throughput.max_element().min(1.0);
            if random.next() >= keep {
                return false;
            }
            self.throughput /= keep;
        }
        self.org += self.dir * t;
        let u = [random.next(), random.next(), random.next()];
        self.dir = Vec3::from(self.phase.sample(self.dir.into(), u).0);
        self.span = [0.0; 2];
        self.events < MOST_EVENTS && self.light() > 0.0 && self.throughput.is_finite()
    }
}

impl Leaving {
    fn begin(&mut self, from: HitLanes) {
        self.rays.clone_from(from.rays);
        self.keys.clear();
        self.keys.extend_from_slice(from.keys);
        self.hits.clone_from(from.hits);
        self.order.clear();
    }

    /// A walk that met its object from within at a hit: the path's ray now comes from the other side, as if it had hit that.
    fn push(&mut self, walk: &Walk, (hits, lane): (&HitBatch, usize)) {
        let (i, t) = (walk.number as usize, hits.t[lane]);
        let org = walk.org + walk.dir * (2.0 * t);
        for k in 0..3 {
            (self.rays.org[k][i], self.rays.dir[k][i]) = (org[k], -walk.dir[k]);
        }
        let to = &mut self.hits;
        (to.t[i], to.u[i], to.v[i]) = (t, hits.u[lane], hits.v[lane]);
        (to.prim_id[i], to.geom_id[i]) = (hits.prim_id[lane], hits.geom_id[lane]);
        (to.inst_id[i], to.leaf_id[i]) = (hits.inst_id[lane], hits.leaf_id[lane]);
        self.keys[i] = walk.key.fork(LEAVING);
        self.order.push(i as u64);
    }
}

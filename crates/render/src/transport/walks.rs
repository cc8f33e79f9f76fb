// SPDX-License-Identifier: GPL-3.0-or-later
//! Random walks whose vertices are processed one by one: from lights, from the eye to virtual lights, from
//! the pilot points. Each walk carries data of its owner from edge to edge. The search for the next surface
//! that stops it, the choice of a direction and the next ray are common to all walks. Paths that need no more
//! than `path` take their steps sixteen at a time: `step`.
//! Source: wavefronts after the paper's section 8. Space: world.
//! Invariant: the hits of a walk depend on its ray, key and random numbers only.
//! Tests: crates/render/tests/{many_lights,agreement}.rs.

use glam::Vec3;
use gnurt_accel::{Coherence, Ray, RayBatch};
use gnurt_scene::RayMask;
use gnurt_shading::bsdf::{Bsdf, BsdfSample, Carrying};
use gnurt_shading::{SampleKey, SurfacePoint};

use super::Vertex;
use super::opacity::{self, MOST_LAYERS};
use crate::cone::{Cone, Cones};
use crate::tracer::BatchTracer;
use crate::world::HitLanes;

/// Active walks, each with data of its owner.
#[derive(Clone)]
pub(crate) struct Walks<W> {
    pub(crate) rays: RayBatch,
    pub(crate) keys: Vec<SampleKey>,
    /// Numbers in [0, 1) that decide about transparency on the current edges, if walks have numbers of their
    /// own; else empty, and their keys decide.
    pub(crate) chances: Vec<f32>,
    /// `None` = those of camera rays.
    pub(crate) cones: Option<Cones>,
    pub(crate) carried: Vec<W>,
}

impl<W> Default for Walks<W> {
    fn default() -> Self {
        Self {
            rays: RayBatch::default(),
            keys: Vec::new(),
            chances: Vec::new(),
            cones: Some(Cones::default()),
            carried: Vec::new(),
        }
    }
}

/// Where rays stop.
#[derive(Default)]
pub(crate) struct Stops {
    /// By ray; `None` where it leaves the scene.
    pub(crate) vertices: Vec<Option<Vertex>>,
    /// The factors of light of what rays passed; empty if all are 1.
    passed: Vec<Vec3>,
}

impl Stops {
    /// Of no light so far, for this number of rays.
    pub(crate) fn none(count: usize) -> Self {
        let mut vertices = Vec::new();
        vertices.resize_with(count, || None);
        Self { vertices, passed: Vec::new() }
    }

    /// The factor of light that comes to a ray's origin from where it stops.
    pub(crate) fn passed(&self, ray: usize) -> Vec3 {
        self.passed.get(ray).copied().unwrap_or(Vec3::ONE)
    }

    /// Whether some factor is another than 1.
    pub(crate) fn is_tinted(&self) -> bool {
        !self.passed.is_empty()
    }

    /// Multiplies that factor.
    pub(crate) fn tint(&mut self, ray: usize, factor: Vec3) {
        if factor != Vec3::ONE {
            self.passed.resize(self.vertices.len(), Vec3::ONE);
            self.passed[ray] *= factor;
        }
    }
}

impl<W> Walks<W> {
    /// Appends one.
    pub(crate) fn push(&mut self, (ray, cone): (Ray, Cone), key: SampleKey, carried: W) {
        self.cones.get_or_insert_default().push(cone);
        self.rays.push(ray);
        self.keys.push(key);
        self.carried.push(carried);
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.carried.is_empty()
    }

    /// The vertex where each is stopped; `None` where it leaves the scene. `depth` counts edges.
    pub(crate) fn meet(&self, tracer: &mut BatchTracer, depth: u32) -> Stops {
        self.meet_all(tracer, depth, &mut |_, _| ())
    }

    /// The same; calls `passed` with each surface that emits and that a ray, by its lane, passes.
    pub(crate) fn meet_all(
        &self,
        tracer: &mut BatchTracer,
        depth: u32,
        passed: &mut dyn FnMut(usize, Vertex),
    ) -> Stops {
        if self.is_empty() {
            return Stops::default();
        }
        tracer.stats.secondary_rays += self.rays.len() as u64;
        let hits = tracer.intersect(RayMask::OTHER, &self.rays, &self.keys, Coherence::Incoherent);
        let (rays, keys, cones) = (&self.rays, &self.keys, self.cones.as_ref());
        let from = HitLanes { rays, keys, hits: &hits, cones, depth };
        tracer.stopped(from, &self.chances, passed)
    }
}

impl BatchTracer<'_> {
    /// Where each ray stops, given its hit. A partly transparent surface is passed at random, by
    /// the `chances` of the rays, or by their keys if there are none; `passed` gets those that emit, by their lanes.
    pub(crate) fn stopped(
        &mut self,
        from: HitLanes,
        chances: &[f32],
        passed: &mut dyn FnMut(usize, Vertex),
    ) -> Stops {
        let (depth, seed) = (from.depth, self.options.seed);
        let mut stops = Stops { vertices: self.vertices(from), passed: Vec::new() };
        // Vertices that may be transparent, with their keys and random numbers.
        let chance_of = |lane: usize| chances.get(lane).copied();
        let requests = from.keys.iter().enumerate();
        let mut requests: Vec<(usize, SampleKey, Option<f32>)> =
            requests.map(|(lane, &key)| (lane, key, chance_of(lane))).collect();
        for layer in 0.. {
            let mut beyond = Walks::default();
            for (lane, key, probability) in requests {
                let before = stops.passed(lane);
                let Some(vertex) = &mut stops.vertices[lane] else { continue };
                let coverage = vertex.scattering.coverage;
                if coverage >= 1.0 {
                    continue;
                }
                let number = probability.unwrap_or_else(|| opacity::probability(seed, key, depth));
                let Some(next) = opacity::passed(number, coverage) else { continue };
                if layer < MOST_LAYERS {
                    let straight = vertex.point.spawn(-vertex.wo, f32::INFINITY);
                    let carried = (lane, probability.map(|_| next));
                    beyond.push((straight, vertex.cone.straight()), opacity::key_beyond(key), carried);
                    let passing = vertex.scattering.passing;
                    if let Some(mut vertex) =
                        stops.vertices[lane].take_if(|vertex| vertex.scattering.emission != Vec3::ZERO)
                    {
                        vertex.scattering.emission *= before;
                        vertex.shown *= before;
                        passed(lane, vertex);
                    }
                    stops.tint(lane, passing);
                } else {
                    vertex.darken();
                }
            }
            if beyond.is_empty() {
                return stops;
            }
            let Walks { rays, keys, cones, carried, .. } = &beyond;
            self.stats.secondary_rays += rays.len() as u64;
            // Straight on: the rays are of one kind.
            let kind = if from.is_of_camera(0) { RayMask::CAMERA } else { RayMask::OTHER };
            let hits = self.intersect(kind, rays, keys, Coherence::Incoherent);
            let found = self.vertices(HitLanes { rays, keys, hits: &hits, cones: cones.as_ref(), depth });
            carried.iter().zip(found).for_each(|(&(lane, _), found)| stops.vertices[lane] = found);
            let met = beyond.carried.into_iter().zip(beyond.keys);
            requests = met.map(|((lane, probability), key)| (lane, key, probability)).collect();
        }
        stops
    }
}

/// The weight of light of this colour in the choice of a direction.
fn counted(bsdf: &Bsdf, light: Vec3) -> Vec3 {
    // A caller that computes densities does not know the light's weight: only without densities the choice of
    // colours depends on it.
    let by_light = bsdf.is_dispersed() && !bsdf.is_smooth();
    if by_light { light } else { Vec3::ONE }
}

/// The continuation of a walk from the eye whose light has this weight: a direction that the BSDF chooses,
/// and its ray.
pub(crate) fn scatter(
    point: &SurfacePoint,
    bsdf: &Bsdf,
    (wo, light): (Vec3, Vec3),
    u: [f32; 3],
) -> Option<(Ray, BsdfSample)> {
    let sample = bsdf.sample_by(wo, counted(bsdf, light), u)?;
    let ray = point.scatter_ray(sample.wi, sample.transmitted, f32::INFINITY)?;
    Some((ray, sample))
}

/// The same for a walk that carries this light from the unit direction `from`: the weight is that of light.
pub(crate) fn scatter_light(
    point: &SurfacePoint,
    bsdf: &Bsdf,
    (from, light): (Vec3, Vec3),
    u: [f32; 3],
) -> Option<(Ray, BsdfSample)> {
    let carrying = Carrying::by(bsdf, from, counted(bsdf, light));
    // Light may continue to either side, but must be consistent with its face.
    let is_honest = |sample: &BsdfSample| (point.ng.dot(sample.wi) > 0.0) != sample.transmitted;
    let sample = carrying.sample(u, point.ng).filter(is_honest)?;
    Some((point.spawn(sample.wi, f32::INFINITY), sample))
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! What the camera sees in mirrors and through smooth glass: features for denoisers.
//! Rays of the camera follow all branches of smooth surfaces, where paths choose one by chance, so that these
//! layers have less noise than the light. Albedo and normal are those of the surfaces behind; shares of a pixel
//! are those of the light. `light` is the light of lamps and environment that paths found behind smooth surfaces
//! only, `split` the same over all branches: their means agree. Rare branches are followed by chance.
//! Where media, holes, pixel shaders or restricted lights are, nothing is followed.
//! Space: world. Invariant: nothing here changes the picture. Tests: crates/render/tests/seen.rs.

use std::ops::Range;

use glam::Vec3;
use gnurt_accel::{Coherence, RayBatch};
use gnurt_scene::RayMask;
use gnurt_shading::bsdf::{Bsdf, BsdfSample, ClosureBatch, Kind, Lobe, left_after};
use gnurt_shading::sampling::{purpose, sample_pair};
use gnurt_shading::{SampleKey, SurfaceBatch, Vec3s};

use crate::cone::{Cone, ConeHit, Cones, fineness};
use crate::first_hit::{FirstHit, NOTHING};
use crate::options::RenderOptions;
use crate::state::{SavedState, put_f32, put_f64, put_u32};
use crate::tracer::{AttributeRequests, BatchTracer, MID_GREY};
use crate::transport::opacity;
use crate::world::HitLanes;

/// Path segments up to the last surface that is seen, the camera's included.
const MOST_EDGES: u32 = 8;
/// Segments, and transparent parts between them.
const MOST_ROUNDS: u32 = 48;
/// Branches with less of the light are followed by chance.
const RARE: f32 = 0.01;
/// Microfacets with narrower slopes show features, as mirrors do; their light counts as scattered.
const NARROW: f32 = 0.15;
/// Still narrower ones show points, which move as those in mirrors.
const SHARP: f32 = 0.05;
/// Marks the random numbers of that choice.
const CHANCE: u32 = 0x5ee;

/// Path segments up to the light that counts as seen; contributions beyond are limited, if any are.
pub(crate) fn most_edges(options: &RenderOptions) -> u32 {
    match options.clamp {
        _ if !options.seen => 0,
        Some(_) => 2,
        None => MOST_EDGES,
    }
}

/// Sums over the camera rays of a tile's pixels.
#[derive(Clone, Debug)]
pub(crate) struct TileSeen {
    pub(crate) albedo: Vec<[f64; 3]>,
    pub(crate) normal: Vec<[f64; 3]>,
    pub(crate) light: Vec<[f64; 3]>,
    pub(crate) split: Vec<[f64; 3]>,
    /// The light that is scattered elsewhere, and its squares.
    rest: Vec<[f64; 3]>,
    squares: Vec<[f64; 3]>,
    /// Camera rays of each pixel that albedo, normal and split light are sums of; the others are sums of samples.
    views: Vec<u32>,
    /// Albedo, normal and split light of the first one, and whether another one differs.
    reference: Vec<View>,
    pub(crate) differs: Vec<bool>,
    /// The brightest surface of the first sample, and how bright it is; depths along the way there.
    pub(crate) first: Vec<FirstHit>,
    brightest: Vec<f32>,
}

/// Albedo, normal and split light of a camera ray.
type View = [[f32; 3]; 3];

/// A ray that is followed.
#[derive(Clone, Copy)]
struct Branch {
    pixel: usize,
    /// The share of the light at its end that the camera gets.
    weight: Vec3,
    /// The share of the pixel; those of all branches make 1.
    share: f32,
    edges: u32,
    /// The length of the way so far.
    way: f32,
    /// Whether only smooth surfaces are before it: then its light is known.
    is_exact: bool,
    /// Whether only smooth and very narrow ones are: then one point is behind it.
    is_sharp: bool,
    /// Where it was scattered, and how much is absorbed along it there.
    start: Vec3,
    absorption: Vec3,
}

/// Rays that are followed.
#[derive(Default)]
struct Branches {
    rays: RayBatch,
    keys: Vec<SampleKey>,
    cones: Cones,
    all: Vec<Branch>,
}

impl Branches {
    fn push(&mut self, ray: gnurt_accel::Ray, key: SampleKey, cone: Cone, branch: Branch) {
        self.rays.push(ray);
        self.keys.push(key);
        self.cones.resize(self.all.len() + 1);
        self.cones.set(self.all.len(), cone);
        self.all.push(branch);
    }
}

impl TileSeen {
    pub(crate) fn new(pixels: usize) -> Self {
        let zero = || vec![[0.0; 3]; pixels];
        let (albedo, normal, light, split) = (zero(), zero(), zero(), zero());
        let (first, brightest) = (vec![NOTHING; pixels], vec![0.0; pixels]);
        let (views, reference, differs) =
            (vec![0; pixels], vec![View::default(); pixels], vec![false; pixels]);
        let (rest, squares) = (zero(), zero());
        Self { albedo, normal, light, split, rest, squares, views, reference, differs, first, brightest }
    }

    /// The mean over the camera rays of pixel `i` of a sum.
    pub(crate) fn mean(&self, i: usize, sums: &[[f64; 3]]) -> [f32; 3] {
        sums[i].map(|sum| (sum / f64::from(self.views[i].max(1))) as f32)
    }

    /// Variance of the mean of the light that is scattered elsewhere, by `count` samples; 0 if it is not known.
    pub(crate) fn variance(&self, i: usize, count: u32) -> [f32; 3] {
        let n = f64::from(count);
        if count < 2 {
            return [0.0; 3];
        }
        [0, 1, 2].map(|k| {
            let mean = self.rest[i][k] / n;
            ((self.squares[i][k] / n - mean * mean).max(0.0) / (n - 1.0)) as f32
        })
    }

    /// Adds one sample of each pixel in `range`.
    pub(crate) fn add(
        &mut self,
        tracer: &mut BatchTracer,
        camera: HitLanes,
        range: Range<usize>,
        (sample, radiance): (u32, &Vec3s),
    ) {
        if sample == 0 {
            self.first.fill(NOTHING);
            self.brightest.fill(0.0);
        }
        let follows = follows(tracer);
        let found = if follows { &tracer.seen } else { &tracer.direct };
        for (pixel, lane) in range.clone().enumerate() {
            let all = radiance.get(lane);
            let all = if all.is_finite() { all } else { Vec3::ZERO };
            let light = if found.is_empty() || all == Vec3::ZERO { Vec3::ZERO } else { found.get(lane) };
            for k in 0..3 {
                let rest = f64::from(all[k] - light[k]);
                self.light[pixel][k] += f64::from(light[k]);
                self.rest[pixel][k] += rest;
                self.squares[pixel][k] += rest * rest;
                if !follows {
                    self.split[pixel][k] += f64::from(light[k]);
                }
            }
        }
        self.add_views(tracer, camera, range.clone(), sample == 0, &|lane| lane - range.start);
    }

    /// Adds the camera rays in `range`, at most one of each pixel: albedo, normal, and light that all their branches see.
    pub(crate) fn add_views(
        &mut self,
        tracer: &mut BatchTracer,
        camera: HitLanes,
        range: Range<usize>,
        is_first: bool,
        pixel_of: &dyn Fn(usize) -> usize,
    ) {
        let before: Vec<[[f64; 3]; 3]> = range.clone().map(|lane| self.sums(pixel_of(lane))).collect();
        let follows = follows(tracer);
        let has_light = follows && !tracer.seen.is_empty();
        let most = if follows { MOST_EDGES.min(tracer.options.max_depth) } else { 1 };
        let of_camera = |lane: usize| Branch {
            pixel: pixel_of(lane),
            weight: Vec3::ONE,
            share: 1.0,
            edges: 1,
            way: 0.0,
            is_exact: true,
            is_sharp: true,
            start: Vec3::from(camera.rays.get(lane).org),
            absorption: Vec3::ZERO,
        };
        let mut next = self.gather(tracer, camera, range.clone(), (is_first, most, has_light), &of_camera);
        for _ in 1..MOST_ROUNDS {
            if next.all.is_empty() {
                break;
            }
            let Branches { rays, keys, cones, all } = &next;
            tracer.stats.secondary_rays += keys.len() as u64;
            let hits = tracer.intersect(RayMask::OTHER, rays, keys, Coherence::Coherent);
            let from = HitLanes { rays, keys, hits: &hits, cones: Some(cones), depth: 1 };
            next = self.gather(tracer, from, 0..all.len(), (is_first, most, has_light), &|lane| all[lane]);
        }
        for (lane, before) in range.zip(before) {
            let pixel = pixel_of(lane);
            let after = self.sums(pixel);
            let view: View =
                [0, 1, 2].map(|layer| [0, 1, 2].map(|k| (after[layer][k] - before[layer][k]) as f32));
            if self.views[pixel] == 0 {
                self.reference[pixel] = view;
            }
            self.differs[pixel] |= differ(&view, &self.reference[pixel]);
            self.views[pixel] += 1;
        }
    }

    fn sums(&self, pixel: usize) -> [[f64; 3]; 3] {
        [self.albedo[pixel], self.normal[pixel], self.split[pixel]]
    }

    /// Notes a surface, if none that is brighter is seen in its pixel.
    fn note(&mut self, branch: &Branch, albedo: Vec3, hit: FirstHit) {
        let light = (branch.weight * albedo).max_element().max(1e-9);
        if branch.is_sharp && light > self.brightest[branch.pixel] {
            (self.brightest[branch.pixel], self.first[branch.pixel]) = (light, hit);
        }
    }

    /// Adds what the rays in `range` meet; returns those that go on.
    fn gather(
        &mut self,
        tracer: &mut BatchTracer,
        from: HitLanes,
        range: Range<usize>,
        (is_first, most, has_light): (bool, u32, bool),
        of: &dyn Fn(usize) -> Branch,
    ) -> Branches {
        let most_light = if has_light { most_edges(tracer.options) } else { 0 };
        if has_light {
            let missed: Vec<usize> = range.clone().filter(|&lane| from.hits.get(lane).is_none()).collect();
            let sky = tracer.environment(from.rays, &missed, |lane| from.is_of_camera(lane));
            for (k, &lane) in missed.iter().enumerate() {
                let branch = of(lane);
                if branch.is_exact && branch.edges <= most_light {
                    let left = left_after(f32::INFINITY, [branch.absorption, Vec3::ZERO]);
                    add(&mut self.split[branch.pixel], branch.weight * sky.get(k) * left);
                }
            }
        }
        if is_first {
            for lane in range.clone().filter(|&lane| from.hits.get(lane).is_none()) {
                self.note(&of(lane), Vec3::ONE, NOTHING);
            }
        }
        let mut next = Branches::default();
        let mut closures = ClosureBatch::default();
        let world = tracer.world;
        let absorbs = tracer.world.materials().has_media();
        tracer.for_each_surface_in(range, from, AttributeRequests::Light, |tracer, shader, lanes, points| {
            closures.reset(points.len());
            shader.evaluate(points, &mut closures);
            let mut albedo = Vec3s::splat(lanes.len(), MID_GREY);
            shader.albedo(points, &mut albedo);
            let is_final = shader.radiance().is_some();
            for (k, &lane) in lanes.iter().enumerate() {
                let (before, key) = (of(lane as usize), from.keys[lane as usize]);
                let mut here = before;
                here.way += points.t[k];
                if absorbs {
                    let way = (points.p.get(k) - before.start).length();
                    here.weight *= left_after(way, [before.absorption, closures.medium(k).on(true)]);
                }
                if !is_final && before.is_exact && before.edges <= most_light {
                    add(&mut self.split[here.pixel], here.weight * closures.emission(k));
                }
                let coverage = closures.coverage(k).clamp(0.0, 1.0);
                let hit = ConeHit::of(points, k);
                if coverage < 1.0 {
                    let rest = Branch {
                        weight: before.weight * (1.0 - coverage),
                        share: before.share * (1.0 - coverage),
                        way: here.way,
                        ..before
                    };
                    if let Some(rest) = chosen(tracer.options.seed, key, rest) {
                        let ray = points.spawn(k, points.ray_dir.get(k), f32::INFINITY);
                        next.push(ray, opacity::key_beyond(key), hit.straight(), rest);
                    }
                }
                here.weight *= coverage;
                here.share *= coverage;
                let mut own = (albedo.get(k), 1.0);
                if !before.is_exact {
                    // Lamps are white.
                    own.0 = (own.0 + closures.emission(k)).min(Vec3::ONE);
                }
                let is_smooth =
                    |(kind, alpha): (Kind, f32)| kind.is_delta() || !kind.is_wide() && alpha < NARROW;
                if !is_final && closures.widths(k).any(is_smooth) {
                    own = follow(
                        tracer.options.seed,
                        (points, &closures, k),
                        (here, key, hit),
                        most,
                        &mut next,
                    );
                }
                let (own, share) = own;
                if is_first {
                    let (material, (_, object)) = (
                        world.material_of(points.leaf_id[k], points.geom_id[k]),
                        world.leaf(points.leaf_id[k]),
                    );
                    let hit = FirstHit {
                        position: points.p.get(k),
                        depth: here.way,
                        z: here.way,
                        object: object.0,
                        instance: points.inst_id[k],
                        prim: points.prim_id[k],
                        material,
                    };
                    self.note(&here, own, hit);
                }
                add(&mut self.albedo[here.pixel], here.weight * own);
                add(&mut self.normal[here.pixel], points.facing_ns(k) * (here.share * share));
            }
        });
        next
    }
}

/// Whether two camera rays of a pixel see different things.
fn differ(a: &View, b: &View) -> bool {
    let off = |layer: usize, most: f32| {
        (0..3).any(|k| {
            let (a, b) = (a[layer][k], b[layer][k]);
            (a - b).abs() > most * a.abs().max(b.abs()).max(1.0)
        })
    };
    off(0, 0.05) || off(1, 0.2) || off(2, 0.05)
}

/// Whether smooth surfaces are followed.
pub(crate) fn follows(tracer: &BatchTracer) -> bool {
    let world = tracer.world;
    world.media().is_empty()
        && tracer.held.is_empty()
        && world.pixel().is_none()
        && tracer.wavefront.linked.is_none()
}

/// Sends the branches of a smooth surface on. Returns the albedo of its other scattering, and the share of that.
fn follow(
    seed: u64,
    (points, closures, k): (&SurfaceBatch, &ClosureBatch, usize),
    (here, key, hit): (Branch, SampleKey, ConeHit<f32>),
    most: u32,
    next: &mut Branches,
) -> (Vec3, f32) {
    let (bsdf, wo) = (closures.point(k).bsdf, -points.ray_dir.get(k));
    let all = bsdf.albedo(wo);
    if most == 1 || bsdf.is_dispersed() {
        return (all, 1.0);
    }
    let is_last = here.edges >= most;
    let (point, whole) = (points.point(k), all.element_sum().max(1e-6));
    let (mut rest, mut share) = (all, 1.0);
    let mirrored = 2.0 * bsdf.normal().dot(wo) * bsdf.normal() - wo;
    let polished = closures.is_polished(k).then(|| {
        let (value, pdf) = bsdf.eval_pdf(wo, mirrored);
        let weight = if pdf > 0.0 { value / pdf } else { Vec3::ZERO };
        BsdfSample { wi: mirrored, weight, pdf, delta: true, transmitted: false, wide: false }
    });
    for (i, branch) in bsdf.delta_branches(wo).into_iter().chain([polished]).enumerate() {
        let Some(sample) = branch else { continue };
        rest = (rest - sample.weight).max(Vec3::ZERO);
        let part = (sample.weight.element_sum() / whole).min(1.0);
        share = (share - part).max(0.0);
        if is_last {
            // Light that is still between smooth surfaces is as unknown as that of the sky.
            continue;
        }
        let Some(ray) = point.scatter_ray(sample.wi, sample.transmitted, f32::INFINITY) else { continue };
        let beyond = Branch {
            weight: here.weight * sample.weight,
            share: here.share * part,
            edges: here.edges + 1,
            start: points.p.get(k),
            absorption: closures.medium(k).on(!sample.transmitted),
            ..here
        };
        let key = key.fork(i as u32);
        if let Some(beyond) = chosen(seed, key, beyond) {
            next.push(ray, key, hit.after(&sample, fineness(key)), beyond);
        }
    }
    if polished.is_some() {
        return (rest, share);
    }
    let is_gloss = |lobe: &Lobe| lobe.is_narrow(NARROW) && !lobe.kind.is_delta();
    let gloss = Bsdf::new(bsdf.normal(), bsdf.lobes().clone().filtered(is_gloss).reflecting());
    let is_sharp = here.is_sharp && gloss.lobes().as_slice().iter().all(|lobe| lobe.is_narrow(SHARP));
    let gloss = gloss.albedo(wo);
    if !is_last
        && gloss.max_element() > 0.0
        && let Some(ray) = point.scatter_ray(mirrored, false, f32::INFINITY)
    {
        rest = (rest - gloss).max(Vec3::ZERO);
        // The surface keeps its normal, for most of its edges are seen in the light.
        let beyond = Branch {
            weight: here.weight * gloss,
            share: 0.0,
            edges: here.edges + 1,
            is_exact: false,
            is_sharp,
            start: points.p.get(k),
            absorption: closures.medium(k).on(true),
            ..here
        };
        let (key, cone) = (key.fork(2), hit.straight());
        if let Some(beyond) = chosen(seed, key, beyond) {
            next.push(ray, key, cone, beyond);
        }
    }
    (rest, share)
}

/// The branch, if it is followed: rare ones are by chance, and count for the others.
fn chosen(seed: u64, key: SampleKey, branch: Branch) -> Option<Branch> {
    let size = branch.weight.max_element();
    if size >= RARE {
        return Some(branch);
    }
    if size.is_nan() || size <= 0.0 {
        return None;
    }
    let chance = size / RARE;
    let drawn = sample_pair(seed, key.fork(CHANCE), branch.edges, purpose::CHOICE)[0];
    (drawn < chance).then(|| Branch {
        weight: branch.weight / chance,
        share: branch.share / chance,
        ..branch
    })
}

fn add(sum: &mut [f64; 3], value: Vec3) {
    if value.is_finite() {
        (0..3).for_each(|k| sum[k] += f64::from(value[k]));
    }
}

impl SavedState for TileSeen {
    fn state(&mut self, with: &mut dyn FnMut(&mut u64)) {
        let Self { albedo, normal, light, split, rest, squares, views, reference, differs, first, .. } = self;
        for sums in [albedo, normal, light, split, rest, squares] {
            sums.as_flattened_mut().iter_mut().for_each(|x| put_f64(x, with));
        }
        views.iter_mut().for_each(|count| put_u32(count, with));
        reference.as_flattened_mut().as_flattened_mut().iter_mut().for_each(|x| put_f32(x, with));
        for flag in differs {
            let mut value = u32::from(*flag);
            put_u32(&mut value, with);
            *flag = value != 0;
        }
        first.iter_mut().for_each(|hit| hit.state(with));
    }
}

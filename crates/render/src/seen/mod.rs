// SPDX-License-Identifier: GPL-3.0-or-later
//! Surfaces and light that the camera sees in mirrors and through smooth glass: features for denoisers.
//! Rays of the camera follow all branches of smooth surfaces, where paths choose one by chance, so that these
//! layers have less noise than the light. Albedo and normal are those of the surfaces behind; shares of a pixel
//! are those of the light. `light` is the light of lamps and environment that paths found behind smooth surfaces and
//! polished metal only, `split` the same over all branches: their means agree. Rare branches are followed by chance.
//! Where media, holes, pixel shaders or restricted lights are, nothing is followed.
//! Space: world. Invariant: nothing here changes the picture. Tests: crates/render/tests/seen.rs.

mod branches;
pub(crate) mod closer_look;
mod light;
mod view;

use std::ops::Range;

use glam::Vec3;
use gnurt_accel::Coherence;
use gnurt_scene::RayMask;
use gnurt_shading::Vec3s;
use gnurt_shading::bsdf::{ClosureBatch, Kind, left_after};

use crate::cone::ConeHit;
use crate::first_hit::{FirstHit, NOTHING};
use crate::moments::variance_of_mean;
use crate::options::RenderOptions;
use crate::state::{SavedState, put_f32, put_f64, put_u32};
use crate::tracer::{AttributeRequests, BatchTracer, MID_GREY};
use crate::transport::opacity;
use crate::world::HitLanes;

use branches::{Branch, Branches, NARROW, chosen, follow};
pub(crate) use light::{MANY, SeenLight};
use view::{Differs, View, differ};

/// Path segments up to the last surface that is seen, the camera's included.
const MOST_EDGES: u32 = 8;
/// Segments, and transparent parts between them.
const MOST_ROUNDS: u32 = 48;

/// Path segments up to the light that counts as seen; contributions beyond are limited, if any are.
pub(crate) fn most_edges(options: &RenderOptions) -> u32 {
    match options.clamp {
        _ if !options.seen => 0,
        Some(_) => 2,
        None => MOST_EDGES,
    }
}

/// Sums of light and of its squares.
#[derive(Clone, Debug)]
struct Moments {
    sums: Vec<[f64; 3]>,
    squares: Vec<[f64; 3]>,
}

/// Sums over the camera rays of a tile's pixels.
#[derive(Clone, Debug)]
pub(crate) struct TileSeen {
    pub(crate) albedo: Vec<[f64; 3]>,
    pub(crate) normal: Vec<[f64; 3]>,
    pub(crate) light: Vec<[f64; 3]>,
    pub(crate) split: Vec<[f64; 3]>,
    /// Direct and indirect light of the surfaces.
    scattered: [Moments; 2],
    /// Camera rays of each pixel that albedo, normal and split light are sums of; the others are sums of samples.
    views: Vec<u32>,
    /// Albedo, normal and split light of the first one, and whether another one differs.
    reference: Vec<View>,
    differs: Vec<Differs>,
    /// The brightest surface of the first sample, and how bright it is; depths along the way there.
    pub(crate) first: Vec<FirstHit>,
    brightest: Vec<f32>,
}

impl Moments {
    fn add(&mut self, pixel: usize, light: Vec3) {
        for k in 0..3 {
            let light = f64::from(light[k]);
            self.sums[pixel][k] += light;
            self.squares[pixel][k] += light * light;
        }
    }

    fn variance(&self, i: usize, count: u32) -> [f32; 3] {
        variance_of_mean(&self.sums[i], &self.squares[i], count)
    }
}

impl TileSeen {
    pub(crate) fn new(pixels: usize) -> Self {
        let zero = || vec![[0.0; 3]; pixels];
        let (albedo, normal, light, split) = (zero(), zero(), zero(), zero());
        let (first, brightest) = (vec![NOTHING; pixels], vec![0.0; pixels]);
        let (views, reference, differs) =
            (vec![0; pixels], vec![View::default(); pixels], vec![Differs::Nothing; pixels]);
        let scattered = [0, 1].map(|_| Moments { sums: zero(), squares: zero() });
        Self { albedo, normal, light, split, scattered, views, reference, differs, first, brightest }
    }

    /// The mean over the camera rays of pixel `i` of a sum.
    pub(crate) fn mean(&self, i: usize, sums: &[[f64; 3]]) -> [f32; 3] {
        sums[i].map(|sum| (sum / f64::from(self.views[i].max(1))) as f32)
    }

    /// The sums of direct light.
    pub(crate) fn direct(&self) -> &[[f64; 3]] {
        &self.scattered[0].sums
    }

    /// Variances of the means of direct and indirect light, by `count` samples; 0 if they are not known.
    pub(crate) fn variances(&self, i: usize, count: u32) -> [[f32; 3]; 2] {
        [0, 1].map(|part| self.scattered[part].variance(i, count))
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
        let found = if follows { &tracer.seen.unscattered } else { &tracer.direct };
        for (pixel, lane) in range.clone().enumerate() {
            let all = radiance.get(lane);
            let of = |sums: &Vec3s| if sums.is_empty() { Vec3::ZERO } else { sums.get(lane) };
            let [all, light, direct] = match all.is_finite() && all != Vec3::ZERO {
                true => [all, of(found), of(&tracer.seen.direct)],
                false => [Vec3::ZERO; 3],
            };
            add(&mut self.light[pixel], light);
            if !follows {
                add(&mut self.split[pixel], light);
            }
            self.scattered[0].add(pixel, direct);
            self.scattered[1].add(pixel, all - light - direct);
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
            self.differs[pixel] = self.differs[pixel].max(differ(&view, &self.reference[pixel]));
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

    /// Adds the surfaces and light that the rays in `range` meet; returns those that go on.
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
                let (coverage, passing) = (closures.coverage(k).clamp(0.0, 1.0), closures.passing(k));
                let hit = ConeHit::of(points, k);
                if coverage < 1.0 {
                    let rest = Branch {
                        weight: before.weight * passing * (1.0 - coverage),
                        share: before.share * (1.0 - closures.stopped(k)),
                        way: here.way,
                        ..before
                    };
                    if let Some(rest) = chosen(tracer.options.seed, key, rest) {
                        let ray = points.spawn(k, points.ray_dir.get(k), f32::INFINITY);
                        next.push(ray, opacity::key_beyond(key), hit.straight(), rest);
                    }
                }
                here.weight *= coverage;
                here.share *= closures.stopped(k);
                let mut own = (albedo.get(k), 1.0);
                if !before.is_exact {
                    // Lamps are white.
                    own.0 = (own.0 + closures.emission(k)).min(Vec3::ONE);
                }
                let is_smooth =
                    |(kind, alpha): (Kind, f32)| kind.is_delta() || !kind.is_wide() && alpha < NARROW;
                if !is_final && closures.widths(k).any(is_smooth) {
                    own = follow(
                        (tracer.options.seed, tracer.pixel_order),
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

/// Whether smooth surfaces are followed.
pub(crate) fn follows(tracer: &BatchTracer) -> bool {
    let world = tracer.world;
    world.media().is_empty()
        && tracer.held.is_empty()
        && world.pixel().is_none()
        && tracer.wavefront.linked.is_none()
}

fn add(sum: &mut [f64; 3], value: Vec3) {
    if value.is_finite() {
        (0..3).for_each(|k| sum[k] += f64::from(value[k]));
    }
}

impl SavedState for TileSeen {
    fn state(&mut self, with: &mut dyn FnMut(&mut u64)) {
        let Self { albedo, normal, light, split, scattered, views, reference, differs, first, .. } = self;
        let scattered = scattered.iter_mut().flat_map(|part| [&mut part.sums, &mut part.squares]);
        for sums in [albedo, normal, light, split].into_iter().chain(scattered) {
            sums.as_flattened_mut().iter_mut().for_each(|x| put_f64(x, with));
        }
        views.iter_mut().for_each(|count| put_u32(count, with));
        reference.as_flattened_mut().as_flattened_mut().iter_mut().for_each(|x| put_f32(x, with));
        for flag in differs {
            let mut value = *flag as u32;
            put_u32(&mut value, with);
            *flag = match value {
                0 => Differs::Nothing,
                1 => Differs::Surface,
                _ => Differs::Light,
            };
        }
        first.iter_mut().for_each(|hit| hit.state(with));
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! The first visible surface of each pixel of a picture in motion: camera rays to the first surface that
//! scatters light, through mirrors and smooth glass along the strongest branch. No light is sampled.
//! Space: world.
//! Behind a mirror a point has two positions: on the visible surface, for the comparison of surfaces, and
//! that of its image straight ahead, for the projection into other pictures; for flat mirrors that is exact.

use glam::Vec3;
use gnurt_accel::{Coherence, INVALID_ID};
use gnurt_image::srgb::luminance;
use gnurt_scene::RayMask;
use gnurt_shading::bsdf::{Bsdf, BsdfSample, ClosureBatch, Kind};
use gnurt_shading::sampling::hash_combine;
use gnurt_shading::{SampleKey, SurfaceBatch, SurfacePoint, SurfaceShader, Vec3s};

use super::lattice::Lattice;
use super::surface_key::{SurfaceKey, Tint};
use crate::cone::{ConeHit, fineness};
use crate::film::{self, BLOCK};
use crate::job::Job;
use crate::tracer::{AttributeRequests, BatchTracer, MID_GREY};
use crate::transport::walks::Walks;
use crate::world::HitLanes;

/// Added to a surface's albedo, so that the light on it can be divided out.
const LEAST_SHARE: f32 = 0.04;
/// Lobes of surfaces that also scatter to all sides count as no narrower than this.
const HALF_WIDE: f32 = 0.3;
/// No lobe is narrower.
const NARROWEST: f32 = 0.02;
/// Distance of the environment's image.
const FAR: f32 = 1e12;
/// Mirrors behind mirrors that are followed.
const MOST_MIRRORS: u32 = 8;
/// Columns that are processed together.
const COLUMNS: u32 = 64;
/// Kinds with the same appearance from all sides.
const WIDE: u32 =
    Kind::None.bit() | Kind::Diffuse.bit() | Kind::Sheen.bit() | Kind::Fibres.bit() | Kind::Translucent.bit();

/// The surface of a pixel.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SurfaceSample {
    pub(super) surface_key: SurfaceKey,
    pub(super) tint: Tint,
    /// Where the image of the point is.
    pub(super) image: Vec3,
    /// Unit, to where it is seen from.
    pub(super) toward: Vec3,
}

/// A ray behind a mirror.
#[derive(Clone, Copy)]
struct Beyond {
    lane: usize,
    throughput: Vec3,
    /// From the eye to where it leaves.
    distance: f32,
}

/// The scattering of a point, as pictures in motion need it.
struct Manner {
    share: Vec3,
    roughness: f32,
    /// Where more light comes from than from all other sides.
    onward: Option<BsdfSample>,
}

impl Manner {
    fn of(bsdf: &Bsdf, wo: Vec3) -> Self {
        let share = bsdf.albedo(wo);
        let counts = |branch: &BsdfSample| luminance(branch.weight.into());
        let branches = bsdf.delta_branches(wo).into_iter().flatten();
        let most = branches.max_by(|a, b| counts(a).total_cmp(&counts(b)));
        let onward = most.filter(|branch| counts(branch) > luminance(share.into()));
        let lobes = bsdf.lobes().as_slice().iter().filter(|lobe| !lobe.is_black());
        Self { share, roughness: grain_of(lobes.map(|lobe| (lobe.kind, lobe.alpha))), onward }
    }
}

/// The width of the narrowest of some lobes, of these kinds and with these widths of their facets' slopes.
fn grain_of(lobes: impl Iterator<Item = (Kind, f32)>) -> f32 {
    let (mut narrowest, mut is_wide) = (1.0_f32, false);
    for (kind, alpha) in lobes {
        if WIDE & kind.bit() != 0 {
            is_wide |= kind != Kind::None;
        } else {
            narrowest = narrowest.min(if kind.is_delta() { 0.0 } else { alpha });
        }
    }
    narrowest.clamp(if is_wide { HALF_WIDE } else { NARROWEST }, 1.0)
}

/// Takes columns and rows of the lattice, and the samples there.
type Keep<'a> = dyn FnMut(&[[u32; 2]], &[SurfaceSample]) + 'a;

/// Calls `with` for the pixels of some rows of the lattice, many at once.
pub(super) fn sample_surfaces(
    job: &Job,
    lattice: Lattice,
    tracer: &mut BatchTracer,
    rows: [u32; 2],
    with: &mut Keep,
) {
    let mut batch = std::mem::take(&mut tracer.camera);
    let (mut sights, mut places) = (Vec::<SurfaceSample>::new(), Vec::new());
    let [width, _] = lattice.size();
    for left in (0..width).step_by(COLUMNS as usize) {
        let rect = [left, rows[0], (left + COLUMNS).min(width), rows[1]];
        places.clear();
        // An iterator of rows and columns is fast from inside only.
        film::blocks(rect)
            .flat_map(|[x0, y0, x1, y1]| (y0..y1).flat_map(move |y| (x0..x1).map(move |x| [x, y])))
            .for_each(|at| places.push(at));
        job.camera_rays(places.iter().map(|&at| lattice.pixel(at)), 0..1, &mut batch);
        tracer.intersect_into(
            RayMask::CAMERA,
            &batch.rays,
            &batch.keys,
            Coherence::Coherent,
            &mut batch.hits,
        );
        tracer.stats.camera_rays += batch.rays.len() as u64;
        // Each of them is written: by a surface or by the environment.
        sights.resize(batch.rays.len(), SurfaceSample::default());
        see(tracer, batch.met(), &mut sights);
        // Widths of pixels are those of the lattice: neighbours are so far apart.
        sights.iter_mut().for_each(|sample| sample.surface_key.width *= lattice.stride as f32);
        with(&places, &sights);
    }
    tracer.camera = batch;
}

/// Rows that go together.
pub(super) const ROWS: u32 = BLOCK;

/// Surfaces of camera rays.
fn see(tracer: &mut BatchTracer, camera: HitLanes, sights: &mut [SurfaceSample]) {
    let missed: Vec<usize> =
        (0..sights.len()).filter(|&lane| camera.hits.prim_id[lane] == INVALID_ID).collect();
    let visible = tracer.environment(camera.rays, &missed, |_| true);
    for (k, &lane) in missed.iter().enumerate() {
        let dir = Vec3::from(camera.rays.get(lane).dir);
        let tint = Tint { plain: visible.get(k), ..Tint::default() };
        let image = Vec3::from(camera.rays.get(lane).org) + dir * FAR;
        sights[lane] = SurfaceSample { tint, image, toward: -dir, ..SurfaceSample::default() };
    }
    let mut beyond = Walks::default();
    let mut closures = std::mem::take(&mut tracer.closures);
    let mut albedo = Vec3s::default();
    tracer.for_each_surface(camera, AttributeRequests::Light, |tracer, shader, lanes, points| {
        closures.reset(points.len());
        shader.evaluate_traced(tracer, points, &mut closures);
        albedo.reset(points.len(), MID_GREY);
        shader.albedo(points, &mut albedo);
        // All of these points show one.
        let material = tracer.world.material_of(points.leaf_id[0], points.geom_id[0]);
        let met = Met { tracer, shader, points, closures: &closures, albedo: &albedo, material };
        for (k, &lane) in lanes.iter().enumerate() {
            met.see(k, lane as usize, &mut sights[lane as usize], &mut beyond);
        }
    });
    tracer.closures = closures;
    for depth in 1.. {
        if beyond.is_empty() {
            return;
        }
        beyond = see_beyond(tracer, &beyond, depth, sights);
    }
}

/// Points of one shader that camera rays met.
struct Met<'a, 'w> {
    tracer: &'a BatchTracer<'w>,
    shader: &'a dyn SurfaceShader,
    points: &'a SurfaceBatch,
    closures: &'a ClosureBatch,
    albedo: &'a Vec3s,
    material: u32,
}

impl Met<'_, '_> {
    /// Writes the surface of point `k`, or sends a ray beyond it.
    #[inline(always)]
    fn see(&self, k: usize, lane: usize, sample: &mut SurfaceSample, beyond: &mut Walks<Beyond>) {
        let Self { tracer, shader, points, closures, albedo, material } = *self;
        let (toward, t) = (-points.ray_dir.get(k), points.t[k]);
        let (mut share, mut roughness) = (albedo.get(k), 1.0);
        if shader.radiance().is_some() {
            // Its scattering is unknown.
            roughness = HALF_WIDE;
        } else if closures.kinds(k) & Kind::DELTAS != 0 {
            let bsdf = closures.point(k).bsdf;
            let manner = Manner::of(&bsdf, toward);
            if let Some(branch) = manner.onward {
                let (point, key) = (points.point(k), points.key[k]);
                let cone = (ConeHit::of(points, k), fineness(tracer.pixel_order.sample(key)));
                let carried = Beyond { lane, throughput: branch.weight, distance: t };
                send(beyond, (&point, &branch), cone, key, carried);
            }
            (share, roughness) = (manner.share, manner.roughness);
        } else if closures.kinds(k) & !WIDE != 0 {
            roughness = grain_of(closures.widths(k));
        }
        if closures.is_partly_transparent() && closures.stopped(k) < 0.5 {
            let (point, cone) = (points.point(k), ConeHit::of(points, k));
            let ray = (point.spawn(-toward, f32::INFINITY), cone.straight());
            beyond.push(ray, points.key[k], Beyond { lane, throughput: Vec3::ONE, distance: t });
        }
        let p = points.p.get(k);
        let surface_key = SurfaceKey {
            p,
            ns: points.facing_ns(k),
            id: id_of(points.leaf_id[k], material),
            width: tracer.cone.width_at(t),
        };
        let tint = Tint { plain: closures.emission(k), share: share + LEAST_SHARE, roughness, opacity: 1.0 };
        *sample = SurfaceSample { surface_key, tint, image: p, toward };
    }
}

fn id_of(leaf: u32, material: u32) -> u32 {
    hash_combine(leaf, material) | 1
}

/// Sends a ray along a branch of mirrors and smooth glass.
fn send(
    beyond: &mut Walks<Beyond>,
    (point, branch): (&SurfacePoint, &BsdfSample),
    cone: (ConeHit<f32>, f32),
    key: SampleKey,
    carried: Beyond,
) {
    if let Some(ray) = point.scatter_ray(branch.wi, branch.transmitted, f32::INFINITY) {
        let (cone, fineness) = cone;
        beyond.push((ray, cone.after(branch, fineness)), key, carried);
    }
}

/// Surfaces seen in mirrors, and the mirrors themselves.
fn see_beyond(
    tracer: &mut BatchTracer,
    walks: &Walks<Beyond>,
    depth: u32,
    sights: &mut [SurfaceSample],
) -> Walks<Beyond> {
    let mut beyond = Walks::default();
    // The radiance of shaders that trace rays themselves counts as light on their surfaces.
    let probes = std::mem::replace(&mut tracer.probes, true);
    let found = walks.meet(tracer, depth);
    tracer.probes = probes;
    for (i, (&Beyond { lane, throughput, distance }, vertex)) in
        walks.carried.iter().zip(&found.vertices).enumerate()
    {
        let (sample, throughput) = (&mut sights[lane], throughput * found.passed(i));
        let Some(vertex) = vertex else {
            let visible = tracer.environment(&walks.rays, &[i], |_| false).get(0);
            let plain = sample.tint.plain + throughput * visible;
            // The rest of its radiance counts as light on the mirror.
            sample.tint = Tint { plain, ..sample.tint };
            continue;
        };
        let bsdf = &vertex.scattering.bsdf;
        let (manner, distance) = (Manner::of(bsdf, vertex.wo), distance + vertex.t);
        sample.tint.plain += throughput * vertex.scattering.emission;
        if let Some(branch) = manner.onward.filter(|_| depth < MOST_MIRRORS && !vertex.is_final) {
            let carried = Beyond { lane, throughput: throughput * branch.weight, distance };
            let key = walks.keys[i];
            let cone = (vertex.cone, fineness(tracer.pixel_order.sample(key)));
            send(&mut beyond, (&vertex.point, &branch), cone, key, carried);
        }
        let material = tracer.world.material_of(vertex.ids[0], vertex.ids[1]);
        sample.surface_key = SurfaceKey {
            p: vertex.point.p,
            ns: vertex.point.ns,
            id: hash_combine(id_of(vertex.ids[0], material), sample.surface_key.id) | 1,
            width: tracer.cone.width_at(distance),
        };
        sample.tint.share = throughput * manner.share + LEAST_SHARE;
        sample.tint.roughness = sample.tint.roughness.min(manner.roughness).max(NARROWEST);
        // Straight ahead, by the length of the path.
        sample.image -= sample.toward * vertex.t;
    }
    beyond
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Radiance from a BSDF after Whitted: lights are sampled, near-mirror reflections are traced.
//! Source: [Whi80]. Light is counted once: narrow lobes (mirrors, glass, microfacets of roughness below
//! [`SMOOTH`]) follow one ray each and ignore samples of lights that such a ray can meet; wide lobes weigh
//! all light samples and send no ray. Light samples reach narrow lobes if the light has no extent. Smooth
//! glass follows both branches at the ray's first hit; later ones choose one by its share, which keeps the
//! tree small and the mean right. Dispersive glass sends one ray, of one of its colours. Absorption of glass
//! is applied where light leaves it. Wide lobes scatter no light of other surfaces: that would be light
//! scattered twice.
//! Tests: crates/render/tests/{mirrors,appearance,lights}.rs.

use glam::Vec3;
use gnurt_accel::Ray;

use crate::batch::{RayKind, SurfaceBatch, Vec3s};
use crate::bsdf::{Bsdf, BsdfSample, ClosureBatch, Scattering, left_after};
use crate::materials::SMOOTH;
use crate::materials::direct::direct_light;
use crate::sampling::purpose;
use crate::shader::{RayRequest, SurfaceShader, Tracer};

/// Numbers of the branches that leave a hit.
mod branch {
    pub(super) const REFLECTED: u32 = 0;
    pub(super) const REFRACTED: u32 = 1;
    pub(super) const STRAIGHT: u32 = 2;
}

/// Adds to `out` the radiance that leaves each point against its ray: emitted + coverage * scattered + (1 -
/// coverage) * passing * radiance straight behind. `closures` is memory.
pub fn recursive_radiance(
    tracer: &mut dyn Tracer,
    hits: &SurfaceBatch,
    surface: &dyn SurfaceShader,
    closures: &mut ClosureBatch,
    out: &mut Vec3s,
) {
    closures.reset(hits.len());
    surface.evaluate(hits, closures);
    let lanes_where = |there: &dyn Fn(f32) -> bool| -> Vec<u32> {
        (0..hits.len() as u32).filter(|&i| there(closures.coverage(i as usize))).collect()
    };
    let (solid, open) = (lanes_where(&|c| c > 0.0), lanes_where(&|c| c < 1.0));
    let points: Vec<Scattering> = (0..hits.len()).map(|i| closures.point(i)).collect();
    if open.is_empty() {
        solid_radiance(tracer, hits, surface, &points, out);
    } else if !solid.is_empty() {
        let (part, mut radiance) = (hits.gather(&solid), Vec3s::splat(solid.len(), Vec3::ZERO));
        let some: Vec<Scattering> = solid.iter().map(|&i| points[i as usize].clone()).collect();
        solid_radiance(tracer, &part, surface, &some, &mut radiance);
        for (k, &i) in solid.iter().enumerate() {
            out.add(i as usize, radiance.get(k) * points[i as usize].coverage);
        }
    }
    for (i, point) in points.iter().enumerate().filter(|(_, point)| point.emission != Vec3::ZERO) {
        out.add(i, point.emission);
    }
    let mut behind = Branches::default();
    for &i in &open {
        let i = i as usize;
        let straight = hits.spawn(i, hits.ray_dir.get(i), f32::INFINITY);
        behind.push(
            hits,
            i,
            straight,
            (branch::STRAIGHT, points[i].passing * (1.0 - points[i].coverage)),
            hits.ray_kind(i),
        );
    }
    behind.trace(tracer, hits, out);
    if closures.has_media() {
        for i in 0..hits.len() {
            let left = left_after(hits.t[i], [closures.medium(i).on(true), Vec3::ZERO]);
            out.set(i, out.get(i) * left);
        }
    }
}

/// Adds what the opaque part scatters.
fn solid_radiance(
    tracer: &mut dyn Tracer,
    hits: &SurfaceBatch,
    surface: &dyn SurfaceShader,
    points: &[Scattering],
    out: &mut Vec3s,
) {
    match surface.radiance() {
        Some(shader) => shader.shade(tracer, hits, out),
        None => scattered_radiance(tracer, hits, points, out),
    }
}

/// Adds the light that points scatter against their rays: direct light, mirror reflections, and light through
/// glass.
pub fn scattered_radiance(
    tracer: &mut dyn Tracer,
    hits: &SurfaceBatch,
    points: &[Scattering],
    out: &mut Vec3s,
) {
    let wo = |i: usize| -hits.ray_dir.get(i);
    let split: Vec<[Bsdf; 2]> = points.iter().map(|point| point.bsdf.split_at(SMOOTH * SMOOTH)).collect();
    let value = |i: usize, dir: Vec3, light_is_visible: bool| {
        let bsdf = if light_is_visible { &split[i][1] } else { &points[i].bsdf };
        bsdf.eval(wo(i), dir)
    };
    if points.iter().any(|point| point.bsdf.is_smooth()) {
        direct_light(tracer, hits, &value, out);
    }
    let mut rays = Branches::default();
    for (i, [narrow, _]) in split.iter().enumerate() {
        if narrow.is_black() {
            continue;
        }
        let deltas = narrow.delta_branches(wo(i));
        if hits.depth == 0 && !narrow.is_smooth() && !narrow.is_dispersed() {
            deltas.into_iter().flatten().for_each(|sample| rays.push_sample(hits, i, &sample));
        } else {
            let pair = tracer.random(hits.key[i], hits.depth, purpose::DIRECTION);
            let choice = tracer.random(hits.key[i], hits.depth, purpose::CHOICE)[0];
            if let Some(sample) = narrow.sample(wo(i), [choice, pair[0], pair[1]]) {
                rays.push_sample(hits, i, &sample);
            }
        }
    }
    rays.trace(tracer, hits, out);
}

/// Rays and their weights.
#[derive(Default)]
struct Branches {
    request: RayRequest,
    weight: Vec<Vec3>,
}

impl Branches {
    fn push_sample(&mut self, hits: &SurfaceBatch, i: usize, sample: &BsdfSample) {
        let number = if sample.transmitted { branch::REFRACTED } else { branch::REFLECTED };
        let ray = hits.point(i).scatter_ray(sample.wi, sample.transmitted, f32::INFINITY);
        if let Some(ray) = ray.filter(|_| sample.weight != Vec3::ZERO) {
            self.push(hits, i, ray, (number, sample.weight), sample.ray_kind());
        }
    }

    fn push(
        &mut self,
        hits: &SurfaceBatch,
        i: usize,
        ray: Ray,
        (number, weight): (u32, Vec3),
        kind: RayKind,
    ) {
        self.request.push(ray, i, hits.key[i].fork(number));
        self.request.width.push(hits.footprint.get(i).copied().unwrap_or(0.0));
        self.request.kinds.push(kind);
        self.weight.push(weight);
    }

    fn trace(&self, tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        if self.weight.is_empty() {
            return;
        }
        let mut found = Vec3s::default();
        tracer.trace(hits.depth, &self.request, &mut found);
        for (k, (&parent, &weight)) in self.request.parent.iter().zip(&self.weight).enumerate() {
            out.add(parent as usize, weight * found.get(k));
        }
    }
}

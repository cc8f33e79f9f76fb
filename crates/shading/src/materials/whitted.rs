// SPDX-License-Identifier: GPL-3.0-or-later
//! Radiance from a BSDF, the way ray tracing began: lights are asked, what is nearly a mirror image is traced.
//! Source: [Whi80]. Light is counted once: narrow lobes (mirrors, glass, facets of roughness below [`SMOOTH`]) follow one
//! ray each and ignore light samples of lights that such a ray can meet; wide lobes weigh all light samples and send no
//! ray. Lights without extent reach narrow lobes by samples either way. Smooth glass follows both branches at the ray's
//! first hit; later ones choose one by its share, which keeps the tree small and the mean right.
//! What wide lobes would scatter of other surfaces is left out: that is light scattered twice.
//! Proof: crates/render/tests/{mirrors,appearance,lights}.rs.

use glam::Vec3;

use crate::batch::{SurfaceBatch, Vec3s};
use crate::bsdf::{Bsdf, BsdfSample, Scattering};
use crate::materials::direct::direct_light;
use crate::sampling::purpose;
use crate::shader::{RayRequest, SurfaceShader, Tracer};

/// Perceptual roughness below which reflections are traced. Just above 0.5, which many glTF files have: there, at grazing
/// views, rays drawn from the facets leave a tenth to a quarter of the error that light samples leave.
pub const SMOOTH: f32 = 0.55;

/// Numbers of the branches that leave a hit.
pub(crate) mod branch {
    pub(crate) const REFLECTED: u32 = 0;
    pub(crate) const REFRACTED: u32 = 1;
    pub(crate) const STRAIGHT: u32 = 2;
}

/// Adds to `out` the light that the surface, which must say how it scatters, sends against each ray.
pub(super) fn shade(
    tracer: &mut dyn Tracer,
    hits: &SurfaceBatch,
    surface: &dyn SurfaceShader,
    out: &mut Vec3s,
) {
    let mut points = Vec::with_capacity(hits.len());
    surface.scatter(hits, &mut points);
    shade_points(tracer, hits, &points, out);
}

fn shade_points(tracer: &mut dyn Tracer, hits: &SurfaceBatch, points: &[Scattering], out: &mut Vec3s) {
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
        if hits.depth == 0 && !narrow.is_smooth() {
            deltas.into_iter().flatten().for_each(|sample| rays.push(hits, i, &sample));
        } else {
            let pair = tracer.random(hits.key[i], hits.depth, purpose::DIRECTION);
            let choice = tracer.random(hits.key[i], hits.depth, purpose::CHOICE)[0];
            if let Some(sample) = narrow.sample(wo(i), [choice, pair[0], pair[1]]) {
                rays.push(hits, i, &sample);
            }
        }
    }
    rays.trace(tracer, hits, out);
}

/// Rays and what each is worth.
#[derive(Default)]
struct Branches {
    request: RayRequest,
    weight: Vec<Vec3>,
}

impl Branches {
    fn push(&mut self, hits: &SurfaceBatch, i: usize, sample: &BsdfSample) {
        if sample.weight == Vec3::ZERO {
            return;
        }
        let Some(ray) = hits.point(i).scatter_ray(sample.wi, sample.transmitted, f32::INFINITY) else {
            return;
        };
        let number = if sample.transmitted { branch::REFRACTED } else { branch::REFLECTED };
        self.request.rays.push(ray);
        self.request.parent.push(i as u32);
        self.request.key.push(hits.key[i].fork(number));
        self.request.width.push(hits.footprint.get(i).copied().unwrap_or(0.0));
        self.weight.push(sample.weight);
    }

    fn trace(&self, tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        if self.weight.is_empty() {
            return;
        }
        let mut seen = Vec3s::default();
        tracer.trace(hits.depth, &self.request, &mut seen);
        for (k, (&parent, &weight)) in self.request.parent.iter().zip(&self.weight).enumerate() {
            out.add(parent as usize, weight * seen.get(k));
        }
    }
}

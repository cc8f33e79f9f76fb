// SPDX-License-Identifier: GPL-3.0-or-later
//! Virtual lights for surface shaders that loop over lights themselves: after the lights of the scene come
//! the virtual lights of the pass, one by one, and then one light for the remainder that their bound leaves
//! to rays.
//! Source: [Kel97], as [SIP06], section 7, in OpenRT; the bound [KK06]. Space: world. The bound treats the
//! surface as Lambertian: any other share would do, as long as both use the same.
//! Invariant: for diffuse shaders the sum over all lights has the mean of path tracing, for any bound.
//! Tests: bindings/openrt/tests/plugins.rs, crates/render/tests/shader_lights.rs.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::Vec3;
use gnurt_shading::bsdf::left_after;
use gnurt_shading::{LightBatch, SurfaceBatch, SurfacePoint};

use super::bound::Bound;
use super::estimate;
use super::interleave::share_of_key;
use super::pass::PassLights;
use super::vpl::{Vpl, is_open, pdf_of_other_end};
use crate::tracer::{BatchTracer, FurtherLights, Sharing};

/// How many virtual lights a point has, at most.
fn vpl_count(tracer: &BatchTracer, pass: &PassLights) -> usize {
    match tracer.sharing {
        Sharing::All => pass.vpls.len(),
        Sharing::Pattern | Sharing::Random => pass.shares.iter().map(Vec::len).max().unwrap_or(0),
    }
}

impl FurtherLights for PassLights {
    fn count(&self, tracer: &BatchTracer) -> usize {
        vpl_count(tracer, self) + 1
    }

    /// If pixels share virtual lights, light `number` differs from position to position.
    fn illuminate(
        &self,
        tracer: &mut BatchTracer,
        number: usize,
        points: &SurfaceBatch,
        out: &mut LightBatch,
    ) {
        let pass = self;
        let count = vpl_count(tracer, pass);
        if number >= count {
            if number == count {
                the_rest(tracer, pass, points, out);
            }
            return;
        }
        let scale = FRAC_1_PI / tracer.options.white;
        for i in 0..points.len() {
            let vpls = match tracer.sharing {
                Sharing::All => &pass.vpls,
                sharing => &pass.shares[share_of_key(sharing, points.key[i], pass.shares.len())],
            };
            let Some(vpl) = vpls.get(number) else { continue };
            if vpl.edges + points.depth + 2 > tracer.options.max_depth {
                continue;
            }
            if let Some((dir, dist, arriving)) = brings(vpl, &points.point(i), &pass.bound) {
                out.dir.set(i, dir);
                out.dist[i] = dist;
                out.radiance.set(i, arriving * scale);
            }
        }
    }
}

/// Direction, distance and light at a surface that faces a virtual light, with its bound applied; `None` if
/// there is no light.
fn brings(vpl: &Vpl, point: &SurfacePoint, bound: &Bound) -> Option<(Vec3, f32, Vec3)> {
    let offset = vpl.point.p - point.p;
    let distance2 = offset.length_squared();
    let distance = distance2.sqrt();
    let to = offset / distance;
    if !(distance2 > 0.0 && to.is_finite() && is_open(point, to)) {
        return None;
    }
    let sent = vpl.sent(-to);
    if sent == Vec3::ZERO {
        return None;
    }
    let pdf_eye = point.ns.dot(to).max(0.0) * FRAC_1_PI * vpl.point.ng.dot(to).abs() / distance2;
    let pdf_vpl = pdf_of_other_end(&vpl.point, &vpl.bsdf, vpl.from, -to) * point.ng.dot(to).abs() / distance2;
    let left = left_after(distance, [Vec3::ZERO, vpl.bsdf.absorption(-to)]);
    let arriving = sent * left * (bound.share(pdf_eye, pdf_vpl) / distance2);
    arriving.is_finite().then_some((to, distance, arriving))
}

/// A cosine-distributed ray from each point: the part of its light that virtual lights do not bring.
fn the_rest(tracer: &mut BatchTracer, pass: &PassLights, points: &SurfaceBatch, out: &mut LightBatch) {
    for (i, found) in estimate::rest_at(tracer, pass, points).into_iter().enumerate() {
        let Some(found) = found.filter(|found| found.radiance != Vec3::ZERO) else { continue };
        out.dir.set(i, found.dir);
        out.dist[i] = found.dist;
        // The density is the cosine over pi.
        let arriving = found.radiance * (PI / found.cos);
        out.radiance.set(i, arriving * (FRAC_1_PI / tracer.options.white));
        out.pdf[i] = found.cos * FRAC_1_PI;
    }
}

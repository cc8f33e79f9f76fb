// SPDX-License-Identifier: GPL-3.0-or-later
//! Smooth glass: Fresnel's shares mirrored and refracted.
//! Source: [Whi80] (both branches), [PJH23] section 9.5 (Fresnel's equations). The ray's first hit follows both
//! branches; later ones choose one by its share, which keeps the tree small and the mean right.
//! Differs: radiance is not scaled by the square of the index ratio, because rays that enter glass leave it again; shadow
//! rays go straight through with the share that is not mirrored, as if the glass were thin, so that windows let light
//! in; there are no caustics.
//! Proof: `tests::{fresnel_has_its_closed_forms, refraction_follows_snell}`, crates/render/tests/mirrors.rs.

use glam::Vec3;

use crate::batch::{SurfaceBatch, Vec3s};
use crate::materials::mirror::{branch, reflect_above};
use crate::sampling::purpose;
use crate::shader::{RayRequest, SurfaceShader, Tracer};

/// Smooth glass; the geometric normal points out of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dielectric {
    /// Index of refraction inside over outside, > 0.
    pub ior: f32,
    /// Tint of what is mirrored.
    pub reflectance: Vec3,
    /// Tint of what goes through.
    pub transmittance: Vec3,
}

/// Rays and what each is worth.
#[derive(Default)]
struct Branches {
    request: RayRequest,
    weight: Vec<Vec3>,
}

impl Branches {
    fn push(&mut self, hits: &SurfaceBatch, i: usize, dir: Vec3, weight: Vec3, number: u32) {
        if weight != Vec3::ZERO {
            self.request.rays.push(hits.spawn(i, dir, f32::INFINITY));
            self.request.parent.push(i as u32);
            self.request.key.push(hits.key[i].fork(number));
            self.weight.push(weight);
        }
    }
}

impl SurfaceShader for Dielectric {
    fn shade(&self, tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        let mut branches = Branches::default();
        for i in 0..hits.len() {
            let (dir, ns, ng) = (hits.ray_dir.get(i), hits.facing_ns(i), hits.facing_ng(i));
            let eta = if hits.front(i) { 1.0 / self.ior } else { self.ior };
            // Against the ray; a shading normal that the ray sees from behind is no normal.
            let ns = if ns.dot(dir) < 0.0 { ns } else { ng };
            let share = fresnel(-dir.dot(ns), eta);
            let reflected = reflect_above(dir, ns, ng);
            let refracted = refract_below(dir, ns, ng, eta);
            let Some(refracted) = refracted.filter(|_| share < 1.0) else {
                branches.push(hits, i, reflected, self.reflectance, branch::REFLECTED);
                continue;
            };
            if hits.depth == 0 {
                branches.push(hits, i, reflected, self.reflectance * share, branch::REFLECTED);
                branches.push(hits, i, refracted, self.transmittance * (1.0 - share), branch::REFRACTED);
            } else if tracer.random(hits.key[i], hits.depth, purpose::CHOICE)[0] < share {
                branches.push(hits, i, reflected, self.reflectance, branch::REFLECTED);
            } else {
                branches.push(hits, i, refracted, self.transmittance, branch::REFRACTED);
            }
        }
        let mut seen = Vec3s::default();
        tracer.trace(hits.depth, &branches.request, &mut seen);
        for (k, (&parent, &weight)) in branches.request.parent.iter().zip(&branches.weight).enumerate() {
            out.add(parent as usize, weight * seen.get(k));
        }
    }

    fn transmit(&self, _tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        for i in 0..hits.len() {
            let cos = hits.ray_dir.get(i).dot(hits.facing_ng(i)).abs();
            // Straight on, so the share is that of the denser side's outside wherever one is.
            out.set(i, self.transmittance * (1.0 - fresnel(cos, (1.0 / self.ior).min(self.ior))));
        }
    }

    fn is_opaque(&self) -> bool {
        self.transmittance == Vec3::ZERO
    }

    fn albedo(&self, _hits: &SurfaceBatch, out: &mut Vec3s) {
        (0..out.len()).for_each(|i| out.set(i, self.transmittance.max(self.reflectance)));
    }
}

/// Share of unpolarised light that is mirrored; `cos` of the angle to the normal on the side that light comes from,
/// `eta` = index there over index beyond.
pub(crate) fn fresnel(cos: f32, eta: f32) -> f32 {
    let cos = cos.clamp(0.0, 1.0);
    let sin2_beyond = eta * eta * (1.0 - cos * cos);
    if sin2_beyond >= 1.0 {
        return 1.0;
    }
    let beyond = (1.0 - sin2_beyond).sqrt();
    let parallel = (cos - eta * beyond) / (cos + eta * beyond);
    let perpendicular = (eta * cos - beyond) / (eta * cos + beyond);
    (0.5 * (parallel * parallel + perpendicular * perpendicular)).min(1.0)
}

/// `dir` refracted at the shading normal; at the geometric one if that would not lead into the surface. `None` if all
/// is mirrored.
fn refract_below(dir: Vec3, ns: Vec3, ng: Vec3, eta: f32) -> Option<Vec3> {
    let at = |n: Vec3| {
        let cos = -dir.dot(n);
        let cos2_beyond = 1.0 - eta * eta * (1.0 - cos * cos);
        (cos2_beyond > 0.0).then(|| (dir * eta + n * (eta * cos - cos2_beyond.sqrt())).normalize())
    };
    at(ns).filter(|d| d.dot(ng) < 0.0).or_else(|| at(ng))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fresnel_has_its_closed_forms() {
        let normal = ((1.5_f32 - 1.0) / (1.5 + 1.0)).powi(2);
        assert!((fresnel(1.0, 1.0 / 1.5) - normal).abs() < 1e-6, "at normal incidence from outside");
        assert!((fresnel(1.0, 1.5) - normal).abs() < 1e-6, "and from inside");
        assert_eq!(fresnel(0.0, 1.0 / 1.5), 1.0, "all at grazing incidence");
        assert_eq!(fresnel(0.5, 1.5), 1.0, "total inside reflection beyond the critical angle");
        assert!(fresnel(0.3, 1.0) < 1e-6, "no boundary, no reflection");
        // Brewster's angle: parallel light is not mirrored, so half of the perpendicular share is left.
        let cos = (1.0 / (1.0 + 1.5_f32 * 1.5)).sqrt();
        let perpendicular = ((1.0 - 2.25_f32) / (1.0 + 2.25)).powi(2);
        assert!((fresnel(cos, 1.0 / 1.5) - 0.5 * perpendicular).abs() < 1e-6, "at Brewster's angle");
    }

    #[test]
    fn refraction_follows_snell() {
        let dir = Vec3::new(0.6, 0.0, -0.8);
        let inside = refract_below(dir, Vec3::Z, Vec3::Z, 1.0 / 1.5).expect("light enters");
        assert!((inside.x - 0.6 / 1.5).abs() < 1e-6 && inside.z < 0.0, "sines are as the indices: {inside}");
        let back = refract_below(inside, Vec3::Z, Vec3::Z, 1.5).expect("light leaves");
        assert!((back - dir).length() < 1e-6, "and comes out as it went in: {back}");
        assert_eq!(refract_below(dir, Vec3::Z, Vec3::Z, 2.0), None, "total reflection");
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays that smooth surfaces send on, all branches of them, in place of the one that a path chooses. Rare ones are followed
//! by chance. Space: world. Tests: crates/render/tests/seen.rs.

use glam::Vec3;
use gnurt_accel::RayBatch;
use gnurt_shading::bsdf::{Bsdf, BsdfSample, ClosureBatch, Lobe};
use gnurt_shading::sampling::{purpose, sample_pair};
use gnurt_shading::{SampleKey, SurfaceBatch};

use crate::cone::{Cone, ConeHit, Cones, fineness};
use crate::pixel_order::PixelOrder;

/// Branches with less of the light are followed by chance.
const RARE: f32 = 0.01;
/// Microfacets with narrower slopes show features, as mirrors do; their light counts as scattered.
pub(super) const NARROW: f32 = 0.15;
/// Still narrower ones show points, which move as those in mirrors.
const SHARP: f32 = 0.05;
/// Marks the random numbers of that choice.
const CHANCE: u32 = 0x5ee;

/// A ray that is followed.
#[derive(Clone, Copy)]
pub(super) struct Branch {
    pub(super) pixel: usize,
    /// The share of the light at its end that the camera gets.
    pub(super) weight: Vec3,
    /// The share of the pixel; those of all branches make 1.
    pub(super) share: f32,
    pub(super) edges: u32,
    /// The length of the way so far.
    pub(super) way: f32,
    /// Whether only smooth surfaces are before it: then its light is known.
    pub(super) is_exact: bool,
    /// Whether only smooth and very narrow ones are: then one point is behind it.
    pub(super) is_sharp: bool,
    /// Where it was scattered, and how much is absorbed along it there.
    pub(super) start: Vec3,
    pub(super) absorption: Vec3,
}

/// Rays that are followed.
#[derive(Default)]
pub(super) struct Branches {
    pub(super) rays: RayBatch,
    pub(super) keys: Vec<SampleKey>,
    pub(super) cones: Cones,
    pub(super) all: Vec<Branch>,
}

impl Branches {
    pub(super) fn push(&mut self, ray: gnurt_accel::Ray, key: SampleKey, cone: Cone, branch: Branch) {
        self.rays.push(ray);
        self.keys.push(key);
        self.cones.resize(self.all.len() + 1);
        self.cones.set(self.all.len(), cone);
        self.all.push(branch);
    }
}

/// Sends the branches of a smooth surface on. Returns the albedo of its other scattering, and the share of that.
pub(super) fn follow(
    (seed, order): (u64, PixelOrder),
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
            next.push(ray, key, hit.after(&sample, fineness(order.sample(key))), beyond);
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
pub(super) fn chosen(seed: u64, key: SampleKey, branch: Branch) -> Option<Branch> {
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

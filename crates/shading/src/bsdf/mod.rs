// SPDX-License-Identifier: GPL-3.0-or-later
//! What surfaces do to light, as plain values: a BSDF per point that can be evaluated, sampled and asked for densities.
//! Source: [PJH23] chapter 9 (interface); one lobe, one file.
//! Space: world outside, the shading frame inside (z = the shading normal on the side that the first ray came from).
//! `wo` points to where the path came from, `wi` to where it goes; both unit and away from the surface.
//! Invariants: values are BSDF times |cos| to the shading normal; they are the same with `wo` and `wi` exchanged but for
//! that cosine (refraction does not scale radiance by the square of the index: what enters glass leaves it again).
//! Proof: `tests`.

mod lambert;

use glam::Vec3;

use crate::batch::SurfaceBatch;
use crate::sampling::Basis;

/// The BSDF of one point. Plain data: it outlives the batch that it was made from.
#[derive(Clone, Copy, Debug)]
pub struct Bsdf {
    basis: Basis,
    model: Model,
}

/// How a point scatters.
#[derive(Clone, Copy, Debug)]
pub enum Model {
    /// Not at all.
    Black,
    /// Alike to all sides, on the side that light comes from.
    Lambert {
        /// Share of light that is scattered.
        albedo: Vec3,
    },
}

/// A direction that a BSDF chose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// Where the path goes on, unit, world.
    pub wi: Vec3,
    /// BSDF times |cos| over the density of `wi`.
    pub weight: Vec3,
    /// Density per solid angle with which [`Bsdf::sample`] chooses `wi`, all lobes counted; infinite if `delta`.
    pub pdf: f32,
    /// Whether no other direction could have been chosen by that lobe: mirrors, smooth glass. No light sample meets it.
    pub delta: bool,
    /// Whether it goes through the surface.
    pub transmitted: bool,
}

impl Bsdf {
    /// A BSDF around the unit shading normal `ns`, which is on the side that the first ray came from.
    #[must_use]
    pub fn new(ns: Vec3, model: Model) -> Self {
        Self { basis: Basis::around(ns), model }
    }

    /// Scatters nothing.
    #[must_use]
    pub fn black(ns: Vec3) -> Self {
        Self::new(ns, Model::Black)
    }

    /// The shading normal that it is made around.
    #[must_use]
    pub fn normal(&self) -> Vec3 {
        self.basis.normal
    }

    /// BSDF times |cos| of `wi` to the shading normal; delta lobes count nothing.
    #[must_use]
    pub fn eval(&self, wo: Vec3, wi: Vec3) -> Vec3 {
        let (wo, wi) = (self.basis.to_local(wo), self.basis.to_local(wi));
        match self.model {
            Model::Black => Vec3::ZERO,
            Model::Lambert { albedo } => lambert::eval(albedo, wo, wi),
        }
    }

    /// Density per solid angle with which [`sample`](Self::sample) chooses `wi`; delta lobes count nothing.
    #[must_use]
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        let (wo, wi) = (self.basis.to_local(wo), self.basis.to_local(wi));
        match self.model {
            Model::Black => 0.0,
            Model::Lambert { .. } => lambert::pdf(wo, wi),
        }
    }

    /// Chooses where a path goes on; `u` holds three numbers in [0, 1), the first chooses between lobes. `None` = it
    /// ends here.
    #[must_use]
    pub fn sample(&self, wo: Vec3, u: [f32; 3]) -> Option<BsdfSample> {
        let wo = self.basis.to_local(wo);
        let local = match self.model {
            Model::Black => None,
            Model::Lambert { albedo } => lambert::sample(albedo, wo, [u[1], u[2]]),
        }?;
        let wi = self.basis.to_world(local.wi).normalize();
        Some(BsdfSample { wi, ..local })
    }

    /// Share of light from `wo` that is scattered to all sides, in [0, 1] per channel; about, where no closed form is known.
    #[must_use]
    pub fn albedo(&self, wo: Vec3) -> Vec3 {
        let _ = wo;
        match self.model {
            Model::Black => Vec3::ZERO,
            Model::Lambert { albedo } => albedo,
        }
    }

    /// The albedo of a point that scatters alike to all sides, and does nothing else.
    #[must_use]
    pub fn lambertian(&self) -> Option<Vec3> {
        match self.model {
            Model::Lambert { albedo } => Some(albedo),
            Model::Black => Some(Vec3::ZERO),
        }
    }

    /// Whether light samples can bring anything: some lobe is not a delta.
    #[must_use]
    pub fn is_smooth(&self) -> bool {
        !matches!(self.model, Model::Black)
    }
}

/// All that light transport needs to know of a point.
#[derive(Clone, Copy, Debug)]
pub struct Scattering {
    /// What it does to light.
    pub bsdf: Bsdf,
    /// Radiance that it sends against the ray.
    pub emission: Vec3,
    /// Share of light that the surface stops, in [0, 1]; the rest goes straight on as if nothing were there.
    pub coverage: f32,
}

impl Scattering {
    /// A point of lane `i` that only scatters, around its mesh's shading normal.
    #[must_use]
    pub fn new(hits: &SurfaceBatch, i: usize, model: Model) -> Self {
        Self { bsdf: Bsdf::new(hits.facing_ns(i), model), emission: Vec3::ZERO, coverage: 1.0 }
    }
}

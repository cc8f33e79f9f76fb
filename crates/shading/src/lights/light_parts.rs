// SPDX-License-Identifier: GPL-3.0-or-later
//! The input of a light set, and its answers.
//! Source: [PJH23] section 12.5 (environments). Space: world. Tests: `light_set_tests`.

use std::f32::consts::{FRAC_1_PI, PI};
use std::sync::Arc;

use glam::Vec3;
use gnurt_image::srgb::luminance;

use super::{ConstantEnvironment, DirectionalLight, PictureEnvironment, PointLight, ShapeLights};
use crate::batch::SampleKey;
use crate::sampling::{Basis, cosine_hemisphere, sample_pair, uniform_sphere};

/// A light of a [`LightSet`](super::LightSet): shapes first, then points, directional lights and the environment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct LightId(pub u32);

/// The kind of a light, and its index among those of its kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightKind {
    /// A triangle that emits to one side, or a sphere.
    Shape(u32),
    /// From a point, to all sides or into a cone.
    Point(u32),
    /// From infinitely far away.
    Directional(u32),
    /// From everywhere.
    Environment,
}

/// Light from everywhere.
#[derive(Clone)]
pub enum EnvironmentLight {
    /// The same from everywhere.
    Constant(Arc<ConstantEnvironment>),
    /// By direction.
    Picture(Arc<PictureEnvironment>),
}

/// The input of a light set.
#[derive(Clone, Default)]
pub struct LightParts {
    /// Emissive shapes.
    pub shapes: Option<Arc<ShapeLights>>,
    /// The names of a hit on each of them: leaf (the instance's object), mesh and primitive; ascending, twice
    /// where both sides of a triangle emit.
    pub shape_ids: Arc<Vec<[u32; 3]>>,
    /// Lights at points: no scattered ray meets them.
    pub points: Vec<PointLight>,
    /// Lights infinitely far away.
    pub directionals: Vec<DirectionalLight>,
    /// Light from everywhere.
    pub environment: Option<EnvironmentLight>,
    /// Lower and upper corner of the lit scene.
    pub bounds: [Vec3; 2],
}

/// A direction to a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// Unit, towards the light.
    pub dir: Vec3,
    /// Its distance; infinite for lights without a position.
    pub dist: f32,
    /// Radiance against `dir`; for `delta` lights the irradiance of a surface that faces them.
    pub radiance: Vec3,
    /// Density per solid angle, the choice of the light included; for `delta` lights the probability of the choice.
    pub pdf: f32,
    /// Whether no scattered ray could meet it.
    pub delta: bool,
    /// Which light.
    pub light: LightId,
}

/// Of even light: techniques without scattered rays need some samples.
const LEAST_UNEVEN: f32 = 0.05;

/// Whether a sample can count.
pub(super) fn is_sound(sample: &LightSample) -> bool {
    sample.pdf > 0.0 && sample.pdf.is_finite() && sample.radiance.is_finite()
}

impl EnvironmentLight {
    /// Whether it is the very same, not one like it.
    #[must_use]
    pub fn is(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Constant(one), Self::Constant(other)) => Arc::ptr_eq(one, other),
            (Self::Picture(one), Self::Picture(other)) => Arc::ptr_eq(one, other),
            _ => false,
        }
    }

    pub(super) fn radiance(&self, dir: Vec3) -> Vec3 {
        match self {
            Self::Constant(constant) => constant.radiance,
            Self::Picture(picture) => picture.at(dir),
        }
    }

    /// Brightness summed over all directions.
    pub(super) fn total(&self) -> f32 {
        match self {
            Self::Constant(constant) => 4.0 * PI * luminance(constant.radiance.into()),
            Self::Picture(picture) => {
                const N: u32 = 256;
                let share = |sample| {
                    let u = sample_pair(0, SampleKey { pixel: 0, sample, branch: 0 }, 0, 0);
                    let (dir, pdf) = picture.sample(u);
                    luminance(picture.at(dir).into()) / pdf / N as f32
                };
                (0..N).map(share).filter(|x| x.is_finite()).sum()
            }
        }
    }

    /// About the brightness that a surface which faces `normal` (zero = any) receives; 0 only where all of it is black.
    pub(super) fn irradiance(&self, normal: Vec3) -> f32 {
        match self {
            Self::Constant(constant) => {
                luminance(constant.radiance.into()) * if normal == Vec3::ZERO { 4.0 * PI } else { PI }
            }
            Self::Picture(picture) => picture.irradiance(normal),
        }
    }

    /// The part of its light, from [`LEAST_UNEVEN`] to 1, for which directions chosen by brightness are better than scattered
    /// rays: the least for the same from everywhere, near 1 for a sun.
    pub(super) fn unevenness(&self) -> f32 {
        match self {
            Self::Constant(_) => LEAST_UNEVEN,
            Self::Picture(picture) => picture.unevenness().max(LEAST_UNEVEN),
        }
    }

    /// A direction for a surface that faces `normal` (zero = any), and its density.
    pub(super) fn sample(&self, normal: Vec3, u: [f32; 2]) -> (Vec3, f32) {
        match self {
            Self::Constant(_) if normal == Vec3::ZERO => (uniform_sphere(u), 0.25 * FRAC_1_PI),
            Self::Constant(_) => {
                let local = cosine_hemisphere(u);
                let dir = Basis::around(normal).to_world(local).normalize();
                (dir, normal.dot(dir).max(0.0) * FRAC_1_PI)
            }
            Self::Picture(picture) => picture.sample(u),
        }
    }

    pub(super) fn pdf(&self, normal: Vec3, dir: Vec3) -> f32 {
        match self {
            Self::Constant(_) if normal == Vec3::ZERO => 0.25 * FRAC_1_PI,
            Self::Constant(_) => normal.dot(dir).max(0.0) * FRAC_1_PI,
            Self::Picture(picture) => picture.pdf(dir),
        }
    }

    /// A direction for any surface, and its density.
    pub(super) fn sample_any(&self, u: [f32; 2]) -> (Vec3, f32) {
        self.sample(Vec3::ZERO, u)
    }
}

impl LightParts {
    /// Whether the lights with a position are identical.
    pub(super) fn same_near(&self, other: &Self) -> bool {
        let same_shapes = match (&self.shapes, &other.shapes) {
            (Some(one), Some(other)) => Arc::ptr_eq(one, other),
            (None, None) => true,
            _ => false,
        };
        same_shapes && self.points == other.points
    }

    pub(super) fn shape_count(&self) -> usize {
        self.shapes.as_ref().map_or(0, |shapes| shapes.len())
    }

    /// Lights with a position.
    pub(super) fn finite_count(&self) -> usize {
        self.shape_count() + self.points.len()
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Light of the previous picture at the point that a pixel shows. The point is projected to its previous
//! position, and the four pixels around it contribute if they showed the same surface.
//! Source: temporal reprojection [NSL*07], light and surface apart, bilinear so that light stays in place
//! while the camera moves by fractions of pixels. Differs: samples are counted, so that pixels without
//! samples bring nothing. Space: world. View-dependent light is forgotten at a rate given by the rotation of
//! the view direction relative to the width of the lobes.
//! Invariant: no light is reused from another surface, nor from a point that has moved further than the
//! pixels nearby show.
//! Tests: `super::tests`.

use std::sync::Arc;

use glam::Vec3;
use gnurt_shading::CameraShader;

use super::around::around;
use super::lattice::Lattice;
use super::surface_key::{Light, SurfaceKey};
use super::surface_sample::SurfaceSample;

/// Rate at which light of narrow lobes is forgotten, relative to the rotation of the view in units of their
/// width.
const TURN: f32 = 4.0;
/// Lobes as wide as this scatter to all sides.
const WIDE: f32 = 0.99;

/// A picture in motion.
pub(super) struct Before {
    pub(super) camera: Arc<dyn CameraShader>,
    /// Where its middle was seen from.
    pub(super) eye: Vec3,
    pub(super) lattice: Lattice,
    /// Row by row of the lattice.
    pub(super) surface_keys: Vec<SurfaceKey>,
    pub(super) lights: Vec<Light>,
}

impl Before {
    /// Where that point was, in pixels from the left and the top; NaN where it was not.
    #[inline(always)]
    pub(super) fn origin(&self, sample: &SurfaceSample) -> [f32; 2] {
        let [width, height] = self.lattice.full.map(|side| side as f32);
        let at = self.camera.project(sample.image, width / height);
        at.map_or([f32::NAN; 2], |[across, up]| [across * width, (1.0 - up) * height])
    }

    /// The light at that point, which was at `origin`; `most` samples count at most.
    #[inline(always)]
    pub(super) fn recall(&self, sample: &SurfaceSample, origin: [f32; 2], most: f32) -> Light {
        if !sample.surface_key.is_surface() {
            return Light::default();
        }
        let [width, height] = self.lattice.size();
        // From the middle of a pixel that would be left of and above all.
        let [x, y] = self.lattice.column_and_row(origin).map(|at| at + 1.0);
        if !(x > 0.0 && y > 0.0 && x < width as f32 + 1.0 && y < height as f32 + 1.0) {
            return Light::default();
        }
        let (left, top) = (x as i32, y as i32);
        let beyond = [x - left as f32, y - top as f32];
        let (at, weights) = around([left - 1, top - 1], beyond, [width, height]);
        let keys = [
            &self.surface_keys[at[0]],
            &self.surface_keys[at[1]],
            &self.surface_keys[at[2]],
            &self.surface_keys[at[3]],
        ];
        let weights = sample.surface_key.agreeing(keys, weights.into(), 1.5).to_array();
        let mut sum = Light::default();
        for (i, weight) in at.into_iter().zip(weights) {
            sum.add(&self.lights[i], weight);
        }
        let weights = weights[0] + weights[1] + weights[2] + weights[3];
        if weights <= 0.0 {
            return Light::default();
        }
        let Light { mean, count } = sum.averaged();
        let count = (count / weights).min(most);
        Light { mean, count: count * self.lasting(sample) }
    }

    /// The share of samples that still count.
    #[inline(always)]
    fn lasting(&self, sample: &SurfaceSample) -> f32 {
        let roughness = sample.tint.roughness;
        if roughness >= WIDE {
            return 1.0;
        }
        let angle_change =
            (sample.toward - (self.eye - sample.image).normalize_or_zero()).length() * TURN / roughness;
        1.0 / (1.0 + angle_change * angle_change)
    }
}

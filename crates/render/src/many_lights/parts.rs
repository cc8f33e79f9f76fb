// SPDX-License-Identifier: GPL-3.0-or-later
//! Layers of light of the integrators with virtual lights: emission, environment, direct and indirect light.
//! All walks of a step have as many edges as the others, and steps add their light one after the other. So each part
//! is the light that was added between two moments; what remains in the end is indirect.
//! Invariant: the radiance is only read, and the parts make it, up to rounding.
//! Tests: crates/render/tests/light_layers.rs.

use glam::Vec3;
use gnurt_shading::Vec3s;

use crate::expressions::{LightLayer, Part};

/// Parts of the light against camera rays, by lane.
#[derive(Default)]
pub(super) struct Parts {
    emission: Vec3s,
    environment: Vec3s,
    direct: Vec3s,
    /// The light before the parts that come next.
    before: Vec3s,
}

impl Parts {
    /// Takes light on the first edge. `emission` is that of surfaces passed on the way, `missed` are the lanes that met nothing.
    pub(super) fn take_visible(&mut self, radiance: &Vec3s, emission: &Vec3s, missed: &[bool]) {
        self.emission.clone_from(radiance);
        self.environment.reset(radiance.len(), Vec3::ZERO);
        self.direct.reset(radiance.len(), Vec3::ZERO);
        for lane in (0..radiance.len()).filter(|&lane| missed[lane]) {
            let passed = emission.get(lane);
            self.emission.set(lane, passed);
            self.environment.set(lane, radiance.get(lane) - passed);
        }
        self.begin(radiance);
    }

    /// Light that comes from now on belongs together.
    pub(super) fn begin(&mut self, radiance: &Vec3s) {
        self.before.clone_from(radiance);
    }

    /// Takes the light since [`begin`](Self::begin) as light that was scattered once.
    pub(super) fn take_direct(&mut self, radiance: &Vec3s) {
        for lane in 0..radiance.len() {
            self.direct.add(lane, radiance.get(lane) - self.before.get(lane));
        }
    }

    /// Writes the layers, of which those of colours and outputs stay black.
    pub(super) fn write(&self, radiance: &Vec3s, layers: &[LightLayer], out: &mut [Vec3s]) {
        for (layer, out) in layers.iter().zip(out) {
            out.reset(radiance.len(), Vec3::ZERO);
            let Some(part) = layer.part() else { continue };
            for lane in 0..radiance.len() {
                let [emission, environment, direct] =
                    [&self.emission, &self.environment, &self.direct].map(|part| part.get(lane));
                out.set(
                    lane,
                    match part {
                        Part::Emission => emission,
                        Part::Environment => environment,
                        Part::Direct => direct,
                        Part::Indirect => radiance.get(lane) - emission - environment - direct,
                    },
                );
            }
        }
    }
}

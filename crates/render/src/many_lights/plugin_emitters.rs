// SPDX-License-Identifier: GPL-3.0-or-later
//! Starts of light paths at lights that only have `illuminate`, and at an environment that only has `miss`.
//! Queries at some points classify them: a light with a constant position or direction is a point light or a
//! directional light. Its radiance is queried where a path arrives.
//! Space: world. Units: as `LightBatch`.
//! Invariant: unbiased for lights of these two kinds; others, and those that light none of the points, start
//! no paths.
//! Tests: `tests`, crates/render/tests/shader_lights.rs.

use std::f32::consts::PI;
use std::sync::Arc;

use glam::Vec3;
use gnurt_image::srgb::luminance;
use gnurt_shading::sampling::{Basis, Distribution, concentric_disk, sample_pair, uniform_sphere};
use gnurt_shading::{EnvironmentShader, LightBatch, LightShader, SampleKey, Vec3s};

/// Points at which lights are queried.
const ASKED: u32 = 64;
/// Share of the scene's extent, and of a unit direction, that answers may differ by.
const SLACK: f32 = 1e-3;
/// Marks numbers for those points.
const PURPOSE: u32 = 0x1a3b_0000;

/// Where a light is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum StartKind {
    /// At a point.
    Near(Vec3),
    /// In a direction, unit.
    Far(Vec3),
    /// Everywhere around the scene.
    Around,
}

/// The source of the light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Source {
    /// A light, by its number among those of the shader table.
    Light(usize),
    Environment,
}

struct PluginLight {
    source: Source,
    start_kind: StartKind,
}

/// The lights of a shader table that light paths can start at.
#[derive(Default)]
pub(crate) struct PluginEmitters {
    plugin_lights: Vec<PluginLight>,
    /// By their light in the scene.
    choice: Option<Distribution>,
    /// Centre and radius of a ball around the scene.
    ball: (Vec3, f32),
}

/// The first edge of a light path.
pub(super) struct Start {
    pub(super) org: Vec3,
    /// Unit.
    pub(super) dir: Vec3,
    pub(super) source: Source,
    /// One over the density of position and direction.
    pub(super) weight: f32,
}

impl PluginEmitters {
    pub(crate) fn new(
        lights: &[Arc<dyn LightShader>],
        environment: Option<&dyn EnvironmentShader>,
        bounds: Option<([f32; 3], [f32; 3])>,
    ) -> Self {
        let Some((low, high)) = bounds.map(|(low, high)| (Vec3::from(low), Vec3::from(high))) else {
            return Self::default();
        };
        let ball = (0.5 * (low + high), (0.5 * (high - low)).length());
        let (mut plugin_lights, mut powers) = (Vec::new(), Vec::new());
        for (light, shader) in lights.iter().enumerate() {
            if let Some((start_kind, power)) = locate(&**shader, low, high) {
                plugin_lights.push(PluginLight { source: Source::Light(light), start_kind });
                powers.push(f64::from(power));
            }
        }
        if let Some(environment) = environment {
            plugin_lights.push(PluginLight { source: Source::Environment, start_kind: StartKind::Around });
            powers.push(f64::from(4.0 * PI * PI * ball.1 * ball.1 * mean(environment)));
        }
        let choice = Distribution::new(powers);
        if choice.is_none() {
            plugin_lights.clear();
        }
        Self { plugin_lights, choice, ball }
    }

    /// The number of lights; 0 if the choice among them is unknown.
    pub(super) fn len(&self) -> usize {
        self.plugin_lights.len()
    }

    /// Starts a path, if there are lights: `choice` chooses one, all numbers are in [0, 1).
    pub(super) fn start(&self, choice: f32, start_kind: [f32; 2], direction: [f32; 2]) -> Option<Start> {
        let chosen = self.choice.as_ref()?.sample(choice);
        let emitter_choice = &self.plugin_lights[chosen.index];
        Some(match emitter_choice.start_kind {
            StartKind::Near(org) => {
                let weight = 4.0 * PI / chosen.probability;
                Start { org, dir: uniform_sphere(direction), source: emitter_choice.source, weight }
            }
            StartKind::Far(_) | StartKind::Around => {
                let (towards, weight) = match emitter_choice.start_kind {
                    StartKind::Far(towards) => (towards, 1.0),
                    _ => (uniform_sphere(direction), 4.0 * PI),
                };
                let (centre, radius) = self.ball;
                let on_disk = (concentric_disk(start_kind) * radius).extend(0.0);
                let org = centre + towards * radius + Basis::around(towards).to_world(on_disk);
                let weight = weight * PI * radius * radius / chosen.probability;
                Start { org, dir: -towards, source: emitter_choice.source, weight }
            }
        })
    }
}

/// Light at points, as intensity if the light has a position.
pub(super) fn arriving(light: &dyn LightShader, p: &Vec3s, normal: &Vec3s) -> Vec<Vec3> {
    let mut out = LightBatch::default();
    out.reset(p.len());
    light.illuminate(p, normal, &vec![[0.5; 2]; p.len()], &mut out);
    let scale = |i: usize| if out.dist[i].is_finite() { out.dist[i] * out.dist[i] } else { 1.0 };
    (0..p.len()).map(|i| out.radiance.get(i) * scale(i)).collect()
}

/// Mean radiance of an environment.
fn mean(environment: &dyn EnvironmentShader) -> f32 {
    let mut dirs = Vec3s::default();
    for sample in 0..ASKED {
        let key = SampleKey { pixel: PURPOSE, sample, branch: PURPOSE };
        dirs.push(uniform_sphere(sample_pair(0, key, 0, PURPOSE + 2)));
    }
    let mut visible = Vec3s::splat(dirs.len(), Vec3::ZERO);
    environment.miss(&dirs, &mut visible);
    let sum: f32 = (0..dirs.len()).map(|i| luminance(visible.get(i).into())).sum();
    // One that is dark in all of these directions may be bright in others.
    if sum.is_finite() { (sum / ASKED as f32).max(f32::MIN_POSITIVE) } else { 0.0 }
}

/// Where a light is, and about how much it brings to the scene; `None` if it is neither a point nor a direction.
fn locate(light: &dyn LightShader, low: Vec3, high: Vec3) -> Option<(StartKind, f32)> {
    let mut p = Vec3s::default();
    for sample in 0..ASKED {
        let key = SampleKey { pixel: PURPOSE, sample, branch: PURPOSE };
        let ([x, y], [z, _]) = (sample_pair(0, key, 0, PURPOSE), sample_pair(0, key, 0, PURPOSE + 1));
        p.push(low + (high - low) * Vec3::new(x, y, z));
    }
    // Lights with an extent are seen elsewhere with other numbers.
    let random: Vec<[f32; 2]> =
        (0..ASKED).map(|i| [(i as f32 + 0.5) / ASKED as f32, (i as f32 * 0.37).fract()]).collect();
    let [mut out, other] = [Vec3::Z, -Vec3::Z].map(|normal| {
        let mut out = LightBatch::default();
        out.reset(p.len());
        light.illuminate(&p, &Vec3s::splat(p.len(), normal), &random, &mut out);
        out
    });
    // A light may be dark for normals that face away from it.
    for i in 0..p.len() {
        if out.radiance.get(i) != Vec3::ZERO {
            continue;
        }
        out.dir.set(i, other.dir.get(i));
        out.radiance.set(i, other.radiance.get(i));
        out.dist[i] = other.dist[i];
    }
    let extent = (high - low).length();
    let mut found: Option<StartKind> = None;
    let mut power = 0.0;
    for i in (0..p.len()).filter(|&i| out.radiance.get(i) != Vec3::ZERO) {
        let (dir, dist) = (out.dir.get(i), out.dist[i]);
        let arriving = luminance(out.radiance.get(i).into());
        let (start_kind, brought) = if dist.is_finite() {
            (StartKind::Near(p.get(i) + dir * dist), 4.0 * PI * arriving * dist * dist)
        } else {
            (StartKind::Far(dir), PI * 0.25 * extent * extent * arriving)
        };
        power += brought / ASKED as f32;
        let agrees = match (*found.get_or_insert(start_kind), start_kind) {
            (StartKind::Near(a), StartKind::Near(b)) => a.distance(b) <= SLACK * (extent + dist),
            (StartKind::Far(a), StartKind::Far(b)) => a.distance(b) <= SLACK,
            _ => false,
        };
        if !agrees {
            return None;
        }
    }
    found.filter(|_| power > 0.0 && power.is_finite()).map(|start_kind| (start_kind, power))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lights the half space z > 0: from a position, from a direction, or from a position that depends on the
    /// random numbers.
    struct PluginLight(u32);

    impl LightShader for PluginLight {
        fn illuminate(&self, p: &Vec3s, _: &Vec3s, random: &[[f32; 2]], out: &mut LightBatch) {
            for i in (0..p.len()).filter(|&i| p.get(i).z > 0.0) {
                let start_kind =
                    Vec3::new(0.5, 0.5, 2.0) + Vec3::X * if self.0 == 2 { random[i][0] } else { 0.0 };
                let offset = if self.0 == 1 { Vec3::Y } else { start_kind - p.get(i) };
                out.dir.set(i, offset.normalize());
                out.dist[i] = if self.0 == 1 { f32::INFINITY } else { offset.length() };
                out.radiance.set(i, Vec3::ONE);
            }
        }
    }

    /// An environment without a finite radiance.
    struct Boundless;

    impl EnvironmentShader for Boundless {
        fn miss(&self, dir: &Vec3s, out: &mut Vec3s) {
            (0..dir.len()).for_each(|i| out.set(i, Vec3::INFINITY));
        }
    }

    /// Otherwise light paths with these numbers would start at other lights.
    #[test]
    fn lamps_that_cannot_be_chosen_are_none() {
        let bounds = Some(([-1.0; 3], [1.0; 3]));
        let plugin_lights = PluginEmitters::new(&[], Some(&Boundless), bounds);
        assert_eq!(plugin_lights.len(), 0, "an environment without a power");
        assert!(plugin_lights.start(0.5, [0.5; 2], [0.5; 2]).is_none(), "no path starts there");
        let plugin_lights = PluginEmitters::new(&[Arc::new(PluginLight(1))], Some(&Boundless), bounds);
        assert_eq!(plugin_lights.len(), 2, "beside a lamp it only has no chance");
        assert_eq!(plugin_lights.start(0.999, [0.5; 2], [0.5; 2]).map(|s| s.source), Some(Source::Light(0)));
    }

    #[test]
    fn places_are_found() {
        let start_kind =
            |kind| locate(&PluginLight(kind), -Vec3::ONE, Vec3::ONE).map(|(start_kind, _)| start_kind);
        let Some(StartKind::Near(p)) = start_kind(0) else { panic!("a point light") };
        assert!(p.distance(Vec3::new(0.5, 0.5, 2.0)) < 1e-5, "where it is: {p}");
        assert_eq!(start_kind(1), Some(StartKind::Far(Vec3::Y)), "a directional one");
        assert_eq!(start_kind(2), None, "one with an extent");
        assert_eq!(locate(&PluginLight(0), -Vec3::ONE, Vec3::ZERO), None, "one that lights nothing here");
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! A sky with a sun's glow, painted into an environment texture.
//! Source: original; a gradient after the look, not the physics, of clear skies. Space: that of
//! [`Light::Environment`]: the middle of the picture lies along -z, its upper edge at +y. Radiance is linear.

use std::f32::consts::{PI, TAU};
use std::sync::Arc;

use super::noise::smoothstep;
use crate::affine::Affine;
use crate::light::Light;
use crate::scene::Scene;
use crate::texture::{Filter, TexelData, Texels, Texture, Wrap};

const WIDTH: u32 = 512;
const HEIGHT: u32 = 256;

/// The colours of a sky.
#[derive(Clone, Copy)]
pub(super) struct Sky {
    pub(super) zenith: [f32; 3],
    pub(super) horizon: [f32; 3],
    /// Added around the sun, most at the horizon.
    pub(super) glow: [f32; 3],
    /// Below the horizon.
    pub(super) ground: [f32; 3],
    /// Towards the sun; a unit vector.
    pub(super) sun: [f32; 3],
    /// Irradiance that the sun gives a surface that faces it.
    pub(super) sunlight: [f32; 3],
}

impl Sky {
    /// Adds the sky and its sun to a scene.
    pub(super) fn add_to(&self, scene: &mut Scene) {
        let direction_of = |x: u32, y: u32| {
            let phi = ((x as f32 + 0.5) / WIDTH as f32 - 0.5) * TAU;
            let theta = (y as f32 + 0.5) / HEIGHT as f32 * PI;
            [theta.sin() * phi.sin(), theta.cos(), -theta.sin() * phi.cos()]
        };
        let texels = (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y)));
        let data = texels.map(|(x, y)| {
            let [r, g, b] = self.radiance(direction_of(x, y));
            [r, g, b, 1.0]
        });
        let texels = Texels { width: WIDTH, height: HEIGHT, data: TexelData::Float(data.collect()) };
        let texture = scene.add_texture(Texture {
            name: "sky".into(),
            texels: Arc::new(texels),
            wrap: [Wrap::Repeat, Wrap::ClampToEdge],
            filter: Filter::Linear,
        });
        let world_from_light = Affine::IDENTITY;
        scene.add_light(Light::Environment { radiance: [1.0; 3], texture: Some(texture), world_from_light });
        let direction = self.sun.map(|x| -x);
        scene.add_light(Light::Directional { direction, irradiance: self.sunlight });
    }

    /// What comes from a direction, a unit vector.
    fn radiance(&self, direction: [f32; 3]) -> [f32; 3] {
        let up = direction[1];
        let toward_sun: f32 = (0..3).map(|k| direction[k] * self.sun[k]).sum::<f32>().clamp(-1.0, 1.0);
        let height = up.max(0.0).powf(0.5);
        // A wide warm veil low over the horizon, and a bright patch close around the sun.
        let veil = (0.5 + 0.5 * toward_sun).powi(4) * (-5.0 * up.abs()).exp();
        let patch = toward_sun.max(0.0).powi(60) + 6.0 * toward_sun.max(0.0).powi(900);
        let ground = smoothstep(0.0, -0.02, up);
        [0, 1, 2].map(|k| {
            let air = self.horizon[k] + (self.zenith[k] - self.horizon[k]) * height;
            let air = air + self.glow[k] * (veil + patch);
            air + (self.ground[k] - air) * ground
        })
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Skies with a sun's glow, painted into an environment texture; some that any scene can be put under.
//! A gradient after the appearance, not the physics, of clear skies. Space: that of [`Light::Environment`]:
//! the middle of the picture lies along -z, its upper edge at +y. Radiance is linear.

use std::f32::consts::{PI, TAU};
use std::sync::Arc;

use super::noise::smoothstep;
use crate::affine::Affine;
use crate::light::Light;
use crate::scene::Scene;
use crate::texture::{Filter, TexelData, Texels, Texture, Wrap};

/// A built-in sky.
#[derive(Clone, Copy, Debug)]
pub struct BuiltinSky {
    /// The name after `builtin:`.
    pub name: &'static str,
    /// The appearance of the sky, in one line.
    pub description: &'static str,
    sky: Sky,
}

/// All skies.
pub const SKIES: &[BuiltinSky] = &[
    BuiltinSky {
        name: "day",
        description: "a clear day, the sun high on the left, behind a camera that faces -z",
        sky: Sky {
            zenith: [0.17, 0.33, 0.75],
            horizon: [0.75, 0.86, 1.0],
            glow_radiance: [0.8, 0.75, 0.65],
            ground: [0.16, 0.15, 0.13],
            sun: [-0.5, 0.7, 0.51],
            sunlight: [4.4, 4.1, 3.7],
        },
    },
    BuiltinSky { name: "evening", description: "a low warm sun on the left", sky: EVENING },
    BuiltinSky {
        name: "overcast",
        description: "clouds without a sun, three times as bright above as at the horizon",
        sky: Sky {
            zenith: [1.2, 1.23, 1.28],
            horizon: [0.4, 0.41, 0.43],
            glow_radiance: [0.0; 3],
            ground: [0.1, 0.1, 0.1],
            sun: [0.0, 1.0, 0.0],
            sunlight: [0.0; 3],
        },
    },
];

/// A low sun to the left behind the camera, and a sky that becomes warmer towards the sun.
pub(super) const EVENING: Sky = Sky {
    zenith: [0.10, 0.20, 0.46],
    horizon: [0.62, 0.56, 0.58],
    glow_radiance: [0.95, 0.50, 0.22],
    ground: [0.012, 0.050, 0.062],
    sun: [-0.8387, 0.3172, 0.4427],
    sunlight: [4.1, 2.75, 1.65],
};

impl BuiltinSky {
    /// Puts a scene under this sky; `world_from_sky` is a rotation that maps +y to the up direction.
    pub fn add_to(&self, scene: &mut Scene, world_from_sky: Affine) {
        self.sky.add_to(scene, world_from_sky);
    }
}

const WIDTH: u32 = 512;
const HEIGHT: u32 = 256;

/// The colours of a sky.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sky {
    pub(super) zenith: [f32; 3],
    pub(super) horizon: [f32; 3],
    /// Added around the sun, most at the horizon.
    pub(super) glow_radiance: [f32; 3],
    /// Below the horizon.
    pub(super) ground: [f32; 3],
    /// Towards the sun; a unit vector.
    pub(super) sun: [f32; 3],
    /// Irradiance that the sun gives a surface that faces it.
    pub(super) sunlight: [f32; 3],
}

impl Sky {
    /// Adds the sky and its sun to a scene.
    pub(super) fn add_to(&self, scene: &mut Scene, world_from_light: Affine) {
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
        scene.add_light(Light::Environment { radiance: [1.0; 3], texture: Some(texture), world_from_light });
        if self.sunlight != [0.0; 3] {
            let direction = world_from_light.vector(self.sun.map(|x| -f64::from(x))).map(|x| x as f32);
            scene.add_light(Light::Directional { direction, irradiance: self.sunlight, angle: 0.0 });
        }
    }

    /// Radiance from a direction, which is a unit vector.
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
            let air = air + self.glow_radiance[k] * (veil + patch);
            air + (self.ground[k] - air) * ground
        })
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Lights without a surface; surfaces emit through their material's emission.
//! Source: glTF KHR_lights_punctual for point, spot and directional; units are radiometric, or photometric
//! ones all over the scene: no efficacy is applied (docs/decisions/0019).
//! Space: world. Colours are linear.

use serde::{Deserialize, Serialize};

use crate::affine::Affine;
use crate::id::TextureId;

/// How the light of a spot fades from its inner cone, where the share of the way between the cones' cosines is 1, to its outer one, where
/// it is 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ConeEdge {
    /// By the square of that share, as glTF recommends.
    #[default]
    Squared,
    /// By its smooth step 3x² - 2x³, as in pbrt and Blender.
    Smooth,
}

impl ConeEdge {
    /// The inner angle with which the squared edge lets through as much light as this one does with `inner`; half angles, radians. For
    /// formats that know the squared edge alone.
    #[must_use]
    pub fn squared_inner(self, inner: f32, outer: f32) -> f32 {
        match self {
            Self::Squared => inner,
            // The mean of a square is a third, that of a smooth step a half.
            Self::Smooth => (0.75 * inner.cos() + 0.25 * outer.cos()).clamp(-1.0, 1.0).acos(),
        }
    }
}

/// A light.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Light {
    /// From a point to all sides.
    Point {
        /// Where it is.
        position: [f32; 3],
        /// Radiant intensity, W·sr⁻¹ per channel.
        intensity: [f32; 3],
        /// Of a disc around the position from which its light comes, and which faces the lit point, world units: 0 = a point. It
        /// lights surfaces and media; no ray sees it.
        radius: f32,
    },
    /// From a point into a cone.
    Spot {
        /// Where it is.
        position: [f32; 3],
        /// Where it points, any length but zero.
        direction: [f32; 3],
        /// Radiant intensity inside the inner cone, W·sr⁻¹.
        intensity: [f32; 3],
        /// Half angle of the full-intensity cone, radians.
        inner_angle: f32,
        /// Half angle at which it ends, radians, > inner.
        outer_angle: f32,
        /// How it fades between the two.
        edge: ConeEdge,
        /// Of a disc around the position, as that of a point.
        radius: f32,
    },
    /// From infinitely far away.
    Directional {
        /// Where its light goes, any length but zero.
        direction: [f32; 3],
        /// Irradiance on a surface that faces it, W·m⁻².
        irradiance: [f32; 3],
        /// The angle that its disc covers, radians: 0 = parallel light, at most pi. The disc is of the same radiance everywhere, and
        /// lights surfaces and media; rays that hit nothing do not see it.
        angle: f32,
    },
    /// From everywhere: the radiance of rays that hit nothing. A scene has at most one; the last one counts.
    Environment {
        /// Radiance, multiplied to the texture.
        radiance: [f32; 3],
        /// Latitude-longitude picture: its middle lies along -z, its upper edge at +y of the light's space.
        texture: Option<TextureId>,
        /// A rotation.
        world_from_light: Affine,
    },
    /// The radiance of camera rays that hit nothing, in place of the environment; it lights nothing. The last
    /// one counts, and none where there is no environment.
    Backdrop {
        /// Radiance, a latitude-longitude picture like that of an environment.
        texture: TextureId,
        /// A rotation.
        world_from_light: Affine,
    },
}

impl Light {
    /// The picture that it shows.
    #[must_use]
    pub fn texture(&self) -> Option<TextureId> {
        match self {
            Self::Environment { texture, .. } => *texture,
            Self::Backdrop { texture, .. } => Some(*texture),
            _ => None,
        }
    }

    /// The same, to be changed.
    pub fn texture_mut(&mut self) -> Option<&mut TextureId> {
        match self {
            Self::Environment { texture, .. } => texture.as_mut(),
            Self::Backdrop { texture, .. } => Some(texture),
            _ => None,
        }
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Clips: named sets of channels, each of which drives one value of the animation.
//! Source: glTF 2.0 section 3.11, KHR_animation_pointer. Numbers of targets are indices of the lists of
//! `Animation`.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::sampler::Sampler;

/// A piece of animation that is played by itself.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Clip {
    /// A label; may be empty, need not be unique.
    pub name: String,
    /// The driven values; if two channels drive one value, the last one counts.
    pub channels: Vec<Channel>,
}

impl Clip {
    /// The times of its first and of its last key, in seconds; the pose is constant outside of these. `[0,
    /// 0]` without channels.
    #[must_use]
    pub fn range(&self) -> [f64; 2] {
        let ranges = self.channels.iter().map(|channel| channel.sampler.range());
        ranges.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]).unwrap_or([0.0; 2])
    }
}

/// A value over time and its target.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Channel {
    /// The driven value.
    pub target: Target,
    /// Its keys.
    pub sampler: Arc<Sampler>,
}

/// The target of a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Target {
    /// Where a node is: 3 numbers.
    Translation(u32),
    /// The rotation of a node: 4 numbers.
    Rotation(u32),
    /// How large a node is: 3 numbers.
    Scale(u32),
    /// Whether a node and those below it are seen: 1 number, 0 = no.
    Visible(u32),
    /// A set of morph weights: as many numbers as it has.
    Weights(u32),
    /// One weight of a set: 1 number.
    Weight(u32, u32),
    /// A vertical angle of view, in radians: 1 number.
    FieldOfView(u32),
    /// A part of a light.
    Light(u32, LightPart),
    /// A part of a material.
    Material(u32, FactorPart),
}

/// Parts of a light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum LightPart {
    /// 3 numbers.
    Color,
    /// 1 number.
    Intensity,
    /// Radians: 1 number.
    InnerAngle,
    /// Radians: 1 number.
    OuterAngle,
}

/// Parts of a material: the fields of [`Factors`](crate::factors::Factors).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[expect(missing_docs, reason = "named as what they are parts of")]
pub enum FactorPart {
    BaseColor,
    Metallic,
    Roughness,
    Emission,
    EmissionStrength,
    AlphaCutoff,
    NormalScale,
    Ior,
    Specular,
    SpecularColor,
    Clearcoat,
    ClearcoatRoughness,
    SheenColor,
    SheenRoughness,
    Transmission,
    Thickness,
    AttenuationColor,
    AttenuationDistance,
    Dispersion,
    Anisotropy,
    AnisotropyRotation,
    Iridescence,
    IridescenceIor,
    IridescenceThickness,
    DiffuseTransmission,
    DiffuseTransmissionColor,
    /// The texture of the base colour is moved.
    BaseTexture(TexturePart),
    MetallicRoughnessTexture(TexturePart),
    NormalTexture(TexturePart),
    AnisotropyTexture(TexturePart),
    EmissionTexture(TexturePart),
}

/// Parts of a texture's transform.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[expect(missing_docs, reason = "named as in KHR_texture_transform")]
pub enum TexturePart {
    Offset,
    Rotation,
    Scale,
}

impl LightPart {
    /// How many numbers it has.
    #[must_use]
    pub fn width(self) -> usize {
        if self == Self::Color { 3 } else { 1 }
    }
}

impl FactorPart {
    /// How many numbers it has.
    #[must_use]
    pub fn width(self) -> usize {
        match self {
            Self::BaseColor => 4,
            Self::Emission
            | Self::SpecularColor
            | Self::SheenColor
            | Self::AttenuationColor
            | Self::DiffuseTransmissionColor => 3,
            Self::BaseTexture(part)
            | Self::MetallicRoughnessTexture(part)
            | Self::NormalTexture(part)
            | Self::AnisotropyTexture(part)
            | Self::EmissionTexture(part) => match part {
                TexturePart::Offset | TexturePart::Scale => 2,
                TexturePart::Rotation => 1,
            },
            _ => 1,
        }
    }
}

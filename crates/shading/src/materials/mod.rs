// SPDX-License-Identifier: GPL-3.0-or-later
//! The built-in surfaces, as shaders: each returns the BSDF of its points, from which Whitted's renderer
//! derives the radiance; [`Material`] adds emission, bumps and opacity around any of them.
//! Source: see each file. One model, one file.

mod bump;
mod color;
mod dielectric;
mod direct;
mod layer_textures;
mod material;
mod matte;
mod metallic_roughness;
mod mirror;
mod normal_map;
mod points;
mod shadow_catcher;
mod unlit;
mod whitted;

pub use bump::BumpMap;
pub use color::{Coverage, Emission, OpacityChannel, TexturedColor};
pub use dielectric::Dielectric;
pub use direct::direct_light;
pub use layer_textures::{Channel, LayerTextures};
pub use material::Material;
pub use matte::Matte;
pub use metallic_roughness::{Anisotropy, MetallicRoughness};
pub use mirror::Mirror;
pub use normal_map::NormalMap;
pub use points::{FromPoints, RoughGlass, metal, rough_matte};
pub use shadow_catcher::ShadowCatcher;
pub use unlit::Unlit;
pub use whitted::{recursive_radiance, scattered_radiance};

/// Perceptual roughness below which Whitted's renderer traces reflections, and sees straight through glass.
/// Just above 0.5, which many glTF files have: there, at grazing views, rays drawn from the microfacets leave
/// a tenth to a quarter of the error of light samples.
pub const SMOOTH: f32 = 0.55;

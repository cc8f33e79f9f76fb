// SPDX-License-Identifier: GPL-3.0-or-later
//! The built-in surfaces, as shaders: each scatters; [`Material`] adds emission and holes around any of them.
//! Source: see each file. One model, one file.

mod color;
mod dielectric;
mod direct;
mod ggx;
mod material;
mod matte;
mod metallic_roughness;
mod mirror;

pub use color::{Coverage, Emission, OpacityChannel, TexturedColor};
pub use dielectric::Dielectric;
pub use direct::direct_light;
pub use material::Material;
pub use matte::Matte;
pub use metallic_roughness::{MetallicRoughness, NormalMap, SMOOTH};
pub use mirror::Mirror;

// SPDX-License-Identifier: GPL-3.0-or-later
//! Lights: where light comes from, and how a point chooses a direction to it.
//! Source: see each file. One light, one file.

mod area;
mod environment;
mod punctual;

pub use area::{EmissiveTriangle, Emitter, TriangleLights};
pub use environment::{ConstantEnvironment, PictureEnvironment};
pub use punctual::{DirectionalLight, PointLight, SpotLight};

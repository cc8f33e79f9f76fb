// SPDX-License-Identifier: GPL-3.0-or-later
//! Lights: where light comes from, and how a point chooses a direction to it.
//! Source: see each file. One light, one file.

mod area;
mod beam;
mod disc;
mod environment;
mod lamp_points;
mod light_emission;
mod light_estimates;
mod light_groups;
mod light_lanes;
mod light_parts;
mod light_set;
mod light_set_lanes;
#[cfg(test)]
mod light_set_tests;
mod light_tree;
mod places;
mod punctual;
mod shape;
mod sphere;
mod spherical;

pub use area::{EmissiveShape, Emitter, EmitterPoint, EmitterShaders, ShapeLights, looking_at};
pub use beam::Beam;
pub use environment::{ConstantEnvironment, PictureEnvironment};
pub use lamp_points::{LampPoint, Place};
pub use light_emission::LightRay;
pub use light_estimates::LEAST_SHARE;
pub use light_lanes::{LightSampleX16, LightSamples};
pub use light_parts::{EnvironmentLight, LightId, LightKind, LightParts, LightSample};
pub use light_set::LightSet;
pub use punctual::{Cone, ConeEdge, DirectionalLight, PointLight};
pub use shape::Outline;

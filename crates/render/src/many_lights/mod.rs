// SPDX-License-Identifier: GPL-3.0-or-later
//! Light transport by many virtual lights: their placement, their shading, and the rays that replace their
//! clamped part.
//! Source: see each file.

mod bidirectional;
mod bound;
mod candidates;
mod caustics;
mod chosen;
mod chunks;
mod common;
mod contribution;
mod cut;
mod direct;
mod estimate;
mod eye;
mod gather;
mod instant;
pub(crate) mod interleave;
mod lanes;
mod learned_lights;
mod light_choice;
mod light_path;
mod make;
mod metropolis;
mod mixing;
mod neighbours;
mod offers;
mod parts;
mod pass;
mod persistent;
mod pilots;
mod plugin_emitters;
mod shader_lights;
#[cfg(test)]
mod test_points;
mod vpl;
mod walk;

pub(crate) use common::Common;
pub(crate) use estimate::{radiance, split_radiance};
pub(crate) use make::pass_lights;
pub(crate) use pass::PassLights;
pub use persistent::PersistentLights;
pub(crate) use persistent::alike;
pub(crate) use plugin_emitters::PluginEmitters;

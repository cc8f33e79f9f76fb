// SPDX-License-Identifier: GPL-3.0-or-later
//! Light transport by many virtual lights: where they are put, how they shine, how what they cannot bring comes back.
//! Source: see each file.

mod bidirectional;
mod bound;
mod candidates;
mod chosen;
mod chunks;
mod common;
mod cut;
mod direct;
mod estimate;
mod eye;
mod gather;
mod instant;
pub(crate) mod interleave;
mod kept;
mod lamp_choice;
mod lamps;
mod lanes;
mod light_path;
mod make;
mod metropolis;
mod mixing;
mod neighbours;
mod offers;
mod pass;
mod pilots;
mod promise;
mod shader_lamps;
mod shader_lights;
#[cfg(test)]
mod test_points;
mod vpl;
mod walk;

pub(crate) use common::Common;
pub(crate) use estimate::{radiance, radiance_apart};
pub use kept::KeptLights;
pub(crate) use kept::alike;
pub(crate) use make::pass_lights;
pub(crate) use pass::PassLights;
pub(crate) use shader_lamps::ShaderLamps;

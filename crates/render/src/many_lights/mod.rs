// SPDX-License-Identifier: GPL-3.0-or-later
//! Light transport by many virtual lights: where they are put, how they shine, how what they cannot bring comes back.
//! Source: see each file.

mod bidirectional;
mod bound;
mod candidates;
mod cut;
mod estimate;
mod eye;
pub(crate) mod finals;
mod follow;
mod gather;
mod instant;
pub(crate) mod interleave;
mod kept;
mod lamps;
mod lanes;
mod light_path;
mod metropolis;
mod neighbours;
mod pass;
mod pilots;
mod promise;
mod shader_lamps;
mod shader_lights;
mod vpl;

pub(crate) use estimate::{radiance, radiance_apart};
pub use kept::KeptLights;
pub(crate) use lamps::LampChoice;
pub(crate) use pass::PassLights;
pub(crate) use shader_lamps::ShaderLamps;
pub(crate) use shader_lights::{illuminate, light_count};

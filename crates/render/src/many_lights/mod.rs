// SPDX-License-Identifier: GPL-3.0-or-later
//! Light transport by many virtual lights: where they are put, how they shine, how what they cannot bring comes back.
//! Source: see each file.

mod bound;
mod estimate;
mod eye;
mod follow;
mod gather;
mod instant;
#[expect(dead_code, reason = "bidirectional instant radiosity comes next")]
mod light_path;
mod pass;
mod vpl;

pub(crate) use estimate::radiance;
pub(crate) use pass::PassLights;

// SPDX-License-Identifier: GPL-3.0-or-later
//! Plain types of shaders in the shading language, for programs with its compiler and without.
//! The compiler and the shaders that it makes are `gnurt-sl-shading`, which uses these types; a program without it reports
//! an error for every script, and still has types for its options and controls.

mod access;
mod camera_frame;
mod kind;
mod names;
mod parameter;
mod pictures;

pub use access::Access;
pub use camera_frame::CameraFrame;
pub use kind::Kind;
pub use names::{built_in_name, document_and_node};
pub use parameter::{Parameter, ParameterValue};
pub use pictures::sampler;

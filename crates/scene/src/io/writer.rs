// SPDX-License-Identifier: GPL-3.0-or-later
//! Parts of writers, for scene formats in crates of their own.
//! A writer checks that its files can be written, writes those that others refer to first, and notes what it leaves out.
//! Tests: `tests/save.rs`.

pub use super::save::files::{check_writable, leave_out, write};
pub use super::save::losses::{of_layer_textures, of_texcoords};
pub use super::save::png::{encode as encode_texture, measures};

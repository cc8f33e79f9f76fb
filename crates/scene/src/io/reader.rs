// SPDX-License-Identifier: GPL-3.0-or-later
//! Parts of readers, for scene formats in crates of their own.
//! A reader is a [`Format`](super::Format) whose `read` opens files by [`Access`], charges its budget before
//! it takes memory, and notes oddities in [`Warnings`](super::Warnings). Tests: `tests/ply.rs`.

pub use super::clean::{clean, clean_attributes, clean_by, replace_bad};
pub use super::corner_numbers::CornerNumbers;
pub use super::error::quoted;
pub use super::plain::Cursor;
pub use super::ply::{read_mesh as read_ply_mesh, read_mesh_from as read_ply_mesh_from};
pub use super::polygon::Cutter;
pub use super::source::{Access, open, percent_decode, read_by, resolve};
pub use super::textures::{Meaning, Pictures};
pub use super::threads::fill;
pub use crate::tangents::BYTES_PER_TRIANGLE as TANGENT_BYTES_PER_TRIANGLE;
pub use gnurt_image::{Budget, Excess};

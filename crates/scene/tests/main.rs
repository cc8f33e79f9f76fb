// SPDX-License-Identifier: GPL-3.0-or-later
//! Readers, writers and animation.
//!
//! One program for all files: each of its own takes a second to link.

mod animated_scenes;
mod animation;
mod benchmark_scenes;
mod broken_files;
mod builtin;
mod common;
mod confine;
mod mutations;
mod obj;
mod ply;
mod save;
#[cfg(feature = "snapshot")]
mod snapshot;
mod solids;

// SPDX-License-Identifier: GPL-3.0-or-later
//! The reader. What concerns several formats, and animation, is tested in `crates/scene/tests`.

#[path = "../../scene/tests/common/mod.rs"]
mod common;
mod draco;
mod extensions;
mod gltf;

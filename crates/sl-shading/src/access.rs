// SPDX-License-Identifier: GPL-3.0-or-later
//! Which files shaders may name, with the cache of their machine code.
//! Tests: `tests/scripts.rs`.

use crate::codes::Codes;

/// Where shaders may take files from.
pub type Access = gnurt_shading::script::Access<Codes>;

// SPDX-License-Identifier: GPL-3.0-or-later
//! What the virtual lights of all passes of a picture have in common: learned by the first pass that asks, and kept for the others.
//! Invariant: a function of world, camera and options, whichever pass learns it.
//! Tests: crates/render/tests/accumulation.rs.

use std::sync::OnceLock;

use super::light_choice::LightChoice;

/// Learned once for a world, a camera and options.
#[derive(Debug, Default)]
pub(crate) struct Common {
    /// Lamps that matter, where it is worth asking.
    pub(super) light_choices: OnceLock<Option<LightChoice>>,
    /// How many light paths bring the lights that are wanted.
    pub(super) paths: OnceLock<u32>,
}

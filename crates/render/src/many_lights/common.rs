// SPDX-License-Identifier: GPL-3.0-or-later
//! State that the virtual lights of all passes of a picture share: the first pass computes it, and later
//! passes reuse it.
//! Invariant: a function of world, camera and options, independent of the pass that computes it.
//! Tests: crates/render/tests/accumulation.rs.

use std::sync::OnceLock;

use super::light_choice::LightChoice;

/// Learned once for a world, a camera and options.
#[derive(Debug, Default)]
pub(crate) struct Common {
    /// The important lights, if the choice is learned.
    pub(super) light_choices: OnceLock<Option<LightChoice>>,
    /// The number of light paths for the requested number of virtual lights.
    pub(super) paths: OnceLock<u32>,
}

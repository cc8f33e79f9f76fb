// SPDX-License-Identifier: GPL-3.0-or-later
//! A skeleton's pose. Tests: `tests/skeletons.rs`.

use std::collections::HashMap;

use gnurt_scene::Affine;

/// A skeleton at a moment.
pub(crate) struct Skeleton {
    pub(crate) joints: Vec<String>,
    /// By joint: from where it was bound to where it is.
    pub(crate) moves: Vec<Affine>,
    /// Weights of blend shapes by name.
    pub(crate) weights: HashMap<String, f32>,
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! The program's choices for rendering: samples, depth, origin of rays.
//! Tests: tests/c/frames.c, tests/c/errors.c.

/// How many samples frames take, and whether they add up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Sampling {
    /// Samples that a frame takes of each pixel.
    pub(crate) samples: u32,
    /// Whether frames of an unchanged scene add up.
    pub(crate) progressive: bool,
}

impl Default for Sampling {
    fn default() -> Self {
        Self { samples: 1, progressive: false }
    }
}

/// Numbers that bound rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Limits {
    /// Greatest depth of a ray; camera rays have 0.
    pub(crate) max_depth: u32,
    /// How far from their surface rays begin, world units.
    pub(crate) epsilon: f32,
}

impl Default for Limits {
    fn default() -> Self {
        Self { max_depth: 16, epsilon: 1e-4 }
    }
}

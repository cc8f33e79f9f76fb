// SPDX-License-Identifier: GPL-3.0-or-later
//! Kinds of scripts.

/// The kind of a script.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The appearance of a surface: `surface` and `shader`.
    Surface,
    /// The offsets of a surface's vertices.
    Displacement,
    /// A light.
    Light,
    /// A camera.
    Camera,
    /// Radiance of rays that hit nothing.
    Environment,
    /// The colour of a pixel.
    Pixel,
}

impl Kind {
    /// The word in the language.
    #[must_use]
    pub const fn kind_name(self) -> &'static str {
        match self {
            Self::Surface => "surface",
            Self::Displacement => "displacement",
            Self::Light => "light",
            Self::Camera => "camera",
            Self::Environment => "environment",
            Self::Pixel => "pixel",
        }
    }
}

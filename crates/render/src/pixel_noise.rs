// SPDX-License-Identifier: GPL-3.0-or-later
//! The choice between independent errors of pixels and errors that cancel out between neighbours.
//! Source: [AW20]. Tests: crates/render/tests/noise_color.rs.

use crate::by_name::by_name;

/// How the errors of neighbouring pixels relate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum PixelNoise {
    /// They are independent. A picture may get further samples later.
    #[default]
    White,
    /// Errors of pixels side by side have opposite signs more often than not: a mean over neighbours, as eyes take it from
    /// afar, has less noise \[AW20\]. Denoisers that compare neighbours gain nothing. The number of samples must be known
    /// before the first one; powers of two give the most. Without effect on the integrators with virtual lights.
    Blue,
}

impl PixelNoise {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::White, Self::Blue];

    /// The name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::White => "white",
            Self::Blue => "blue",
        }
    }
}

by_name!(PixelNoise, UnknownPixelNoise, "noise");

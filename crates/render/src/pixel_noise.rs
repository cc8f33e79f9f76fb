// SPDX-License-Identifier: GPL-3.0-or-later
//! The choice between independent errors of pixels and errors that cancel out between neighbours.
//! Source: [AW20]. Tests: crates/render/tests/noise_color.rs.

use std::fmt;
use std::str::FromStr;

/// How the errors of neighbouring pixels relate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum PixelNoise {
    /// They are independent. A picture may get further samples later.
    #[default]
    White,
    /// Errors of pixels side by side have opposite signs more often than not: a mean over neighbours, by an eye or a
    /// filter, has less noise \[AW20\]. The number of samples must be known before the first one; powers of two give the
    /// most. Without effect
    /// on the integrators with virtual lights.
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

impl FromStr for PixelNoise {
    type Err = UnknownPixelNoise;

    fn from_str(name: &str) -> Result<Self, UnknownPixelNoise> {
        let found = Self::ALL.into_iter().find(|noise| noise.name() == name);
        found.ok_or_else(|| UnknownPixelNoise(name.to_owned()))
    }
}

/// A name that is none of [`PixelNoise::ALL`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown noise '{0}': expected {names}", names = PixelNoise::ALL.map(PixelNoise::name).join(", "))]
pub struct UnknownPixelNoise(pub String);

impl fmt::Display for PixelNoise {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

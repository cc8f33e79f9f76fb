// SPDX-License-Identifier: GPL-3.0-or-later
//! Kinds of mattes, and which of them a picture has.

/// What the mattes of a layer are of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MatteKind {
    /// Instances, by their names.
    Object,
    /// Materials.
    Material,
    /// The objects that instances show: all copies of one thing.
    Asset,
}

impl MatteKind {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Object, Self::Material, Self::Asset];

    /// The name of its layers, before the two digits.
    #[must_use]
    pub fn layer(self) -> &'static str {
        match self {
            Self::Object => "CryptoObject",
            Self::Material => "CryptoMaterial",
            Self::Asset => "CryptoAsset",
        }
    }
}

/// Mattes of a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mattes {
    /// Their kinds, each once; none by default.
    pub kinds: Vec<MatteKind>,
    /// Things per pixel in the picture; odd numbers count as the next one. The others are left out.
    pub depth: u32,
}

impl Mattes {
    /// Things per pixel that films and compositors expect.
    pub const DEPTH: u32 = 6;
    /// Most things per pixel.
    pub const DEEPEST: u32 = 32;

    /// How many layers a kind has: each holds two things.
    pub(crate) fn layers(&self) -> u32 {
        self.depth.clamp(1, Self::DEEPEST).div_ceil(2)
    }
}

impl Default for Mattes {
    fn default() -> Self {
        Self { kinds: Vec::new(), depth: Self::DEPTH }
    }
}

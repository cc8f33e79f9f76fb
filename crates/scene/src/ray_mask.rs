// SPDX-License-Identifier: GPL-3.0-or-later
//! Which rays see an instance. Source: the masks of Embree; our bits have the meaning of Blender's "ray
//! visibility". A bit for each kind of ray; a ray sees an instance that has its bit.

use std::ops::{BitAnd, BitOr, Not};

use serde::{Deserialize, Serialize};

/// Kinds of rays, as bits. All kinds by default.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct RayMask(pub u32);

impl RayMask {
    /// None.
    pub const NONE: Self = Self(0);
    /// Rays from the camera to the first surface, and straight on through transparent surfaces and media.
    pub const CAMERA: Self = Self(1);
    /// Rays from a surface to a light: an instance without this bit casts no shadow.
    pub const SHADOW: Self = Self(2);
    /// All other rays: reflected, refracted and scattered ones, and those from lights. An instance without
    /// this bit is in no mirror, takes no part in indirect light, and emits no light to others.
    pub const OTHER: Self = Self(4);
    /// All; bits that no kind of ray has are for later.
    pub const ALL: Self = Self(u32::MAX);

    /// Whether both have a bit in common.
    #[must_use]
    pub const fn meets(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }
}

impl Default for RayMask {
    fn default() -> Self {
        Self::ALL
    }
}

impl BitOr for RayMask {
    type Output = Self;

    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl BitAnd for RayMask {
    type Output = Self;

    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

impl Not for RayMask {
    type Output = Self;

    fn not(self) -> Self {
        Self(!self.0)
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! A hint about the deformation of an object. See docs/explanation/moving.md. glTF: the string `gnurt_motion`
//! in a mesh's `extras`. Tests: `tests::parts`, `tests/save.rs`.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// The treatment of an object's tree after edits of its vertices. Its instances may move with any hint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Motion {
    /// Derived from the edits.
    #[default]
    Auto,
    /// Vertices stay: an edit is the exception, and the tree is built again.
    Static,
    /// The object moves as a whole, by its instances.
    Rigid,
    /// Vertices move again and again: the tree is refitted, and built again when that pays.
    Deforming,
    /// Vertices move among poses that come back: the tree is refitted, and not built again.
    Known,
}

impl Motion {
    const NAMES: [(&'static str, Self); 5] = [
        ("auto", Self::Auto),
        ("static", Self::Static),
        ("rigid", Self::Rigid),
        ("deforming", Self::Deforming),
        ("known", Self::Known),
    ];
}

impl fmt::Display for Motion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = Self::NAMES.into_iter().find(|(_, motion)| motion == self);
        f.write_str(name.map_or("auto", |(name, _)| name))
    }
}

/// A word that is none of the five.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownMotion(String);

impl fmt::Display for UnknownMotion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "unknown motion {:?}; valid are: auto, static, rigid, deforming, known", self.0)
    }
}

impl std::error::Error for UnknownMotion {}

impl FromStr for Motion {
    type Err = UnknownMotion;

    fn from_str(name: &str) -> Result<Self, UnknownMotion> {
        let known = Self::NAMES.into_iter().find(|(known, _)| *known == name);
        known.map(|(_, motion)| motion).ok_or_else(|| UnknownMotion(name.chars().take(40).collect()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts() {
        for (name, motion) in Motion::NAMES {
            assert_eq!((name.parse(), motion.to_string()), (Ok(motion), name.to_owned()), "there and back");
        }
        let error = "wobbly".parse::<Motion>().expect_err("no such word").to_string();
        assert!(error.contains("wobbly") && error.contains("deforming"), "{error}");
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Structures of the feature `research`, by name: kd-trees, interval hierarchies and grids of the literature.
//! Without it they are not compiled, and what asks for one gets an error that says so.
//! Tests: `tests::names_are_found`.

use gnurt::accel::Structure;

use crate::Error;

#[cfg(feature = "research")]
const ALL: &[(&str, Structure)] = &[
    ("bih-plain", Structure::PlainBih),
    ("bih", Structure::Bih),
    ("b-kd", Structure::BKd),
    ("kd", Structure::Kd),
    ("grid", Structure::Grid),
];
#[cfg(not(feature = "research"))]
const ALL: &[(&str, Structure)] = &[];

/// Whether they are compiled in.
pub const IS_COMPILED: bool = !ALL.is_empty();

/// The structure of this name.
pub(crate) fn find(name: &str) -> Option<Structure> {
    ALL.iter().find(|(known, _)| *known == name).map(|&(_, structure)| structure)
}

/// The same, or an error that names the feature.
pub(crate) fn require(name: &str) -> Result<Structure, Error> {
    find(name).ok_or_else(|| Error::NoResearch { structure: name.into() })
}

/// The name of a structure; `bvh` of any that is not of this feature.
pub(crate) fn name(structure: Structure) -> &'static str {
    ALL.iter().find(|&&(_, known)| known == structure).map_or("bvh", |&(name, _)| name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_found() {
        assert_eq!(name(Structure::Bvh), "bvh", "not of the feature");
        for &(known, structure) in ALL {
            assert_eq!((find(known), name(structure)), (Some(structure), known), "both ways");
        }
        let error = require("octree").expect_err("there is none").to_string();
        assert!(error.contains("--features research"), "{error}");
    }
}

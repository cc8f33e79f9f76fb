// SPDX-License-Identifier: GPL-3.0-or-later
//! Scenes made by code, each complete with camera and lights: `builtin:NAME`.
//! Every scene is the same on every machine: its chance comes from hashes, not from a clock.
//! Tests: `tests/builtin.rs`.

mod cornell;
mod island;
mod materials;
mod noise;
mod rooms;
pub(crate) mod shapes;
mod sky;
mod slit;
mod spheres;
mod textures;

use crate::scene::Scene;
pub use sky::{BuiltinSky, SKIES};

/// A built-in scene.
#[derive(Clone, Copy, Debug)]
pub struct Builtin {
    /// The name after `builtin:`.
    pub name: &'static str,
    /// The contents of the scene, in one line.
    pub description: &'static str,
    make: fn() -> Scene,
}

/// All scenes, the showpiece first.
pub const ALL: &[Builtin] = &[
    Builtin {
        name: "island",
        description: "a wooded island with a lighthouse in a still sea at evening: thousands of instances, sun and sky",
        make: island::scene,
    },
    Builtin {
        name: "cornell",
        description: "the Cornell box: two blocks under an area light",
        make: cornell::scene,
    },
    Builtin {
        name: "spheres",
        description: "mirror, glass, metal and matte spheres on a checkerboard under a sky",
        make: spheres::scene,
    },
    Builtin {
        name: "materials",
        description: "balls from smooth to rough and from plastic to metal under three lights",
        make: materials::scene,
    },
    Builtin {
        name: "textures",
        description: "how textures repeat, mirror, clamp and are filtered, on four panels",
        make: textures::scene,
    },
    Builtin {
        name: "slit",
        description: "two rooms with a slit between them: the camera is in the one without the light",
        make: slit::scene,
    },
    Builtin {
        name: "rooms",
        description: "three rooms joined by narrow openings: the light is in the last one, the camera in the first",
        make: rooms::scene,
    },
    Builtin {
        name: "wind",
        description: "the island from nearer, its trees in the wind: an animation of four seconds that comes back to itself",
        make: island::in_the_wind,
    },
];

/// Makes the scene of this name.
#[must_use]
pub fn load(name: &str) -> Option<Scene> {
    ALL.iter().find(|builtin| builtin.name == name).map(|builtin| (builtin.make)())
}

/// All names and the most similar one to `name`, for messages.
pub(crate) fn suggestion(name: &str) -> String {
    let names: Vec<_> = ALL.iter().map(|b| b.name).collect();
    let nearest = names.iter().min_by_key(|candidate| edit_distance(candidate, name));
    let did_you_mean = nearest.filter(|candidate| edit_distance(candidate, name) <= 3);
    let did_you_mean = did_you_mean.map_or(String::new(), |n| format!("did you mean `builtin:{n}`? "));
    format!("{did_you_mean}valid are {}", names.join(", "))
}

/// Fewest letters to add, drop or change that make `b` of `a` (Levenshtein).
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().take(64).collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = std::mem::replace(&mut row[0], i + 1);
        for (j, &y) in b.iter().enumerate() {
            let changed = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = changed.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn suggests_the_nearest() {
        assert!(suggestion("iland").starts_with("did you mean `builtin:island`?"), "{}", suggestion("iland"));
        assert!(suggestion("xyzzyxyzzy").starts_with("valid are island"), "nothing is near");
        assert_eq!(edit_distance("kitten", "sitting"), 3, "the textbook pair");
    }
}

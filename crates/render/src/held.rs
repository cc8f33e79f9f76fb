// SPDX-License-Identifier: GPL-3.0-or-later
//! The part of a camera ray that sees a hole in the picture.
//! Tests: crates/render/tests/holdouts.rs.

/// What holdouts take of a camera ray.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Held {
    /// The share of its coverage, in [0, 1].
    pub(crate) share: f32,
    /// Whether its light, too: of an instance that is held out. Closures only bring none.
    pub(crate) is_dark: bool,
}

impl Held {
    /// All of a ray.
    pub(crate) const ALL: Self = Self { share: 1.0, is_dark: true };

    /// That of a lane; none if it is not known.
    pub(crate) fn of(list: &[Self], lane: usize) -> Self {
        list.get(lane).copied().unwrap_or_default()
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! What a scene was last committed to, without a lock. Embree's manual for who may commit when.
//! Tests: `tests/c/joined.c`, `tests/c/stale.c`.

use crate::objects::{Committed, Scene};

/// `None` before the first commit.
#[inline]
pub(crate) fn present(scene: &Scene) -> Option<&Committed> {
    // SAFETY: null, or what the last commit has made: the scene keeps it until it is committed twice with edits in between, and programs
    // do not commit edits of a scene while they ask it, or another that shows it. Commits of a scene without edits change nothing.
    unsafe { scene.current().as_ref() }
}

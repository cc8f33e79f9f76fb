// SPDX-License-Identifier: GPL-3.0-or-later
//! The last commit of a scene, without a lock. Embree's manual defines the allowed threads of a commit.
//! Tests: `tests/c/joined.c`, `tests/c/stale.c`.

use crate::objects::{Committed, Scene};

/// `None` before the first commit.
#[inline]
pub(crate) fn present(scene: &Scene) -> Option<&Committed> {
    // SAFETY: null, or the result of the last commit. The scene keeps it until it is committed twice with
    // edits in between, and programs do not commit edits of a scene while they query it, or another that
    // shows it. Commits of a scene without edits change nothing.
    unsafe { scene.current().as_ref() }
}

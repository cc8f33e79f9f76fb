// SPDX-License-Identifier: GPL-3.0-or-later
//! Panics of our own end here: none crosses to C.
//! Calls of the program must not run inside: a catcher of panics cannot pass a C++ exception on to the
//! program's own handler, and would end the process. Tests: tests/window.rs.

use std::panic::{AssertUnwindSafe, catch_unwind};

/// Runs `f`; `None` if a panic has stopped it.
pub(crate) fn guard<T>(f: impl FnOnce() -> T) -> Option<T> {
    catch_unwind(AssertUnwindSafe(f)).ok()
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Panics of our own end here: none crosses to C.
//! What runs inside must call nothing of the program: an exception of C++ on its way to the program's own handler cannot
//! be let through by what stops panics, and would end the process. Tests: tests/window.rs.

use std::panic::{AssertUnwindSafe, catch_unwind};

/// Runs `f`; `None` if a panic has stopped it.
pub(crate) fn guard<T>(f: impl FnOnce() -> T) -> Option<T> {
    catch_unwind(AssertUnwindSafe(f)).ok()
}

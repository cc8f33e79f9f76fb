// SPDX-License-Identifier: GPL-3.0-or-later
//! Files in a circle of imports that remain to be separated. This list only ever gets shorter: nothing is
//! added to it, and `tidy` requires the removal of a file that has left its circle.

/// Paths from the root.
#[rustfmt::skip]
pub(super) const KNOWN: &[&str] = &[
];

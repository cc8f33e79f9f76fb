// SPDX-License-Identifier: GPL-3.0-or-later
//! How chores fail.

/// A failure, in one line.
pub(crate) type Failure = String;

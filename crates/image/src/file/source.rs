// SPDX-License-Identifier: GPL-3.0-or-later
//! Where the formats' readers read from.

use std::io::{BufRead, Seek};

/// Bytes that can be read in any order.
pub(super) trait Source: BufRead + Seek {}
impl<T: BufRead + Seek> Source for T {}

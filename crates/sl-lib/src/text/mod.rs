// SPDX-License-Identifier: GPL-3.0-or-later
//! Strings, and numbers as text.

mod format;
mod hash;
mod number;
mod strings;

pub use format::{Argument, Format, TooFewArguments};
pub use hash::{hash_string, hash64};
pub use number::{Notation, digits, general};
pub use strings::{endswith, getchar, split, startswith, stof, stoi, strlen, substr};

// SPDX-License-Identifier: GPL-3.0-or-later
//! Tokens to a tree.
//! The grammar is OSL's, read by recursive descent, operators by how tightly they bind.
//!
//! `reader` looks at tokens; `expression`, `statement` and `declaration` teach it each part of the grammar; `fold` works out
//! constants that are written as sums; `unescape` reads strings.

mod declaration;
mod expression;
mod fold;
mod illuminance;
mod reader;
mod statement;
mod unescape;

pub use reader::{Parsed, Parser};
pub(crate) use unescape::unescape;

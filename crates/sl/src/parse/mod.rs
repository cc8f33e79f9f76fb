// SPDX-License-Identifier: GPL-3.0-or-later
//! Tokens to a tree.
//! The grammar is OSL's, read by recursive descent, operators by how tightly they bind.
//!
//! `reader` reads tokens; `expression`, `statement` and `declaration` add each part of the grammar to it;
//! `fold` computes constants that are written as sums; `unescape` reads strings.

mod declaration;
mod expression;
mod fold;
mod illuminance;
mod reader;
mod statement;
mod unescape;

pub use reader::{Parsed, Parser};
pub(crate) use unescape::unescape;

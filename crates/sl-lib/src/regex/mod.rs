// SPDX-License-Identifier: GPL-3.0-or-later
//! Regular expressions, for `regex_search` and `regex_match`: ECMAScript's syntax and meaning, on bytes.
//!
//! Lookahead and references back are a part of it, which the libraries that run in linear time lack; so this is a machine that
//! goes back, with a bound on its steps.

mod parse;
mod program;
mod run;

pub use run::{Groups, Regex, RegexError, TooManySteps};

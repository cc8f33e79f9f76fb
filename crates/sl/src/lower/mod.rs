// SPDX-License-Identifier: GPL-3.0-or-later
//! The checked tree to the intermediate form: structs become a symbol for each member, functions are put where they are
//! called, conversions become assignments.
//! Which operations a piece of text becomes is OSL's.
//!
//! `lowerer` keeps the state, `position` what can be assigned to; `expression`, `logic`, `aggregate`, `call` and `statement` each
//! lower a part of the language; `parameter` makes defaults, `program` the whole.

mod aggregate;
mod call;
mod effects;
mod expression;
mod logic;
mod lowerer;
mod parameter;
mod position;
mod program;
mod statement;

pub use program::lower;

// SPDX-License-Identifier: GPL-3.0-or-later
//! Lowers the checked tree to the intermediate form: structs become a symbol for each member, functions are
//! inlined, conversions become assignments. The choice of operations is OSL's.
//!
//! `lowerer` keeps the state, `position` handles assignable expressions; `expression`, `logic`, `aggregate`,
//! `call` and `statement` each lower a part of the language; `parameter` makes defaults, `program` the whole.

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

// SPDX-License-Identifier: GPL-3.0-or-later
//! The intermediate form: operations on typed symbols, with control flow as nested blocks. Its text form is `.oso`.
//! Operations and their arguments are those of OSL's compiler, so that its files can be read and ours by it.
//!
//! Blocks are nested and not joined by jumps, because lanes of different opinion go through a block together: a back end makes
//! masks of `If`, `Loop`, `break`, `continue`, `return` and `exit`, and one value a variable where it needs that.
//! `shader` is the form itself, `visit` walks it, `verify` checks that it is whole, `write` and `read` are
//! the text form, `flat` numbers operations as the text does.

mod flat;
mod read;
mod shader;
mod tokens;
mod verify;
mod visit;
mod write;

pub use flat::Flat;
pub use read::read;
pub use shader::{Block, Node, Op, Shader, SourcePosition, SymId, Symbol, SymbolKind};
pub use verify::verify;
pub use visit::{Use, ops, ops_mut, uses};
pub use write::write;

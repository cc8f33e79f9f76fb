// SPDX-License-Identifier: GPL-3.0-or-later
//! Resolves names, checks types and chooses overloads: tree in, checked tree out. The rules and the words of
//! messages are OSL's.
//!
//! `signature` and `builtins` list the functions, `scope` stores names, `checker` holds the state;
//! `expression`, `operator`, `assignment`, `call`, `overload`, `initializer`, `printf`, `special` and
//! `statement` each check a part of the language; `declaration` checks files.

mod assignment;
mod builtins;
mod call;
mod checker;
mod declaration;
mod expression;
mod initializer;
mod literal;
mod operator;
mod overload;
mod printf;
mod scope;
mod signature;
mod special;
mod statement;

pub use checker::{Known, Options};
pub use declaration::{check, check_library};
pub(crate) use literal::literal;

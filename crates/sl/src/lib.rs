// SPDX-License-Identifier: GPL-3.0-or-later
//! The shading language of GNU RT: OSL 1.14, from source text to an interpreter.
//! Source: the OSL specification 1.14; original code.
//!
//! Stages of a shader: `preprocess` (files to tokens), `parse` (to a tree, `ast`), `check` (names, types and
//! overloads, to `hir`), `lower` (to the intermediate form, `ir`, whose text form is `.oso`), `passes`
//! (analyses and optimisations). [`compile()`] does all of it. `opcode` is the table of operations.
#![forbid(unsafe_code)]

pub mod ast;
pub mod budget;
pub mod check;
mod compile;
pub mod diagnostics;
pub mod engine;
pub mod exec;
pub mod format;
pub mod group;
pub mod hir;
pub mod ir;
pub mod lexer;
pub mod lower;
pub mod opcode;
pub mod parse;
pub mod passes;
pub mod preprocess;
pub mod source;
pub mod stored;
pub mod token;
pub mod types;

pub use compile::{Compiled, Options, compile, preprocess as preprocess_only};

/// The version of OSL that is followed, as its tools print it.
pub const VERSION: &str = "1.14.7.0";
/// Major, minor and patch.
pub const VERSION_PARTS: [u32; 3] = [1, 14, 7];
/// The version as shaders compare it.
pub const VERSION_CODE: u32 = 11407;

// SPDX-License-Identifier: GPL-3.0-or-later
//! The C preprocessor: files in, tokens out.
//! The rules are those of C99.
//!
//! `macros` keeps and expands macros, `condition` decides `#if`, `driver` reads files and directives.

mod condition;
mod driver;
mod macros;

pub use driver::{Loader, Macros, Preprocessor};
pub use macros::Macro;

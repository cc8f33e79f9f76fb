// SPDX-License-Identifier: GPL-3.0-or-later
//! The front end, the passes and the interpreter.
//!
//! One program for all files: each of its own takes a second to link.

mod closures;
mod common;
mod diagnostics;
mod format;
mod hostile;
mod hostile_texts;
mod layers;
mod meaning;
mod passes;
mod shader_library;

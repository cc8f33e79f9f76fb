// SPDX-License-Identifier: GPL-3.0-or-later
//! The calls of the API as methods of the context, a file for each noun. Source: \[DWBS03\], OpenGL 1.x.
//! Invariant: a call that fails has changed nothing. Tests: the C programs of tests/c; `random`.

pub(crate) mod block;
pub(crate) mod camera;
pub(crate) mod current;
pub(crate) mod frame;
pub(crate) mod instance;
pub(crate) mod listener;
pub(crate) mod matrix;
pub(crate) mod object;
pub(crate) mod parameter;
pub(crate) mod query;
pub(crate) mod settings;
pub(crate) mod shader;
pub(crate) mod shader_class;
pub(crate) mod snapshot;
pub(crate) mod texture;
pub(crate) mod usage;

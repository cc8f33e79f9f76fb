// SPDX-License-Identifier: GPL-3.0-or-later
//! A shader class of a plugin, after all its statements have been checked. Invariants: each parameter lies in
//! its block; the callback of the class's kind is there; the library stays loaded as long as the class lives.
//! Tests: bindings/openrt/tests/plugins.rs (plugins that say wrong things).

use std::sync::Arc;

use crate::description::{Kind, Parameter};
use crate::ffi_library::Library;
use crate::ffi_rts::{BlockFn, CameraFn, IlluminateFn, LensFn, MissFn, PrepareFn, ShadeFn};

/// A parameter of a plugin's class.
#[derive(Clone, Debug)]
pub struct PluginParameter {
    /// The description that every class has.
    pub description: Parameter,
    /// Offset in the block per shader, bytes; not used for those that vary.
    pub offset: usize,
}

/// Functions of a class.
#[derive(Clone, Copy, Default)]
pub(crate) struct Calls {
    pub(crate) init: Option<BlockFn>,
    pub(crate) fini: Option<BlockFn>,
    pub(crate) prepare: Option<PrepareFn>,
    pub(crate) shade: Option<ShadeFn>,
    pub(crate) transmit: Option<ShadeFn>,
    pub(crate) miss: Option<MissFn>,
    pub(crate) illuminate: Option<IlluminateFn>,
    pub(crate) camera: Option<CameraFn>,
    pub(crate) camera_lens: Option<LensFn>,
}

/// A class of a plugin.
pub struct PluginClass {
    /// Its name.
    pub name: String,
    /// The file as the program named it.
    pub file: String,
    /// The purpose of its shaders.
    pub kind: Kind,
    /// Bytes of the block per shader.
    pub shader_size: usize,
    /// Alignment of that block, a power of two.
    pub shader_align: usize,
    /// Its parameters.
    pub parameters: Vec<PluginParameter>,
    pub(crate) calls: Calls,
    /// Keeps the functions where they are.
    pub(crate) library: Arc<Library>,
}

impl PluginClass {
    /// How messages name it.
    #[must_use]
    pub fn title(&self) -> String {
        format!("shader class \"{}\" of \"{}\"", self.name, self.file)
    }
}

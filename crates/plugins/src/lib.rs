// SPDX-License-Identifier: GPL-3.0-or-later
//! Shader plugins: classes in shared libraries of C's interface `openrt/rts.h`, loaded, checked, and called by batches.
//!
//! Programs that shade a scene of their own by a class, built-in or of a plugin, make a [`SceneShader`]. The C API,
//! whose programs load classes and set parameters call by call, takes the parts of [`host`].
//!
//! From a file to a picture: `search` finds it, `load` checks its description and returns a
//! [`host::PluginClass`]. A shader's values are in a [`host::PluginBlock`]. A frame copies the blocks,
//! prepares them, and gives the renderer its shaders ([`host::PluginFrame`]). `ffi*.rs` hold all of the
//! `unsafe` code.
#![deny(unsafe_code)]

mod class;
#[cfg(test)]
mod cost;
mod data_type;
mod description;
#[expect(unsafe_code, reason = "plugins describe the memory")]
mod ffi_block;
#[expect(unsafe_code, reason = "exceptions of others are caught")]
mod ffi_catch;
#[expect(unsafe_code, reason = "plugins call in, with pointers")]
mod ffi_host;
#[expect(unsafe_code, reason = "plugins read and write arrays")]
mod ffi_lanes;
#[expect(unsafe_code, reason = "code is loaded")]
mod ffi_library;
#[expect(unsafe_code, reason = "structures of C")]
mod ffi_rts;
#[expect(unsafe_code, reason = "plugins are called")]
mod ffi_shader;
#[expect(unsafe_code, reason = "the system is asked about a stack")]
mod ffi_stack;
#[cfg(all(unix, any(test, fuzzing)))]
#[expect(unsafe_code, reason = "plugins' functions are made")]
pub mod ffi_tables;
#[expect(unsafe_code, reason = "a child process is made")]
mod ffi_trial;
mod frame;
mod frame_shader;
mod frame_state;
mod load;
mod print_line;
mod scene_shader;
mod search;

pub use scene_shader::{SceneShader, is_script};

/// The parts that a host of plugins with a state machine needs: classes, blocks and frames one by one.
pub mod host {
    pub use crate::class::{PluginClass, PluginParameter};
    pub use crate::data_type::DataType;
    pub use crate::description::{Kind, Parameter};
    pub use crate::ffi_block::PluginBlock;
    pub use crate::ffi_shader::TRIANGLE_NUMBER;
    pub use crate::frame::PluginFrame;
    pub use crate::frame_state::FrameState;
    pub use crate::load::{LoadError, load, suggestion};
    pub use crate::print_line::print_line;
}

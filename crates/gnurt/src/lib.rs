// SPDX-License-Identifier: GPL-3.0-or-later
//! GNU RT: a free ray tracing system, the open implementation of OpenRT.
#![forbid(unsafe_code)]

pub mod defaults;
mod error;
mod load;
mod threads;

pub use error::Error;
pub use gnurt_accel as accel;
pub use gnurt_image as image;
pub use gnurt_render as render;
pub use gnurt_scene as scene;
pub use gnurt_shading as shading;
pub use gnurt_simd as simd;
pub use load::{BUILTIN, Loaded, load_scene};
pub use rayon::ThreadPool;
pub use threads::{cores, thread_pool};

// SPDX-License-Identifier: GPL-3.0-or-later
//! The contract of the command line, checked by running the program itself.
//! One file per clause; `harness` runs the program in a folder of its own.

#![expect(clippy::print_stdout, reason = "a failing table tells the row that it was at")]

mod animation;
mod arguments;
mod bands;
mod bench;
mod broken_pictures;
mod broken_scenes;
mod cameras;
mod checkpoint;
mod confine;
mod conversion;
mod denoise;
mod denoising;
mod determinism;
mod differences;
mod display;
mod film;
mod finished;
#[cfg(all(feature = "usd", target_os = "linux"))]
mod freecad;
mod harness;
mod info;
mod interface;
mod interrupts;
mod layers;
mod light_layers;
mod manuals;
mod mattes;
#[cfg(target_os = "linux")]
#[cfg(feature = "ocio")]
mod ocio;
mod out_of_core;
mod output;
mod overrides;
mod pieces;
mod recoverable;
mod relight;
mod samples;
#[cfg(target_os = "linux")]
mod scripts;
mod shader_outputs;
mod shader_queries;
mod shaders;
mod statistics;
mod surroundings;
mod textures;
#[cfg(feature = "usd")]
mod usd;
mod viewing;
mod volumes;
#[cfg(all(target_os = "linux", feature = "window"))]
mod window;
mod working_space;

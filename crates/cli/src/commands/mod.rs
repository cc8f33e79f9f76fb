// SPDX-License-Identifier: GPL-3.0-or-later
//! The subcommands, one file each. Each has `run`, which takes its arguments and returns its outcome.

#[cfg(all(test, feature = "bench"))]
#[expect(dead_code, reason = "its tests run in programs with benchmarks, too")]
mod absent_bench;
mod band_rows;
mod bands;
#[cfg_attr(not(feature = "bench"), path = "absent_bench.rs")]
pub(crate) mod bench;
#[cfg(feature = "bench")]
mod bench_files;
#[cfg(feature = "bench")]
mod bench_light;
mod contents;
pub(crate) mod convert;
pub(crate) mod denoise;
pub(crate) mod diff;
mod film;
mod frame;
pub(crate) mod info;
pub(crate) mod join;
mod light_layers;
pub(crate) mod manuals;
mod picture_info;
mod pictures;
mod pieces;
pub(crate) mod relight;
pub(crate) mod render;
pub(crate) mod scenes;
mod stage;
mod times;
pub(crate) mod trace;
pub(crate) mod view;
#[cfg(feature = "window")]
mod window;

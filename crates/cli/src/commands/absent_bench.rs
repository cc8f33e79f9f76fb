// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt bench` in a program without benchmarks.

use crate::arguments::BenchArguments;
use crate::environment::Environment;
use crate::failure::{Failure, Outcome};
use crate::messages::Messages;

/// Says how to get them.
pub(crate) fn run(_: &BenchArguments, _: &Environment, _: Messages) -> Outcome {
    Err(Failure::usage(
        "this program was compiled without benchmarks. `cargo run --release --features bench -- bench ...` compiles \
         them; `cargo build --release` and `cargo xtask install` have them",
    ))
}

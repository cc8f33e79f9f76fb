// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt bench` in a program without benchmarks.
//! Tests: `tests`, and `cargo xtask ci`, which compiles the program without features.

use crate::arguments::BenchArguments;
use crate::environment::Environment;
use crate::failure::{Failure, Outcome};
use crate::messages::Messages;

/// Reports how to get them.
pub(crate) fn run(_: &BenchArguments, _: &Environment, _: Messages) -> Outcome {
    Err(absent())
}

fn absent() -> Failure {
    Failure::usage(
        "this program was compiled without benchmarks. `cargo run --release --features bench -- bench ...` compiles \
         them; `cargo build --release` and `cargo xtask install` have them",
    )
}

#[cfg(test)]
mod tests {
    use super::absent;

    #[test]
    fn the_failure_has_a_remedy() {
        let failure = absent();
        let message = failure.message().expect("a message");
        assert!(
            message.contains("--features bench -- bench ...") && message.lines().count() == 1,
            "{message}"
        );
        assert_eq!(failure.status(), 2, "as of other requests that the program cannot meet");
    }
}

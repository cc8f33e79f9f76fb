// SPDX-License-Identifier: GPL-3.0-or-later
//! Chores of the workspace: `cargo xtask tidy | ci | install | installed | python | blender | notices | crates | wheel | dist | arm | miri | sanitize | results`.
//! Errors go to stderr, one line each, with exit status 1.
#![forbid(unsafe_code)]

mod arm;
mod blender;
mod ci;
mod command;
mod dist;
mod failure;
mod free_threads;
mod install;
mod installed;
mod notices;
mod publish;
mod python;
mod python_upload;
mod readme;
mod results;
mod sanitize;
mod tidy;
mod wheel;
mod workspace;

use std::process::ExitCode;

use failure::Failure;

struct Chore {
    name: &'static str,
    about: &'static str,
    run: fn(&[String]) -> Result<(), Failure>,
}

const CHORES: [Chore; 14] = [
    Chore {
        name: "tidy",
        about: "check arrows, file heads, sizes, words and where unsafe code lives",
        run: tidy::run,
    },
    Chore {
        name: "ci",
        about: "all that must pass: fmt, clippy, tidy, doc, tests, installed files, the README's commands",
        run: ci::run,
    },
    Chore {
        name: "install",
        about: "build and install: --prefix DIR [--destdir DIR] [--libdir DIR] ...",
        run: install::run,
    },
    Chore {
        name: "python",
        about: "build the Python package's compiled part, and run its tests: [--free-threaded [INTERPRETER]]",
        run: python::run,
    },
    Chore {
        name: "blender",
        about: "pack the extension for Blender: [--wheel FILE]; [--judge] renders beside Cycles",
        run: blender::run,
    },
    Chore {
        name: "installed",
        about: "install what the tests have built, and use it",
        run: installed::check,
    },
    Chore {
        name: "notices",
        about: "write the notices of all parts by others that are given away: [--check]",
        run: notices::run,
    },
    Chore {
        name: "crates",
        about: "pack all crates for crates.io: [--verify] compiles each, [--publish] sends them",
        run: publish::crates,
    },
    Chore {
        name: "wheel",
        about: "the Python package's wheel, in target/wheels: [--machine x86_64|aarch64] [--python INTERPRETER]; --check, --publish",
        run: wheel::run,
    },
    Chore { name: "dist", about: "tarballs and Debian packages, in target/dist", run: dist::run },
    Chore {
        name: "arm",
        about: "tests on 64-bit ARM, under emulation: shaders and some ray kernels; --whole, once a week",
        run: arm::run,
    },
    Chore {
        name: "miri",
        about: "unit tests with unsafe code in them, interpreted by Miri; once a week",
        run: sanitize::miri,
    },
    Chore {
        name: "sanitize",
        about: "the tests of the C APIs under address or thread sanitizer; once a week",
        run: sanitize::run,
    },
    Chore {
        name: "results",
        about: "measure docs/explanation/results.md: SCENES [--only ROW,...] [--all] [--quick] [--busy]",
        run: results::run,
    },
];

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match dispatch(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("error: {failure}");
            ExitCode::FAILURE
        }
    }
}

fn dispatch(arguments: &[String]) -> Result<(), Failure> {
    let list = || CHORES.map(|chore| format!("\n  {:<9} {}", chore.name, chore.about)).concat();
    let Some((name, rest)) = arguments.split_first() else {
        return Err(format!("which chore? one of:{}", list()));
    };
    match CHORES.iter().find(|chore| chore.name == name) {
        Some(chore) => (chore.run)(rest),
        None => Err(format!("unknown chore '{name}'; there are:{}", list())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknown_chores_list_the_known_ones() {
        for arguments in [vec![], vec!["bake".to_string()]] {
            let message = dispatch(&arguments).expect_err("there is no such chore");
            for chore in &CHORES {
                assert!(message.contains(chore.name), "{} is listed: {message}", chore.name);
            }
        }
    }
}

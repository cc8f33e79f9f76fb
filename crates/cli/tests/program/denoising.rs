// SPDX-License-Identifier: GPL-3.0-or-later
//! `--denoise`: which denoiser is used, what is said of it, and what is refused. Source: original.

use super::harness::{Folder, finish};

const SCENE: [&str; 9] =
    ["render", "builtin:cornell", "-r", "40x30", "--spp", "2", "--integrator", "path", "--max-depth=3"];

fn words<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&SCENE, more].concat()
}

#[test]
fn the_built_in_one_gives_the_same_bits_on_any_number_of_threads() {
    let folder = Folder::new();
    for (threads, picture) in [("1", "one.png"), ("7", "seven.png")] {
        let run = folder.run(&words(&["--denoise=built-in", "-t", threads, "-o", picture]));
        let run = run.success();
        let notes = run.lines("note: ");
        assert!(notes.iter().any(|line| line.contains("denoised by the built-in filter")), "{}", run.stderr);
    }
    folder.run(&words(&["-o", "noisy.png"])).success();
    assert_eq!(folder.read("one.png"), folder.read("seven.png"), "threads must not show");
    assert_ne!(folder.read("one.png"), folder.read("noisy.png"), "something was done");
    let quiet = folder.run(&words(&["-q", "--denoise=built-in", "-o", "quiet.png"]));
    assert_eq!(quiet.stderr, "", "quiet means quiet");
}

#[test]
fn a_library_that_is_none_is_an_error_or_a_reason() {
    let folder = Folder::new();
    let run = |how: &str| {
        let mut command = folder.command(&words(&[how, "-o", "a.exr"]));
        command.env("OIDN_LIB", folder.at("no.so"));
        finish(command)
    };
    run("--denoise=oidn").fails(1, "no.so");
    assert!(!folder.at("a.exr").exists(), "nothing was rendered");
    let other = run("--denoise").success();
    let notes = other.lines("note: ");
    assert!(notes.iter().any(|line| line.contains("built-in") && line.contains("no.so")), "{}", other.stderr);
}

#[test]
fn unknown_denoisers_are_refused_with_the_names_of_others() {
    Folder::new().run(&words(&["--denoise=oidm"])).fails(2, "did you mean 'oidn'?");
}

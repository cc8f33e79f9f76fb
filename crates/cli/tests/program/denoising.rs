// SPDX-License-Identifier: GPL-3.0-or-later
//! `--denoise`: the choice of the denoiser, its note, and rejections.

use super::harness::{Folder, finish};

const SCENE: [&str; 9] =
    ["render", "builtin:cornell", "-r", "40x30", "--spp", "2", "--integrator", "path", "--max-depth=3"];

fn arguments_given<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&SCENE, more].concat()
}

#[test]
fn the_built_in_one_gives_the_same_bits_on_any_number_of_threads() {
    let folder = Folder::new();
    for (threads, picture) in [("1", "one.png"), ("7", "seven.png")] {
        let run = folder.run(&arguments_given(&["--denoise=built-in", "-t", threads, "-o", picture]));
        let run = run.success();
        let notes = run.lines("note: ");
        assert!(notes.iter().any(|line| line.contains("denoised by the built-in filter")), "{}", run.stderr);
    }
    folder.run(&arguments_given(&["--denoise=none", "-o", "noisy.png"])).success();
    assert_eq!(folder.read("one.png"), folder.read("seven.png"), "threads must not show");
    assert_ne!(folder.read("one.png"), folder.read("noisy.png"), "something was done");
    let quiet = folder.run(&arguments_given(&["-q", "--denoise=built-in", "-o", "quiet.png"]));
    assert_eq!(quiet.stderr, "", "quiet means quiet");
}

#[test]
fn a_library_that_is_none_is_an_error_or_a_reason() {
    let folder = Folder::new();
    let run = |how: &str| {
        let mut command = folder.command(&arguments_given(&[how, "-o", "a.exr"]));
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
    Folder::new().run(&arguments_given(&["--denoise=oidm"])).fails(2, "did you mean 'oidn'?");
}

#[test]
fn files_with_layers_are_denoised_as_renderings_are() {
    let folder = Folder::new();
    folder.run(&arguments_given(&["-q", "--layers", "denoise", "-o", "noisy.exr"])).success();
    folder.run(&arguments_given(&["-q", "--denoise=built-in", "-o", "direct.exr"])).success();
    folder.gnurt("convert -q noisy.exr later.exr --denoise=built-in").success();
    // Layers of first hits are enough, if not as good.
    folder.run(&arguments_given(&["-q", "-o", "first.exr"])).success();
    folder.gnurt("convert -q first.exr first-hits.exr --denoise=built-in").success();
    let [noisy, direct, later] = ["noisy", "direct", "later"]
        .map(|name| gnurt::image::read(&folder.at(&format!("{name}.exr"))).expect("a picture"));
    let apart = |a, b| gnurt::image::compare(a, b).expect("of one size").mse;
    assert!(
        apart(&direct, &later) < 0.01 * apart(&direct, &noisy),
        "files keep less than memory, but enough"
    );
    folder.run(&arguments_given(&["-q", "-o", "flat.png"])).success();
    folder
        .gnurt("convert flat.png later.png --denoise=built-in")
        .fails(1, "flat.png: the picture has no channel");
    folder.gnurt("convert builtin:cornell box.obj --denoise").fails(2, "scenes have no noise");
}

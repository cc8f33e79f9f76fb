// SPDX-License-Identifier: GPL-3.0-or-later
//! Help, version, standard streams, `trace`.

use std::process::Stdio;

use super::harness::{Folder, collect, finish};
use super::samples;

#[test]
fn help_and_version_go_to_standard_output() {
    let folder = Folder::new();
    for line in ["--help", "-h", "help", "help render", "render --help", "diff -h", "--version", "-V"] {
        let run = folder.gnurt(line).success();
        assert!(!run.stdout.is_empty() && run.stderr.is_empty(), "gnurt {line}: {}", run.stderr);
    }
    assert!(folder.gnurt("--version").stdout.contains(env!("CARGO_PKG_VERSION")), "the version");
    let help = folder.gnurt("help render").stdout;
    for option in
        ["--output", "--resolution", "--spp", "--threads", "--seed", "--integrator", "--crop", "--heatmap"]
    {
        assert!(help.contains(option), "{option} is explained");
    }
}

/// Frequent options on one screen, and all on request, grouped by task.
#[test]
fn help_has_two_lengths() {
    let folder = Folder::new();
    for command in ["render", "view"] {
        let [short, all] =
            ["--help", "--help-all"].map(|help| folder.gnurt(&format!("{command} {help}")).success().stdout);
        let options = |text: &str| text.lines().filter(|line| line.trim_start().starts_with('-')).count();
        assert!((8..=15).contains(&options(&short)), "{command}: {} options:\n{short}", options(&short));
        assert!(short.lines().count() < 60, "one screen: {short}");
        assert!(options(&all) > 2 * options(&short), "{command}: all options:\n{all}");
        for option in ["--resolution", "--spp", "--eye", "--exposure", "--denoise", "--help-all"] {
            assert!(short.contains(option), "{command} {option} is for most people:\n{short}");
        }
        for heading in
            ["Picture:", "Camera:", "Light:", "Quality:", "Look:", "Time and machine:", "Messages:"]
        {
            assert!(all.contains(heading), "{command}, {heading}\n{all}");
        }
        for option in ["--vpls", "--isa", "--seed", "--filter", "--shader", "--verbose"] {
            assert!(
                all.contains(option) && !short.contains(option),
                "{command} {option} is for some:\n{short}"
            );
        }
        assert!(folder.gnurt(&format!("{command} -h")).success().stdout == short, "the same");
    }
}

#[test]
fn a_reader_may_leave_early() {
    let folder = Folder::new();
    let mut command = folder.command(&["help", "render"]);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("the program starts");
    drop(child.stdout.take());
    let run = collect(child);
    assert!(run.stderr.is_empty(), "a closed pipe is no panic: {}", run.stderr);
    assert_eq!(run.status, Some(0), "nor a failure");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_device_is_an_error() {
    let folder = Folder::new();
    let mut command = folder.command(&["scenes"]);
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").expect("Linux has it");
    command.stdout(full).stderr(Stdio::piped());
    let run = collect(command.spawn().expect("the program starts"));
    run.fails(1, "standard output");
}

#[test]
fn a_pixel_is_followed() {
    let folder = Folder::new();
    folder.write("a.ply", samples::PLY);
    let run = folder.gnurt("trace a.ply --pixel 32,24 -r 64x48").success();
    for expected_text in ["ray", "hit", "normal", "radiance"] {
        assert!(run.stdout.contains(expected_text), "'{expected_text}' is told: {}", run.stdout);
    }
    folder.gnurt("trace a.ply --pixel 0,0 -r 64x48").success();
}

#[test]
fn names_move_no_cursors() {
    let folder = Folder::new();
    let mut command = folder.command(&["info", "evil\x1b[2J\nname.obj"]);
    command.env("LANG", "C");
    let run = finish(command);
    assert_eq!(run.stderr.lines().count(), 1, "one line: {:?}", run.stderr);
    assert!(!run.stderr.contains('\x1b'), "no control characters: {:?}", run.stderr);
}

#[cfg(unix)]
#[test]
fn file_names_need_not_be_text() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let folder = Folder::new();
    let unknown = [&b"render"[..], b"builtin:\xff"].map(OsStr::from_bytes);
    folder.run(&unknown).fails(2, "unknown built-in scene");
    let name = OsStr::from_bytes(b"na\xffme.ply");
    std::fs::write(folder.path().join(name), samples::PLY).expect("a file");
    let arguments_given = ["render", "-r", "4x4", "--spp", "1"].map(OsStr::new);
    folder.run(&[&arguments_given[..], &[name]].concat()).success();
    assert!(
        folder.path().join(OsStr::from_bytes(b"na\xffme.png")).exists(),
        "the picture has the scene's name"
    );
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Signals: the first one saves, the second one leaves. Real signals to the real program.
#![cfg(unix)]

use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use super::harness::{Folder, collect};

fn signal(name: &str, child: &Child) {
    let status = Command::new("kill").args([name, &child.id().to_string()]).status();
    assert!(status.expect("kill can be run").success(), "the program is there to be signalled");
}

/// A rendering that would take hours.
fn long_rendering(folder: &Folder, output: &str, more: &[&str]) -> Child {
    let arguments_given = ["render", "builtin:cornell", "-r", "400x300", "--spp", "10000000", "-o", output];
    let mut command = folder.command(&arguments_given);
    command.args(more);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command.spawn().expect("the program starts")
}

#[test]
fn one_signal_saves() {
    for name in ["-INT", "-TERM"] {
        let folder = Folder::new();
        let child = long_rendering(&folder, "p.png", &[]);
        std::thread::sleep(Duration::from_millis(1500));
        signal(name, &child);
        // `timeout` sends each twice: to the program, and to all of its group.
        signal(name, &child);
        let begin = Instant::now();
        let run = collect(child).success();
        assert!(begin.elapsed() < Duration::from_secs(10), "{name}: it took {:?}", begin.elapsed());
        assert!(run.stderr.contains("stopp"), "{name} is answered: {}", run.stderr);
        folder.gnurt("diff p.png p.png").success();
        assert_eq!(folder.contents().len(), 1, "{name}: the picture and nothing else");
    }
}

#[test]
fn two_signals_leave() {
    let folder = Folder::new();
    folder.write("p.png", "old");
    // So that there is still something to do when the second one comes.
    let child = long_rendering(&folder, "p.png", &["-r", "1600x1200", "--denoise=built-in"]);
    std::thread::sleep(Duration::from_millis(1500));
    signal("-INT", &child);
    std::thread::sleep(Duration::from_millis(250));
    signal("-TERM", &child);
    let run = collect(child);
    assert_eq!(run.status, Some(130), "stopped: {}", run.stderr);
    assert_eq!(folder.read("p.png"), b"old", "nothing was saved");
    assert_eq!(folder.contents().len(), 1, "nothing else is left");
}

#[test]
fn an_early_signal_ends_cleanly() {
    let folder = Folder::new();
    let child = long_rendering(&folder, "p.png", &[]);
    std::thread::sleep(Duration::from_millis(30));
    signal("-INT", &child);
    let run = collect(child);
    match run.status {
        // Before the program listens, the signal's own effect; while it loads, one of the two documented ends.
        None => assert!(folder.contents().is_empty(), "nothing is left"),
        Some(0) => drop(folder.read("p.png")),
        Some(130) => assert!(folder.contents().is_empty(), "nothing is left: {}", run.stderr),
        other => panic!("status {other:?}: {}", run.stderr),
    }
}

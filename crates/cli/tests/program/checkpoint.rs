// SPDX-License-Identifier: GPL-3.0-or-later
//! `--checkpoint`: a rendering that is killed goes on where it was, with the same bits. Real kills.
#![cfg(unix)]

use std::process::Stdio;
use std::time::{Duration, Instant};

use super::harness::Folder;

const PICTURE: &str = "render builtin:cornell -r 96x72 --integrator path --seed 3";

#[test]
fn a_killed_rendering_goes_on_with_the_same_bits() {
    let folder = Folder::new();
    folder.gnurt(&format!("{PICTURE} --spp 64 -t 2 -o whole.png")).success();
    let line = format!("{PICTURE} --spp 64 -t 1 -o broken.png --checkpoint state --checkpoint-every 50ms");
    let arguments_given: Vec<&str> = line.split_whitespace().collect();
    let mut before = Vec::new();
    let mut kills = 0;
    for _ in 0..3 {
        let mut command = folder.command(&arguments_given);
        let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("it starts");
        let begin = Instant::now();
        // Until it has come further than the kill before.
        let is_further = || std::fs::read(folder.at("state")).is_ok_and(|state| state != before);
        while !is_further() && begin.elapsed() < Duration::from_secs(30) {
            std::thread::sleep(Duration::from_millis(5));
        }
        child.kill().expect("it can be killed");
        child.wait().expect("it is dead");
        kills += u32::from(!folder.at("broken.png").exists());
        before = folder.read("state");
    }
    assert!(kills > 0, "killed in the middle at least once");
    let run = folder.run(&arguments_given).success();
    assert!(run.stderr.contains("going on from state"), "it says so: {}", run.stderr);
    assert!(folder.read("whole.png") == folder.read("broken.png"), "the same picture, bit for bit");

    // A finished picture gets more samples.
    folder.gnurt(&format!("{PICTURE} --spp 80 -o more.png --checkpoint state")).success();
    folder.gnurt(&format!("{PICTURE} --spp 80 -o at-once.png")).success();
    assert!(folder.read("more.png") == folder.read("at-once.png"), "as if taken at once");
}

#[test]
fn what_does_not_match_is_refused() {
    let folder = Folder::new();
    folder.gnurt(&format!("{PICTURE} --spp 2 -o p.png --checkpoint state")).success();
    let state = folder.read("state");
    for (more, message) in [
        ("--spp 4 --max-depth 3", "scene, camera or options differ"),
        ("--spp 4 --eye 1,2,3", "scene, camera or options differ"),
        ("--spp 4 -r 40x30", "scene, camera or options differ"),
        ("--spp 1", "2 samples per pixel already"),
    ] {
        let without = PICTURE.replace(" -r 96x72", if more.contains("-r ") { "" } else { " -r 96x72" });
        folder.gnurt(&format!("{without} {more} -o q.png --checkpoint state")).fails(1, message);
        assert!(folder.read("state") == state, "nothing was overwritten");
    }
    // As long as no memory is: all but the beginning is left alone.
    let file = std::fs::File::options().write(true).open(folder.at("state")).expect("it is there");
    file.set_len(1 << 40).expect("a file with a hole");
    let run = folder.gnurt(&format!("{PICTURE} --spp 4 -o q.png --checkpoint state"));
    run.fails(1, "scene, camera or options differ");
    folder.write("state", &state[..state.len() - 8]);
    folder.gnurt(&format!("{PICTURE} --spp 4 -o q.png --checkpoint state")).fails(1, "damaged");
    folder.write("state", "something else");
    folder.gnurt(&format!("{PICTURE} --spp 4 -o q.png --checkpoint state")).fails(1, "not a checkpoint");
    folder.gnurt(&format!("{PICTURE} -o state.png --checkpoint state.png")).fails(2, "give another");
    folder.gnurt(&format!("{PICTURE} --checkpoint-every 5s")).fails(2, "--checkpoint");
}

#[test]
fn noise_decides_samples() {
    let folder = Folder::new();
    let run = folder.gnurt(&format!("{PICTURE} --spp 4096 --noise 0.2 --stats -o p.exr")).success();
    assert!(run.stderr.contains("picture"), "it counts: {}", run.stderr);
    folder.gnurt(&format!("{PICTURE} --noise 0 -o p.png")).fails(2, "above 0");
    let with_lights = PICTURE.replace("path", "ir");
    folder.gnurt(&format!("{with_lights} --noise 0.1 -o p.png")).fails(2, "share their noise");
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! The window of librtut: without a display, and on one without screen (Xvfb) with real keys and a real mouse (xdotool).
//! The latter is skipped, with a line that says so, where one of these programs is missing.

#[path = "../../openrt/tests/common/mod.rs"]
mod common;

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use OpenRT as _;
use common::{Workshop, source};

const LIBRARIES: &[&str] = &["rtut", "OpenRT"];
const PATIENCE: Duration = Duration::from_secs(60);

/// Pixels of a picture of this size.
fn picture(workshop: &Workshop, name: &str, [width, height]: [usize; 2]) -> Vec<u8> {
    let file = std::fs::read(workshop.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
    let header = format!("P6\n{width} {height}\n255\n");
    assert!(file.starts_with(header.as_bytes()), "{name} is {width} by {height}");
    let pixels = file[header.len()..].to_vec();
    assert_eq!(pixels.len(), 3 * width * height, "{name} is whole");
    pixels
}

#[test]
fn runs_without_a_window() {
    let workshop = Workshop::with(LIBRARIES);
    let example = workshop.build("cc", "c99", &source("../../examples/c/window.c"));
    let run = |frames: &str, prefix: &str| {
        let mut command = Command::new(&example);
        command.envs([("RTUT_HEADLESS", "1"), ("RTUT_FRAMES", frames)]).env_remove("DISPLAY");
        command.env("RTUT_SAVE", workshop.path(prefix)).output().expect("it runs")
    };
    let first = run("3", "a-");
    assert!(first.status.success(), "{first:?}");
    assert_eq!(String::from_utf8_lossy(&first.stdout), "longitude 30.0 latitude 20.0\n", "nobody turned it");
    let pictures = ["a-000.ppm", "a-001.ppm", "a-002.ppm"].map(|name| picture(&workshop, name, [640, 480]));
    let colors: std::collections::BTreeSet<&[u8]> = pictures[0].chunks_exact(3).collect();
    assert!(colors.len() > 100, "it shows {} colours", colors.len());
    assert_ne!(pictures[0], pictures[1], "it turns");
    assert!(!workshop.path("a-003.ppm").exists(), "three frames");
    assert!(run("3", "b-").status.success(), "again");
    assert_eq!(picture(&workshop, "b-002.ppm", [640, 480]), pictures[2], "the same each time");
    let nowhere = run("1", "no/such/folder/");
    assert!(String::from_utf8_lossy(&nowhere.stderr).contains("cannot write"), "{nowhere:?}");
    assert_eq!(nowhere.status.code(), Some(1), "and it says so");
}

#[test]
fn calls_are_checked() {
    let workshop = Workshop::with(LIBRARIES);
    let program = workshop.build("cc", "c99", &source("tests/c/window_calls.c"));
    let output =
        Command::new(program).env("RTUT_HEADLESS", "1").env("RTUT_SAVE", workshop.path("w")).output();
    let output = output.expect("it runs");
    assert!(output.status.success(), "{output:?}");
    assert_eq!(
        &picture(&workshop, "w000.ppm", [2, 1])[..],
        [255, 0, 0, 0, 0, 255],
        "the program's own pixels"
    );
}

/// A program that runs longer hangs.
const SECONDS: &str = "60";

fn headless(program: &Path) -> std::process::Output {
    // A deadlock is a failure, not a test that never ends.
    let mut command = Command::new("timeout");
    command.arg(SECONDS).arg(program).envs([("RTUT_HEADLESS", "1"), ("RTUT_FRAMES", "6")]);
    command.env("ASAN_OPTIONS", "detect_leaks=0").output().expect("timeout of coreutils must be there")
}

/// Sizes change while frames can neither start nor end, and the callback for that calls back.
#[test]
fn failed_frames_harm_nobody() {
    let workshop = Workshop::with(LIBRARIES);
    let program = source("tests/c/window_hostile.c");
    let output = headless(&workshop.build("cc", "c99", &program));
    assert!(output.status.success(), "{output:?}");
    let Some(binary) = workshop.build_with_sanitizer("cc", "c99", &program, "address") else {
        eprintln!("SKIPPED: the C compiler has no AddressSanitizer");
        return;
    };
    let output = headless(&binary);
    assert!(output.status.success(), "under AddressSanitizer: {output:?}");
}

#[test]
fn exceptions_arrive() {
    let workshop = Workshop::with(LIBRARIES);
    let output = headless(&workshop.build("c++", "c++11", &source("tests/c/exceptions.cpp")));
    assert!(output.status.success(), "{output:?}");
}

/// Stopped at the end.
struct Stopped(Child);

impl Drop for Stopped {
    fn drop(&mut self) {
        // It may be gone already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A display without a screen, and its name; `None`, told of, where that is not to be had.
fn display() -> Option<(Stopped, String)> {
    let works = |name: &str| Command::new(name).arg("-help").output().is_ok();
    if !(works("Xvfb") && works("xdotool")) {
        eprintln!("SKIPPED: Xvfb or xdotool is missing; .ci/run installs them");
        return None;
    }
    let server = Command::new("Xvfb")
        .args(["-displayfd", "1", "-screen", "0", "800x600x24", "-nolisten", "tcp", "-noreset"])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn();
    let mut server = Stopped(server.expect("Xvfb starts"));
    let mut number = String::new();
    let message = server.0.stdout.as_mut().expect("a pipe");
    BufReader::new(message).read_line(&mut number).expect("it says its number");
    Some((server, format!(":{}", number.trim())))
}

/// Requests on other threads wake a window at rest.
#[test]
fn other_threads_wake_it() {
    let Some((_server, display)) = display() else { return };
    let workshop = Workshop::with(LIBRARIES);
    let program = workshop.build("cc", "c99", &source("tests/c/window_threads.c"));
    let output = Command::new(program).env("DISPLAY", &display).env_remove("WAYLAND_DISPLAY").output();
    let output = output.expect("it runs");
    assert!(output.status.success(), "{output:?}");
}

#[test]
fn hears_hands() {
    let Some((_server, display)) = display() else { return };
    let query = |text: &str| {
        let mut hands = Command::new("xdotool");
        let output = hands.env("DISPLAY", &display).args(text.split_whitespace()).output();
        output.expect("xdotool starts")
    };
    let act = |text: &str| assert!(query(text).status.success(), "xdotool {text}");

    let workshop = Workshop::with(LIBRARIES);
    let example = workshop.build("cc", "c99", &source("../../examples/c/window.c"));
    let mut command = Command::new(&example);
    command.env("DISPLAY", &display).env_remove("WAYLAND_DISPLAY").stdout(Stdio::piped());
    let mut window = Stopped(command.env("RTUT_SAVE", workshop.path("s-")).spawn().expect("it starts"));
    let begin = Instant::now();
    loop {
        let _ = query("search --onlyvisible --name OpenRT windowfocus");
        let name = query("getwindowfocus getwindowname");
        if String::from_utf8_lossy(&name.stdout).contains("OpenRT") {
            break;
        }
        assert!(begin.elapsed() < PATIENCE, "no window came");
        std::thread::sleep(Duration::from_millis(20));
    }
    let mut message = BufReader::new(window.0.stdout.take().expect("a pipe"));
    let mut line = String::new();
    act("key space");
    message.read_line(&mut line).expect("it says so");
    assert_eq!(line, "stands\n", "a key is heard");
    act("mousemove 200 200 mousedown 1 mousemove 220 210 mouseup 1 click 4 key Escape");
    let mut rest = String::new();
    message.read_to_string(&mut rest).expect("it ends");
    assert_eq!(rest, "longitude 20.0 latitude 25.0\n", "a drag of 20 by 10 pixels, and Esc");
    assert!(window.0.wait().expect("it has ended").success(), "without errors");
    picture(&workshop, "s-000.ppm", [640, 480]);
}

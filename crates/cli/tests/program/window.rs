// SPDX-License-Identifier: GPL-3.0-or-later
//! A real window on a display without screen (Xvfb), with real keys and a real mouse (xdotool).
//! Skipped, with a line that says so, where one of these programs is missing; `.ci/run` installs them.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use gnurt::image::{Picture, compare};

use super::harness::Folder;
use super::{animation, samples, shaders};

const PATIENCE: Duration = Duration::from_secs(60);

/// A change of a plugin's text, as `shaders::BLACK`: divides by zero.
const NOT_A_NUMBER: [&str; 2] = ["product[i] *= a;", "product[i] = 0 / (a - a);"];

/// A display of its own, taken away at the end.
struct Display {
    server: Child,
    name: String,
}

impl Display {
    /// `None` if there is no Xvfb or no xdotool here.
    fn new() -> Option<Self> {
        let works = |name: &str| Command::new(name).arg("-help").output().is_ok();
        if !(works("Xvfb") && works("xdotool")) {
            eprintln!("SKIPPED: Xvfb or xdotool is missing; .ci/run installs them");
            return None;
        }
        // Without a reset when the last client leaves: xdotool comes and goes before there is a window.
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "800x600x24", "-nolisten", "tcp", "-noreset"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("Xvfb starts");
        let mut number = String::new();
        let message = server.stdout.as_mut().expect("a pipe");
        BufReader::new(message).read_line(&mut number).expect("it says its number");
        Some(Self { server, name: format!(":{}", number.trim()) })
    }

    /// The output of xdotool, if it succeeds. Never with its `--sync`: that waits for ever for a closed
    /// window.
    fn ask(&self, arguments_given: &str) -> Result<String, String> {
        let mut command = Command::new("xdotool");
        command.env("DISPLAY", &self.name).args(arguments_given.split_whitespace());
        let output = command.output().expect("xdotool starts");
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        if output.status.success() { Ok(text(&output.stdout)) } else { Err(text(&output.stderr)) }
    }

    /// Lets hands act.
    #[track_caller]
    fn act(&self, arguments_given: &str) {
        if let Err(message) = self.ask(arguments_given) {
            panic!("xdotool {arguments_given}: {message}");
        }
    }

    /// Gives the keyboard focus to the window as soon as it exists, because there is no window manager here.
    #[track_caller]
    fn focus(&self) {
        let begin = Instant::now();
        while begin.elapsed() < PATIENCE {
            // Refused while the window is not yet to be seen.
            let _ = self.ask("search --onlyvisible --name GNU windowfocus");
            if self.ask("getwindowfocus getwindowname").is_ok_and(|name| name.contains("GNU")) {
                return;
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        panic!("no window came");
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        // It may be gone already.
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

/// The program with its window.
struct Viewer<'a> {
    display: &'a Display,
    folder: &'a Folder,
    child: Child,
    message: Receiver<String>,
    pictures: u32,
}

impl<'a> Viewer<'a> {
    /// With a window that hears the keys.
    #[track_caller]
    fn open(display: &'a Display, folder: &'a Folder, line: &str) -> Self {
        let viewer = Self::start(display, folder, line);
        display.focus();
        display.act("mousemove 30 30");
        viewer
    }

    fn start(display: &'a Display, folder: &'a Folder, line: &str) -> Self {
        let arguments_given: Vec<&str> = line.split_whitespace().collect();
        let mut command = folder.command(&arguments_given);
        command.env("DISPLAY", &display.name).env_remove("WAYLAND_DISPLAY");
        let mut child =
            command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the program starts");
        let (sender, message) = channel();
        let pipes: [Box<dyn Read + Send>; 2] =
            [Box::new(child.stdout.take().expect("a pipe")), Box::new(child.stderr.take().expect("a pipe"))];
        for pipe in pipes {
            let sender = sender.clone();
            std::thread::spawn(move || {
                BufReader::new(pipe).lines().map_while(Result::ok).for_each(|line| drop(sender.send(line)));
            });
        }
        Self { display, folder, child, message, pictures: 0 }
    }

    /// Waits for a line that contains this.
    #[track_caller]
    fn hears(&self, part: &str) -> String {
        let begin = Instant::now();
        let mut others = Vec::new();
        while let Ok(line) = self.message.recv_timeout(PATIENCE.saturating_sub(begin.elapsed())) {
            if line.contains(part) {
                return line;
            }
            others.push(line);
        }
        panic!("'{part}' was not said, but: {others:#?}");
    }

    /// The picture that a key writes.
    #[track_caller]
    fn picture(&mut self) -> Picture {
        self.display.act("key F12");
        self.pictures += 1;
        let name = format!("view-{:04}.png", self.pictures);
        self.hears(&format!("wrote ./{name}"));
        gnurt::image::read(&self.folder.at(&name)).expect("a picture")
    }

    #[track_caller]
    fn ends(mut self, status: i32) {
        let begin = Instant::now();
        while begin.elapsed() < PATIENCE {
            if let Some(ended) = self.child.try_wait().expect("it can be waited for") {
                assert_eq!(ended.code(), Some(status), "its status");
                return;
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        panic!("the window is still there");
    }
}

impl Drop for Viewer<'_> {
    fn drop(&mut self) {
        // It has ended, unless the test has failed.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn differ(a: &Picture, b: &Picture) -> bool {
    compare(a, b).map_or(true, |comparison| comparison.mse > 1e-5)
}

#[test]
fn clips_are_played_and_stepped() {
    let Some(display) = Display::new() else { return };
    let folder = Folder::new();
    animation::animated(&folder);
    let same = "a.gltf -r 64x48 --spp 1 -t 2 --exposure 0 --tone clamp --denoise=none --eye 0,0,4 --target 0,0,0 --up 0,1,0 --fov 45";
    let mut viewer = Viewer::open(&display, &folder, &format!("view {same}"));
    let rest = viewer.picture();
    for _ in 0..13 {
        display.act("key period");
    }
    display.act("key comma");
    let stepped = viewer.picture();
    assert!(differ(&rest, &stepped), "twelve frames on");
    folder.gnurt(&format!("render {same} --at 0.5 -o half.png")).success();
    let half = gnurt::image::read(&folder.at("half.png")).expect("a picture");
    assert_eq!(compare(&half, &stepped).expect("two pictures").max_difference, 0.0, "half a second");
    display.act("key space sleep 0.3 key space");
    assert!(differ(&stepped, &viewer.picture()), "it went on, and stopped");
    display.act("key r");
    assert!(viewer.picture() == rest, "at rest again");
    display.act("key Escape");
    viewer.ends(0);
}

#[test]
fn finished_pictures_are_shown() {
    let Some(display) = Display::new() else { return };
    let folder = Folder::new();
    for (name, seed) in [("f.0001", 1), ("f.0002", 2), ("f.0003", 3), ("g", 4)] {
        let line = format!(
            "render builtin:materials -r 320x240 --spp 1 --seed {seed} --layers normal -o {name}.exr"
        );
        folder.gnurt(&line).success();
        folder.gnurt(&format!("convert {name}.exr {name}.png --exposure 1 --tone clamp")).success();
    }
    let of = |name: &str| gnurt::image::read(&folder.at(name)).expect("a picture");
    let line = "view f.####.exr --compare g.exr --compare-as first -t 2 --exposure 1 --tone clamp";
    let mut viewer = Viewer::open(&display, &folder, line);
    assert!(viewer.picture().color == of("f.0001.png").color, "as it is in the file");
    display.act("key period");
    assert!(viewer.picture().color == of("f.0002.png").color, "the next frame");
    display.act("key comma key comma");
    assert!(viewer.picture().color == of("f.0003.png").color, "before the first one");
    display.act("key 2");
    let second = viewer.picture();
    assert!(second.color == of("g.png").color, "the other picture");
    display.act("key 3");
    let split = viewer.picture();
    assert!(split.color[0] == of("f.0003.png").color[0] && split.color[319] == second.color[319], "both");
    display.act("key 1 key Tab");
    let normals = viewer.picture();
    assert!(differ(&normals, &split), "a layer");
    display.act("key Tab click 4 click 4");
    assert!(differ(&viewer.picture(), &of("f.0003.png")), "larger");
    display.act("key x key i key h key space sleep 0.3 key space key Escape");
    viewer.ends(0);
}

#[test]
fn hands_move_the_camera() {
    let Some(display) = Display::new() else { return };
    let folder = Folder::new();
    // One sample: a screenshot holds the samples that are there, which with more might be the first only.
    let mut viewer = Viewer::open(&display, &folder, "view builtin:materials -r 160x120 --spp 1 -t 2");
    let first = viewer.picture();
    assert_eq!((first.width, first.height), (160, 120), "the size that was asked for");
    display.act("key c");
    let home = viewer.hears("--eye");
    display.act("mousemove 80 60 mousedown 1 mousemove 90 62 mousemove 100 64 mouseup 1");
    let orbited = viewer.picture();
    assert!(differ(&first, &orbited), "a drag with the left button shows another side");
    display.act("mousemove 80 60 mousedown 3 mousemove 90 63 mousemove 100 65 mouseup 3");
    let panned = viewer.picture();
    assert!(differ(&orbited, &panned), "a drag with the right button moves it aside");
    display.act("click 4 click 4 click 4");
    let nearer = viewer.picture();
    assert!(differ(&panned, &nearer), "the wheel brings it nearer");
    display.act("keydown w sleep 0.3 keyup w");
    let flown = viewer.picture();
    assert!(differ(&nearer, &flown), "a key that is held flies");
    display.act("key c");
    let away = viewer.hears("--eye");
    assert_ne!(home, away, "the camera is elsewhere");
    display.act("key r");
    assert!(viewer.picture() == first, "home is where it was, bit for bit");
    display.act("key c");
    assert_eq!(viewer.hears("--eye"), home, "in numbers, too");
    // The printed options restore the view on the command line.
    display.act("key Escape");
    viewer.ends(0);
    let arguments_given = format!("render builtin:materials -r 160x120 --spp 1 -o there.png {away}");
    folder.gnurt(&arguments_given).success();
    let there = gnurt::image::read(&folder.at("there.png")).expect("a picture");
    assert!(there.color == flown.color, "the pixels that were seen");
}

#[test]
fn keys_switch_what_is_shown() {
    let Some(display) = Display::new() else { return };
    let folder = Folder::new();
    let mut viewer = Viewer::open(&display, &folder, "view builtin:cornell -r 200x200 --spp 1");
    let mut pictures = vec![viewer.picture()];
    for keys in ["key b key b", "key t key t", "key r key 1", "key Tab", "key ctrl+s key 9"] {
        display.act(keys);
        if keys.contains("ctrl") {
            viewer.pictures += 1;
            viewer.hears(&format!("view-{:04}.png", viewer.pictures));
        }
        pictures.push(viewer.picture());
    }
    for (i, a) in pictures.iter().enumerate() {
        for (j, b) in pictures.iter().enumerate().skip(i + 1) {
            assert!(differ(a, b), "pictures {i} and {j} are the same");
        }
    }
    display.act("mousemove 100 150 click 1");
    let line = viewer.hears("pixel 100,150");
    for expected_text in ["instance", "object", "triangle", "material"] {
        assert!(line.contains(expected_text), "'{expected_text}' is told: {line}");
    }
    display.act("key h key g key p key p key f key f key ctrl+q");
    viewer.ends(0);
}

/// Saves a file as editors do.
fn save(path: &Path, text: &str) {
    let beside = path.with_extension("new");
    std::fs::write(&beside, text).expect("a file");
    std::fs::rename(&beside, path).expect("a file");
}

#[test]
fn files_that_change_are_read_again() {
    let Some(display) = Display::new() else { return };
    let folder = Folder::new();
    let mtl = folder.write("scene.mtl", samples::MTL);
    let obj = folder.write("scene.obj", samples::OBJ);
    let mut viewer = Viewer::open(
        &display,
        &folder,
        "view scene.obj -r 120x90 --spp 1 --integrator eyelight --eye 0,1,3 --target 0,1,0 --frames 100000",
    );
    let red = viewer.picture();
    save(&mtl, "newmtl red\nKd 0.1 0.8 0.1\n");
    viewer.hears("read again");
    let green = viewer.picture();
    assert!(differ(&red, &green), "another colour");
    save(&obj, "v 1 2 3\nf 1 2 3\n");
    viewer.hears("warning: scene.obj:2");
    assert!(viewer.picture() == green, "the old scene stays while the new one is broken");
    save(&obj, samples::OBJ);
    viewer.hears("read again");
    assert!(viewer.picture() == green, "mended");
    display.act("key Escape");
    viewer.ends(0);
}

/// A plugin that is built again shades from then on; one that cannot be loaded leaves the old one.
#[test]
fn plugins_that_change_are_loaded_again() {
    let Some(display) = Display::new() else { return };
    let folder = Folder::new();
    let plugin = shaders::compile(&folder, "diffuse", shaders::SAME);
    let mut viewer = Viewer::open(
        &display,
        &folder,
        "view builtin:cornell -r 120x90 --spp 1 --shader *=diffuse@diffuse.so --frames 100000",
    );
    let lit = viewer.picture();
    save(&plugin, "no library");
    viewer.hears("diffuse.so");
    assert!(viewer.picture() == lit, "the old one stays while the new one is broken");
    shaders::compile(&folder, "diffuse", shaders::BLACK);
    viewer.hears("read again");
    assert!(differ(&lit, &viewer.picture()), "the new one shades");
    display.act("key Escape");
    viewer.ends(0);
}

/// Faults of a plugin are reported while the window is open, once.
#[test]
fn faults_of_plugins_are_told() {
    let Some(display) = Display::new() else { return };
    let folder = Folder::new();
    shaders::compile(&folder, "diffuse", NOT_A_NUMBER);
    let line = "builtin:cornell -r 120x90 --spp 1 --shader *=diffuse@diffuse.so";
    let viewer = Viewer::open(&display, &folder, &format!("view {line} --frames 100000"));
    let fault = viewer.hears("NaN or infinite");
    assert!(fault.starts_with("warning: ") && fault.contains("diffuse"), "{fault}");
    // The file is looked at and faults are asked for again and again.
    std::thread::sleep(Duration::from_millis(700));
    // On a busy machine other notes may come late.
    let again: Vec<String> =
        viewer.message.try_iter().filter(|line| line.contains("NaN or infinite")).collect();
    assert!(again.is_empty(), "said once: {again:?}");
    display.act("key Escape");
    viewer.ends(0);
    let headless = folder.gnurt(&format!("view {line} --headless"));
    assert!(headless.success().stderr.contains("NaN or infinite"), "without a window, too");
}

#[test]
fn noise_goes_and_comes_back() {
    let Some(display) = Display::new() else { return };
    let folder = Folder::new();
    // A view meters its first picture and a rendering its last one: both get the exposure as an option.
    let line = "builtin:cornell -r 80x60 --spp 1 --integrator path --exposure 0";
    let mut viewer = Viewer::open(&display, &folder, &format!("view {line} --denoise=none --frames 100000"));
    let noisy = viewer.picture();
    display.act("key n");
    viewer.hears("denoised by");
    let clean = viewer.picture();
    assert!(differ(&noisy, &clean), "another picture");
    display.act("key n");
    assert!(viewer.picture() == noisy, "as it was, bit for bit");
    display.act("key Escape");
    viewer.ends(0);
    folder.gnurt(&format!("render {line} --denoise -o there.png")).success();
    let there = gnurt::image::read(&folder.at("there.png")).expect("a picture");
    assert!(there.color == clean.color, "the pixels of render --denoise");
}

#[test]
fn pictures_are_recorded_while_asked_for() {
    let Some(display) = Display::new() else { return };
    let folder = Folder::new();
    let line = "view builtin:materials -r 160x120 --spp 1 --integrator eyelight --frames 100000";
    let mut viewer = Viewer::open(&display, &folder, line);
    let first = viewer.picture();
    display.act("key ctrl+r keydown w");
    let begin = Instant::now();
    while !folder.at("take-001-00004.png").exists() {
        assert!(begin.elapsed() < PATIENCE, "nothing is recorded");
        std::thread::sleep(Duration::from_millis(5));
    }
    display.act("keyup w");
    // At the write the camera rests, and the picture then was recorded, too.
    let shown = viewer.picture();
    display.act("sleep 0.2 key ctrl+r");
    let reported = viewer.hears("recorded");
    let count = std::fs::read_dir(folder.path()).expect("a folder").filter_map(Result::ok);
    let count = count.filter(|file| file.file_name().to_string_lossy().starts_with("take-001-")).count();
    assert!(reported.contains(&format!("recorded {count} pictures")), "{count} files: {reported}");
    let last = gnurt::image::read(&folder.at(&format!("take-001-{count:05}.png"))).expect("a picture");
    assert_eq!((last.width, last.height), (160, 120), "as large as the window");
    assert!(last.color == shown.color && differ(&first, &last), "what is seen at last, without numbers");
    display.act("key ctrl+r key b");
    viewer.pictures += 1;
    display.act("key F12");
    viewer.hears("wrote");
    display.act("key Escape");
    assert!(
        viewer.hears("recorded").contains("take-002-00001.png"),
        "what is not ended ends with the window"
    );
    viewer.ends(0);
}

#[test]
fn windows_close_by_themselves() {
    let Some(display) = Display::new() else { return };
    let folder = Folder::new();
    // It may have gone before anybody finds it.
    let viewer = Viewer::start(&display, &folder, "view builtin:cornell -r 64x64 --spp 64 --frames 3");
    viewer.ends(0);
}

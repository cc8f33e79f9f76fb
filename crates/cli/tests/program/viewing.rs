// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt view` without a window, and pictures that another program shows.

use std::io::Read;
use std::net::TcpListener;
use std::thread::JoinHandle;

use super::harness::{Folder, finish};

#[test]
fn frames_are_rendered_and_timed() {
    let folder = Folder::new();
    let run = folder.gnurt(
        "view builtin:cornell --headless --frames 5 -r 48x32 --integrator eyelight --stats=json -o last.png -t 2",
    );
    let json: serde_json::Value = serde_json::from_str(&run.success().stdout).expect("JSON alone");
    assert_eq!(
        (&json["frames"], &json["spp"], &json["threads"]),
        (&5.into(), &1.into(), &2.into()),
        "{json}"
    );
    assert_eq!(json["rays"], 5 * 48 * 32, "a ray per pixel and frame: {json}");
    let ms = |name: &str| json["ms"][name].as_f64().expect("a number");
    assert!(ms("min") > 0.0 && ms("min") <= ms("median") && ms("median") <= ms("max"), "{json}");
    assert!(json["fps"].as_f64().is_some_and(|fps| fps > 0.0), "{json}");
    let last = folder.read("last.png");
    folder
        .gnurt("view builtin:cornell --headless --frames 5 -r 48x32 --integrator eyelight -o again.png -t 1")
        .success();
    assert!(last == folder.read("again.png"), "the same bytes each time");
    folder.gnurt("view builtin:cornell --headless -r 48x32 --integrator eyelight -o first.png").success();
    assert!(last != folder.read("first.png"), "the camera went around");
}

/// After pictures in motion by integrators that find light by chance, those at rest change by steps that are not seen.
#[test]
fn pictures_at_rest_do_not_flicker() {
    let folder = Folder::new();
    for integrator in ["path", "bir"] {
        let run = folder.gnurt(&format!(
            "view builtin:cornell --headless --frames 6 --orbit 6 --rest 7 -r 64x48 --integrator {integrator} --vpls 64 --stats=json"
        ));
        let json: serde_json::Value = serde_json::from_str(&run.success().stdout).expect("JSON alone");
        assert_eq!((&json["rest"]["pictures"], &json["rest"]["spp"]), (&7.into(), &48.into()), "{json}");
        let most = json["rest"]["flicker"]["max"].as_f64().expect("a number");
        assert!(most > 0.0 && most <= 0.02, "{integrator}: {most}");
    }
}

#[test]
fn a_still_view_is_what_render_makes() {
    let folder = Folder::new();
    let same = "builtin:cornell -r 40x30 --spp 5 --seed 3 --eye 1,1,3.5";
    folder.gnurt(&format!("view {same} --headless -o seen.pfm")).success();
    folder.gnurt(&format!("render {same} -o rendered.pfm")).success();
    assert!(folder.read("seen.pfm") == folder.read("rendered.pfm"), "the same bits");
}

#[test]
fn bad_arguments_of_view_are_refused() {
    let folder = Folder::new();
    for (line, message) in [
        ("view", "SCENE"),
        ("view builtin:cornel", "did you mean"),
        ("view builtin:cornell --frames 0", "--frames"),
        ("view builtin:cornell --orbit 90", "--headless"),
        ("view builtin:cornell --rest 9", "--headless"),
        ("view builtin:cornell --stats", "--headless"),
        ("view builtin:cornell -o a.png", "--headless"),
        ("view builtin:cornell --headless -o a.xyz", "unknown picture format"),
        ("view builtin:cornell --headless --orbit x", "--orbit"),
        ("view builtin:cornell --headless --eye 1,1,1 --target 1,1,1", "same point"),
        ("view builtin:cornell --display screen", "tev:HOST:PORT"),
        ("render builtin:cornell --display tev:a:b", "tev:HOST:PORT"),
    ] {
        folder.gnurt(line).fails(2, message);
    }
    folder.gnurt("view none.obj --headless").fails(1, "no such file");
    assert!(folder.contents().is_empty(), "nothing was written");
}

#[test]
fn no_display_is_a_clear_error() {
    let folder = Folder::new();
    let mut command = folder.command(&["view", "builtin:cornell", "-r", "32x32"]);
    for variable in ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"] {
        command.env_remove(variable);
    }
    let run = finish(command);
    run.fails(1, "no window can be opened");
    assert!(run.stderr.contains("--headless"), "what would work: {}", run.stderr);
    assert!(!run.stderr.contains(".rs:"), "no place in a library: {}", run.stderr);
    let mut command = folder.command(&["view", "builtin:cornell", "-r", "32x32"]);
    command.env_remove("WAYLAND_DISPLAY").env("DISPLAY", ":4711");
    finish(command).fails(1, "no window can be opened");
}

/// Takes one connection and gives back all that came over it.
fn server() -> (u16, JoinHandle<Vec<u8>>) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = listener.local_addr().expect("an address").port();
    let thread = std::thread::spawn(move || {
        let mut bytes = Vec::new();
        let (mut stream, _) = listener.accept().expect("somebody calls");
        stream.read_to_end(&mut bytes).expect("it can be read");
        bytes
    });
    (port, thread)
}

/// Kinds of packets, and the pixels of the last picture: an update sends bands from the top.
fn decode(bytes: &[u8], pixels: usize) -> (Vec<u8>, Vec<f32>) {
    let (mut kinds, mut floats, mut rest) = (Vec::new(), Vec::new(), bytes);
    while !rest.is_empty() {
        let length = u32::from_le_bytes(rest[..4].try_into().expect("4 bytes")) as usize;
        let packet = &rest[4..length];
        kinds.push(packet[0]);
        if packet[0] == 6 {
            // Behind the name: 3 channels by name, x, y, width, height, offsets and strides.
            let name = 2 + packet[2..].iter().position(|&byte| byte == 0).expect("a name") + 1;
            let data = &packet[name + 4 + 6 + 16 + 48..];
            floats.extend(data.chunks(4).map(|four| f32::from_le_bytes(four.try_into().expect("4 bytes"))));
        }
        rest = &rest[length..];
    }
    let last = floats.split_off(floats.len() - 3 * pixels);
    (kinds, last)
}

#[test]
fn another_program_shows_the_picture() {
    let folder = Folder::new();
    for command in ["render", "view"] {
        let (port, server) = server();
        let line = format!(
            "{command} builtin:cornell -r 20x100 --spp 3 -o {command}.pfm --display tev:127.0.0.1:{port}"
        );
        folder.gnurt(&line).success();
        let (kinds, last) = decode(&server.join().expect("the server ends"), 20 * 100);
        assert_eq!(
            kinds,
            [4, 6, 6, 6, 6, 6, 6],
            "{command}: created, then two bands for each of three passes"
        );
        let picture = gnurt::image::read(&folder.at(&format!("{command}.pfm"))).expect("a picture");
        let expected: Vec<f32> = picture.color.iter().flat_map(|pixel| pixel[..3].to_vec()).collect();
        assert!(last == expected, "{command}: what was shown at last is what was written");
    }
}

#[test]
fn nobody_listens_there() {
    let folder = Folder::new();
    let port = TcpListener::bind("127.0.0.1:0").and_then(|l| l.local_addr()).expect("a port").port();
    for command in ["render", "view"] {
        let line = format!("{command} builtin:cornell -r 8x8 --spp 1 --display tev:127.0.0.1:{port}");
        folder.gnurt(&line).fails(1, &format!("tev at 127.0.0.1:{port}"));
    }
}

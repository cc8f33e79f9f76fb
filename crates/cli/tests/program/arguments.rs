// SPDX-License-Identifier: GPL-3.0-or-later
//! Wrong command lines and variables: one error line each, the right status, before any work, and nothing is written.

use super::harness::{Folder, finish};
use super::samples;

/// A folder with good files of each kind.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("ok.obj", samples::OBJ);
    folder.write("scene.mtl", samples::MTL);
    folder.write("ok.ply", samples::PLY);
    folder.write("a.pfm", samples::pfm());
    folder.write("b.pfm", b"PF\n1 1\n-1.0\n\0\0\0\0\0\0\0\0\0\0\0\0");
    folder.write("sub/ok.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder
}

#[track_caller]
fn check(rows: &[(&str, i32, &str)]) {
    let folder = folder();
    let before = folder.contents();
    for &(line, status, expected) in rows {
        println!("gnurt {line}");
        folder.gnurt(line).fails(status, expected);
        assert_eq!(folder.contents(), before, "`gnurt {line}` left something behind");
    }
}

#[test]
fn commands_and_their_words() {
    check(&[
        ("", 2, "command missing"),
        ("rendr ok.obj", 2, "unknown command 'rendr'; did you mean 'render'?"),
        (
            "draw ok.obj",
            2,
            "valid are: render, join, denoise, relight, view, info, diff, convert, trace, bench, scenes, help",
        ),
        ("--frobnicate", 2, "unknown option '--frobnicate'"),
        ("help nonsense", 2, "nonsense"),
        ("render", 2, "<SCENE> is missing"),
        ("info", 2, "<SCENE> is missing"),
        ("diff a.pfm", 2, "<B> is missing"),
        ("diff", 2, "is missing"),
        ("convert a.pfm", 2, "<OUT> is missing"),
        ("trace ok.obj", 2, "--pixel"),
        ("render ok.obj ok.ply", 2, "'ok.ply' is one argument too many"),
        ("info ok.obj ok.ply", 2, "'ok.ply' is one argument too many"),
        ("diff a.pfm b.pfm a.pfm", 2, "one argument too many"),
        ("scenes ok.obj", 2, "one argument too many"),
        ("render ok.obj --sppp 3", 2, "unknown option '--sppp'; did you mean '--spp'?"),
        ("render ok.obj --sampels=3", 2, "did you mean '--samples'?"),
        ("render ok.obj --heat h.png", 2, "did you mean '--heatmap'?"),
        ("render ok.obj -z", 2, "unknown option '-z'"),
        ("info ok.obj --spp 3", 2, "valid are: --json"),
        ("diff a.pfm a.pfm --json", 2, "unknown option '--json'"),
        ("render ok.obj --spp", 2, "--spp: a value is missing"),
        ("render ok.obj -o", 2, "--output: a value is missing"),
        ("render ok.obj --eye", 2, "--eye: a value is missing"),
        ("render ok.obj --quiet=yes", 2, "--quiet"),
        ("--threads 2 render ok.obj", 2, "--threads: options follow the command"),
        ("-r 4x4 render ok.obj", 2, "-r: options follow the command"),
        ("render ok.obj --stats=xml", 2, "unknown form 'xml'"),
        ("render ok.obj --stats=jsn", 2, "did you mean 'json'?"),
    ]);
}

#[test]
fn sizes_and_samples() {
    check(&[
        ("render ok.obj -r 0x0", 2, "without pixels"),
        ("render ok.obj -r 0x10", 2, "without pixels"),
        ("render ok.obj -r 10x0", 2, "without pixels"),
        ("render ok.obj -r 640", 2, "--resolution '640'"),
        ("render ok.obj -r 640,480", 2, "like 1280x720"),
        ("render ok.obj -r -640x480", 2, "like 1280x720"),
        ("render ok.obj -r 6.4x480", 2, "like 1280x720"),
        ("render ok.obj -r axb", 2, "like 1280x720"),
        ("render ok.obj -r 1x2x3", 2, "like 1280x720"),
        ("render ok.obj -r x", 2, "like 1280x720"),
        ("render ok.obj -r 65536x32769", 2, "too many pixels"),
        ("render ok.obj -r 4294967295x4294967295", 2, "too many pixels"),
        ("render ok.obj -r 99999999999999999999999x1", 2, "too many pixels"),
        ("render ok.obj --resolution=1e3x1e3", 2, "like 1280x720"),
        ("trace ok.obj --pixel 0,0 -r 0x0", 2, "without pixels"),
        ("render ok.obj --spp 0", 2, "--spp '0'"),
        ("render ok.obj --spp -1", 2, "from 1 to 2147483647"),
        ("render ok.obj --spp=2147483648", 2, "from 1 to 2147483647"),
        ("render ok.obj --spp 1.5", 2, "--spp '1.5'"),
        ("render ok.obj --spp many", 2, "whole number"),
        ("render ok.obj --samples 0", 2, "--spp '0'"),
        ("render ok.obj --seed -1", 2, "--seed '-1'"),
        ("render ok.obj --seed 18446744073709551616", 2, "18446744073709551615"),
        ("render ok.obj --seed x", 2, "--seed 'x'"),
        ("render ok.obj --max-depth -1", 2, "--max-depth '-1'"),
        ("render ok.obj --max-depth 1001", 2, "from 1 to 1000"),
        ("render ok.obj --max-depth 0", 2, "from 1 to 1000"),
        ("render ok.obj -t -1", 2, "--threads '-1'"),
        ("render ok.obj -t 1025", 2, "from 0 to 1024"),
        ("render ok.obj -t two", 2, "from 0 to 1024"),
        ("info ok.obj --tree -t 99999", 2, "from 0 to 1024"),
        ("render ok.obj --time 0", 2, "--time '0'"),
        ("render ok.obj --time -5", 2, "like 90, 90s, 1.5m"),
        ("render ok.obj --time 5x", 2, "like 90, 90s, 1.5m"),
        ("render ok.obj --time nan", 2, "--time 'nan'"),
        ("render ok.obj --time inf", 2, "--time 'inf'"),
        ("render ok.obj --time 1e300s", 2, "--time '1e300s'"),
    ]);
}

#[test]
fn cameras() {
    check(&[
        ("render ok.obj --eye 1,2", 2, "--eye '1,2': give three numbers"),
        ("render ok.obj --eye 1,2,3,4", 2, "three numbers"),
        ("render ok.obj --eye 1,2,x", 2, "three numbers"),
        ("render ok.obj --eye nan,0,0", 2, "not a finite number"),
        ("render ok.obj --eye 0,inf,0", 2, "not a finite number"),
        ("render ok.obj --eye 0,0,1e39", 2, "not a finite number"),
        ("render ok.obj --target -inf,0,0", 2, "--target '-inf,0,0'"),
        ("render ok.obj --target ,,", 2, "three numbers"),
        ("render ok.obj --up 0,0,0", 2, "the zero vector has no direction"),
        ("render ok.obj --up z", 2, "--up-axis z names the upward axis of a file"),
        ("render ok.obj --up-axis w", 2, "expected x, y or z"),
        ("render ok.obj --up 0,nan,0", 2, "not a finite number"),
        ("render ok.obj --eye 1,2,3 --target 1,2,3", 2, "the same point"),
        ("render ok.obj --eye=-1,0,0 --target=-1,0,0", 2, "the same point"),
        ("render missing.obj --eye 0,0,0 --target -0,0,0", 2, "the same point"),
        ("render ok.obj --fov 0", 2, "above 0 and below 180"),
        ("render ok.obj --fov 180", 2, "--fov '180': the camera shows nothing"),
        ("render ok.obj --fov -45", 2, "above 0 and below 180"),
        ("render ok.obj --fov 1e9", 2, "above 0 and below 180"),
        ("render ok.obj --fov nan", 2, "not a finite number"),
        ("render ok.obj --fov inf", 2, "not a finite number"),
        ("render ok.obj --fov wide", 2, "not a finite number"),
        ("render ok.obj --camera 0", 2, "the scene has no camera"),
        ("render ok.obj --camera front", 2, "the scene has no camera"),
        ("trace ok.obj --pixel 0,0 --fov 200", 2, "above 0 and below 180"),
    ]);
}

#[test]
fn regions_and_pixels() {
    check(&[
        ("render ok.obj --crop 0,0,10", 2, "give x0,y0,x1,y1"),
        ("render ok.obj --crop 0,0,10,10,10", 2, "give x0,y0,x1,y1"),
        ("render ok.obj --crop a,b,c,d", 2, "give x0,y0,x1,y1"),
        ("render ok.obj --crop 0,0,.5,.5", 2, "give x0,y0,x1,y1"),
        ("render ok.obj --crop 5,5,5,9", 2, "no pixel"),
        ("render ok.obj --crop 9,5,5,9", 2, "no pixel"),
        ("render ok.obj -r 64x48 --crop 64,0,99,48", 2, "no pixel of the 64x48 picture"),
        ("render ok.obj --crop -9,-9,0,0", 2, "no pixel"),
        ("trace ok.obj --pixel 1280,0", 2, "outside the 1280x720 picture"),
        ("trace ok.obj --pixel 0,720", 2, "rows at 719"),
        ("trace ok.obj -r 4x4 --pixel 4,4", 2, "columns end at 3"),
        ("trace ok.obj --pixel -1,0", 2, "--pixel '-1,0'"),
        ("trace ok.obj --pixel 5", 2, "column and row"),
        ("trace ok.obj --pixel 1,2,3", 2, "column and row"),
    ]);
}

#[test]
fn names() {
    check(&[
        ("render ok.obj --integrator paths", 2, "valid are: eyelight, normals, whitted, path, ir, bir, mir"),
        ("render ok.obj --integrator Whited", 2, "did you mean 'whitted'?"),
        ("render ok.obj --integrator=", 2, "--integrator"),
        ("render ok.obj --filter gauss", 2, "did you mean 'gaussian'?"),
        ("render ok.obj --filter blackman", 2, "did you mean 'blackman-harris'?"),
        ("render ok.obj --isa avx3", 2, "unknown instruction set 'avx3'; did you mean 'avx2'?"),
        ("render ok.obj --isa mmx", 2, "scalar"),
        ("render ok.obj --memory compakt", 2, "did you mean 'compact'?"),
        ("render ok.obj --tone aces", 2, "valid are: clamp, reinhard, filmic"),
        ("render ok.obj --tone filmc", 2, "did you mean 'filmic'?"),
        ("render ok.obj --exposure nan", 2, "--exposure 'nan'"),
        ("render ok.obj --exposure 65", 2, "from -64 to 64"),
        ("convert a.pfm a.png --tone aces", 2, "unknown tone curve"),
        ("render builtin:cornel", 2, "did you mean 'cornell'?"),
        ("render builtin:", 2, "unknown built-in scene"),
        ("render builtin:nothing-like-it", 2, "cornell"),
        ("info builtin:../../etc/passwd", 2, "unknown built-in scene"),
        ("trace builtin:cornel --pixel 0,0", 2, "did you mean 'cornell'?"),
        ("diff a.pfm a.pfm --fail -1", 2, "not negative"),
        ("diff a.pfm a.pfm --fail nan", 2, "--fail 'nan'"),
        ("diff a.pfm a.pfm --fail lots", 2, "--fail 'lots'"),
    ]);
}

#[test]
fn outputs() {
    check(&[
        ("render ok.obj -o picture", 2, "unknown picture format"),
        ("render ok.obj -o picture.", 2, "unknown picture format"),
        ("render ok.obj -o picture.pgn", 2, "did you mean '.png'?"),
        ("render ok.obj -o picture.tga", 2, "valid are: .png, .exr, .hdr, .pfm"),
        ("render ok.obj -o .png", 2, "unknown picture format"),
        ("render ok.obj -o ok.obj", 2, "unknown picture format '.obj'"),
        ("render missing.obj -o picture.tif", 2, "unknown picture format"),
        ("render ok.obj -o a.png --heatmap a.png", 2, "the same file"),
        ("render ok.obj -o a.png --heatmap ./a.png", 2, "the same file"),
        ("render ok.obj -o a.png --heatmap h.gif", 2, "unknown picture format '.gif'"),
        ("render ok.obj -o none/a.png", 1, "none/a.png: cannot be written"),
        ("render ok.obj -o ok.obj/a.png", 1, "ok.obj/a.png"),
        ("render ok.obj -o /proc/a.png", 1, "/proc/a.png"),
        ("render ok.obj -o a.png --heatmap none/h.png", 1, "none/h.png"),
        ("render ok.obj -r 46000x46000", 1, "the picture takes"),
        ("convert a.pfm a.xyz", 2, "a.xyz"),
        ("convert a.pfm none/a.png", 1, "none/a.png"),
        ("convert a.pfm a.pfm", 2, "the same file"),
        ("convert a.pfm ./a.pfm", 2, "the same file"),
        ("convert a.pfm sub/../a.pfm", 2, "the same file"),
        ("convert ok.obj ok.obj", 2, "the same file"),
        ("convert ok.obj a.png", 2, "render"),
        ("convert a.pfm a.obj", 2, "picture"),
        ("convert builtin:nothing a.obj", 2, "unknown built-in scene"),
    ]);
}

#[test]
fn variables() {
    let folder = folder();
    let rows = [
        ("GNURT_THREADS", "many", "GNURT_THREADS: 'many'"),
        ("GNURT_THREADS", "-1", "from 0 to 1024"),
        ("GNURT_THREADS", "1025", "from 0 to 1024"),
        ("GNURT_ISA", "sse9", "GNURT_ISA: unknown instruction set 'sse9'"),
        ("GNURT_LOG", "loud", "GNURT_LOG: unknown level 'loud'"),
        ("GNURT_PATH", "/no/such/folder", "GNURT_PATH: '/no/such/folder' is not a folder"),
        ("GNURT_PATH", "sub:ok.obj", "GNURT_PATH: 'ok.obj' is not a folder"),
    ];
    for (name, value, expected) in rows {
        println!("{name}={value}");
        let mut command = folder.command(&["render", "ok.obj", "-r", "4x4", "--spp", "1"]);
        command.env(name, value);
        finish(command).fails(2, expected);
    }
}

#[test]
fn options_win_over_variables() {
    let folder = folder();
    let rows = [
        ("GNURT_THREADS", "many", &["-t", "1"][..]),
        ("GNURT_ISA", "sse9", &["--isa", "scalar"]),
        ("GNURT_LOG", "loud", &["-q"]),
        ("GNURT_THREADS", "", &[]),
        ("GNURT_ISA", "auto", &[]),
        ("GNURT_LOG", "debug", &[]),
        ("GNURT_THREADS", "2", &[]),
    ];
    for (name, value, options) in rows {
        println!("{name}={value} {options:?}");
        let arguments_given =
            [&["render", "ok.obj", "-r", "4x4", "--spp", "1", "-o", "p.png"], options].concat();
        let mut command = folder.command(&arguments_given);
        command.env(name, value);
        finish(command).success();
    }
    let mut command = folder.command(&["render", "ok.obj", "-r", "4x4", "--spp", "1", "-o", "p.png"]);
    command.env("GNURT_LOG", "error");
    assert_eq!(finish(command).success().stderr, "", "GNURT_LOG=error is as quiet as -q");
}

#[test]
fn scenes_are_looked_for_in_the_path() {
    let folder = folder();
    folder.write("library/tree.obj", samples::OBJ);
    folder.write("library/scene.mtl", samples::MTL);
    let run = |scene: &str| {
        let mut command = folder.command(&["info", scene]);
        command.env("GNURT_PATH", "sub:library");
        finish(command)
    };
    assert!(run("tree.obj").success().stdout.contains("library/tree.obj"), "found in the second folder");
    assert!(!run("ok.obj").success().stdout.contains("sub/ok.obj"), "the current folder comes first");
    run("./tree.obj").fails(1, "no such file");
    run("bush.obj").fails(1, "nor in the folders of GNURT_PATH");
}

#[test]
fn the_last_of_repeated_options_wins() {
    let folder = folder();
    let run = folder.gnurt("render ok.obj -r 9x9 -r 4x2 --spp 5 --samples 2 --stats=table --stats=json --seed 1 --seed 7 -o p.png");
    let json: serde_json::Value = serde_json::from_str(&run.success().stdout).expect("JSON alone");
    assert_eq!((&json["width"], &json["height"]), (&4.into(), &2.into()), "the last size");
    assert_eq!((&json["spp"], &json["seed"]), (&2.into(), &7.into()), "the last numbers");
    for (options, is_quiet) in
        [("-q -v", false), ("-v -q", true), ("-vv -q", true), ("-q -vv", false), ("-q -q", true)]
    {
        let run = folder.gnurt(&format!("render ok.obj -r 4x2 --spp 1 -o p.png {options}")).success();
        assert_eq!(run.stderr.is_empty(), is_quiet, "the later of {options} wins: {}", run.stderr);
    }
    let run = folder.gnurt("-v -q render ok.obj -r 4x2 --spp 1 -o p.png").success();
    assert_eq!(run.stderr, "", "they may stand before the command");
}

#[test]
fn values_may_begin_with_a_minus() {
    let folder = folder();
    for line in [
        "render ok.obj -r 4x4 --spp 1 --eye -0.5,1,3 --target -1,-1,-1 --up -0,1,-0 --exposure -2 -o p.png",
        "render ok.obj -r 4x4 --spp 1 --eye=-0.5,1,3 --target=-1,-1,-1 --crop -1,-1,2,2 -o p.png",
        "render ok.obj -r 4x4 --spp 1 -o -p.png",
    ] {
        folder.gnurt(line).success();
    }
    assert!(folder.at("-p.png").exists(), "a file's name may begin with a minus, too");
}

/// An option without effect gets a warning.
#[test]
fn options_without_effect_are_told() {
    let folder = folder();
    let reported = |line: &str| {
        let run = folder.gnurt(line).success();
        run.lines("warning: ").into_iter().map(str::to_owned).collect::<Vec<_>>()
    };
    let small = "-r 4x4 --spp 1";
    for (line, expected) in [
        (format!("render ok.obj {small} --vpls 64 --interleave 3"), &["--vpls", "--interleave"][..]),
        (format!("render ok.obj {small} --integrator whitted --clamp 2"), &["--clamp"]),
        (format!("render ok.obj {small} --integrator normals --max-depth 3"), &["--max-depth"]),
        (format!("render ok.obj {small} -o a.exr --exposure 2 --tone clamp"), &["--tone", "--exposure"]),
        (format!("render ok.obj {small} --integrator ir --vpls 64 --exposure 2"), &[]),
        (format!("render ok.obj {small} --integrator bir --vpls 64 --pixel-noise blue"), &["--pixel-noise"]),
        (format!("render ok.obj {small}"), &[]),
        ("convert a.pfm a.hdr --exposure 2".to_owned(), &["--exposure"]),
        ("convert a.pfm a.png --exposure 2 --confine .".to_owned(), &["--confine"]),
        ("convert ok.obj a.ply --tone clamp --confine .".to_owned(), &["--tone"]),
        ("convert a.pfm a.png".to_owned(), &[]),
    ] {
        let found = reported(&line);
        let of_options: Vec<&String> = found.iter().filter(|text| text.contains("has no effect")).collect();
        assert_eq!(of_options.len(), expected.len(), "{line}: {found:?}");
        for option in expected {
            let begin = format!("warning: {option} has no effect ");
            assert!(of_options.iter().any(|text| text.starts_with(&begin)), "{line}: {option}: {found:?}");
        }
    }
}

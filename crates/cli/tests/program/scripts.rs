// SPDX-License-Identifier: GPL-3.0-or-later
//! Shaders in the shading language: `--shader`, scene files, skies, `trace`.

use gnurt::image::{Picture, compare};

use super::harness::Folder;
use super::samples;

const MATTE: &str = "surface my_matte (color tint = 0.5 [[ string label = \"Tint\" ]])\n{\n    float unused = u + 1;\n    Ci = tint * diffuse (N);\n}\n";

fn picture(folder: &Folder, name: &str) -> Picture {
    gnurt::image::read(&folder.at(name)).expect("a picture")
}

/// The greatest difference of two pictures.
fn difference(folder: &Folder, [a, b]: [&str; 2]) -> f64 {
    compare(&picture(folder, a), &picture(folder, b)).expect("one size").max_difference
}

#[test]
fn a_diffuse_script_is_the_built_in_matte() {
    let folder = Folder::new();
    folder.write("matte.osl", MATTE);
    for integrator in ["whitted", "path", "ir"] {
        let line = format!("render builtin:cornell -r 16x12 --spp 1 --integrator {integrator} --shader");
        folder.gnurt(&format!("{line} *=MatteShader:color=0.9,0.5,0.2 -o class.pfm")).success();
        folder.gnurt(&format!("{line} *=matte.osl:tint=0.9,0.5,0.2 -o script.pfm")).success();
        let found = difference(&folder, ["class.pfm", "script.pfm"]);
        assert!(found < 1e-4, "{integrator}: the same light: {found}");
    }
    let shown =
        folder.gnurt("trace builtin:cornell --pixel 8,6 -r 16x12 --shader *=matte.osl:tint=0.25").success();
    for expected in ["tint = 0.25 0.25 0.25", "Ci = (0.25, 0.25, 0.25) * diffuse"] {
        assert!(shown.stdout.contains(expected), "{expected}: {}", shown.stdout);
    }
}

#[test]
fn lights_and_skies_in_the_language_shine() {
    let folder = Folder::new();
    folder.write("scene.obj", samples::OBJ);
    folder.write("scene.mtl", "newmtl red\nKd 0.5 0.5 0.5\n");
    folder.write(
        "lamp.osl",
        "light lamp (color power = 1) { vector way = point (0, 1, 4) - Ps; lightdist = length (way); L = normalize (way); Cl = power / dot (way, way); }",
    );
    folder.write("sky.osl", "environment sky () { Ci = color (0.5, 1, 2) * background (); }");
    let line = "render scene.obj -r 16x12 --spp 1 --integrator whitted --environment";
    folder.gnurt(&format!("{line} 0,0,0 --shader lamp.osl:power=2,4,8 -o lamp.pfm")).success();
    let lamp = picture(&folder, "lamp.pfm");
    let bright = lamp.color.iter().map(|pixel| pixel[2]).fold(0.0, f32::max);
    // Near the middle: albedo / pi * power / distance squared.
    assert!((bright - 0.5 / std::f32::consts::PI * 8.0 / 16.0).abs() < 0.01, "{bright}");
    let line = line.replace("--spp 1 ", "--spp 64 ");
    folder.gnurt(&format!("{line} sky.osl -o sky.pfm")).success();
    folder.gnurt(&format!("{line} 0.5,1,2 -o even.pfm")).success();
    let found = difference(&folder, ["sky.pfm", "even.pfm"]);
    assert!(found < 0.2, "the same sky, sampled by a table or evenly: {found}");
    let sky = picture(&folder, "sky.pfm");
    assert!((sky.color[0][2] - 2.0).abs() < 1e-3, "what is seen of it: {:?}", sky.color[0]);
}

#[test]
fn scene_files_name_shaders() {
    let folder = Folder::new();
    folder.write("scene.obj", samples::OBJ);
    folder.write("shaders/glow.osl", "surface glow (color tint = 1) { Ci = tint * emission (); }");
    let line = "render scene.obj -r 16x12 --spp 1 --integrator whitted --environment 0,0,0";
    folder
        .write("scene.mtl", "newmtl red\nKd 0.5 0.5 0.5\ngnurt_shader shaders/glow.osl tint=0.25,0.5,0.75\n");
    folder.gnurt(&format!("{line} -o glow.pfm")).success();
    let glow = picture(&folder, "glow.pfm");
    assert!(glow.color.iter().any(|pixel| pixel[..3] == [0.25, 0.5, 0.75]), "as the file says");
    folder.write("scene.mtl", "newmtl red\nKd 0.5 0.5 0.5\ngnurt_shader shaders/none.osl\n");
    let run = folder.gnurt(&format!("{line} -o none.pfm")).success();
    assert!(run.stderr.contains("warning: ") && run.stderr.contains("none.osl"), "{}", run.stderr);
    folder.write("other/secret.osl", "surface secret () { Ci = emission (); }");
    folder.write("inner/scene.obj", samples::OBJ);
    folder.write("inner/scene.mtl", "newmtl red\ngnurt_shader ../other/secret.osl\n");
    let run = folder.gnurt("render inner/scene.obj -r 8x8 --spp 1 --confine inner -o no.png");
    assert_eq!(run.status, Some(1), "it lies outside: {}", run.stderr);
}

#[test]
fn surfaces_that_glow_are_lamps() {
    let folder = Folder::new();
    let floor = "v -2 0 -2\nv -2 0 2\nv 2 0 2\nv 2 0 -2\nusemtl floor\nf 1 2 3 4\n";
    let lamp = "v -0.1 1 -0.1\nv 0.1 1 -0.1\nv 0.1 1 0.1\nv -0.1 1 0.1\nusemtl lamp\nf 5 6 7 8\n";
    folder.write("scene.obj", format!("mtllib scene.mtl\n{floor}{lamp}"));
    folder.write("glow.osl", "surface glow () { Ci = (backfacing () ? 0 : 40) * emission (); }");
    for integrator in ["whitted", "path", "ir", "mir"] {
        for (name, says) in [("told", "Kd 0 0 0\nKe 40 40 40"), ("asked", "gnurt_shader glow.osl")] {
            folder.write("scene.mtl", format!("newmtl floor\nKd 0.5 0.5 0.5\nnewmtl lamp\n{says}\n"));
            let line = "render scene.obj --eye 2,2,3 --target 0,0,0 -r 12x8 --spp 1 --vpls 16 --max-depth 2";
            let line = format!("{line} --environment 0,0,0 --integrator {integrator}");
            folder.gnurt(&format!("{line} -o {name}.pfm")).success();
        }
        let lit = picture(&folder, "told.pfm").color.iter().filter(|pixel| pixel[1] > 0.01).count();
        assert!(lit > 48, "{integrator}: the lamp shines on the floor: {lit} pixels");
        let found = difference(&folder, ["told.pfm", "asked.pfm"]);
        assert!(found < 1e-3, "{integrator}: one light, and the same samples of it: {found}");
    }
}

#[test]
fn wrong_scripts_are_refused() {
    let folder = Folder::new();
    folder.write("bad.osl", "surface bad ()\n{\n    Ci = diffus (N);\n}\n");
    folder.write("matte.osl", MATTE);
    folder.write("lamp.osl", "light lamp () { Cl = 1; L = N; }");
    folder.write("eye.osl", "camera eye () { I = N; }");
    for (choice, message) in [
        (
            "*=bad.osl",
            "bad.osl: bad.osl:3:10: function 'diffus' was not declared in this scope; did you mean 'diffuse'?\n",
        ),
        ("*=none.osl", "none.osl: no such file"),
        ("*=matte.osl:tnt=1", "unknown parameter 'tnt'"),
        ("*=matte.osl:tint=red", "'red' is not numbers"),
        ("*=lamp.osl", "of type light; one of type surface is expected"),
        ("matte.osl", "give MATERIAL=matte.osl"),
        ("eye.osl", "give --camera eye.osl"),
    ] {
        let run = folder.run(&["render", "builtin:cornell", "-r", "8x8", "-o", "p.png", "--shader", choice]);
        assert!(matches!(run.status, Some(1 | 2)), "{choice}: {:?} {}", run.status, run.stderr);
        assert!(run.stderr.contains(message), "{choice}: '{message}' must be said: {}", run.stderr);
        assert!(!run.stderr.contains("panicked") && !folder.at("p.png").exists(), "{choice}");
    }
    // An endless shader is stopped, and the picture continues.
    folder.write("endless.osl", "surface endless () { while (1) { } }");
    let run = folder.gnurt("render builtin:cornell -r 8x8 --spp 1 --shader *=endless.osl -o p.pfm").success();
    assert!(run.stderr.contains("did not end"), "{}", run.stderr);
}

const PINHOLE: &str = "camera eye (float fov = 45, float aspect = 1) { float half = tan (radians (0.5 * fov));
    P = point (\"camera\", 0, 0, 0); I = vector (\"camera\", (2 * u - 1) * half * aspect, (2 * v - 1) * half, -1); }";

#[test]
fn cameras_in_the_language_see() {
    let folder = Folder::new();
    folder.write("eye.osl", PINHOLE);
    let line = "render builtin:cornell -r 24x16 --spp 4 --integrator whitted --eye 0.5,1,3 --target 0.5,1,0";
    folder.gnurt(&format!("{line} --fov 60 -o built-in.pfm")).success();
    folder.gnurt(&format!("{line} --camera eye.osl:fov=60 -o script.pfm")).success();
    let found =
        compare(&picture(&folder, "built-in.pfm"), &picture(&folder, "script.pfm")).expect("one size");
    assert!(found.mse < 1e-4, "the same view, but for edges: {found:?}");
    // In a scene's file, where the camera moves, and in its place by name.
    super::animation::animated(&folder);
    let text = String::from_utf8(folder.read("a.gltf")).expect("text");
    let with =
        text.replacen("\"cameras\":[{", "\"cameras\":[{\"extras\":{\"gnurt\":{\"shader\":\"eye.osl\"}},", 1);
    assert_ne!(text, with, "it has a camera");
    folder.write("b.gltf", &with);
    let clip = "-r 24x16 --spp 2 --integrator eyelight --animation all --shutter 0.5 --at 0.1";
    folder.gnurt(&format!("render b.gltf {clip} -o file.pfm")).success();
    folder.gnurt(&format!("render a.gltf {clip} --camera eye.osl -o option.pfm")).success();
    assert!(folder.read("file.pfm") == folder.read("option.pfm"), "the file's or the option's");
    for (options, message) in [
        ("--camera eye.osl --fov 30", "give its parameters as eye.osl:NAME=VALUE"),
        ("--camera none.osl", "--camera: none.osl: no such file"),
        ("--camera eye.osl:fv=1", "unknown parameter 'fv'"),
        ("--camera nobody=eye.osl", "no such camera"),
        ("--pixel-shader eye.osl", "of type camera; one of type pixel is expected"),
        ("--pixel-shader *=eye.osl", "give FILE.osl"),
    ] {
        let run = folder.gnurt(&format!("render builtin:cornell -r 8x8 -o p.png {options}"));
        assert!(matches!(run.status, Some(1 | 2)), "{options}: {:?} {}", run.status, run.stderr);
        assert!(run.stderr.contains(message), "{options}: '{message}' must be said: {}", run.stderr);
    }
}

#[test]
fn pixels_show_what_a_shader_says() {
    let folder = Folder::new();
    folder.write(
        "grade.osl",
        "pixel grade (color gain = 1, float far = 0, output color Cpixel = 0) {
            float d = 0; if (trace (P, I)) getmessage (\"trace\", \"hitdist\", d);
            Cpixel = gain * (color) trace (P, I) + far * d; }",
    );
    let line = "render builtin:cornell -r 40x30 --spp 3 --denoise=none";
    folder.gnurt(&format!("{line} -o plain.pfm")).success();
    folder.gnurt(&format!("{line} --pixel-shader grade.osl -o same.pfm")).success();
    assert!(folder.read("plain.pfm") == folder.read("same.pfm"), "the radiance along its ray");
    // Pieces and threads make the same bytes, and a piece knows its shader.
    let line = format!("{line} --pixel-shader grade.osl:gain=2,1,0.5:far=0.25");
    folder.gnurt(&format!("{line} -o whole.png -t 1")).success();
    for i in [1, 2] {
        folder.gnurt(&format!("{line} --piece {i}/2 -o {i}.exr")).success();
    }
    folder.gnurt("join 1.exr 2.exr --denoise=none -o joined.png").success();
    assert!(folder.read("whole.png") == folder.read("joined.png"), "the bytes of the single run");
    folder.gnurt(&format!("{line}:gain=1 --piece 2/2 -o other.exr")).success();
    assert_ne!(folder.gnurt("join 1.exr other.exr -o no.png").status, Some(0), "of another picture");
    folder.gnurt("view builtin:cornell --headless -r 40x30 --integrator eyelight --pixel-shader grade.osl:gain=0 -o v.pfm").success();
    assert!(picture(&folder, "v.pfm").color.iter().all(|pixel| pixel[..3] == [0.0; 3]), "in the viewer, too");
    let shown = folder.gnurt("trace builtin:cornell --pixel 8,6 -r 16x12 --pixel-shader grade.osl").success();
    assert!(shown.stdout.contains("radiance"), "{}", shown.stdout);
}

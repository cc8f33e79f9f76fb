// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt render --at` and `--frames`: moments of clips, and sequences of files.

use super::harness::Folder;

/// A triangle that turns in steps of 90 degrees within 2 seconds and glows more and more, a light that fades, a camera that moves
/// away; and a second clip in which nothing but the triangle moves.
pub(crate) fn animated(folder: &Folder) {
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let floats: &[&[f32]] = &[
        &[-1.0, -1.0, 0.0, 1.0, -1.0, 0.0, 0.0, 1.0, 0.0],
        &[0.0, 1.0, 2.0],
        &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, half, half, 0.0, 0.0, 1.0, 0.0],
        &[9.0, 6.0, 3.0],
        &[0.0, 0.0, 4.0, 0.5, 0.0, 5.0, 1.0, 0.0, 6.0],
        &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 2.0, 0.0, 0.0],
    ];
    let bytes: Vec<u8> = floats.iter().flat_map(|list| list.iter().flat_map(|x| x.to_le_bytes())).collect();
    let mut offset = 0;
    let (mut views, mut accessors) = (Vec::new(), Vec::new());
    for (i, (list, shape)) in
        floats.iter().zip(["VEC3", "SCALAR", "VEC4", "SCALAR", "VEC3", "VEC3"]).enumerate()
    {
        views.push(format!(r#"{{"buffer":0,"byteOffset":{offset},"byteLength":{}}}"#, 4 * list.len()));
        accessors.push(format!(r#"{{"bufferView":{i},"componentType":5126,"count":3,"type":"{shape}"}}"#));
        offset += 4 * list.len();
    }
    folder.write("a.bin", &bytes);
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"uri":"a.bin","byteLength":{offset}}}],
        "bufferViews":[{}],"accessors":[{}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
        "cameras":[{{"type":"perspective","perspective":{{"yfov":0.8,"znear":0.1}}}}],
        "extensions":{{"KHR_lights_punctual":{{"lights":[{{"type":"point","intensity":9}}]}}}},
        "nodes":[{{"mesh":0}},{{"camera":0,"translation":[0,0,4]}},{{"translation":[1,1,3],"extensions":{{"KHR_lights_punctual":{{"light":0}}}}}}],
        "animations":[{{"name":"all","samplers":[{{"input":1,"output":2}},{{"input":1,"output":3}},{{"input":1,"output":4}}],
        "channels":[{{"sampler":0,"target":{{"node":0,"path":"rotation"}}}},{{"sampler":2,"target":{{"node":1,"path":"translation"}}}},
        {{"sampler":1,"target":{{"path":"pointer","extensions":{{"KHR_animation_pointer":{{"pointer":"/extensions/KHR_lights_punctual/lights/0/intensity"}}}}}}}}]}},
        {{"name":"slide","samplers":[{{"input":1,"output":5}}],"channels":[{{"sampler":0,"target":{{"node":0,"path":"translation"}}}}]}}]}}"#,
        views.join(","),
        accessors.join(",")
    );
    folder.write("a.gltf", json);
}

const SMALL: &str = "-r 24x16 --spp 2 -t 2";

#[test]
fn a_sequence_has_the_pictures_of_its_moments() {
    let folder = Folder::new();
    animated(&folder);
    let run = folder
        .gnurt(&format!("render a.gltf --frames 0..4 --fps 3 --denoise-window 0 -o f.###.png {SMALL}"))
        .success();
    assert_eq!(run.stderr.matches("denoised").count(), 1, "said once: {}", run.stderr);
    let mut before = Vec::new();
    for frame in 0..=4_u32 {
        let seconds = f64::from(frame) / 3.0;
        folder.gnurt(&format!("render a.gltf --at {seconds} --seed {frame} -o one.png {SMALL}")).success();
        let one = folder.read("one.png");
        assert!(one == folder.read(&format!("f.{frame:03}.png")), "frame {frame}: the same bytes");
        assert!(one != before, "frame {frame}: something moved");
        before = one;
    }
    folder
        .gnurt(&format!("render a.gltf --frames 0..4:2 --fps 3 --denoise-window 0 -o step.#.png {SMALL}"))
        .success();
    for frame in 0..=4 {
        let (step, all) = (folder.at(&format!("step.{frame}.png")), format!("f.{frame:03}.png"));
        assert_eq!(step.exists(), frame % 2 == 0, "every second frame");
        assert!(
            !step.exists() || folder.read(&format!("step.{frame}.png")) == folder.read(&all),
            "the same frame"
        );
    }
    for (name, file) in [("slide", "name.png"), ("1", "number.png")] {
        folder.gnurt(&format!("render a.gltf --at 1 --animation {name} -o {file} {SMALL}")).success();
    }
    assert!(folder.read("name.png") == folder.read("number.png"), "a clip by its name and by its number");
    folder.gnurt(&format!("render a.gltf --at 1 -o first.png {SMALL}")).success();
    assert!(folder.read("name.png") != folder.read("first.png"), "it is not the first one");
}

#[test]
fn scenes_without_camera_and_light_keep_theirs() {
    let folder = Folder::new();
    animated(&folder);
    let json = String::from_utf8(folder.read("a.gltf")).expect("text");
    let bare = json
        .replace(r#""camera":0,"#, "")
        .replace(r#","extensions":{"KHR_lights_punctual":{"light":0}}"#, "");
    folder.write("b.gltf", bare);
    let run = folder
        .gnurt(&format!("render b.gltf --animation slide --frames 0..2 --fps 1 --denoise-window 0 {SMALL}"))
        .success();
    assert_eq!(run.stderr.matches("the scene has no camera").count(), 1, "told once: {}", run.stderr);
    for frame in 0..=2 {
        folder
            .gnurt(&format!("render b.gltf --animation slide --at {frame} --seed {frame} -o one.png {SMALL}"))
            .success();
        let name = format!("b.{frame:04}.png");
        assert!(folder.read("one.png") == folder.read(&name), "frame {frame} by its default name");
    }
}

#[test]
fn frames_that_are_there_are_kept() {
    let folder = Folder::new();
    animated(&folder);
    folder.write("f.1.png", "mine");
    folder.gnurt(&format!("render a.gltf --frames 0..2 --skip-existing -o f.#.png {SMALL}")).success();
    assert_eq!(folder.read("f.1.png"), b"mine", "kept");
    let all = folder.contents();
    let run =
        folder.gnurt(&format!("render a.gltf --frames 0..2 --skip-existing -o f.#.png {SMALL}")).success();
    assert!(run.stderr.contains("all frames are there already"), "{}", run.stderr);
    assert!(folder.contents() == all, "nothing to do");
    folder.gnurt(&format!("render a.gltf --frames 1 -o f.#.png {SMALL}")).success();
    assert_eq!(&folder.read("f.1.png")[1..4], b"PNG", "one frame, written again");
}

#[test]
fn files_with_numbers_are_a_sequence() {
    let folder = Folder::new();
    for (number, x) in [(0, 0.0), (3, 0.5), (4, 1.0)] {
        folder.write(
            &format!("m.{number:02}.obj"),
            format!("v {x} 0.2 0\nv 1 0 0\nv 0 1 {x}\nv 0 0 1\nf 1 2 3\nf 1 2 4\n"),
        );
    }
    folder.gnurt(&format!("render m.##.obj --frames 0..4:3 {SMALL}")).success();
    let [zero, three] = [0, 3].map(|frame| folder.read(&format!("m.{frame:02}.png")));
    assert!(zero != three, "the files differ");
    folder.gnurt(&format!("render m.##.obj --at 0.125 --seed 3 -o one.png {SMALL}")).success();
    assert!(folder.read("one.png") == three, "the third file is that of 3 / 24 s");
    folder.gnurt(&format!("render m.00.obj -o still.png {SMALL}")).success();
    assert!(folder.read("still.png") == zero, "the first one as it is by itself");
    folder
        .gnurt(&format!("render m.##.obj --frames 4..5 -q -o n.#.png {SMALL}"))
        .fails(1, "m.05.obj: no such file");
    assert!(folder.at("n.4.png").exists(), "what could be made is there");
    folder
        .gnurt(&format!("render m.##.obj {SMALL}"))
        .fails(2, "sequence of files; give --frames FIRST..LAST");
    folder
        .gnurt(&format!("render n.##.obj --frames 1..2 {SMALL}"))
        .fails(1, "no file of this sequence, such as n.01.obj");
}

#[test]
fn mistakes_are_told_before_any_work() {
    let folder = Folder::new();
    animated(&folder);
    folder.write("still.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    for (line, status, expected) in [
        ("a.gltf --frames 3..1 -o f.#.png", 2, "did you mean 1..3?"),
        ("a.gltf --frames 0..1 -o f.png", 2, "mark the number by #, as in frame.####.png"),
        (
            "a.gltf --frames 0..1 -o f.#.png --heatmap h.png",
            2,
            "--heatmap h.png: --frames makes more than one",
        ),
        ("a.gltf --frames 0..1 --at 1 -o f.#.png", 2, "--frames"),
        ("a.gltf --at nan", 2, "give a time in seconds like 1.5"),
        ("a.gltf --fps 0 --at 1", 2, "give frames per second above 0"),
        ("a.gltf --animation all", 2, "give --at SECONDS or --frames FIRST..LAST, too"),
        ("a.gltf --at 1 --animation slid", 2, "did you mean 'slide'? valid are: 0 'all', 1 'slide'"),
        ("a.gltf --at 1 --animation 2", 2, "no such animation"),
        ("still.obj --at 1", 2, "the scene has no animation"),
        ("a.gltf --frames 0..1 -o f.#.png --checkpoint c", 2, "--skip-existing continues"),
    ] {
        let before = folder.contents();
        folder.gnurt(&format!("render {line} -q")).fails(status, expected);
        assert!(folder.contents() == before, "{line}: nothing was written");
    }
}

#[test]
fn animations_are_listed_and_their_loss_is_told() {
    let folder = Folder::new();
    animated(&folder);
    let json: serde_json::Value =
        serde_json::from_str(&folder.gnurt("info a.gltf --json").success().stdout).expect("JSON");
    let clip = &json["animations"][1];
    assert_eq!(
        (&clip["name"], &clip["last_seconds"], &clip["channels"]),
        (&"slide".into(), &2.0.into(), &1.into()),
        "{json}"
    );
    let text = folder.gnurt("info a.gltf").success().stdout;
    assert!(text.contains("0 'all': 0 to 2 s, 3 channels"), "{text}");
    let run = folder.gnurt("convert a.gltf b.obj").success();
    assert!(run.stderr.contains("animation, written as it is shown) [2 in all]"), "{}", run.stderr);
}

#[test]
fn an_open_shutter_blurs() {
    let folder = Folder::new();
    animated(&folder);
    let picture = |more: &str, file: &str| {
        folder.gnurt(&format!("render a.gltf {more} -o {file} -r 24x16 --spp 4 -t 2")).success();
        folder.read(file)
    };
    let sharp = picture("--at 0.25", "sharp.png");
    assert!(sharp == picture("--at 0.25 --shutter 0", "closed.png"), "0 closes it at once");
    for integrator in ["whitted", "path", "ir", "bir", "mir", "eyelight", "normals"] {
        let sharp = picture(&format!("--at 0.25 --integrator {integrator}"), "sharp.png");
        let blurred = picture(&format!("--at 0.25 --shutter 12 --integrator {integrator}"), "blurred.png");
        assert!(sharp != blurred, "{integrator} sees what moves");
    }
    // A sequence is, byte for byte, its moments, each under a seed of its own.
    folder
        .gnurt(&format!(
            "render a.gltf --frames 3..4 --fps 8 --shutter 1.5 --denoise-window 0 -o f.#.png {SMALL}"
        ))
        .success();
    for (frame, seconds) in [(3, "0.375"), (4, "0.5")] {
        folder
            .gnurt(&format!(
                "render a.gltf --at {seconds} --fps 8 --shutter 1.5 --seed {frame} -o one.png {SMALL}"
            ))
            .success();
        assert!(folder.read("one.png") == folder.read(&format!("f.{frame}.png")), "frame {frame}");
    }
    let refused = |arguments: &str, why: &str| {
        let run = folder.gnurt(&format!("render {arguments}"));
        assert!(run.status != Some(0) && run.stderr.contains(why), "{arguments}: {}", run.stderr);
    };
    refused("a.gltf --shutter 1", "the time is missing");
    refused("a.gltf --at 1 --shutter -1", "0 or more");
    folder.write("m.01.ply", "ply");
    refused("m.##.ply --frames 1..2 --shutter 0.5 -o f.#.png", "motion blur needs an animation");
}

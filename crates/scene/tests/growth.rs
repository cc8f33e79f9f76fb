// SPDX-License-Identifier: GPL-3.0-or-later
//! Cost of scene files: at most 512 MiB and 64 times their length, and a few seconds. Every allocation of the
//! program is counted. One test only, so that nothing else is counted.

#![expect(clippy::print_stdout, reason = "a failing table tells the row that it was at")]

mod common;

use std::path::Path;
use std::time::{Duration, Instant};

use common::load;
use gnurt_image::{Picture, PictureFormat, WriteOptions};
use peak_alloc::PeakAlloc;

#[global_allocator]
static ALLOCATIONS: PeakAlloc = PeakAlloc;

/// Memory that loading a file may always take.
const BELIEVED: u64 = 512 << 20;
/// And for each byte of all that was read.
const GROWTH: u64 = 64;
/// It takes tenths of a second where nothing else runs.
const LONGEST: Duration = Duration::from_secs(60);

/// The result of a file.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Outcome {
    Loaded,
    Refused,
    /// Either result is right, depending on the size of a value.
    Either,
}
use Outcome::{Either, Loaded, Refused};

/// As many copies of `element` as `megabytes` hold, with commas between them.
fn list(element: &str, megabytes: usize) -> String {
    let count = (megabytes << 20) / (element.len() + 1);
    format!("{}{element}", format!("{element},").repeat(count))
}

fn gltf(body: &str) -> Vec<u8> {
    format!(r#"{{"asset":{{"version":"2.0"}},{body}}}"#).into_bytes()
}

/// A triangle for accessor 0, and the mesh of it.
const TRIANGLE: &str = r#""buffers":[{"byteLength":36,"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],
"bufferViews":[{"buffer":0,"byteLength":36}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}]"#;
const MESH: &str = r#""meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}]"#;

fn gltf_cases() -> Vec<(String, Vec<u8>, Outcome)> {
    let mut cases = Vec::new();
    let mut case = |name: &str, body: String, outcome| cases.push((name.to_owned(), gltf(&body), outcome));
    for array in [
        "accessors",
        "animations",
        "bufferViews",
        "cameras",
        "images",
        "meshes",
        "nodes",
        "samplers",
        "scenes",
        "skins",
        "textures",
    ] {
        // A skin without joints is none, and is asked for its joints.
        let outcome = if array == "skins" { Refused } else { Loaded };
        case(array, format!(r#""{array}":[{}]"#, list("{}", 3)), outcome);
    }
    case("materials", format!(r#""materials":[{}]"#, list("{}", 9)), Refused);
    case("buffers", format!(r#""buffers":[{}]"#, list(r#"{"byteLength":0}"#, 3)), Loaded);
    case("instances", format!(r#"{TRIANGLE},{MESH},"nodes":[{}]"#, list(r#"{"mesh":0}"#, 3)), Either);
    case(
        "cameras",
        format!(
            r#""cameras":[{{"type":"perspective","perspective":{{"yfov":1}}}}],"nodes":[{}]"#,
            list(r#"{"camera":0}"#, 3)
        ),
        Either,
    );
    case(
        "primitives",
        format!(
            r#"{TRIANGLE},"nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{}]}}]"#,
            list(r#"{"attributes":{"POSITION":0}}"#, 3)
        ),
        Either,
    );
    case(
        "a long name",
        format!(
            r#"{TRIANGLE},"nodes":[{{"mesh":0}}],"meshes":[{{"name":"{}","primitives":[{}]}}]"#,
            "m".repeat(4 << 20),
            list(r#"{"attributes":{"POSITION":0}}"#, 1)
        ),
        Refused,
    );
    case(
        "a long light",
        format!(
            r#""nodes":[{}],"extensions":{{"KHR_lights_punctual":{{"lights":[{{"type":"point","name":"{}"}}]}}}}"#,
            list(r#"{"extensions":{"KHR_lights_punctual":{"light":0}}}"#, 4),
            "x".repeat(4 << 20)
        ),
        Refused,
    );
    case(
        "joints",
        format!(
            r#"{TRIANGLE},{MESH},"nodes":[{}],"skins":[{{"joints":[{}]}}]"#,
            list(r#"{"mesh":0,"skin":0}"#, 1),
            list("0", 8)
        ),
        Refused,
    );
    case(
        "morph targets",
        format!(
            r#"{TRIANGLE},"nodes":[{{"mesh":0}}],"meshes":[{{"weights":[1],"primitives":[{{"attributes":{{"POSITION":0}},"targets":[{}]}}]}}]"#,
            list("{}", 9)
        ),
        Loaded,
    );
    let curve = r#""samplers":[{"input":0,"output":0,"interpolation":"STEP"}]"#;
    let scale = r#"{"sampler":0,"target":{"node":0,"path":"scale"}}"#;
    case(
        "channels",
        format!(r#"{TRIANGLE},"nodes":[{{}}],"animations":[{{{curve},"channels":[{}]}}]"#, list(scale, 9)),
        Either,
    );
    case(
        "clips",
        format!(
            r#"{TRIANGLE},"nodes":[{{}}],"animations":[{}]"#,
            list(&format!(r#"{{{curve},"channels":[{scale}]}}"#), 9)
        ),
        Either,
    );
    case(
        "long times",
        format!(
            r#""accessors":[{{"componentType":5126,"count":20000000,"type":"SCALAR"}}],"nodes":[{{}}],"animations":[{}]"#,
            list(&format!(r#"{{{curve},"channels":[{scale}]}}"#), 1)
        ),
        Refused,
    );
    case(
        "driven morph targets",
        format!(
            r#"{TRIANGLE},"nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"targets":[{}]}}]}}],
            "animations":[{{"samplers":[{{"input":1,"output":1}}],"channels":[{{"sampler":0,"target":{{"node":0,"path":"weights"}}}}]}}]"#,
            list("{}", 9)
        )
        .replace(r#""type":"VEC3"}]"#, r#""type":"VEC3"},{"bufferView":0,"componentType":5126,"count":1,"type":"SCALAR"}]"#),
        Either,
    );
    case("deep", format!(r#""extras":{}{}"#, "[".repeat(4 << 20), "]".repeat(4 << 20)), Loaded);
    let nodes = (1..130_000).map(|k| format!(r#"{{"children":[{k}]}}"#)).collect::<Vec<_>>().join(",");
    case("a chain", format!(r#""nodes":[{nodes},{{}}],"scenes":[{{"nodes":[0]}}],"scene":0"#), Loaded);
    case(
        "zeros",
        format!(
            r#""accessors":[{{"componentType":5126,"count":20000000,"type":"VEC3"}}],"nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{}]}}]"#,
            list(r#"{"attributes":{"POSITION":0}}"#, 1)
        ),
        Refused,
    );
    cases
}

const V: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

/// As many copies of a line as `megabytes` hold, after three vertices.
fn lines(line: &str, megabytes: usize) -> Vec<u8> {
    format!("{V}{}", line.repeat(((megabytes << 20) / line.len()).max(1))).into_bytes()
}

fn obj_cases() -> Vec<(String, Vec<u8>, Outcome)> {
    let case = |name: &str, bytes, outcome| (name.to_owned(), bytes, outcome);
    let corners = |n: usize| format!("f{}\n", " 1 2 3".repeat(n));
    let names = |keyword: &str, n: usize| (0..n).map(|k| format!("{keyword} a{k}\n")).collect::<String>();
    let polygon = format!("f{}\n", (1..=2000).map(|k| format!(" {k}")).collect::<String>());
    let zigzag = (0..2000).map(|k| format!("v {k} {} 0\n", k * 7919 % 1000)).collect::<String>();
    vec![
        case("vertices", lines("v 0 0 0\n", 3), Loaded),
        case("empty vt", lines("vt\n", 3), Loaded),
        case("empty vn", lines("vn\n", 3), Loaded),
        case("groups", lines("g a\n", 3), Loaded),
        case("materials", lines("usemtl a\nf 1 2 3\n", 3), Loaded),
        case("a long line", lines(&corners(1 << 20), 6), Loaded),
        case("a longer line", lines(&corners(3 << 20), 18), Refused),
        case("libraries", names("mtllib", 100_000).into_bytes(), Refused),
        case("polygons", format!("{zigzag}{}", polygon.repeat(100)).into_bytes(), Loaded),
    ]
}

/// Libraries for a file with one triangle.
fn mtl_cases() -> Vec<(String, Vec<u8>, Outcome)> {
    let case = |name: &str, text: String, outcome| (name.to_owned(), text.into_bytes(), outcome);
    let numbered = |count: usize, map: &str| {
        (0..count).map(|k| format!("newmtl m{k}\n{}", map.replace('#', &k.to_string()))).collect::<String>()
    };
    vec![
        case("one name", "newmtl a\n".repeat(1 << 20), Loaded),
        case("names", numbered(1_500_000, ""), Refused),
        case("maps", format!("newmtl a\n{}", "map_Kd a.png\n".repeat(1 << 18)), Loaded),
        case("one missing map", numbered(50_000, "map_Kd a.png\n"), Loaded),
        case("missing maps", numbered(50_000, "map_Kd a#.png\n"), Loaded),
        case("one flat map", numbered(50_000, "map_Kd flat.png\n"), Loaded),
        case("flat maps", numbered(40, "map_Kd flat#.png\n"), Loaded),
    ]
}

fn ply_cases() -> Vec<(String, Vec<u8>, Outcome)> {
    const XYZ: &str = "property uchar x\nproperty uchar y\nproperty uchar z\n";
    let case = |name: &str, header: String, body: &[u8], outcome| {
        let head = format!("ply\nformat binary_little_endian 1.0\n{header}end_header\n");
        (name.to_owned(), [head.as_bytes(), body].concat(), outcome)
    };
    let list = "property list uint uchar vertex_indices\n";
    let corners = |count: u32, bytes: usize| [&[0; 9][..], &count.to_le_bytes(), &vec![1; bytes]].concat();
    let three = format!("element vertex 3\n{XYZ}element face 1\n{list}");
    vec![
        case("vertices", format!("element vertex 3000000\n{XYZ}"), &vec![0; 9_000_000], Loaded),
        case("a list", three.clone(), &corners(6 << 20, 6 << 20), Loaded),
        case("a long list", three.clone(), &corners(20 << 20, 20 << 20), Refused),
        case("a list that is not there", three, &corners(u32::MAX, 9), Refused),
        case(
            "empty faces",
            format!(
                "element vertex 3\n{XYZ}element face 6000000\nproperty list uchar uchar vertex_indices\n"
            ),
            &vec![0; 6_000_009],
            Loaded,
        ),
        case(
            "elements",
            (0..25_000).map(|k| format!("element e{k} 0\nproperty int a\n")).collect(),
            &[],
            Loaded,
        ),
    ]
}

fn judge(folder: &Path, name: &str, length: u64, path: &Path, outcome: Outcome) {
    let begin = Instant::now();
    ALLOCATIONS.reset_peak_usage();
    let before = ALLOCATIONS.current_usage();
    let loaded = load(path);
    let peak = (ALLOCATIONS.peak_usage() - before) as u64;
    let time = begin.elapsed();
    let allowed = BELIEVED + GROWTH * length;
    let message = match &loaded {
        Ok(_) => "loaded".to_owned(),
        Err(error) => error.to_string().replace(&folder.to_string_lossy()[..], ""),
    };
    println!("{name}: {} MiB for {} KiB in {time:?}: {message}", peak >> 20, length >> 10);
    assert!(peak <= allowed, "{name}: {} MiB for a file of {} KiB: {message}", peak >> 20, length >> 10);
    assert!(time <= LONGEST, "{name}: {time:?}: {message}");
    assert_eq!(message.lines().count(), 1, "{name}: one line: {message}");
    match outcome {
        Loaded => assert!(loaded.is_ok(), "{name}: {message}"),
        Refused => assert!(loaded.is_err(), "{name}: was to be refused"),
        Either => {}
    }
}

/// A mesh of this many vertices that a weight lifts, and its memory for an open shutter: one mesh at the
/// start, one at the end, and one or two between.
fn open_shutter(side: u32) {
    use gnurt_scene::animation::{Body, Channel, Clip, Deltas, Interpolation, Morph, Sampler, Target};
    let count = (side * side) as usize;
    let keyed_positions = || (0..side * side).map(|i| [(i % side) as f32, (i / side) as f32, 0.0]);
    let squares = (0..side - 1).flat_map(|y| (0..side - 1).map(move |x| y * side + x));
    let indices = squares.flat_map(|i| [[i, i + 1, i + side], [i + 1, i + side + 1, i + side]]).collect();
    let mut scene = gnurt_scene::Scene::new();
    let material = scene.add_material(gnurt_scene::Material::matte("m", [0.5; 3]));
    let mesh = gnurt_scene::Mesh {
        positions: keyed_positions().collect(),
        normals: vec![[0.0, 0.0, 1.0]; count],
        texcoords: vec![[0.0; 2]; count],
        indices,
        material,
        ..gnurt_scene::Mesh::default()
    };
    let bytes = mesh.memory_bytes();
    let mesh = scene.add_mesh(mesh);
    let object = scene.add_object_of("o", vec![mesh]);
    scene.instantiate(object, gnurt_scene::Affine::IDENTITY);
    let lift = Morph { positions: Deltas::new(vec![[0.0, 0.0, 100.0]; count]), ..Morph::default() };
    let base = scene.meshes()[0].clone();
    let weights =
        Sampler::new(vec![0.0, 1.0].into(), vec![0.0, 1.0], 1, Interpolation::Linear).expect("keys");
    let channel = Channel { target: Target::Weights(0), sampler: weights.into() };
    let animation = gnurt_scene::Animation {
        bodies: vec![Body { mesh, base, morphs: vec![lift], weights: Some(0), influences: None, skin: None }],
        weights: vec![vec![0.0]],
        clips: vec![Clip { name: String::new(), channels: vec![channel] }],
        ..gnurt_scene::Animation::default()
    };
    scene.animate(animation).expect("it is in order");
    ALLOCATIONS.reset_peak_usage();
    let before = ALLOCATIONS.current_usage();
    let exposure = scene.expose(0, 0.0, 1.0);
    let peak = ALLOCATIONS.peak_usage() - before;
    println!("an open shutter: {peak} bytes for a mesh of {bytes}");
    assert_eq!(exposure.meshes[0].1.len(), 2, "it goes straight");
    assert!(peak < 6 * bytes, "{peak} bytes for a mesh of {bytes}");
}

#[test]
fn files_cost_what_their_lengths_account_for() {
    open_shutter(200);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).expect("a file");
        path
    };
    for (extension, cases) in [("gltf", gltf_cases()), ("obj", obj_cases()), ("ply", ply_cases())] {
        for (name, bytes, outcome) in cases {
            let path = write(&format!("t.{extension}"), &bytes);
            let length = bytes.len() as u64;
            drop(bytes);
            judge(folder.path(), &format!("{extension} {name}"), length, &path, outcome);
        }
    }
    let picture = Picture::new(2048, 2048);
    let flat =
        gnurt_image::encode(&picture, PictureFormat::PNG, &WriteOptions::default()).expect("a picture");
    drop(picture);
    write("flat.png", &flat);
    (0..40).for_each(|k| drop(write(&format!("flat{k}.png"), &flat)));
    let obj = write("t.obj", format!("mtllib t.mtl\n{V}usemtl m7\nf 1 2 3\n").as_bytes());
    for (name, bytes, outcome) in mtl_cases() {
        let maps = if name == "flat maps" { 40 } else { 1 };
        let length = (bytes.len() + maps * flat.len()) as u64;
        write("t.mtl", &bytes);
        judge(folder.path(), &format!("mtl {name}"), length, &obj, outcome);
    }
}

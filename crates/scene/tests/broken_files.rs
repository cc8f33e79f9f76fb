// SPDX-License-Identifier: GPL-3.0-or-later
//! Broken and odd files: each gives the one error that names its place, or the warning and the right triangles.
//! The rules are those of the command line's contract.

use crate::common::{glb, load_named};

/// The expected result of a file.
enum Outcome {
    /// An error whose line holds this text.
    Error(&'static str),
    /// So many triangles, and a warning that holds this text (empty = no warning at all).
    Triangles(usize, &'static str),
}
use Outcome::{Error, Triangles};

const V: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

fn obj_cases() -> Vec<(&'static str, Vec<u8>, Outcome)> {
    let text = |s: &str| s.as_bytes().to_vec();
    let after_v = |s: &str| format!("{V}{s}").into_bytes();
    vec![
        ("good", after_v("f 1 2 3\n"), Triangles(1, "")),
        ("no final newline", after_v("f 1 2 3"), Triangles(1, "")),
        (
            "crlf",
            text(&V.replace('\n', "\r\n")).into_iter().chain(*b"f 1 2 3\r\n").collect(),
            Triangles(1, ""),
        ),
        (
            "cr only",
            text(&V.replace('\n', "\r")).into_iter().chain(*b"f 1 2 3\r").collect(),
            Triangles(1, ""),
        ),
        ("bom", [b"\xef\xbb\xbf".to_vec(), after_v("f 1 2 3\n")].concat(), Triangles(1, "")),
        ("tabs and indentation", text("\tv\t0 0 0\n  v 1 0 0\n v 0  1 0\n\t f\t1 2\t3 \n"), Triangles(1, "")),
        ("continuation", after_v("f 1 \\\n2 \\\r\n3\n"), Triangles(1, "")),
        ("negative indices", after_v("f -3 -2 -1\n"), Triangles(1, "")),
        ("unknown keywords", after_v("curv2 1 2\nhello\nf 1 2 3\n"), Triangles(1, "")),
        ("comments", after_v("# c\nf 1 2 3 # end\n"), Triangles(1, "")),
        ("w", text("v 0 0 0 1\nv 1 0 0 1\nv 0 1 0 1\nf 1 2 3\n"), Triangles(1, "")),
        ("quad", after_v("v 1 1 0\nf 1 2 4 3\n"), Triangles(2, "")),
        ("zero index", after_v("f 0 1 2\n"), Error("t.obj:4: vertex index 0 out of range; expected 1 to 3")),
        ("index too large", after_v("f 1 2 4\n"), Error("t.obj:4: vertex index 4 out of range")),
        ("index too negative", after_v("f 1 2 -4\n"), Error("t.obj:4: vertex index -4 out of range")),
        ("index beyond 64 bits", after_v("f 1 2 99999999999999999999\n"), Error("t.obj:4: bad corner")),
        ("face before vertices", text("f 1 2 3\n"), Error("t.obj:1: vertex index 1 out of range; no vertex")),
        ("face of words", after_v("f a b c\n"), Error("t.obj:4: bad corner `a`")),
        ("four slashes", after_v("f 1/1/1/1 2 3\n"), Error("t.obj:4: bad corner")),
        ("bad number", text("v 0 0 x\n"), Error("t.obj:1: bad number `x`; expected `v X Y Z`")),
        ("two numbers", text("v 0 0\n"), Error("t.obj:1: a vertex of 2 numbers")),
        ("binary", b"v 0 0 0\n\0\x01\x02".to_vec(), Error("t.obj:2: binary data; expected text")),
        ("utf-16", b"\xff\xfev\0 \0".to_vec(), Error("binary data")),
        ("prose", text("Dear Sir,\nhow are you\n"), Error("no OBJ statement")),
        ("empty", Vec::new(), Triangles(0, "no triangles")),
        ("no faces", after_v(""), Triangles(0, "no triangles")),
        ("two corners", after_v("f 1 2\nf 1 2 3\n"), Triangles(1, "t.obj:4: face with fewer than 3")),
        ("a line", after_v("l 1 2\nf 1 2 3\n"), Triangles(1, "t.obj:4: points or lines")),
        ("nan", after_v("v nan 0 0\nf 1 2 4\nf 1 2 3\n"), Triangles(1, "NaN or infinite")),
        ("microsoft nan", after_v("v -1.#IND 0 0\nf 1 2 4\nf 1 2 3\n"), Triangles(1, "NaN or infinite")),
        ("overflow", after_v("v 1e99 0 0\nf 1 2 4\nf 1 2 3\n"), Triangles(1, "NaN or infinite")),
        ("zero area", after_v("f 1 1 2\nf 1 2 3\n"), Triangles(1, "without area")),
        ("all degenerate", after_v("f 1 1 1\n"), Triangles(0, "no triangles")),
        (
            "vt out of range",
            after_v("vt 0 0\nf 1/1 2/2 3/1\n"),
            Triangles(1, "t.obj:5: face with a texture coordinate"),
        ),
        ("vn out of range", after_v("f 1//1 2//1 3//1\n"), Triangles(1, "t.obj:4: face with a normal index")),
        (
            "bad vt",
            after_v("vt x 0\nf 1/1 2/1 3/1\n"),
            Triangles(1, "t.obj:4: texture coordinate, normal, colour or weight"),
        ),
        (
            "missing library",
            after_v("mtllib none.mtl\nf 1 2 3\n"),
            Triangles(1, "t.obj:4: material library cannot be read"),
        ),
        ("unknown material", after_v("usemtl gold\nf 1 2 3\n"), Triangles(1, "t.obj:4: unknown material")),
        ("library is a folder", after_v("mtllib .\nf 1 2 3\n"), Triangles(1, "is a folder")),
        (
            "latin-1 name",
            [after_v("usemtl caf"), b"\xe9\nf 1 2 3\n".to_vec()].concat(),
            Triangles(1, "unknown material"),
        ),
    ]
}

fn ply_cases() -> Vec<(&'static str, Vec<u8>, Outcome)> {
    let ascii =
        |header: &str, body: &str| format!("ply\nformat ascii 1.0\n{header}end_header\n{body}").into_bytes();
    let xyz = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
    let faces = "element face 1\nproperty list uchar int vertex_indices\n";
    let both = &format!("{xyz}{faces}");
    let points = "0 0 0\n1 0 0\n0 1 0\n";
    let body = |face: &str| format!("{points}{face}");
    let binary = |count: &str| {
        format!("ply\nformat binary_little_endian 1.0\nelement vertex {count}\nproperty float x\nproperty float y\nproperty float z\nend_header\n")
            .into_bytes()
    };
    vec![
        ("good", ascii(both, &body("3 0 1 2\n")), Triangles(1, "")),
        ("no final newline", ascii(both, &body("3 0 1 2")), Triangles(1, "")),
        ("nan", ascii(both, "nan 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"), Triangles(0, "NaN or infinite")),
        ("bare points", ascii(xyz, points), Triangles(0, "points or lines")),
        ("empty file", Vec::new(), Error("t.ply:1: the file ends in its header")),
        ("not ply", b"plx\n".to_vec(), Error("t.ply:1: not a PLY file")),
        ("no format", b"ply\nend_header\n".to_vec(), Error("no `format` line")),
        ("bad format", b"ply\nformat binary 1.0\n".to_vec(), Error("t.ply:2: bad format line")),
        (
            "bad type",
            ascii("element vertex 1\nproperty real x\n", ""),
            Error("t.ply:4: unknown type `real`; valid are char"),
        ),
        ("bad count", ascii("element vertex -1\n", ""), Error("t.ply:3: bad count `-1`")),
        (
            "a remark without a keyword",
            ascii(&format!("Made by Some Program 1.0\n{both}"), &body("3 0 1 2\n")),
            Triangles(1, "t.ply:3: header line cannot be understood, ignored (`Made by Some Program 1.0`)"),
        ),
        (
            "a line without a keyword among properties",
            ascii(&format!("{xyz}propery uchar red\n{faces}"), &body("3 0 1 2\n")),
            Error("t.ply:7: bad header line"),
        ),
        (
            "vertices with the list of faces, whose line is missing",
            ascii(&format!("{xyz}property list uchar uint vertex_indices\n"), points),
            Triangles(0, "t.ply:9: line with fewer values than the header declares"),
        ),
        (
            "a face without its flag",
            ascii(&format!("{both}property uchar flag\n"), &body("3 0 1 2\n")),
            Triangles(1, "t.ply:14: line with fewer values"),
        ),
        (
            "a vertex without its z",
            ascii(&format!("{xyz}property uchar flag\n"), "0 0 0 1\n1 0\n0 1 0 1\n"),
            Error("bad `vertex` line"),
        ),
        (
            "colours and coordinates of faces",
            ascii(
                &format!(
                    "{both}property uchar red\nproperty list uchar float texcoord\nproperty int texnumber\n"
                ),
                &body("3 0 1 2 255 2 0 0 1\n"),
            ),
            Triangles(1, "colours of faces"),
        ),
        ("huge count", ascii("element vertex 99999999999999999999\n", ""), Error("t.ply:3: bad count")),
        (
            "property first",
            ascii("property float x\n", ""),
            Error("t.ply:3: a property before the first element"),
        ),
        (
            "twice",
            ascii("element vertex 1\nproperty float x\nproperty float x\n", ""),
            Error("t.ply:5: `x` is declared twice"),
        ),
        (
            "no z",
            ascii("element vertex 1\nproperty float x\nproperty float y\n", "0 0\n"),
            Error("vertices without x, y and z"),
        ),
        (
            "bad word",
            ascii(both, "0 0 0\n1 zero 0\n0 1 0\n3 0 1 2\n"),
            Error("t.ply:11: bad `vertex` line `1 zero 0`; expected numbers for x y z"),
        ),
        ("short line", ascii(both, "0 0 0\n1 0\n0 1 0\n3 0 1 2\n"), Error("t.ply:11: bad `vertex` line")),
        (
            "out of range",
            ascii(both, &body("3 0 1 3\n")),
            Error("t.ply:13: vertex index 3 out of range in face 0; expected 0 to 2"),
        ),
        ("negative", ascii(both, &body("3 0 1 -1\n")), Error("t.ply:13: vertex index -1 out of range")),
        ("short list", ascii(both, &body("4 0 1 2\n")), Error("t.ply:13: bad `face` line")),
        ("cut off", ascii(both, points), Error("are declared, but only")),
        ("binary bomb", binary("4000000000"), Error("4000000000 `vertex` elements")),
        (
            "binary cut off",
            [binary("2"), vec![0; 23]].concat(),
            Error("are declared, but only 23 bytes follow"),
        ),
        ("two corners", ascii(both, &body("2 0 1\n")), Triangles(0, "fewer than 3")),
        ("trailing", ascii(both, &body("3 0 1 2\n9 9\n")), Triangles(1, "bytes after the end")),
    ]
}

fn gltf_cases() -> Vec<(&'static str, Vec<u8>, Outcome)> {
    let text = |s: &str| s.as_bytes().to_vec();
    let doc = |s: &str| format!(r#"{{"asset":{{"version":"2.0"}}{s}}}"#).into_bytes();
    let mesh = |positions: usize, more: &str| {
        doc(&format!(
            r#","nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":{positions}}}{more}}}]}}],
            "buffers":[{{"byteLength":36,"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}}],
            "bufferViews":[{{"buffer":0,"byteLength":36}},{{"buffer":7,"byteLength":1}},{{"buffer":0,"byteOffset":30,"byteLength":36}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}},
            {{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"}},{{"bufferView":1,"componentType":5126,"count":3,"type":"VEC3"}},
            {{"bufferView":2,"componentType":5126,"count":3,"type":"VEC3"}},{{"componentType":5126,"count":9000000000,"type":"VEC3"}},
            {{"bufferView":0,"componentType":5121,"count":3,"type":"SCALAR","byteOffset":13}}]"#
        ))
    };
    vec![
        ("good", mesh(0, ""), Triangles(1, "")),
        ("empty", Vec::new(), Error("broken JSON")),
        ("cut off", text("{\"asset\":\n"), Error("t.gltf:2: broken JSON")),
        ("no asset", text("{}"), Error("missing field `asset`")),
        (
            "version 1",
            text(r#"{"asset":{"version":"1.0"}}"#),
            Error("glTF version `1.0`; expected version 2.0"),
        ),
        (
            "glTF 1.0, whose arrays are objects",
            text(r#"{"accessors":{"a":{"count":3}},"asset":{"version":"1.0"},"nodes":{"n":{}}}"#),
            Error("t.gltf: glTF version `1.0`; expected version 2.0"),
        ),
        (
            "a draft of glTF",
            text(r#"{"asset":{"version":0.8},"nodes":{"n":{}}}"#),
            Error("glTF version `0.8`; expected version 2.0"),
        ),
        (
            "version 2 with an object for an array",
            text(r#"{"asset":{"version":"2.0"},"nodes":{"n":{}}}"#),
            Error("broken JSON: invalid type: map"),
        ),
        (
            "an extension that is used and not known",
            mesh(
                0,
                r#"}]}],"extensionsUsed":["KHR_lights_punctual","KHR_xmp","KHR_materials_variants","EXT_x"],"x":[{"y":[{"z":0"#,
            ),
            Triangles(1, "not supported, left out (extension `EXT_x`)"),
        ),
        ("nothing in it", doc(""), Triangles(0, "no triangles")),
        (
            "required extension",
            doc(r#","extensionsRequired":["X_magic"]"#),
            Error("the file requires the extension `X_magic`; write the file without it"),
        ),
        ("no accessor", mesh(99, ""), Error("meshes[0].primitives[0]: accessor 99 does not exist")),
        ("accessor too long", mesh(1, ""), Error("4 elements do not fit into the 36 bytes")),
        ("no buffer", mesh(2, ""), Error("buffer 7 does not exist")),
        ("view too long", mesh(3, ""), Error("bufferView 2 ends after its buffer's 36 bytes")),
        ("accessor bomb", mesh(4, ""), Error("more memory is needed than a file of this length may take")),
        ("no material", mesh(0, r#","material":3"#), Error("material 3 does not exist")),
        (
            "index out of range",
            mesh(0, r#","indices":5"#),
            Error("vertex index 128 out of range; expected 0 to 2"),
        ),
        ("indices of floats", mesh(0, r#","indices":0"#), Error("indices of a wrong type")),
        ("lines", mesh(0, r#","mode":1"#), Triangles(0, "points or lines")),
        ("mode 9", mesh(0, r#","mode":9"#), Error("unknown mode")),
        (
            "buffer cut off",
            doc(r#","buffers":[{"byteLength":9,"uri":"data:;base64,AAAA"}]"#),
            Error("buffers[0]: 9 bytes are declared, but there are 3"),
        ),
        (
            "buffer missing",
            doc(r#","buffers":[{"byteLength":9,"uri":"no%20such.bin"}]"#),
            Error("no such file"),
        ),
        (
            "bad base64",
            doc(r#","buffers":[{"byteLength":9,"uri":"data:;base64,*"}]"#),
            Error("broken data URI"),
        ),
        (
            "a sparse accessor of nothing",
            doc(r#","buffers":[{"byteLength":12,"uri":"data:;base64,AAAAAAAAAAAAAAAA"}],
                "bufferViews":[{"buffer":0,"byteLength":12}],
                "accessors":[{"componentType":5126,"count":0,"type":"VEC3","sparse":{"count":1,
                "indices":{"bufferView":0,"componentType":5121},"values":{"bufferView":0}}}],
                "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"nodes":[{"mesh":0}]"#),
            Error("sparse index 0 out of range; the accessor has no elements"),
        ),
        (
            "cycle",
            doc(r#","nodes":[{"children":[1]},{"children":[0]}],"scenes":[{"nodes":[0]}],"scene":0"#),
            Error("t.gltf: nodes[0]: its children lead back to it; expected a tree"),
        ),
        (
            "pictures of another kind",
            doc(r#","extensionsRequired":["KHR_texture_transform","KHR_texture_basisu"]"#),
            Error("the file requires the extension `KHR_texture_basisu`"),
        ),
        (
            "layers",
            doc(
                r#","extensionsRequired":["KHR_materials_clearcoat","KHR_materials_sheen","KHR_materials_volume"]"#,
            ),
            Triangles(0, "no triangles"),
        ),
        (
            "an animation of pointers",
            doc(
                r#","animations":[{"channels":[{"sampler":0,"target":{"path":"pointer"}}],"samplers":[{"input":0,"output":0}]}]"#,
            ),
            Triangles(0, "animations[0].channels[0]: animation of `pointer`"),
        ),
        (
            "index 2^32 + 1",
            doc(r#","nodes":[{"mesh":4294967297}]"#),
            Error("index 4294967297 is beyond 32 bits"),
        ),
        ("a root beyond 32 bits", doc(r#","scene":4294967296"#), Error("index 4294967296 is beyond 32 bits")),
        ("a negative index", doc(r#","nodes":[{"mesh":-1}]"#), Error("a whole number that is not negative")),
        ("half an index", doc(r#","nodes":[{"mesh":0.5}]"#), Error("a whole number that is not negative")),
        ("indices as decimals", mesh(0, r#","indices":null,"mode":4.0"#), Triangles(1, "")),
        (
            "draco alone",
            mesh(4, r#","extensions":{"KHR_draco_mesh_compression":{}}"#),
            Error("missing field `bufferView`"),
        ),
        ("no node", doc(r#","scenes":[{"nodes":[5]}],"scene":0"#), Error("node 5 does not exist")),
    ]
}

fn judge(format: &str, cases: Vec<(&'static str, Vec<u8>, Outcome)>) {
    for (name, bytes, outcome) in cases {
        let loaded = load_named(&format!("t.{format}"), &bytes);
        match (loaded, outcome) {
            (Err(error), Error(text)) => {
                let line = error.to_string();
                assert!(line.contains(text), "{format} {name}: `{line}` should hold `{text}`");
                assert!(!line.contains(['\n', '{']), "{format} {name}: one line of plain words: {line}");
            }
            (Ok(loaded), Triangles(count, text)) => {
                let found: usize = loaded.scene.meshes().iter().map(|m| m.indices.len()).sum();
                assert_eq!(found, count, "{format} {name}: triangles");
                let lines: Vec<String> = loaded.warnings.iter().map(ToString::to_string).collect();
                let warned =
                    if text.is_empty() { lines.is_empty() } else { lines.iter().any(|l| l.contains(text)) };
                assert!(warned, "{format} {name}: warnings {lines:?} should hold `{text}`");
                loaded.scene.check().unwrap_or_else(|e| panic!("{format} {name}: {e}"));
            }
            (Ok(_), Error(text)) => panic!("{format} {name}: loaded, but `{text}` was to be said"),
            (Err(error), Triangles(..)) => panic!("{format} {name}: {error}"),
        }
    }
}

#[test]
fn obj() {
    judge("obj", obj_cases());
}

#[test]
fn ply() {
    judge("ply", ply_cases());
}

#[test]
fn gltf() {
    judge("gltf", gltf_cases());
}

/// A binary file whose length ends with its JSON.
fn with_length(mut file: Vec<u8>) -> Vec<u8> {
    let json = u32::from_le_bytes([file[12], file[13], file[14], file[15]]);
    file[8..12].copy_from_slice(&(20 + json).to_le_bytes());
    file
}

#[test]
fn binary_gltf() {
    let good = glb(br#"{"asset":{"version":"2.0"}}"#, b"");
    let with = |at: usize, bytes: &[u8]| {
        let mut file = good.clone();
        file[at..at + bytes.len()].copy_from_slice(bytes);
        file
    };
    judge(
        "glb",
        vec![
            ("good", good.clone(), Triangles(0, "no triangles")),
            ("magic", with(0, b"glTX"), Error("not a binary glTF file; expected `glTF`")),
            ("version", with(4, &[1]), Error("glTF version 1; expected version 2")),
            ("length", with(8, &[255, 255]), Error("bytes are declared, but the file has")),
            ("chunk length", with(12, &[255, 255]), Error("the file ends in its chunks")),
            ("chunk kind", with(16, b"NOSJ"), Error("no JSON chunk")),
            (
                "JSON that is no UTF-8",
                glb(b"{\"asset\":{\"version\":\"2.0\"},\"x\":\"\xff\"}", b""),
                Error("the JSON is invalid UTF-8 at its byte 32"),
            ),
            ("twelve bytes", good[..10].to_vec(), Error("the file ends in its header")),
            (
                "bytes behind the end",
                [good.clone(), vec![0xff; 12]].concat(),
                Triangles(0, "bytes after the end of the data, ignored (12 after byte 48)"),
            ),
            (
                "a length that leaves out the binary chunk",
                with_length(glb(br#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":4}]}"#, b"abcd")),
                Triangles(0, "no triangles"),
            ),
        ],
    );
}

#[test]
fn many_names_take_no_quadratic_time() {
    let begin = std::time::Instant::now();
    let library: String = (0..50_000).map(|k| format!("newmtl m{k}\nKd 1 0 0\n")).collect();
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("t.mtl"), library).expect("a file");
    let mut text = String::from(V);
    (0..20_000).for_each(|k| text += &format!("mtllib none{k}.mtl\n"));
    text += "mtllib t.mtl\n";
    (0..50_000).for_each(|k| text += &format!("usemtl m{k}\nf 1 2 3\n"));
    let path = folder.path().join("t.obj");
    std::fs::write(&path, text).expect("a file");
    let scene = crate::common::load(&path).unwrap_or_else(|e| panic!("{e}")).scene;
    assert_eq!(scene.meshes().len(), 50_000, "one mesh per material");
    // It takes about half a second; comparing each with each takes minutes.
    assert!(begin.elapsed().as_secs() < 15, "{:?} for one pass over the file", begin.elapsed());
}

#[test]
fn buffers_that_name_one_file_share_its_bytes() {
    // 2,000 times 1 MiB would be 2 GiB; the test has no such limit, but its machine has.
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("big.bin"), vec![0; 1 << 20]).expect("a file");
    let buffers: Vec<String> = (0..2000)
        .map(|k| format!(r#"{{"byteLength":{},"uri":"{}big.bin"}}"#, (1 << 20) - k, "./".repeat(k % 5)))
        .collect();
    let path = folder.path().join("t.gltf");
    let json = format!(r#"{{"asset":{{"version":"2.0"}},"buffers":[{}]}}"#, buffers.join(","));
    std::fs::write(&path, json).expect("a file");
    let begin = std::time::Instant::now();
    crate::common::load(&path).unwrap_or_else(|e| panic!("{e}"));
    assert!(
        begin.elapsed().as_millis() < 300,
        "the file was read once, not 2,000 times: {:?}",
        begin.elapsed()
    );
}

#[cfg(unix)]
#[test]
fn system_errors_come_without_numbers() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("circle.obj");
    std::os::unix::fs::symlink("circle.obj", &path).expect("a link to itself");
    let line = crate::common::load(&path).expect_err("a circle").to_string();
    assert!(line.contains("too many levels") && !line.contains("os error"), "words only: {line}");
}

#[test]
fn paths() {
    let message = |path: &str| crate::common::load(path).expect_err("no scene").to_string();
    assert!(message("no/such.obj").contains("no such file"), "a missing file");
    assert!(
        message("Cargo.toml").contains("unknown scene format `.toml`; valid are .obj, .ply"),
        "an unknown format"
    );
    assert!(message("src").contains("is a folder"), "a folder: {}", message("src"));
}

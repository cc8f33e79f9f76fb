// SPDX-License-Identifier: GPL-3.0-or-later
//! Small files of each format, cut off at every byte and with every byte changed: never a panic, never a wrong index.
//! Source: after the habit of fuzzing parsers, but without chance. Then files changed in several places at once,
//! grown and spliced by a fixed sequence of numbers: half a second of each format, or `GNURT_MUTATE=SECONDS` of them.

use crate::common::{glb, load_named, save};
use gnurt_scene::{Material, Mesh, Scene};

/// One triangle, with everything that the writers can say about it.
fn small() -> Scene {
    let mut scene = Scene::new();
    let material = scene.add_material(Material::matte("m", [0.5; 3]));
    let mesh = scene.add_mesh(Mesh {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        normals: vec![[0.0, 0.0, 1.0]; 3],
        texcoords: vec![[0.0; 2]; 3],
        indices: vec![[0, 1, 2]],
        material,
        ..Mesh::default()
    });
    let object = scene.add_object_of("o", vec![mesh]);
    scene.instantiate(object, gnurt_scene::Affine::IDENTITY);
    scene
}

fn mutate(name: &str, bytes: &[u8]) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join(name);
    let attempt = |bytes: &[u8]| {
        // A new file: file systems write an overwritten one to the disk at once, in milliseconds.
        let _ = std::fs::remove_file(&path);
        std::fs::write(&path, bytes).expect("a file");
        match crate::common::load(&path) {
            Ok(loaded) => loaded.scene.check().unwrap_or_else(|e| panic!("{name}: {e}")),
            Err(error) => assert!(!error.to_string().contains('\n'), "{name}: one line: {error}"),
        }
    };
    for end in 0..bytes.len() {
        attempt(&bytes[..end]);
    }
    for at in 0..bytes.len() {
        for flip in [0x01, 0x90] {
            let mut changed = bytes.to_vec();
            changed[at] ^= flip;
            attempt(&changed);
        }
    }
}

fn written(name: &str) -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join(name);
    save(&small(), &path).expect("it can be written");
    std::fs::read(path).expect("it was written")
}

#[test]
fn obj() {
    mutate("t.obj", b"mtllib t.obj\nv 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvn 0 0 1\nusemtl a\nf 1/1/1 2/1/1 4/1/1 3/1/1\nf -1 -2 \\\n-3\n");
}

#[test]
fn mtl() {
    let obj = b"mtllib t.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n";
    let mtl = b"newmtl a\nKd 1 .5 0\nKs .2 .2 .2\nNs 30\nTr 0.5\nillum 2\nKe 1 1 1\nmap_Kd -s 2 2 t.mtl\n";
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (path, library) = (folder.path().join("t.obj"), folder.path().join("t.mtl"));
    std::fs::write(&path, obj).expect("a file");
    for at in 0..mtl.len() {
        for flip in [0x01, 0x90] {
            let mut changed = mtl.to_vec();
            changed[at] ^= flip;
            std::fs::write(&library, changed).expect("a file");
            let loaded = crate::common::load(&path).expect("a broken library is no error");
            assert_eq!(loaded.scene.meshes().len(), 1, "byte {at}: the triangle is there");
        }
    }
}

#[test]
fn stl() {
    mutate("t.stl", &written("t.stl"));
    mutate("t.stl", b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1e0 0\nendloop\nendfacet\nendsolid a\n");
}

#[test]
fn threemf() {
    mutate("t.3mf", &crate::solids::archive(&[("3D/3dmodel.model", crate::solids::MODEL)]));
}

#[test]
fn ply() {
    mutate("t.ply", &written("t.ply"));
    mutate("t.ply", b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
}

#[test]
fn gltf() {
    mutate("t.glb", &written("t.glb"));
    let deep =
        format!(r#"{{"asset":{{"version":"2.0"}},"extras":{}{}}}"#, "[".repeat(50_000), "]".repeat(50_000));
    let _ = load_named("t.gltf", deep.as_bytes());
    let _ = load_named("t.glb", &glb(deep.as_bytes(), b""));
}

#[test]
fn deep_trees_do_not_overflow_the_stack() {
    let count = 100_000;
    let nodes: Vec<String> = (1..count).map(|i| format!(r#"{{"children":[{i}]}}"#)).collect();
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"nodes":[{},{{}}],"scenes":[{{"nodes":[0]}}],"scene":0}}"#,
        nodes.join(",")
    );
    let loaded = load_named("t.gltf", json.as_bytes()).expect("deep, but right");
    assert!(loaded.scene.instances().is_empty(), "nothing to see");
}

/// A sequence of numbers that looks random: xorshift64.
struct Dice(u64);

impl Dice {
    fn below(&mut self, end: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % end.max(1) as u64) as usize
    }
}

/// Texts that break parsers.
const PIECES: &[&[u8]] = &[
    b"0", b"-1", b"1e999", b"nan", b"-inf", b"4294967295", b"4294967296", b"4294967297", b"2147483648", b"18446744073709551615",
    b"9223372036854775808", b"-0.0", b"1.0", b"0.5", b"null", b"true", b"{}", b"[]", b"[[[[", b"}}]]", b"\"\"", b"\\u0000", b",",
    b":", b"\n", b"\r", b"\\\n", b"\t", b"/", b"//", b"#", b"\xef\xbb\xbf", b"\0\0\0\0", b"\xff\xff\xff\xff", b"\x7f\xff\xff\xff",
    b"\0\0\0\x80", b"data:;base64,AAAA", b"../", b"%2e%2e/", b"mtllib t.obj\n", b"usemtl a\n", b"f 1 2 3\n", b"f -1 -1 -1 -1\n",
    b"element vertex 1\n", b"property list uint uint x\n", b"\"mesh\":0", b"\"children\":[0]", b"\"count\":4000000000", b"\"byteStride\":1",
    b"\"sparse\":{\"count\":1,\"indices\":{\"bufferView\":0,\"componentType\":5121},\"values\":{\"bufferView\":0}}",
];

/// Changes a file in a few places.
fn change(bytes: &mut Vec<u8>, dice: &mut Dice) {
    for _ in 0..=dice.below(6) {
        let at = dice.below(bytes.len() + 1);
        let end = (at + dice.below(24)).min(bytes.len());
        match dice.below(7) {
            0 if at < bytes.len() => bytes[at] ^= 1 << dice.below(8),
            1 => drop(bytes.drain(at..end)),
            2 => drop(bytes.splice(at..at, PIECES[dice.below(PIECES.len())].iter().copied())),
            3 => drop(bytes.splice(at..end, PIECES[dice.below(PIECES.len())].iter().copied())),
            4 => {
                let copy = bytes[at..end].repeat(1 + dice.below(40));
                let to = dice.below(bytes.len() + 1);
                drop(bytes.splice(to..to, copy));
            }
            5 => bytes.truncate(at.max(1)),
            _ => {
                let digits: Vec<usize> = (0..bytes.len()).filter(|&i| bytes[i].is_ascii_digit()).collect();
                if let Some(&i) = digits.get(dice.below(digits.len())) {
                    bytes[i] = b'0' + dice.below(10) as u8;
                }
            }
        }
    }
}

#[test]
fn many_changes_at_once() {
    let seconds = std::env::var("GNURT_MUTATE").ok().and_then(|text| text.parse().ok()).unwrap_or(0.5);
    let obj = b"mtllib t.mtl\nv 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvn 0 0 1\nusemtl a\nf 1/1/1 2/1/1 4/1/1 3/1/1\nf -1 -2 \\\n-3\nusemtl b\nl 1 2\nf 1//1 2//1 3//1\n".to_vec();
    let mtl = b"newmtl a\nKd 1 .5 0\nKs .2 .2 .2\nNs 30\nTr 0.5\nillum 2\nKe 1 1 1\nmap_Kd -s 2 2 t.mtl\nnewmtl b\nmap_d -o 1 -clamp on x y.png\nd -halo 0.5\nPr 1\nPc 1\n".to_vec();
    let gltf = br#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,2]}],"nodes":[{"mesh":0,"skin":0,"children":[1]},{"camera":0,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]},{"mesh":0,"weights":[0.5],"extensions":{"KHR_lights_punctual":{"light":0}},"rotation":[0,0,0,1]}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0,"NORMAL":0,"TEXCOORD_0":0,"COLOR_0":0,"JOINTS_0":2,"WEIGHTS_0":3},"indices":1,"material":0,"mode":5,"targets":[{"POSITION":0}]}]}],"skins":[{"joints":[1,2]}],
"materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0,"extensions":{"KHR_texture_transform":{"scale":[2,2]}}}},"normalTexture":{"index":0,"scale":2},"alphaMode":"MASK","extensions":{"KHR_materials_transmission":{"transmissionFactor":1}}}],
"textures":[{"source":0,"sampler":0}],"samplers":[{"wrapS":33071}],"images":[{"uri":"data:;base64,iVBORw0KGgo="}],"cameras":[{"type":"perspective","perspective":{"yfov":1}}],
"extensions":{"KHR_lights_punctual":{"lights":[{"type":"spot","spot":{"innerConeAngle":0.1}}]}},
"buffers":[{"byteLength":36,"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteLength":12,"byteStride":4}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},{"bufferView":1,"componentType":5121,"count":3,"type":"SCALAR"},{"bufferView":1,"componentType":5121,"count":3,"type":"VEC4"},{"componentType":5126,"count":3,"type":"VEC4","sparse":{"count":1,"indices":{"bufferView":1,"componentType":5121},"values":{"bufferView":0,"byteOffset":12}}}]}"#.to_vec();
    let text_ply = b"ply\nformat ascii 1.0\ncomment c\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement face 2\nproperty list uchar int vertex_indices\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n0 0 0 1 2 3\n1 0 0 4 5 6\n0 1 0 7 8 9\n1 1 0 1 1 1\n3 0 1 2\n4 0 1 3 2\n5 0 1 2 -1 3\n".to_vec();
    let seeds: [(&str, Vec<u8>); 6] = [
        ("t.obj", obj.clone()),
        ("t.mtl", mtl.clone()),
        ("t.gltf", gltf.clone()),
        ("t.glb", glb(&gltf, &[0; 40])),
        ("t.ply", text_ply),
        ("u.ply", written("t.ply")),
    ];
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("t.mtl"), &mtl).expect("a file");
    for (name, seed) in seeds {
        let mut dice = Dice(0x9e37_79b9_7f4a_7c15);
        let (begin, mut count) = (std::time::Instant::now(), 0_u64);
        while begin.elapsed().as_secs_f64() < seconds {
            let mut bytes = seed.clone();
            (0..=dice.below(3)).for_each(|_| change(&mut bytes, &mut dice));
            let path = folder.path().join(name);
            std::fs::write(&path, &bytes).expect("a file");
            let scene = if name == "t.mtl" { folder.path().join("s.obj") } else { path };
            if name == "t.mtl" && count == 0 {
                std::fs::write(&scene, &obj).expect("a file");
            }
            let once = std::time::Instant::now();
            match crate::common::load(&scene) {
                Ok(loaded) => loaded.scene.check().unwrap_or_else(|e| panic!("{name} {count}: {e}")),
                Err(error) => assert_eq!(error.to_string().lines().count(), 1, "{name} {count}: {error}"),
            }
            assert!(once.elapsed().as_secs() < 20, "{name} {count}: {:?}", once.elapsed());
            count += 1;
        }
    }
}

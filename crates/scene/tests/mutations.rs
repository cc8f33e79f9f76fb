// SPDX-License-Identifier: GPL-3.0-or-later
//! Small files of each format, cut off at every byte and with every byte changed: never a panic, never a wrong index.
//! Source: original; after the habit of fuzzing parsers, but without chance.

mod common;

use common::{glb, load_named};
use gnurt_scene::io::save;
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
        std::fs::write(&path, bytes).expect("a file");
        match gnurt_scene::io::load(&path) {
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
            let loaded = gnurt_scene::io::load(&path).expect("a broken library is no error");
            assert_eq!(loaded.scene.meshes().len(), 1, "byte {at}: the triangle is there");
        }
    }
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

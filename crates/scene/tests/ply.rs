// SPDX-License-Identifier: GPL-3.0-or-later
//! The meaning of PLY files here, in all three encodings.

use crate::common::load_named;
use gnurt_scene::{Mesh, Scene};

fn mesh(bytes: &[u8]) -> Mesh {
    let scene: Scene = load_named("t.ply", bytes).unwrap_or_else(|e| panic!("{e}")).scene;
    Mesh::clone(&scene.meshes()[0])
}

const HEADER: &str = "comment x\nobj_info y\nelement vertex 4\nproperty double z\nproperty uchar red\n\
property float x\nproperty short y\nproperty uchar green\nproperty uchar blue\nproperty float s\nproperty float t\n\
element edge 1\nproperty list uchar float weights\nelement face 1\nproperty uchar flag\n\
property list ushort uint vertex_index\nend_header\n";

/// The same square in binary, each number written by `swap`.
fn binary(format: &str, line_end: &str, big: bool) -> Vec<u8> {
    let text = format!("ply\nformat {format} 1.0\n{HEADER}").replace('\n', line_end);
    let mut file = text.into_bytes();
    let mut put = |mut bytes: Vec<u8>| {
        if big {
            bytes.reverse();
        }
        file.extend(bytes);
    };
    for (x, y) in [(0.0_f32, 0_i16), (1.0, 0), (1.0, 1), (0.0, 1)] {
        put(5.0_f64.to_le_bytes().to_vec());
        put(vec![255]);
        put(x.to_le_bytes().to_vec());
        put(y.to_le_bytes().to_vec());
        put(vec![0]);
        put(vec![188]);
        put(x.to_le_bytes().to_vec());
        put(0.5_f32.to_le_bytes().to_vec());
    }
    put(vec![1]);
    put(2.0_f32.to_le_bytes().to_vec());
    put(vec![7]);
    put(4_u16.to_le_bytes().to_vec());
    (0..4_u32).for_each(|i| put(i.to_le_bytes().to_vec()));
    file
}

#[test]
fn headers_of_all_kinds() {
    let text = format!(
        "ply\nformat ascii 1.0\n{HEADER}5 255 0 0 0 188 0 .5\n5 255 1 0 0 188 1 .5\n5 255 1 1 0 188 1 .5\n\
         5 255 0 1 0 188 0 .5\n1 2\n7 4 0 1 2 3\n"
    );
    let expected = mesh(text.as_bytes());
    assert_eq!(expected.positions[2], [1.0, 1.0, 5.0], "any order, any type");
    assert_eq!(expected.indices.len(), 2, "a square is two triangles");
    assert_eq!(expected.texcoords[1], [1.0, 0.5], "s and t");
    let [r, g, b, a] = expected.colors[0];
    assert!(
        r == 1.0 && g == 0.0 && (b - 0.503).abs() < 0.002 && a == 1.0,
        "bytes are sRGB: {:?}",
        expected.colors[0]
    );
    for line_end in ["\n", "\r\n", "\r"] {
        assert_eq!(
            mesh(&binary("binary_little_endian", line_end, false)),
            expected,
            "little endian {line_end:?}"
        );
        assert_eq!(mesh(&binary("binary_big_endian", line_end, true)), expected, "big endian {line_end:?}");
    }
    assert_eq!(mesh(text.replace('\n', "\r\n").as_bytes()), expected, "text with CRLF");
}

#[test]
fn strips_turn_every_other_triangle() {
    let text = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                element tristrips 1\nproperty list int int vertex_indices\nend_header\n\
                0 0 0\n1 0 0\n0 1 0\n1 1 0\n8 0 1 2 3 -1 0 1 2\n";
    assert_eq!(mesh(text.as_bytes()).indices, [[0, 1, 2], [2, 1, 3], [0, 1, 2]], "two strips");
}

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

/// Rows and triangles that are read many at once, beside the text, whose elements are read one by one.
#[test]
fn long_files_are_read_alike() {
    const SIDE: u32 = 150;
    let header = |format: &str, faces: usize| {
        let floats: String =
            ["x", "y", "z", "nx", "ny", "nz"].map(|name| format!("property float {name}\n")).concat();
        format!(
            "ply\nformat {format} 1.0\nelement vertex {}\n{floats}element face {faces}\n\
             property list uchar int vertex_indices\nelement odd 2\nproperty short a\nend_header\n",
            SIDE * SIDE
        )
    };
    let mut faces: Vec<Vec<u32>> = Vec::new();
    for i in (0..SIDE * (SIDE - 1)).filter(|i| i % SIDE + 1 < SIDE) {
        let [a, b, c, d] = [i, i + 1, i + SIDE + 1, i + SIDE];
        match i % 97 {
            // Runs of triangles end here and there.
            0 | 40 => faces.push(vec![a, b, c, d]),
            _ => faces.extend([vec![a, b, c], vec![a, c, d]]),
        }
    }
    let vertex =
        |i: u32| [(i % SIDE) as f32 * 0.1, (i / SIDE) as f32 * 0.3, (i * i % 11) as f32, 0.0, 0.6, 0.8];
    let mut text = header("ascii", faces.len());
    for i in 0..SIDE * SIDE {
        text += &format!("{}\n", vertex(i).map(|x| x.to_string()).join(" "));
    }
    for face in &faces {
        text += &face.iter().fold(face.len().to_string(), |line, i| format!("{line} {i}"));
        text.push('\n');
    }
    text += "1\n2\n";
    let expected = mesh(text.as_bytes());
    assert_eq!((expected.normals.len(), expected.positions.len()), (22500, 22500));
    for (format, big) in [("binary_little_endian", false), ("binary_big_endian", true)] {
        let mut file = header(format, faces.len()).into_bytes();
        let number = |bits: u32| if big { bits.to_be_bytes() } else { bits.to_le_bytes() };
        (0..SIDE * SIDE).flat_map(vertex).for_each(|x| file.extend(number(x.to_bits())));
        for face in &faces {
            file.push(face.len() as u8);
            face.iter().for_each(|&i| file.extend(number(i)));
        }
        file.extend([0, 1, 0, 2]);
        assert!(mesh(&file) == expected, "{format}");
        let cut = &file[..file.len() - 10];
        let why = load_named("t.ply", cut).err().map(|why| why.to_string()).unwrap_or_default();
        assert!(why.contains("the file ends in `face`") || why.contains("bytes follow"), "{format}: {why}");
        let at = file.len() - 4 - 12;
        file[at..at + 4].copy_from_slice(&number(SIDE * SIDE));
        let why = load_named("t.ply", &file).err().map(|why| why.to_string()).unwrap_or_default();
        let expected = format!("vertex index 22500 out of range in face {}", faces.len() - 1);
        assert!(why.contains(&expected), "{format}: {why}");
    }
}

#[test]
fn strips_turn_every_other_triangle() {
    let text = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                element tristrips 1\nproperty list int int vertex_indices\nend_header\n\
                0 0 0\n1 0 0\n0 1 0\n1 1 0\n8 0 1 2 3 -1 0 1 2\n";
    assert_eq!(mesh(text.as_bytes()).indices, [[0, 1, 2], [2, 1, 3], [0, 1, 2]], "two strips");
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Triangles of a file: OBJ, or binary PLY whose vertices are three floats.

use std::fs;

pub(crate) struct Mesh {
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) indices: Vec<[u32; 3]>,
}

pub(crate) fn read(path: &str) -> Mesh {
    let bytes = fs::read(path).unwrap_or_else(|error| panic!("{path}: {error}"));
    if bytes.starts_with(b"ply") { ply(&bytes) } else { obj(&String::from_utf8_lossy(&bytes)) }
}

fn ply(bytes: &[u8]) -> Mesh {
    let end = b"end_header\n";
    let at = bytes.windows(end.len()).position(|part| part == end).expect("a header");
    let header = String::from_utf8_lossy(&bytes[..at]);
    let count = |element: &str| {
        let line = header.lines().find_map(|line| line.strip_prefix(element)).expect("a number of elements");
        line.trim().parse::<usize>().expect("a number")
    };
    let (vertices, faces) = (count("element vertex"), count("element face"));
    let body = &bytes[at + end.len()..];
    let word = |at: usize| <[u8; 4]>::try_from(&body[at..at + 4]).expect("four bytes");
    let position = |i: usize| [0, 4, 8].map(|k| f32::from_le_bytes(word(12 * i + k)));
    let face = |i: usize| [1, 5, 9].map(|k| u32::from_le_bytes(word(12 * vertices + 13 * i + k)));
    Mesh { positions: (0..vertices).map(position).collect(), indices: (0..faces).map(face).collect() }
}

fn obj(text: &str) -> Mesh {
    let mut mesh = Mesh { positions: Vec::new(), indices: Vec::new() };
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let mut next = || words.next().and_then(|x| x.parse().ok()).expect("a coordinate");
                mesh.positions.push([next(), next(), next()]);
            }
            Some("f") => {
                let corner = |word: &str| {
                    let i: i64 = word.split('/').next().and_then(|i| i.parse().ok()).expect("an index");
                    (if i > 0 { i - 1 } else { mesh.positions.len() as i64 + i }) as u32
                };
                let corners: Vec<u32> = words.map(corner).collect();
                mesh.indices.extend(corners.windows(2).skip(1).map(|pair| [corners[0], pair[0], pair[1]]));
            }
            _ => {}
        }
    }
    mesh
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Small good files, to be rendered and to be broken.

/// Two triangles above each other, with normals, texture coordinates and a material.
pub(crate) const OBJ: &str = "\
mtllib scene.mtl
v -1 0 0\nv 1 0 0\nv 1 2 0\nv -1 2 0
vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1
vn 0 0 1
usemtl red
f 1/1/1 2/2/1 3/3/1 4/4/1
";

/// Its materials.
pub(crate) const MTL: &str = "newmtl red\nKd 0.8 0.2 0.1\n";

/// A square as text.
pub(crate) const PLY: &str = "\
ply
format ascii 1.0
element vertex 4
property float x
property float y
property float z
element face 2
property list uchar int vertex_indices
end_header
0 0 0
1 0 0
1 1 0
0 1 0
3 0 1 2
3 0 2 3
";

/// The same square in binary, little-endian.
pub(crate) fn binary_ply() -> Vec<u8> {
    let (header, _) = PLY.split_once("end_header\n").expect("a header");
    let mut bytes = header.replace("ascii", "binary_little_endian").into_bytes();
    bytes.extend_from_slice(b"end_header\n");
    for corner in [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]] {
        bytes.extend(corner.iter().flat_map(|x| x.to_le_bytes()));
    }
    for face in [[0_i32, 1, 2], [0, 2, 3]] {
        bytes.push(3);
        bytes.extend(face.iter().flat_map(|i| i.to_le_bytes()));
    }
    bytes
}

/// A triangle: three corners as 36 bytes of floats, then three indices as 6 bytes, padded to 44.
fn triangle_bytes() -> Vec<u8> {
    let corners = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let mut bytes: Vec<u8> = corners.iter().flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend([0_u16, 1, 2].iter().flat_map(|i| i.to_le_bytes()));
    bytes.extend([0, 0]);
    bytes
}

/// glTF of the triangle; the buffer is `uri`, or the binary chunk where that is `None`.
pub(crate) fn gltf(uri: Option<&str>) -> String {
    let uri = uri.map(|uri| format!(r#""uri":"{uri}","#)).unwrap_or_default();
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
"buffers":[{{{uri}"byteLength":44}}],
"bufferViews":[{{"buffer":0,"byteOffset":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":6}}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}},
{{"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}}]}}"#
    )
}

/// The bytes of `triangle.bin`, which `gltf(Some("triangle.bin"))` names.
pub(crate) fn gltf_buffer() -> Vec<u8> {
    triangle_bytes()
}

/// The triangle as one binary file.
pub(crate) fn glb() -> Vec<u8> {
    glb_of(&gltf(None), &triangle_bytes())
}

/// A GLB of these chunks.
pub(crate) fn glb_of(json: &str, binary: &[u8]) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let length = 12 + 8 + json.len() + 8 + binary.len();
    let mut bytes = b"glTF".to_vec();
    let put_u64 = |bytes: &mut Vec<u8>, value: usize| {
        bytes.extend(u32::try_from(value).expect("a small file").to_le_bytes());
    };
    put_u64(&mut bytes, 2);
    put_u64(&mut bytes, length);
    put_u64(&mut bytes, json.len());
    bytes.extend(b"JSON");
    bytes.extend(&json);
    put_u64(&mut bytes, binary.len());
    bytes.extend(b"BIN\0");
    bytes.extend(binary);
    bytes
}

/// A picture of 2 x 2 floats.
pub(crate) fn pfm() -> Vec<u8> {
    let mut bytes = b"PF\n2 2\n-1.0\n".to_vec();
    bytes.extend(
        [0.0_f32, 0.5, 1.0, 2.0, 0.25, 0.125, 3.0, 0.0, 1.0, 0.5, 0.5, 0.5]
            .iter()
            .flat_map(|x| x.to_le_bytes()),
    );
    bytes
}

/// A grey JPEG of 8 x 8 pixels: one block, of which both codes are the only ones of their tables.
pub(crate) fn jpeg() -> Vec<u8> {
    let segment = |marker: u8, body: &[u8]| {
        let length = u16::try_from(body.len() + 2).expect("a short segment").to_be_bytes();
        [&[0xff, marker], &length[..], body].concat()
    };
    let only_symbol_zero = |table: u8| [&[table, 1][..], &[0; 15], &[0]].concat();
    let quantization = [&[0][..], &[1; 64]].concat();
    [
        vec![0xff, 0xd8],
        segment(0xdb, &quantization),
        segment(0xc0, &[8, 0, 8, 0, 8, 1, 1, 0x11, 0]),
        segment(0xc4, &only_symbol_zero(0x00)),
        segment(0xc4, &only_symbol_zero(0x10)),
        segment(0xda, &[1, 1, 0x00, 0, 63, 0]),
        vec![0x3f, 0xff, 0xd9],
    ]
    .concat()
}

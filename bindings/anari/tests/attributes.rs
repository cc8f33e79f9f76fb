// SPDX-License-Identifier: GPL-3.0-or-later
//! Attributes and samplers on surfaces, by the albedo that they make.

use anari_library_gnurt::types as t;

use crate::common::Set;

/// A square from -1 to 1 whose material reads `source`; the albedo of the pixel at these coordinates of the square.
struct Board {
    set: Set,
    square: usize,
    material: usize,
}

impl Board {
    fn new() -> Self {
        let set = Set::new("ao");
        let (square, material) = (set.square(1.0), set.client.object(t::MATERIAL, "matte"));
        // Held on for edits.
        set.client.retain(square);
        set.client.retain(material);
        Self { set, square, material }
    }

    fn list(&self, name: &str, element: t::DataType, floats: &[f32]) {
        let list = self.set.client.floats(element, floats);
        self.set.client.give(self.square, name, t::ARRAY1D, list);
        self.set.client.commit(self.square);
    }

    fn albedos(mut self) -> impl Fn(u32, u32) -> [f32; 3] {
        self.set.client.commit(self.material);
        self.set.add(self.square, self.material);
        let channel = self.set.channel([8, 8], "channel.albedo", t::FLOAT32_VEC3);
        self.set.assert_quiet();
        let floats = channel.floats();
        move |x, y| std::array::from_fn(|k| floats[3 * (8 * y + x) as usize + k])
    }
}

fn near(found: [f32; 3], expected: [f32; 3], text: &str) {
    assert!(
        found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-3),
        "{text}: {found:?}, expected {expected:?}"
    );
}

#[test]
fn vertices_are_interpolated() {
    let board = Board::new();
    board.list(
        "vertex.color",
        t::FLOAT32_VEC3,
        &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0],
    );
    board.set.client.set_text(board.material, "color", "color");
    let at = board.albedos();
    for (x, y) in [(0, 0), (7, 0), (3, 6), (7, 7)] {
        near(at(x, y), [(x as f32 + 0.5) / 8.0, (y as f32 + 0.5) / 8.0, 0.0], "a ramp along each side");
    }
}

#[test]
fn finer_rates_come_first() {
    let board = Board::new();
    board.set.client.set_floats(board.square, "attribute1", t::FLOAT32_VEC4, &[0.1, 0.1, 0.1, 1.0]);
    board.list("primitive.attribute1", t::FLOAT32_VEC3, &[0.2, 0.2, 0.2]);
    board.set.client.set_text(board.material, "color", "attribute1");
    let at = board.albedos();
    near(at(3, 3), [0.2; 3], "the primitive's");
    let board = Board::new();
    board.list("primitive.attribute1", t::FLOAT32_VEC3, &[0.2, 0.2, 0.2]);
    board.list("vertex.attribute1", t::FLOAT32_VEC3, &[0.3; 12]);
    board.list("faceVarying.attribute1", t::FLOAT32_VEC3, &[0.4; 12]);
    board.set.client.set_text(board.material, "color", "attribute1");
    let at = board.albedos();
    near(at(3, 3), [0.4; 3], "the corners'");
}

#[test]
fn bytes_are_shares_and_srgb_is_decoded() {
    let board = Board::new();
    let list = board.set.client.array(t::UFIXED8_RGBA_SRGB, &[1], &[188, 255, 0, 255]);
    board.set.client.give(board.square, "primitive.color", t::ARRAY1D, list);
    board.set.client.commit(board.square);
    board.set.client.set_text(board.material, "color", "color");
    let at = board.albedos();
    near(at(0, 0), [0.5029, 1.0, 0.0], "sRGB 188 is about a half");
}

#[test]
fn positions_and_normals_are_attributes() {
    let board = Board::new();
    board.set.client.set_text(board.material, "color", "worldNormal");
    let at = board.albedos();
    near(at(4, 4), [0.0, 0.0, 1.0], "towards the camera");
    let board = Board::new();
    board.set.client.set_text(board.material, "color", "objectPosition");
    let at = board.albedos();
    near(at(7, 4), [0.875, 0.125, 0.0], "where it is");
}

fn image(wrap: &str, filter: &str, scale: f32) -> impl Fn(u32, u32) -> [f32; 3] {
    let board = Board::new();
    let client = &board.set.client;
    board.list("vertex.attribute0", t::FLOAT32_VEC2, &[0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0]);
    let sampler = client.object(t::SAMPLER, "image2D");
    let texels: Vec<u8> = [0.0_f32, 0.25, 0.5, 0.75].iter().flat_map(|x| x.to_ne_bytes()).collect();
    let texels = client.array(t::FLOAT32, &[2, 2], &texels);
    client.give(sampler, "image", t::ARRAY2D, texels);
    for name in ["wrapMode1", "wrapMode2"] {
        client.set_text(sampler, name, wrap);
    }
    client.set_text(sampler, "filter", filter);
    let s = scale;
    client.set_floats(
        sampler,
        "inTransform",
        t::FLOAT32_MAT4,
        &[s, 0.0, 0.0, 0.0, 0.0, s, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0],
    );
    client.commit(sampler);
    client.give(board.material, "color", t::SAMPLER, sampler);
    board.albedos()
}

#[test]
fn pictures_begin_with_their_lowest_row() {
    let at = image("clampToEdge", "nearest", 1.0);
    for (x, y, value) in [(0, 0, 0.0), (7, 0, 0.25), (0, 7, 0.5), (7, 7, 0.75)] {
        near(at(x, y), [value, 0.0, 0.0], "a corner");
    }
    let at = image("repeat", "nearest", 2.0);
    near(at(3, 0), [0.25, 0.0, 0.0], "the end of the first turn");
    near(at(4, 0), [0.0, 0.0, 0.0], "again from the start");
    let at = image("mirrorRepeat", "nearest", 2.0);
    near(at(4, 0), [0.25, 0.0, 0.0], "back from the end");
    let at = image("clampToEdge", "linear", 1.0);
    near(at(3, 0), [(0.4375 * 2.0 - 0.5) * 0.25, 0.0, 0.0], "between two texels");
}

#[test]
fn primitives_and_transforms_are_sampled() {
    let board = Board::new();
    let client = &board.set.client;
    let sampler = client.object(t::SAMPLER, "primitive");
    let list = client.floats(t::FLOAT32_VEC3, &[0.0, 0.0, 0.0, 0.1, 0.2, 0.3]);
    client.give(sampler, "array", t::ARRAY1D, list);
    client.set(sampler, "inOffset", t::UINT64, &1_u64.to_ne_bytes());
    client.commit(sampler);
    client.give(board.material, "color", t::SAMPLER, sampler);
    let at = board.albedos();
    near(at(2, 2), [0.1, 0.2, 0.3], "the second value of the first primitive");
    let board = Board::new();
    let client = &board.set.client;
    let sampler = client.object(t::SAMPLER, "transform");
    client.set_text(sampler, "inAttribute", "worldNormal");
    client.set_floats(sampler, "outOffset", t::FLOAT32_VEC4, &[0.5, 0.25, -0.5, 0.0]);
    client.commit(sampler);
    client.give(board.material, "color", t::SAMPLER, sampler);
    let at = board.albedos();
    near(at(2, 2), [0.5, 0.25, 0.5], "the normal and an offset");
}

#[test]
fn spheres_and_cylinders_carry_attributes_of_their_vertices() {
    let mut set = Set::new("ao");
    let cylinder = set.client.object(t::GEOMETRY, "cylinder");
    let ends = set.client.floats(t::FLOAT32_VEC3, &[-1.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    set.client.give(cylinder, "vertex.position", t::ARRAY1D, ends);
    let values = set.client.floats(t::FLOAT32, &[0.0, 1.0]);
    set.client.give(cylinder, "vertex.attribute2", t::ARRAY1D, values);
    set.client.set_float(cylinder, "radius", 0.9);
    set.client.commit(cylinder);
    let material = set.client.object(t::MATERIAL, "matte");
    set.client.set_text(material, "color", "attribute2");
    set.client.commit(material);
    set.add(cylinder, material);
    let floats = set.channel([8, 8], "channel.albedo", t::FLOAT32_VEC3).floats();
    for x in 0..8 {
        let found = floats[3 * (8 * 4 + x)];
        assert!((found - (x as f32 + 0.5) / 8.0).abs() < 1e-3, "a ramp along the axis: {found}");
    }
    set.assert_quiet();
}

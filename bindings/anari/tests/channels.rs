// SPDX-License-Identifier: GPL-3.0-or-later
//! Channels of frames in all their formats.

use anari_library_gnurt::types as t;

use crate::common::{Set, assert_close};

/// Two triangles side by side, facing the camera, of one surface with a number.
fn pair() -> Set {
    let mut set = Set::new("default");
    let faces = set.faces(
        "triangle",
        &[
            [-0.9, -0.9, 0.0],
            [-0.1, -0.9, 0.0],
            [-0.5, 0.9, 0.0],
            [0.1, -0.9, 1.0],
            [0.9, -0.9, 1.0],
            [0.5, 0.9, 1.0],
        ],
    );
    let grey = set.matte([0.5, 0.25, 1.0]);
    let surface = set.add(faces, grey);
    set.client.set_u32(surface, "id", t::UINT32, 77);
    set.client.commit(surface);
    set.ambient(1.0);
    set
}

#[test]
fn every_channel_says_what_is_seen() {
    let set = pair();
    let size = [10, 10];
    let (left, right, beside) = (2, 7, 0);
    let row = 10;
    let depth = set.channel(size, "channel.depth", t::FLOAT32).floats();
    assert_close(depth[row + left], 5.0, 1e-5, "left");
    assert_close(depth[row + right], 4.0, 1e-5, "right");
    assert!(depth[10 * 9 + beside].is_infinite(), "nothing");
    let primitives = set.channel(size, "channel.primitiveId", t::UINT32).numbers();
    assert_eq!([primitives[row + left], primitives[row + right]], [0, 1], "the triangles");
    let objects = set.channel(size, "channel.objectId", t::UINT32).numbers();
    assert_eq!([objects[row + left], objects[10 * 9]], [77, u32::MAX], "the surface's number, and none");
    let normals = set.channel(size, "channel.normal", t::FLOAT32_VEC3).floats();
    assert_eq!(normals[3 * (row + left)..][..3], [0.0, 0.0, 1.0], "towards the camera");
    let fixed = set.channel(size, "channel.normal", t::FIXED16_VEC3);
    assert_eq!(fixed.bytes[6 * (row + left) + 4..][..2], i16::MAX.to_ne_bytes(), "1 in 16 bits");
    let albedo = set.channel(size, "channel.albedo", t::UFIXED8_VEC3).bytes;
    assert_eq!(albedo[3 * (row + left)..][..3], [128, 64, 255], "linear bytes");
    let albedo = set.channel(size, "channel.albedo", t::UFIXED8_RGB_SRGB).bytes;
    assert_eq!(albedo[3 * (row + left)..][..3], [188, 137, 255], "sRGB bytes");
    set.assert_quiet();
}

#[test]
fn colours_come_in_three_formats() {
    let set = pair();
    set.samples(64);
    let at = 4 * (10 + 2);
    let floats = set.channel([10, 10], "channel.color", t::FLOAT32_VEC4).floats();
    assert_close(floats[at], 0.5, 0.05, "floats");
    let bytes = set.channel([10, 10], "channel.color", t::UFIXED8_VEC4).bytes;
    assert!(bytes[at].abs_diff(128) < 8 && bytes[at + 3] == 255, "{:?}", &bytes[at..at + 4]);
    let srgb = set.channel([10, 10], "channel.color", t::UFIXED8_RGBA_SRGB).bytes;
    assert!(srgb[at].abs_diff(188) < 8 && srgb[at + 1].abs_diff(137) < 8, "{:?}", &srgb[at..at + 4]);
}

#[test]
fn primitives_have_the_numbers_that_programs_give() {
    let mut set = Set::new("ao");
    let spheres = set.client.object(t::GEOMETRY, "sphere");
    let places = set.client.floats(t::FLOAT32_VEC3, &[-0.5, 0.0, 0.0, 0.5, 0.0, 0.0]);
    set.client.give(spheres, "vertex.position", t::ARRAY1D, places);
    let ids = set.client.numbers(t::UINT32, &[900, 901]);
    set.client.give(spheres, "primitive.id", t::ARRAY1D, ids);
    set.client.set_float(spheres, "radius", 0.4);
    set.client.commit(spheres);
    let grey = set.matte([0.5; 3]);
    set.add(spheres, grey);
    let found = set.channel([8, 8], "channel.primitiveId", t::UINT32).numbers();
    assert_eq!([found[8 * 4 + 2], found[8 * 4 + 5]], [900, 901]);
    set.assert_quiet();
}

#[test]
fn several_channels_come_at_once() {
    let set = pair();
    set.commit();
    let frame = set.frame(
        [6, 4],
        &[("channel.color", t::UFIXED8_VEC4), ("channel.depth", t::FLOAT32), ("channel.objectId", t::UINT32)],
    );
    set.client.render(frame);
    let names = ["channel.color", "channel.depth", "channel.objectId"];
    let channels = names.map(|name| set.client.channel(frame, name).expect("it was asked for"));
    assert!(
        channels.iter().all(|channel| channel.size == [6, 4] && channel.bytes.len() == 96),
        "{channels:?}"
    );
    assert_eq!(set.client.channel(frame, "channel.normal"), None, "not asked for");
}

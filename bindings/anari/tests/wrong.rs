// SPDX-License-Identifier: GPL-3.0-or-later
//! Mistakes of programs: each is named with its object and parameter, and none is fatal.

use anari_library_gnurt::ffi_client::{Client, Message};
use anari_library_gnurt::types as t;

use crate::common::Set;

/// The one message so far that is no information.
#[track_caller]
fn only(client: &Client) -> Message {
    let mut loud: Vec<Message> =
        client.messages().into_iter().filter(|message| message.severity < 5).collect();
    assert_eq!(loud.len(), 1, "one message: {loud:?}");
    loud.remove(0)
}

#[track_caller]
fn assert_says(client: &Client, severity: i32, words: &[&str]) {
    let message = only(client);
    assert_eq!(message.severity, severity, "{message:?}");
    assert!(words.iter().all(|word| message.text.contains(word)), "{message:?} lacks some of {words:?}");
}

#[test]
fn unknown_handles_are_named() {
    let client = Client::new();
    let object = client.object(t::GROUP, "");
    client.release(object);
    client.release(object);
    assert_says(&client, 2, &["release", "unknown, or released already"]);
    client.commit(12_345);
    assert_says(&client, 2, &["commit parameters", "0x3039"]);
    client.set_float(object, "x", 1.0);
    assert_says(&client, 2, &["set parameter"]);
    let surface = client.object(t::SURFACE, "");
    client.set_object(surface, "geometry", t::GEOMETRY, object);
    assert_says(&client, 2, &["surface", "'geometry'", "unknown, or released already"]);
    assert!(!client.is_ready(surface, false), "no frame");
    assert_says(&client, 2, &["surface", "no frame"]);
    client.release(surface);
}

#[test]
fn wrong_types_and_words_are_named_with_what_would_be_right() {
    let client = Client::new();
    let geometry = client.object(t::GEOMETRY, "sphere");
    client.set_text(geometry, "name", "atoms");
    client.set_text(geometry, "radius", "large");
    assert_says(&client, 3, &["geometry 'sphere' \"atoms\"", "'radius'", "ANARI_STRING", "ANARI_FLOAT32"]);
    let cylinder = client.object(t::GEOMETRY, "cylinder");
    client.set_text(cylinder, "caps", "left");
    assert_says(&client, 3, &["'caps'", "'left'", "none, first, second, both"]);
    let wrong = client.floats(t::FLOAT32_VEC2, &[0.0; 4]);
    client.give(geometry, "vertex.position", t::ARRAY1D, wrong);
    assert_says(&client, 3, &["'vertex.position'", "ANARI_FLOAT32_VEC2"]);
    client.set_float(geometry, "colour", 1.0);
    let messages = client.messages();
    assert!(
        messages.iter().all(|m| m.severity == 5) && messages[0].text.contains("'colour'"),
        "{messages:?}"
    );
    client.set(geometry, "radius", 9999, &[0; 8]);
    assert_says(&client, 2, &["'radius'", "9999"]);
    assert_eq!(client.object(9999, "x"), 0, "no such kind");
    assert_says(&client, 2, &["new object", "'x'"]);
    for object in [geometry, cylinder] {
        client.release(object);
    }
}

#[test]
fn what_the_device_cannot_do_is_named() {
    let client = Client::new();
    let camera = client.object(t::CAMERA, "perspective");
    client.set_text(camera, "stereoMode", "left");
    assert_says(&client, 3, &["camera 'perspective'", "'stereoMode'", "unsupported"]);
    let geometry = client.object(t::GEOMETRY, "triangle");
    let list = client.floats(t::FLOAT32, &[0.0]);
    client.give(geometry, "motion.vertex.position", t::ARRAY1D, list);
    assert_says(&client, 3, &["'motion.vertex.position'", "unsupported"]);
}

#[test]
fn unknown_subtypes_are_named() {
    let client = Client::new();
    for (kind, subtype, right) in [
        (t::GEOMETRY, "torus", "triangle"),
        (t::SAMPLER, "compressedImage2D", "image2D"),
        (t::CAMERA, "fisheye", "omnidirectional"),
        (t::SPATIAL_FIELD, "unstructured", "structuredRegular"),
        (t::LIGHT, "sun", "directional"),
        (t::INSTANCE, "billboard", "motionTransform"),
    ] {
        let object = client.object(kind, subtype);
        assert_says(&client, 2, &[subtype, right]);
        assert_ne!(object, 0, "a handle that may be released");
        client.release(object);
    }
}

#[test]
fn missing_parameters_are_named_at_the_commit() {
    let client = Client::new();
    for (kind, subtype, name) in [
        (t::GEOMETRY, "sphere", "vertex.position"),
        (t::SAMPLER, "image3D", "image"),
        (t::VOLUME, "transferFunction1D", "value"),
        (t::INSTANCE, "transform", "group"),
        (t::LIGHT, "hdri", "radiance"),
    ] {
        let object = client.object(kind, subtype);
        client.commit(object);
        assert_says(&client, 3, &[name, "missing"]);
        client.release(object);
    }
}

#[test]
fn incomplete_frames_are_dark_and_named() {
    let set = Set::new("default");
    let frame = set.frame([4, 4], &[("channel.color", t::FLOAT32_VEC4)]);
    set.client.unset(frame, "camera");
    set.client.commit(frame);
    let _ = set.client.messages();
    set.client.render(frame);
    assert_says(&set.client, 2, &["frame", "'camera'", "missing"]);
    let picture = set.client.channel(frame, "channel.color").expect("a picture all the same");
    assert!(picture.floats().iter().all(|&x| x == 0.0), "dark");
    set.client.set(frame, "size", t::UINT32_VEC2, &[0; 8]);
    set.client.commit(frame);
    let _ = set.client.messages();
    set.client.render(frame);
    assert_says(&set.client, 2, &["'size'", "0 x 0"]);
    assert_eq!(set.client.channel(frame, "channel.color"), None, "no picture");
    let huge = [u32::MAX, u32::MAX].map(u32::to_ne_bytes).concat();
    set.client.set(frame, "size", t::UINT32_VEC2, &huge);
    set.client.commit(frame);
    let _ = set.client.messages();
    set.client.render(frame);
    assert_says(&set.client, 2, &["'size'", "out of range"]);
}

#[test]
fn wrong_geometry_is_left_out_and_named() {
    let mut set = Set::new("ao");
    let geometry = set.client.object(t::GEOMETRY, "triangle");
    let positions = set.client.floats(t::FLOAT32_VEC3, &[-1.0, -1.0, 0.0, 1.0, -1.0, 0.0, 0.0, 1.0, 0.0]);
    set.client.give(geometry, "vertex.position", t::ARRAY1D, positions);
    let index = set.client.numbers(t::UINT32_VEC3, &[0, 1, 2, 0, 1, 99]);
    set.client.give(geometry, "primitive.index", t::ARRAY1D, index);
    set.client.commit(geometry);
    let grey = set.matte([0.5; 3]);
    set.add(geometry, grey);
    let picture = set.channel([8, 8], "channel.depth", t::FLOAT32);
    assert!(picture.floats().iter().any(|depth| depth.is_finite()), "the good one is there");
    assert_says(&set.client, 3, &["triangle", "'primitive.index'", "1 of 2", "out of range"]);
}

#[test]
fn arrays_that_cannot_be_are_refused() {
    let client = Client::new();
    assert_eq!(client.managed(t::FLOAT32, &[u64::MAX, u64::MAX]), 0, "no memory has so much");
    assert_says(&client, 2, &["new array", "out of range"]);
    assert_eq!(client.managed(t::FLOAT32, &[1 << 60]), 0, "nor this");
    assert_says(&client, 2, &["new array"]);
    assert_eq!(client.managed(12_345, &[1]), 0, "no such type");
    assert_says(&client, 2, &["new array", "12345"]);
    let empty = client.managed(t::FLOAT32, &[0]);
    assert_ne!(empty, 0, "nothing is something");
    client.release(empty);
}

#[test]
fn views_that_see_nothing_are_named() {
    for (name, kind, floats, words) in [
        ("direction", t::FLOAT32_VEC3, &[0.0_f32; 3][..], "without length"),
        ("position", t::FLOAT32_VEC3, &[f32::NAN; 3], "out of range"),
        ("height", t::FLOAT32, &[-1.0], "above 0"),
    ] {
        let set = Set::new("default");
        set.client.set_floats(set.camera, name, kind, floats);
        set.client.commit(set.camera);
        set.commit();
        let frame = set.frame([2, 2], &[("channel.color", t::FLOAT32_VEC4)]);
        set.client.render(frame);
        assert_says(&set.client, 2, &["camera 'orthographic'", name, words]);
    }
}

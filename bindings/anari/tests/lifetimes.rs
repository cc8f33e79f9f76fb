// SPDX-License-Identifier: GPL-3.0-or-later
//! Objects, arrays and parameters live as long as they have a holder, and no longer.

use std::sync::atomic::{AtomicUsize, Ordering};

use anari_library_gnurt::ffi_client::Client;
use anari_library_gnurt::types as t;

use crate::common::Set;

#[test]
fn objects_die_when_nobody_holds_them() {
    let client = Client::new();
    let (geometry, surface) = (client.object(t::GEOMETRY, "sphere"), client.object(t::SURFACE, ""));
    let list = client.floats(t::FLOAT32_VEC3, &[0.0; 3]);
    assert_eq!(client.alive(), 3, "held by the program");
    client.give(geometry, "vertex.position", t::ARRAY1D, list);
    client.commit(geometry);
    client.give(surface, "geometry", t::GEOMETRY, geometry);
    client.commit(surface);
    assert_eq!(client.alive(), 3, "held by parameters");
    client.retain(surface);
    client.release(surface);
    assert_eq!(client.alive(), 3, "held once more");
    // A parameter that is taken away counts until the commit.
    client.unset(surface, "geometry");
    assert_eq!(client.alive(), 3, "committed still");
    client.commit(surface);
    assert_eq!(client.alive(), 1, "only the surface");
    client.release(surface);
    assert_eq!(client.alive(), 0, "nothing");
}

#[test]
fn whole_scenes_die() {
    let set = {
        let mut set = Set::new("default");
        let (square, grey) = (set.square(1.0), set.matte([0.5; 3]));
        let surface = set.add(square, grey);
        let light = set.light("directional", &[]);
        let frame = {
            let _ = set.picture([8, 8]);
            set.frame([8, 8], &[("channel.color", t::UFIXED8_VEC4)])
        };
        set.client.render(frame);
        assert!(set.client.is_ready(frame, true), "waited for");
        for object in [surface, light, frame, set.world, set.camera, set.renderer] {
            set.client.release(object);
        }
        set
    };
    assert_eq!(set.client.alive(), 0, "caches hold no objects");
}

#[test]
fn captured_memory_is_freed_once() {
    let client = Client::new();
    let (counter, memory) = (AtomicUsize::new(0), [0_u8; 24]);
    let array = client.captured(&memory, &counter);
    let geometry = client.object(t::GEOMETRY, "sphere");
    client.set_object(geometry, "vertex.position", t::ARRAY1D, array);
    client.commit(geometry);
    client.release(array);
    assert_eq!(counter.load(Ordering::SeqCst), 0, "the geometry holds it");
    client.unset_all(geometry);
    client.commit(geometry);
    assert_eq!(counter.load(Ordering::SeqCst), 1, "freed");
    drop(client);
    assert_eq!(counter.load(Ordering::SeqCst), 1, "once");
}

#[test]
fn released_shared_memory_is_not_read_again() {
    let mut set = Set::new("ao");
    set.ambient(1.0);
    let mut corners: Vec<u8> = [[-9.0_f32, -9.0, 0.0], [9.0, -9.0, 0.0], [0.0, 9.0, 0.0]]
        .iter()
        .flatten()
        .flat_map(|x| x.to_ne_bytes())
        .collect();
    let geometry = set.client.object(t::GEOMETRY, "triangle");
    set.client.shared_for(&corners, t::FLOAT32_VEC3, |array| {
        set.client.set_object(geometry, "vertex.position", t::ARRAY1D, array);
        set.client.commit(geometry);
    });
    corners.fill(0xff);
    let white = set.matte([1.0; 3]);
    set.add(geometry, white);
    assert_eq!(set.picture([5, 5]).pixel(2, 2)[0], 1.0, "a copy was made when the array was released");
}

#[test]
fn mapped_arrays_change_what_is_seen() {
    let mut set = Set::new("ao");
    set.ambient(1.0);
    let square = set.square(1.0);
    set.client.retain(square);
    let colors = set.client.floats(t::FLOAT32_VEC3, &[1.0, 0.0, 0.0]);
    set.client.set_object(square, "primitive.color", t::ARRAY1D, colors);
    set.client.commit(square);
    let material = set.client.object(t::MATERIAL, "matte");
    set.client.set_text(material, "color", "color");
    set.client.commit(material);
    set.add(square, material);
    assert_eq!(set.picture([2, 2]).pixel(0, 0)[..3], [1.0, 0.0, 0.0], "red");
    set.client.write(colors, &[0.0_f32, 1.0, 0.0].map(f32::to_ne_bytes).concat());
    assert_eq!(
        set.picture([2, 2]).pixel(0, 0)[..3],
        [0.0, 1.0, 0.0],
        "green, without a commit of the geometry"
    );
    set.client.map_parameter(
        square,
        "primitive.color",
        t::FLOAT32_VEC3,
        &[0.0_f32, 0.0, 1.0].map(f32::to_ne_bytes).concat(),
    );
    set.client.commit(square);
    assert_eq!(set.picture([2, 2]).pixel(0, 0)[..3], [0.0, 0.0, 1.0], "blue, by a mapped parameter");
    set.assert_quiet();
}

#[test]
fn regions_of_lists_count() {
    let mut set = Set::new("ao");
    set.ambient(1.0);
    let square = set.square(1.0);
    set.client.retain(square);
    let colors = set.client.floats(t::FLOAT32_VEC3, &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    set.client.set(colors, "region", t::UINT64_REGION1, &[1_u64.to_ne_bytes(), 2_u64.to_ne_bytes()].concat());
    set.client.commit(colors);
    set.client.give(square, "primitive.color", t::ARRAY1D, colors);
    set.client.commit(square);
    let material = set.client.object(t::MATERIAL, "matte");
    set.client.set_text(material, "color", "color");
    set.client.commit(material);
    set.add(square, material);
    assert_eq!(set.picture([2, 2]).pixel(0, 0)[..3], [0.0, 1.0, 0.0], "the second one is the first");
}

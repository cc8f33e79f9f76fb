// SPDX-License-Identifier: GPL-3.0-or-later
//! Instances: transforms, arrays of them, attributes and numbers of their own, and bounds.

use anari_library_gnurt::types as t;

use crate::common::Set;

fn matrix(scale: f32, x: f32) -> [f32; 16] {
    let s = scale;
    [s, 0.0, 0.0, 0.0, 0.0, s, 0.0, 0.0, 0.0, 0.0, s, 0.0, x, 0.0, 0.0, 1.0]
}

fn group(set: &Set, material: usize) -> usize {
    let square = set.square(0.5);
    let surface = set.surface(square, material);
    let group = set.client.object(t::GROUP, "");
    let list = set.client.objects(t::SURFACE, &[surface]);
    set.client.release(surface);
    set.client.give(group, "surface", t::ARRAY1D, list);
    set.client.commit(group);
    group
}

#[test]
fn transforms_move_groups() {
    let mut set = Set::new("ao");
    let white = set.matte([1.0; 3]);
    let group = group(&set, white);
    for (id, x) in [(7, -0.5), (9, 0.5)] {
        let instance = set.client.object(t::INSTANCE, "transform");
        set.client.set_object(instance, "group", t::GROUP, group);
        set.client.set_floats(instance, "transform", t::FLOAT32_MAT4, &matrix(0.5, x));
        set.client.set_u32(instance, "id", t::UINT32, id);
        set.client.commit(instance);
        set.instance(instance);
    }
    let ids = set.channel([8, 8], "channel.instanceId", t::UINT32).numbers();
    let at = |x: usize| ids[8 * 4 + x];
    assert_eq!([at(1), at(2), at(5), at(6)], [7, 7, 9, 9], "each where it was put");
    assert_eq!(at(0), u32::MAX, "nothing beside them");
    let bounds = set.client.property(set.world, "bounds", t::FLOAT32_BOX3).expect("it has some");
    let bounds: Vec<f32> =
        bounds.chunks_exact(4).map(|b| f32::from_ne_bytes([b[0], b[1], b[2], b[3]])).collect();
    assert_eq!(bounds, [-0.75, -0.25, 0.0, 0.75, 0.25, 0.0], "around both");
    set.assert_quiet();
}

#[test]
fn arrays_of_transforms_have_attributes_and_numbers_of_their_own() {
    let mut set = Set::new("ao");
    let material = set.client.object(t::MATERIAL, "matte");
    set.client.set_text(material, "color", "color");
    set.client.commit(material);
    let group = group(&set, material);
    let instance = set.client.object(t::INSTANCE, "transform");
    set.client.set_object(instance, "group", t::GROUP, group);
    let transforms = set.client.floats(t::FLOAT32_MAT4, &[matrix(0.5, -0.5), matrix(0.5, 0.5)].concat());
    set.client.give(instance, "transform", t::ARRAY1D, transforms);
    let colors = set.client.floats(t::FLOAT32_VEC4, &[1.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0]);
    set.client.give(instance, "color", t::ARRAY1D, colors);
    let ids = set.client.numbers(t::UINT32, &[3, 4]);
    set.client.give(instance, "id", t::ARRAY1D, ids);
    set.client.commit(instance);
    set.instance(instance);
    let albedo = set.channel([8, 8], "channel.albedo", t::FLOAT32_VEC3).floats();
    let at = |x: usize| &albedo[3 * (8 * 4 + x)..][..3];
    assert_eq!(at(2), [1.0, 0.0, 0.0], "the first one's colour");
    assert_eq!(at(5), [0.0, 1.0, 0.0], "the second one's");
    let ids = set.channel([8, 8], "channel.instanceId", t::UINT32).numbers();
    assert_eq!([ids[8 * 4 + 2], ids[8 * 4 + 5]], [3, 4], "their numbers");
    set.assert_quiet();
}

#[test]
fn bounds_of_round_shapes_are_exact() {
    let set = Set::new("ao");
    let bounds = |subtype: &str, points: &[f32], radius: f32| {
        let mut set = Set::new("ao");
        let geometry = set.client.object(t::GEOMETRY, subtype);
        let list = set.client.floats(t::FLOAT32_VEC3, points);
        set.client.give(geometry, "vertex.position", t::ARRAY1D, list);
        set.client.set_float(geometry, "radius", radius);
        set.client.commit(geometry);
        let grey = set.matte([0.5; 3]);
        set.add(geometry, grey);
        set.commit();
        let bytes = set.client.property(set.world, "bounds", t::FLOAT32_BOX3).expect("it has some");
        bytes.chunks_exact(4).map(|b| f32::from_ne_bytes([b[0], b[1], b[2], b[3]])).collect::<Vec<f32>>()
    };
    assert_eq!(bounds("sphere", &[1.0, 2.0, 3.0], 0.5), [0.5, 1.5, 2.5, 1.5, 2.5, 3.5], "a ball");
    let rod = bounds("cylinder", &[0.0, 0.0, 0.0, 0.0, 0.0, 2.0], 0.5);
    assert!(
        rod.iter().zip([-0.5, -0.5, 0.0, 0.5, 0.5, 2.0]).all(|(a, b)| (a - b).abs() < 1e-6),
        "a rod: {rod:?}"
    );
    set.commit();
    assert_eq!(set.client.property(set.world, "bounds", t::FLOAT32_BOX3), None, "nothing has none");
}

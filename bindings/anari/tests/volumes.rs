// SPDX-License-Identifier: GPL-3.0-or-later
//! Volumes, beside Beer's law.

use anari_library_gnurt::types as t;

use crate::common::{Set, assert_close};

/// A box from -0.5 to 0.5 of one value, seen through a colour and an opacity of `unit` distance.
fn fog(set: &mut Set, value: f32, opacity: f32, unit: f32) {
    let field = set.client.object(t::SPATIAL_FIELD, "structuredRegular");
    let values: Vec<u8> = (0..27).flat_map(|_| value.to_ne_bytes()).collect();
    let data = set.client.array(t::FLOAT32, &[3, 3, 3], &values);
    set.client.give(field, "data", t::ARRAY3D, data);
    set.client.set_vec3(field, "origin", [-0.5; 3]);
    set.client.set_vec3(field, "spacing", [0.5; 3]);
    set.client.commit(field);
    let volume = set.client.object(t::VOLUME, "transferFunction1D");
    set.client.give(volume, "value", t::SPATIAL_FIELD, field);
    let colors = set.client.floats(t::FLOAT32_VEC3, &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    set.client.give(volume, "color", t::ARRAY1D, colors);
    set.client.set_float(volume, "opacity", opacity);
    set.client.set_float(volume, "unitDistance", unit);
    set.client.set_u32(volume, "id", t::UINT32, 42);
    set.client.commit(volume);
    set.volume(volume);
}

#[test]
fn uniform_fog_follows_beer() {
    for renderer in ["default", "ao"] {
        let mut set = Set::new(renderer);
        fog(&mut set, 0.25, 0.6, 0.5);
        set.client.set_floats(set.renderer, "background", t::FLOAT32_VEC4, &[0.0, 0.0, 1.0, 0.0]);
        set.client.commit(set.renderer);
        let picture = set.picture([16, 16]);
        let [r, g, b, a] = picture.pixel(8, 8);
        let opacity = 1.0 - 0.4_f32.powi(2);
        assert_close(a, opacity, 0.01, renderer);
        assert_close(r, 0.75 * opacity, 0.01, "three quarters of the first colour");
        assert_close(g, 0.25 * opacity, 0.01, "a quarter of the second one");
        assert_close(b, 1.0 - opacity, 0.01, "the background behind");
        assert_eq!(picture.pixel(0, 0)[3], 0.0, "nothing beside it");
        set.assert_quiet();
    }
}

#[test]
fn surfaces_stand_in_fog() {
    for renderer in ["default", "ao"] {
        let mut set = Set::new(renderer);
        fog(&mut set, 0.0, 0.6, 0.5);
        let (square, white) = (set.square(50.0), set.matte([1.0; 3]));
        set.add(square, white);
        set.ambient(1.0);
        set.samples(32);
        let [r, g, _, _] = set.picture([16, 16]).pixel(8, 8);
        // Half of the fog is in front: it lets 0.4 through.
        assert_close(g, 0.4, 0.02, renderer);
        assert_close(r, 0.4 + 0.6, 0.02, "its own light is red");
    }
}

#[test]
fn volumes_have_depth_and_number() {
    let mut set = Set::new("default");
    fog(&mut set, 0.5, 0.5, 1.0);
    let depths = set.channel([8, 8], "channel.depth", t::FLOAT32).floats();
    assert_close(depths[8 * 4 + 4], 4.5, 1e-4, "where a ray enters it");
    let ids = set.channel([8, 8], "channel.objectId", t::UINT32).numbers();
    assert_eq!([ids[8 * 4 + 4], ids[0]], [42, u32::MAX], "its number, and none");
    let bounds = set.client.property(set.world, "bounds", t::FLOAT32_BOX3).expect("it has some");
    let bounds: Vec<f32> =
        bounds.chunks_exact(4).map(|b| f32::from_ne_bytes([b[0], b[1], b[2], b[3]])).collect();
    assert_eq!(bounds, [-0.5, -0.5, -0.5, 0.5, 0.5, 0.5], "from the first point to the last");
}

#[test]
fn damaged_grids_of_nanovdb_are_named() {
    let mut set = Set::new("default");
    let field = set.client.object(t::SPATIAL_FIELD, "nanovdb");
    let data = set.client.array(t::UINT8, &[16], b"NanoVDB0 or less");
    set.client.give(field, "data", t::ARRAY1D, data);
    set.client.commit(field);
    let volume = set.client.object(t::VOLUME, "transferFunction1D");
    set.client.give(volume, "value", t::SPATIAL_FIELD, field);
    set.client.commit(volume);
    set.volume(volume);
    set.picture([4, 4]);
    let texts: Vec<_> = set.client.messages().into_iter().map(|message| message.text).collect();
    let is_named = |text: &String| text.contains("'data': ") && text.contains("ends too early");
    assert!(texts.iter().any(is_named), "{texts:?}");
}

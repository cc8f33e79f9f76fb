// SPDX-License-Identifier: GPL-3.0-or-later
//! Opacity, emission and the layers of physically based materials.

use anari_library_gnurt::types as t;

use crate::common::{Set, assert_close};

/// A square that fills the picture, of a material with these parameters, under light from everywhere of radiance 1.
fn square(subtype: &str, edit: impl FnOnce(&Set, usize)) -> Set {
    let mut set = Set::new("default");
    let (square, material) = (set.square(50.0), set.client.object(t::MATERIAL, subtype));
    edit(&set, material);
    set.client.commit(material);
    set.add(square, material);
    set.ambient(1.0);
    set
}

#[test]
fn opacities_show_the_background() {
    for (mode, opacity, share) in
        [("opaque", 0.25, 1.0), ("blend", 0.25, 0.25), ("mask", 0.25, 0.0), ("mask", 0.75, 1.0)]
    {
        let set = square("matte", |set, material| {
            set.client.set_vec3(material, "color", [0.8, 0.0, 0.0]);
            set.client.set_text(material, "alphaMode", mode);
            set.client.set_float(material, "opacity", opacity);
        });
        set.client.set_floats(set.renderer, "background", t::FLOAT32_VEC4, &[0.0, 0.0, 1.0, 1.0]);
        set.client.commit(set.renderer);
        let [r, _, b, a] = set.mean([16, 16]);
        assert_close(r, 0.8 * share, 0.02, &format!("{mode} {opacity}: the surface"));
        assert_close(b, 1.0 - share, 0.02, &format!("{mode} {opacity}: what is behind"));
        assert!((a - 1.0).abs() < 1e-5, "the background is opaque: {a}");
        set.client.set_floats(set.renderer, "background", t::FLOAT32_VEC4, &[0.0; 4]);
        set.client.commit(set.renderer);
        assert_close(set.mean([16, 16])[3], share, 0.01, "opacity over nothing");
        set.assert_quiet();
    }
}

#[test]
fn surfaces_one_behind_the_other_add_up() {
    let mut set = Set::new("default");
    for (z, color) in [(0.0, [1.0, 0.0, 0.0]), (1.0, [0.0, 1.0, 0.0])] {
        let corners = [[-9.0, -9.0, z], [9.0, -9.0, z], [9.0, 9.0, z], [-9.0, 9.0, z]];
        let (faces, material) =
            (set.faces("quad", &corners), set.client.object(t::MATERIAL, "physicallyBased"));
        set.client.set_vec3(material, "baseColor", [0.0; 3]);
        set.client.set_vec3(material, "emissive", color);
        set.client.set_float(material, "metallic", 0.0);
        set.client.set_text(material, "alphaMode", "blend");
        set.client.set_float(material, "opacity", 0.5);
        set.client.commit(material);
        set.add(faces, material);
    }
    let [r, g, _, a] = set.mean([8, 8]);
    assert_close(g, 0.5, 0.01, "half of the near one");
    assert_close(r, 0.25, 0.01, "a quarter of the far one");
    assert_eq!(a, 1.0, "over an opaque background");
    assert_close(set.mean([8, 8])[2], 0.0, 0.01, "which is black");
}

#[test]
fn white_layers_lose_no_light() {
    let white = |edit: &dyn Fn(&Set, usize)| {
        let set = square("physicallyBased", edit);
        set.samples(64);
        let [r, ..] = set.mean([16, 16]);
        set.assert_quiet();
        r
    };
    let plastic = white(&|set, material| set.client.set_float(material, "metallic", 0.0));
    assert_close(plastic, 1.0, 0.01, "white body without reflectance");
    let shiny = white(&|set, material| {
        set.client.set_float(material, "metallic", 0.0);
        set.client.set_float(material, "specular", 1.0);
        set.client.set_float(material, "roughness", 0.4);
    });
    assert_close(shiny, 1.0, 0.03, "white plastic");
    let metal = white(&|set, material| set.client.set_float(material, "roughness", 0.3));
    assert_close(metal, 1.0, 0.03, "white metal");
    let coated = white(&|set, material| {
        set.client.set_float(material, "metallic", 0.0);
        set.client.set_float(material, "clearcoat", 1.0);
    });
    assert_close(coated, 1.0, 0.04, "coated");
    let pane = white(&|set, material| {
        set.client.set_float(material, "metallic", 0.0);
        set.client.set_float(material, "roughness", 0.0);
        set.client.set_float(material, "transmission", 1.0);
    });
    assert_close(pane, 1.0, 0.03, "a clear pane shows the light behind");
}

#[test]
fn emission_is_seen_and_lights() {
    let mut set = Set::new("default");
    let area_light = set.client.object(t::MATERIAL, "physicallyBased");
    set.client.set_vec3(area_light, "emissive", [2.0, 1.0, 0.5]);
    set.client.set_vec3(area_light, "baseColor", [0.0; 3]);
    set.client.commit(area_light);
    let square = set.square(0.5);
    set.add(square, area_light);
    let seen = set.picture([9, 9]).pixel(4, 4);
    assert!((seen[0] - 2.0).abs() < 1e-3 && (seen[2] - 0.5).abs() < 1e-3, "{seen:?}");
    // A floor beside it is lit.
    let white = set.matte([1.0; 3]);
    let wall = set.faces("quad", &[[0.6, -9.0, -9.0], [0.6, -9.0, 9.0], [0.6, 9.0, 9.0], [0.6, 9.0, -9.0]]);
    set.add(wall, white);
    let camera = set.client.object(t::CAMERA, "orthographic");
    set.client.set_vec3(camera, "position", [-3.0, 0.0, 3.0]);
    set.client.set_vec3(camera, "direction", [3.6, 0.0, -2.5]);
    set.client.set_float(camera, "height", 0.1);
    set.client.commit(camera);
    let set = set.seen_by(camera);
    set.samples(32);
    assert!(set.mean([4, 4])[0] > 0.05, "the wall is lit");
}

#[test]
fn normal_maps_turn_normals() {
    let mut set = Set::new("debug");
    let square = set.square(1.0);
    set.client.retain(square);
    let uv = set.client.floats(t::FLOAT32_VEC2, &[0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0]);
    set.client.give(square, "vertex.attribute0", t::ARRAY1D, uv);
    set.client.commit(square);
    let sampler = set.client.object(t::SAMPLER, "image2D");
    // 2 value - 1 = (0.6, 0, 0.8).
    let texel: Vec<u8> = [0.8_f32, 0.5, 0.9].iter().flat_map(|x| x.to_ne_bytes()).collect();
    let texel = set.client.array(t::FLOAT32_VEC3, &[1, 1], &texel);
    set.client.give(sampler, "image", t::ARRAY2D, texel);
    set.client.commit(sampler);
    let material = set.client.object(t::MATERIAL, "physicallyBased");
    set.client.give(material, "normal", t::SAMPLER, sampler);
    set.client.commit(material);
    set.add(square, material);
    let normals = set.channel([4, 4], "channel.normal", t::FLOAT32_VEC3).floats();
    assert!((normals[0] - 0.6).abs() < 1e-3 && (normals[2] - 0.8).abs() < 1e-3, "{:?}", &normals[..3]);
    set.assert_quiet();
}

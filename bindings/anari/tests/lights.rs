// SPDX-License-Identifier: GPL-3.0-or-later
//! Light that surfaces send back, beside closed forms.

use std::f32::consts::PI;

use anari_library_gnurt::types as t;

use crate::common::{Set, assert_close};

/// A white floor that fills the picture, with one light.
fn floor(subtype: &str, parameters: &[(&str, &[f32])]) -> Set {
    let mut set = Set::new("default");
    let (square, white) = (set.square(50.0), set.matte([1.0; 3]));
    set.add(square, white);
    set.light(subtype, parameters);
    set
}

#[test]
fn directional_light_follows_lambert() {
    for (direction, cos) in
        [([0.0, 0.0, -2.0], 1.0), ([0.0, -1.0, -1.0], 0.5_f32.sqrt()), ([0.0, 0.0, 1.0], 0.0)]
    {
        // Of a disc as well, if all of it is above the horizon.
        let disc = floor(
            "directional",
            &[("direction", &direction), ("irradiance", &[3.0]), ("angularDiameter", &[0.2])],
        );
        assert_close(disc.mean([16, 16])[0], 3.0 * cos / PI, 1e-2, "a disc");
        disc.assert_quiet();
        let set = floor(
            "directional",
            &[("direction", &direction), ("irradiance", &[3.0]), ("color", &[1.0, 0.5, 0.25])],
        );
        let [r, g, b, a] = set.mean([16, 16]);
        assert_close(r, 3.0 * cos / PI, 1e-3, "red");
        assert_close(g, 1.5 * cos / PI, 1e-3, "green");
        assert_close(b, 0.75 * cos / PI, 1e-3, "blue");
        assert_eq!(a, 1.0, "it is there");
        set.assert_quiet();
    }
}

#[test]
fn convex_bodies_in_a_furnace_show_their_albedo() {
    let mut set = Set::new("default");
    let sphere = set.client.object(t::GEOMETRY, "sphere");
    let middle = set.client.floats(t::FLOAT32_VEC3, &[0.0; 3]);
    set.client.give(sphere, "vertex.position", t::ARRAY1D, middle);
    set.client.set_float(sphere, "radius", 4.0);
    set.client.commit(sphere);
    let grey = set.matte([0.6, 0.3, 0.9]);
    set.add(sphere, grey);
    set.ambient(2.0);
    set.samples(16);
    let [r, g, b, _] = set.mean([16, 16]);
    for (found, albedo) in [(r, 0.6), (g, 0.3), (b, 0.9)] {
        assert_close(found, 2.0 * albedo, 0.01, "albedo times radiance");
    }
}

#[test]
fn point_and_spot_light_fall_with_the_square_of_the_distance() {
    let place: (&str, &[f32]) = ("position", &[0.0, 0.0, 4.0]);
    let camera_sees = |set: &Set| set.picture([33, 33]).pixel(16, 16)[0];
    let point = floor("point", &[place, ("intensity", &[8.0])]);
    assert_close(camera_sees(&point), 8.0 / 16.0 / PI, 5e-3, "intensity over the square, over pi");
    let power = floor("point", &[place, ("power", &[8.0])]);
    assert_close(camera_sees(&power), 8.0 / (4.0 * PI) / 16.0 / PI, 5e-3, "power over the whole sphere");
    let cone: [(&str, &[f32]); 2] = [("openingAngle", &[1.0]), ("falloffAngle", &[0.2])];
    let spot = floor("spot", &[place, ("intensity", &[8.0]), cone[0], cone[1]]);
    assert_close(camera_sees(&spot), 8.0 / 16.0 / PI, 5e-3, "within the cone");
    let aside = floor("spot", &[place, ("direction", &[1.0, 0.0, -0.2]), cone[0], cone[1]]);
    assert_eq!(camera_sees(&aside), 0.0, "beyond the cone");
}

/// Irradiance under the middle of a lamp of radius `r` at height `h` is pi L r^2 / (r^2 + h^2).
#[test]
fn lamps_light_by_their_size() {
    let (r, h) = (0.5_f32, 2.0_f32);
    let form = r * r / (r * r + h * h);
    for subtype in ["ring", "point"] {
        let set = floor(subtype, &[("position", &[0.0, 0.0, h]), ("radius", &[r]), ("radiance", &[6.0])]);
        set.samples(64);
        // Below the lamp.
        set.client.set_vec3(set.camera, "position", [0.0, 0.0, 1.0]);
        set.client.set_float(set.camera, "height", 0.05);
        set.client.commit(set.camera);
        let found = set.mean([8, 8])[0];
        // A ball fills the same cone as its outline: sin = r / h.
        let expected = if subtype == "point" { 6.0 * r * r / (h * h) } else { 6.0 * form };
        assert_close(found, expected, 0.03, subtype);
    }
}

#[test]
fn quads_shine_to_the_sides_that_are_asked_for() {
    let shines = |side: &str, from: f32| {
        let mut set = Set::new("default");
        let (square, white) = (set.square(50.0), set.matte([1.0; 3]));
        set.add(square, white);
        let area_light = set.light(
            "quad",
            &[
                ("position", &[-0.5, -0.5, from]),
                ("edge1", &[1.0, 0.0, 0.0]),
                ("edge2", &[0.0, 1.0, 0.0]),
                ("power", &[3.0]),
            ],
        );
        set.client.set_text(area_light, "side", side);
        set.client.set(area_light, "visible", t::BOOL, &[0]);
        set.client.commit(area_light);
        set.samples(32);
        set.mean([8, 8])[0]
    };
    // Its front looks along +z, away from the floor below it.
    assert_eq!(shines("front", 2.0), 0.0, "the floor is behind it");
    let (back, both) = (shines("back", 2.0), shines("both", 2.0));
    assert!(back > 0.01, "the floor is before its back: {back}");
    assert_close(both, back / 2.0, 0.03, "both sides share the power");
}

#[test]
fn pictures_all_around_are_seen_and_light() {
    let mut set = Set::new("default");
    let (square, white) = (set.square(0.5), set.matte([1.0; 3]));
    set.add(square, white);
    let sky = set.light("hdri", &[("scale", &[2.0])]);
    // Upper half bright, lower half dark.
    let texels: Vec<u8> =
        [[1.0_f32; 3], [1.0; 3], [0.0; 3], [0.0; 3]].iter().flatten().flat_map(|x| x.to_ne_bytes()).collect();
    let picture = set.client.array(t::FLOAT32_VEC3, &[1, 4], &texels);
    set.client.give(sky, "radiance", t::ARRAY2D, picture);
    set.client.set_vec3(sky, "up", [0.0, 1.0, 0.0]);
    set.client.commit(sky);
    set.samples(256);
    let lit = set.picture([9, 9]).pixel(4, 4)[0];
    // Half of the hemisphere over the square is bright, and the seam between is as wide as a texel.
    assert!((0.8..1.2).contains(&lit), "half of 2 arrives: {lit}");
    let camera = set.client.object(t::CAMERA, "perspective");
    set.client.set_vec3(camera, "direction", [0.0, 1.0, 0.0]);
    set.client.set_vec3(camera, "up", [0.0, 0.0, 1.0]);
    set.client.set_vec3(camera, "position", [0.0, 0.0, 9.0]);
    set.client.commit(camera);
    let set = set.seen_by(camera);
    assert_close(set.picture([9, 9]).pixel(4, 4)[0], 2.0, 1e-3, "the sky itself, above");
    set.client.set(sky, "visible", t::BOOL, &[0]);
    set.client.commit(sky);
    assert_eq!(set.picture([9, 9]).pixel(4, 4)[0], 0.0, "not seen where it shall not be");
}

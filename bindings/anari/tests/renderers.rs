// SPDX-License-Identifier: GPL-3.0-or-later
//! Renderers and backgrounds.

use anari_library_gnurt::types as t;

use crate::common::{Set, assert_close};

#[test]
fn open_floors_have_all_light_and_corners_half() {
    let mut set = Set::new("ao");
    let (square, grey) = (set.square(50.0), set.matte([0.5; 3]));
    set.add(square, grey);
    set.ambient(2.0);
    assert_close(set.mean([8, 8])[0], 1.0, 1e-3, "albedo times radiance");
    let wall =
        set.faces("quad", &[[0.0, -50.0, 0.0], [0.0, 50.0, 0.0], [0.0, 50.0, 50.0], [0.0, -50.0, 50.0]]);
    let black = set.matte([0.0; 3]);
    set.add(wall, black);
    set.samples(256);
    set.client.set_vec3(set.camera, "position", [0.02, 0.0, 5.0]);
    set.client.set_float(set.camera, "height", 0.01);
    set.client.commit(set.camera);
    assert_close(set.mean([8, 8])[0], 0.5, 0.03, "a wall hides half of the directions");
}

#[test]
fn eyelight_falls_off_with_the_cosine() {
    let seen = |slope: f32| {
        let mut set = Set::new("eyelight");
        let (h, z) = (9.0, 9.0 * slope);
        let square = set.faces("quad", &[[-h, -h, -z], [h, -h, z], [h, h, z], [-h, h, -z]]);
        let grey = set.matte([0.8; 3]);
        set.add(square, grey);
        set.light("directional", &[("irradiance", &[100.0])]);
        set.mean([4, 4])[0]
    };
    assert_close(seen(0.0), 0.8, 1e-3, "seen upright");
    assert_close(seen(1.0), 0.8 * (0.5 + 0.5 * 0.5_f32.sqrt()), 1e-3, "seen at 45 degrees");
}

#[test]
fn debug_shows_numbers() {
    let mut set = Set::new("debug");
    let (square, grey) = (set.square(50.0), set.matte([0.5, 0.25, 0.125]));
    set.add(square, grey);
    for (method, color) in
        [("normal", [0.5, 0.5, 1.0]), ("albedo", [0.5, 0.25, 0.125]), ("backFace", [0.0, 1.0, 0.0])]
    {
        set.client.set_text(set.renderer, "method", method);
        set.client.commit(set.renderer);
        let [r, g, b, _] = set.mean([4, 4]);
        assert!([r, g, b].iter().zip(color).all(|(a, b)| (a - b).abs() < 1e-4), "{method}: {r} {g} {b}");
    }
    set.assert_quiet();
}

#[test]
fn backgrounds_are_colours_or_pictures() {
    for renderer in ["default", "ao", "eyelight", "debug"] {
        let set = Set::new(renderer);
        set.client.set_floats(set.renderer, "background", t::FLOAT32_VEC4, &[0.1, 0.2, 0.3, 0.5]);
        set.client.commit(set.renderer);
        let found = set.mean([4, 4]);
        let is_near = found.iter().zip([0.1, 0.2, 0.3, 0.5]).all(|(a, b)| (a - b).abs() < 1e-6);
        assert!(is_near, "{renderer}: a colour, not {found:?}");
        let texels: Vec<u8> = [0.0_f32, 1.0].iter().flat_map(|x| x.to_ne_bytes()).collect();
        let rows = set.client.array(t::FLOAT32, &[1, 2], &texels);
        set.client.give(set.renderer, "background", t::ARRAY2D, rows);
        set.client.commit(set.renderer);
        let picture = set.picture([4, 4]);
        assert_eq!(
            [picture.pixel(0, 0)[0], picture.pixel(0, 3)[0]],
            [0.0, 1.0],
            "{renderer}: the lowest row first"
        );
        set.assert_quiet();
    }
}

#[test]
fn denoised_pictures_keep_their_mean() {
    let mut set = Set::new("default");
    let (square, grey) = (set.square(0.7), set.matte([0.5; 3]));
    set.add(square, grey);
    set.light("point", &[("position", &[0.0, 0.0, 2.0]), ("intensity", &[20.0])]);
    set.samples(8);
    let noisy = set.mean([32, 32])[0];
    set.client.set(set.renderer, "denoise", t::BOOL, &[1]);
    set.client.commit(set.renderer);
    assert_close(set.mean([32, 32])[0], noisy, 0.03, "as bright as before");
    set.assert_quiet();
}

#[test]
fn unknown_renderers_become_the_default() {
    let set = Set::new("pathtracer");
    let messages = set.client.messages();
    assert!(messages.iter().any(|m| m.severity == 3 && m.text.contains("'pathtracer'")), "{messages:?}");
    assert_eq!(set.mean([2, 2]), [0.0, 0.0, 0.0, 1.0], "it renders");
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Cameras, by where a square of known size shows.

use anari_library_gnurt::types as t;

use crate::common::{Set, assert_close};

/// The share of the picture that a white square of half side 0.5 fills.
fn share(subtype: &str, edit: impl FnOnce(&Set, usize), size: [u32; 2]) -> f32 {
    let mut set = Set::new("ao");
    set.ambient(1.0);
    let (square, white) = (set.square(0.5), set.matte([1.0; 3]));
    set.add(square, white);
    let camera = set.client.object(t::CAMERA, subtype);
    set.client.set_vec3(camera, "position", [0.0, 0.0, 2.0]);
    edit(&set, camera);
    set.client.commit(camera);
    let set = set.seen_by(camera);
    set.samples(16);
    let share = set.mean(size)[0];
    set.assert_quiet();
    share
}

#[test]
fn squares_fill_their_shares() {
    let tan = 30.0_f32.to_radians().tan();
    let perspective = 1.0 / (4.0 * tan).powi(2);
    assert_close(share("perspective", |_, _| (), [64, 64]), perspective, 0.02, "60 degrees by default");
    let wide = |set: &Set, camera| set.client.set_float(camera, "aspect", 2.0);
    assert_close(share("perspective", wide, [64, 64]), perspective / 2.0, 0.02, "twice as wide");
    let parallel = |set: &Set, camera| set.client.set_float(camera, "height", 2.0);
    assert_close(share("orthographic", parallel, [64, 64]), 0.25, 0.02, "1 of 2 each way");
    assert_close(share("orthographic", parallel, [128, 64]), 0.125, 0.02, "the frame's aspect");
    let region = |set: &Set, camera| {
        set.client.set_float(camera, "height", 2.0);
        set.client.set_floats(camera, "imageRegion", t::FLOAT32_BOX2, &[0.0, 0.0, 0.5, 0.5]);
    };
    assert_close(
        share("orthographic", region, [64, 64]),
        0.25,
        0.02,
        "the lower left quarter has a quarter of it",
    );
}

#[test]
fn planes_clip() {
    let clipped =
        |name: &'static str, at: f32| move |set: &Set, camera| set.client.set_float(camera, name, at);
    assert_eq!(share("orthographic", clipped("near", 2.5), [16, 16]), 0.0, "nearer than the near plane");
    assert_eq!(share("perspective", clipped("far", 1.5), [16, 16]), 0.0, "farther than the far plane");
    assert!(share("perspective", clipped("far", 2.5), [16, 16]) > 0.1, "between them");
}

#[test]
fn all_directions_are_seen() {
    let mut set = Set::new("ao");
    set.ambient(1.0);
    // Around the camera: a box whose sides have their colours.
    let white = set.matte([1.0; 3]);
    let square = set.faces("quad", &[[-9.0, 1.0, -9.0], [9.0, 1.0, -9.0], [9.0, 1.0, 9.0], [-9.0, 1.0, 9.0]]);
    set.add(square, white);
    let camera = set.client.object(t::CAMERA, "omnidirectional");
    set.client.commit(camera);
    let set = set.seen_by(camera);
    let depths = set.channel([64, 32], "channel.depth", t::FLOAT32).floats();
    let at = |x: usize, y: usize| depths[64 * y + x];
    assert!(at(32, 0).is_infinite(), "nothing below");
    assert_close(at(32, 31), 1.0, 0.01, "the ceiling straight above");
    let angle = (5.5 / 32.0 * std::f32::consts::PI).sin();
    assert_close(at(10, 21), 1.0 / angle, 0.05, "by its latitude");
}

#[test]
fn lenses_blur_what_is_out_of_focus() {
    let edge = |radius: f32| {
        let mut set = Set::new("ao");
        set.ambient(1.0);
        let (square, white) = (set.square(0.5), set.matte([1.0; 3]));
        set.add(square, white);
        set.client.set_float(set.camera, "apertureRadius", radius);
        set.client.set_float(set.camera, "focusDistance", 2.5);
        set.client.commit(set.camera);
        set.samples(64);
        let picture = set.picture([40, 40]);
        (0..40).filter(|&x| (0.05..0.95).contains(&picture.pixel(x, 20)[0])).count()
    };
    assert!(edge(0.0) <= 2, "sharp");
    // A lens of radius 0.2 that is focussed half way blurs by as much: 8 pixels of 0.05 each side.
    assert!((8..=20).contains(&edge(0.2)), "blurred: {}", edge(0.2));
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Instances and cameras that move while the shutter is open, by the shares of time that they cover pixels.

use anari_library_gnurt::types as t;

use crate::common::{Set, assert_close};

fn at(x: f32) -> [f32; 16] {
    [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, x, 0.0, 0.0, 1.0]
}

/// A white square of half side 0.5 in a group that moves; `edit` says how.
fn moving(renderer: &str, subtype: &str, shutter: [f32; 2], edit: impl FnOnce(&Set, usize)) -> Set {
    let mut set = Set::new(renderer);
    set.ambient(1.0);
    set.samples(64);
    let (square, white) = (set.square(0.5), set.matte([1.0; 3]));
    let surface = set.surface(square, white);
    let group = set.client.object(t::GROUP, "");
    let list = set.client.objects(t::SURFACE, &[surface]);
    set.client.give(group, "surface", t::ARRAY1D, list);
    set.client.commit(group);
    let instance = set.client.object(t::INSTANCE, subtype);
    set.client.set_object(instance, "group", t::GROUP, group);
    edit(&set, instance);
    set.client.commit(instance);
    set.instance(instance);
    set.client.set_floats(set.camera, "shutter", t::FLOAT32_BOX1, &shutter);
    set.client.commit(set.camera);
    set
}

fn matrices(set: &Set, object: usize) {
    let list = set.client.floats(t::FLOAT32_MAT4, &[at(-1.0), at(1.0)].concat());
    set.client.give(object, "motion.transform", t::ARRAY1D, list);
}

/// Colours along the middle row of 8 pixels, each 0.25 wide, from x = -1 on.
fn row(set: &Set) -> Vec<f32> {
    let pixels = set.picture([8, 8]).floats();
    (0..8).map(|x| pixels[4 * (8 * 4 + x)]).collect()
}

#[test]
fn squares_cover_pixels_for_a_share_of_the_time() {
    for renderer in ["default", "ao"] {
        let set = moving(renderer, "motionTransform", [0.0, 1.0], matrices);
        let found = row(&set);
        // From -1.5 to -0.5 it goes to 0.5 to 1.5: a point at x is covered for half of the time less what lies outside.
        for (i, found) in found.iter().enumerate() {
            let x = (i as f32 + 0.5) / 4.0 - 1.0;
            let covered = 0.5 - (x.abs() - 0.5).max(0.0) / 2.0;
            assert!((found - covered).abs() < 0.05, "{renderer}: {found} at {x}, expected {covered}");
        }
        set.assert_quiet();
    }
}

#[test]
fn a_moment_is_sharp() {
    for (shutter, left) in [([0.5; 2], -0.5), ([0.25; 2], -1.0)] {
        let set = moving("ao", "motionTransform", shutter, matrices);
        let expected = (0..8).map(|i| (i as f32 + 0.5) / 4.0 - 1.0).map(|x| x > left && x < left + 1.0);
        let expected: Vec<f32> = expected.map(|inside| f32::from(u8::from(inside))).collect();
        assert_eq!(row(&set), expected, "at {shutter:?}");
    }
}

#[test]
fn scales_rotations_and_translations_are_applied_in_turn() {
    let parts = |set: &Set, object: usize| {
        let half = std::f32::consts::FRAC_1_SQRT_2;
        let scales = set.client.floats(t::FLOAT32_VEC3, &[1.0, 0.25, 1.0]);
        // A quarter turn around z.
        let rotations = set.client.floats(t::FLOAT32_QUAT_IJKW, &[0.0, 0.0, half, half]);
        let translations = set.client.floats(t::FLOAT32_VEC3, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
        set.client.give(object, "motion.scale", t::ARRAY1D, scales);
        set.client.give(object, "motion.rotation", t::ARRAY1D, rotations);
        set.client.give(object, "motion.translation", t::ARRAY1D, translations);
    };
    // Flat, then upright, a quarter wide; in the middle of the time half on its way.
    let set = moving("ao", "motionScaleRotationTranslation", [0.5; 2], parts);
    for (i, (found, expected)) in
        row(&set).into_iter().zip([0.0, 0.0, 0.0, 0.0, 0.0, 0.5, 0.5, 0.0]).enumerate()
    {
        assert!((found - expected).abs() < 0.15, "pixel {i}: {found}, expected {expected}");
    }
    set.assert_quiet();
}

#[test]
fn cameras_move() {
    for renderer in ["default", "ao"] {
        let set = moving(renderer, "transform", [0.0, 1.0], |_, _| ());
        matrices(&set, set.camera);
        set.client.commit(set.camera);
        let found = row(&set);
        assert_close(found.iter().sum::<f32>() / 8.0, 0.4375, 0.05, "as if it moved itself");
        assert!(found[0] < 0.35 && found[4] > 0.4, "{renderer}: {found:?}");
        set.assert_quiet();
    }
}

#[test]
fn a_shutter_that_closes_before_it_opens_is_an_error() {
    let set = moving("ao", "transform", [1.0, 0.0], |_, _| ());
    set.picture([4, 4]);
    let texts: Vec<_> = set.client.messages().into_iter().map(|message| message.text).collect();
    assert!(texts.iter().any(|text| text.contains("'shutter'")), "{texts:?}");
}

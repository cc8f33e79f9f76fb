// SPDX-License-Identifier: GPL-3.0-or-later
//! Motion while the shutter is open.

use crate::common::{read_with_files, world};

#[test]
fn shapes_instances_and_cameras_move() {
    let text = "LookAt 0 0 -5  0 0 0  0 1 0\nActiveTransform EndTime\nTranslate 0 0 -2\nActiveTransform All\n\
        Camera \"perspective\"\nWorldBegin\nAttributeBegin\nActiveTransform EndTime\nTranslate 4 0 0\nActiveTransform All\n\
        Shape \"sphere\"\nAttributeEnd\nObjectBegin \"o\"\nShape \"disk\"\nObjectEnd\nActiveTransform EndTime\nRotate 90 0 0 1\n\
        ActiveTransform All\nObjectInstance \"o\"\n";
    let (loaded, _folder) = read_with_files(text, &[]);
    let loaded = loaded.expect("a scene");
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let mut scene = loaded.scene;
    let locations = |scene: &gnurt_scene::Scene| -> Vec<[f64; 3]> {
        scene.instances().iter().map(|i| i.world_from_object.point([1.0, 0.0, 0.0])).collect()
    };
    let before = locations(&scene);
    let eye = scene.cameras()[0].eye;
    let _ = scene.pose(0, 0.5);
    let after = locations(&scene);
    assert!(
        (after[0][0] - before[0][0]).abs() > 1.99 && (after[0][0] - before[0][0]).abs() < 2.01,
        "{before:?} {after:?}"
    );
    let turned = after[1];
    let half = std::f64::consts::FRAC_1_SQRT_2;
    assert!((turned[0].abs() - half).abs() < 1e-6 && (turned[1].abs() - half).abs() < 1e-6, "{turned:?}");
    // The world comes nearer by 2, so the camera goes ahead by 2; half of it is done.
    let moved = scene.cameras()[0].eye[2] - eye[2];
    assert!((moved - 1.0).abs() < 1e-5, "{moved}");
}

#[test]
fn what_stands_still_has_no_animation() {
    assert!(world("Shape \"disk\"").scene.animation().is_none());
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Cameras: angles of view, and that what is on the right stays there.

use gnurt_scene::{Camera, Projection, Scene};

use crate::common::read_with_files;

fn scene(text: &str) -> Scene {
    let (loaded, _folder) = read_with_files(text, &[]);
    loaded.unwrap_or_else(|error| panic!("{error}")).scene
}

/// Where a place of the file's world lies from the camera: to the right, above, ahead.
fn seen(scene: &Scene, at: [f64; 3]) -> [f32; 3] {
    let camera: &Camera = &scene.cameras()[0];
    let frame = camera.frame().expect("a view");
    // The disk's middle is there.
    let location = scene.instances()[0].world_from_object.point(at);
    let from = [0, 1, 2].map(|k| location[k] as f32 - camera.eye[k]);
    let along = |axis: [f32; 3]| (0..3).map(|k| axis[k] * from[k]).sum::<f32>();
    [along(frame.right), along(frame.up), along(frame.forward)]
}

#[test]
fn right_is_right() {
    for (before, expected) in [
        ("", [1.0, 2.0, 7.0]),
        ("Scale -1 1 1\n", [-1.0, 2.0, 7.0]),
        ("LookAt 0 0 -3  0 0 0  0 1 0\n", [1.0, 2.0, 10.0]),
        ("Scale -1 1 1\nLookAt 0 0 10  0 0 0  0 1 0\n", [1.0, 2.0, 3.0]),
    ] {
        let scene = scene(&format!("{before}Camera \"perspective\"\nWorldBegin\nShape \"disk\"\n"));
        let found = seen(&scene, [1.0, 2.0, 7.0]);
        assert!((0..3).all(|k| (found[k] - expected[k]).abs() < 1e-5), "{before}: {found:?}");
    }
}

#[test]
fn angles_are_those_of_the_shorter_side() {
    let fov = |film: [i32; 2], more: &str| {
        let text = format!(
            "Film \"rgb\" \"integer xresolution\" {} \"integer yresolution\" {}\nCamera \"perspective\" \"float fov\" 60 {more}\n\
             WorldBegin\nShape \"disk\"\n",
            film[0], film[1]
        );
        scene(&text).cameras()[0].fov_y
    };
    assert!((fov([300, 200], "") - 60.0).abs() < 1e-3, "wide: the height");
    let tall = 2.0 * (2.0 * 30.0_f32.to_radians().tan()).atan().to_degrees();
    assert!((fov([100, 200], "") - tall).abs() < 1e-3, "tall: the width");
    let part = 2.0 * (0.5 * 30.0_f32.to_radians().tan()).atan().to_degrees();
    assert!((fov([200, 200], "\"float screenwindow\" [ -.5 .5 -.5 .5 ]") - part).abs() < 1e-3, "a window");
}

#[test]
fn other_cameras() {
    let camera = |text: &str| {
        let scene = scene(&format!("{text}\nWorldBegin\nShape \"disk\"\n"));
        let has_shader = scene.camera_file(gnurt_scene::CameraId(0)).is_some();
        (scene.cameras()[0].clone(), has_shader)
    };
    let (parallel, _) = camera("Scale .5 .5 .5\nCamera \"orthographic\"");
    assert_eq!(parallel.projection, Projection::Orthographic { height: 4.0 });
    assert!(camera("Camera \"spherical\"").1, "equal areas are a shader");
    assert_eq!(
        camera("Camera \"spherical\" \"string mapping\" \"equirectangular\"").0.projection,
        Projection::Panorama
    );
    assert!(camera("Camera \"perspective\" \"float screenwindow\" [ 0 1 0 1 ]").1, "a window aside");
    let (lens, _) = camera("Camera \"perspective\" \"float lensradius\" .1 \"float focaldistance\" 5");
    assert_eq!((lens.lens.aperture, lens.lens.focus), (0.2, Some(5.0)));
}

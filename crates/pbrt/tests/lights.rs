// SPDX-License-Identifier: GPL-3.0-or-later
//! Lights: units and colours by closed forms.

use gnurt_scene::Light;

use crate::common::{read_with_files, world};

#[track_caller]
fn near(found: [f32; 3], expected: [f32; 3]) {
    let close = (0..3).all(|k| (found[k] - expected[k]).abs() <= 2e-3 * expected[k].abs().max(1e-3));
    assert!(close, "{found:?} instead of {expected:?}");
}

fn intensity(text: &str) -> [f32; 3] {
    let loaded = world(&format!("{text}\nShape \"disk\""));
    match loaded.scene.lights() {
        [Light::Point { intensity, .. } | Light::Spot { intensity, .. }] => *intensity,
        [Light::Directional { irradiance, .. }] => *irradiance,
        [Light::Environment { radiance, .. }] => *radiance,
        other => panic!("{other:?}"),
    }
}

fn luminance([r, g, b]: [f32; 3]) -> f32 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

#[test]
fn scales_are_those_of_pbrt() {
    near(intensity("LightSource \"point\" \"rgb I\" [ 1 2 3 ] \"float scale\" 2"), [2.0, 4.0, 6.0]);
    near(intensity("LightSource \"point\""), [1.0; 3]);
    let spectrum = intensity("LightSource \"point\" \"spectrum I\" [ 300 7 800 7 ] \"float scale\" 3");
    assert!((luminance(spectrum) - 3.0).abs() < 0.01, "numbers of a spectrum do not count: {spectrum:?}");
    let warm = intensity("LightSource \"infinite\" \"blackbody L\" 3000 \"float scale\" 5");
    assert!((luminance(warm) - 5.0).abs() < 0.02 && warm[0] > 2.0 * warm[2], "{warm:?}");
    let pi = std::f32::consts::PI;
    near(intensity("LightSource \"point\" \"float power\" 10"), [10.0 / (4.0 * pi); 3]);
    near(intensity("LightSource \"distant\" \"float illuminance\" 7"), [7.0; 3]);
    near(intensity("LightSource \"infinite\" \"float illuminance\" 7"), [7.0 / pi; 3]);
    let (start, end) = (25.0_f32.to_radians().cos(), 30.0_f32.to_radians().cos());
    let unit = 2.0 * pi * ((1.0 - start) + (start - end) / 2.0);
    near(intensity("LightSource \"spot\" \"float power\" 10"), [10.0 / unit; 3]);
}

#[test]
fn spots_fade_as_in_pbrt() {
    let (loaded, _folder) = read_with_files("WorldBegin\nLightSource \"spot\"\nShape \"disk\"\n", &[]);
    let scene = loaded.expect("a scene").scene;
    let [Light::Spot { inner_angle, outer_angle, edge, .. }] = scene.lights() else { panic!("a spot") };
    near([*inner_angle, *outer_angle, 0.0].map(f32::to_degrees), [25.0, 30.0, 0.0]);
    assert_eq!(*edge, gnurt_scene::ConeEdge::Smooth);
}

#[test]
fn the_film_scales_all_light() {
    let text = "Camera \"perspective\" \"float shutterclose\" 0.5\nFilm \"rgb\" \"float iso\" 400\nWorldBegin\n\
        LightSource \"point\"\nShape \"disk\"\n";
    let (loaded, _folder) = read_with_files(text, &[]);
    let scene = loaded.expect("a scene").scene;
    let [Light::Point { intensity, .. }] = scene.lights() else { panic!("a point") };
    near(*intensity, [2.0; 3]);
}

#[test]
fn area_lights_shine_by_their_area() {
    let pi = std::f32::consts::PI;
    let emission = |text: &str| {
        let loaded = world(text);
        let material = loaded.scene.meshes()[0].material;
        loaded.scene.material(material).emission
    };
    let square = "Shape \"bilinearmesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 1 1 0 ]";
    near(emission(&format!("AreaLightSource \"diffuse\" \"rgb L\" [ 1 2 3 ]\n{square}")), [1.0, 2.0, 3.0]);
    let power = format!("Scale 2 2 2\nAreaLightSource \"diffuse\" \"float power\" 8\n{square}");
    near(emission(&power), [8.0 / (4.0 * pi); 3]);
    let both = format!("AreaLightSource \"diffuse\" \"bool twosided\" true\n{square}");
    let loaded = world(&both);
    let (_, shader) = loaded.scene.shader_files().next().expect("a shader shines to both sides");
    assert!(shader.text.as_ref().is_some_and(|text| text.contains("emission ()")), "{shader:?}");
}

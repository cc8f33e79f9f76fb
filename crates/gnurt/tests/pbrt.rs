// SPDX-License-Identifier: GPL-3.0-or-later
//! Scenes of pbrt-v4 from the file to light: their shaders compile without a word, and reflect the values of closed forms.
#![cfg(feature = "pbrt")]

use std::path::Path;

use gnurt::render::{
    CommitOptions, Integrator, RenderOptions, SceneCamera, ShaderTable, Silent, World, render,
};

/// The mean radiance of a picture that the statements' shapes fill, and the reports of shaders.
fn mean(folder: &Path, statements: &str) -> ([f32; 3], Vec<String>) {
    let path = folder.join("t.pbrt");
    let view = "Camera \"orthographic\" \"float screenwindow\" [ -.5 .5 -.5 .5 ]\nFilm \"rgb\" \"integer xresolution\" 8 \
                \"integer yresolution\" 8\nWorldBegin\nLightSource \"infinite\" \"rgb L\" [ 1 1 1 ]\nTranslate 0 0 5\n";
    std::fs::write(&path, format!("{view}{statements}")).expect("a file");
    let mut scene = gnurt::load_scene(&path).unwrap_or_else(|e| panic!("{e}")).scene;
    let mut table = ShaderTable::default();
    let space = gnurt::image::WorkingSpace::Rec709;
    let reported = gnurt::put_named_shaders(&mut scene, &mut table, space).reported;
    let pool = gnurt::thread_pool(0).expect("threads");
    let mut world = World::new();
    world.commit(&scene, &table, &CommitOptions::default(), &pool).expect("a world");
    let camera = SceneCamera::new(&scene.cameras()[0]).expect("a view");
    let options = RenderOptions {
        width: 8,
        height: 8,
        spp: 256,
        integrator: Integrator::Path,
        ..RenderOptions::default()
    };
    let picture = render(&world, &camera, &options, &pool, &Silent).expect("a picture").picture;
    let count = picture.color.len() as f32;
    let sum = |k: usize| picture.color.iter().map(|pixel| pixel[k]).sum::<f32>() / count;
    ([sum(0), sum(1), sum(2)], reported)
}

const SQUARE: &str = "Shape \"bilinearmesh\" \"point3 P\" [ -4 -4 0 4 -4 0 -4 4 0 4 4 0 ]\n";

#[test]
fn all_kinds_compile_without_a_word() {
    let folder = tempfile::tempdir().expect("a folder");
    let spectra = [
        "bilerp\" \"rgb v00\" [ 1 0 0 ]",
        "checkerboard\" \"string mapping\" \"spherical\"",
        "checkerboard\" \"integer dimension\" 3",
        "dots\" \"string mapping\" \"planar\"",
        "directionmix\" \"rgb tex1\" [ 1 0 0 ]",
        "mix\" \"rgb tex1\" [ 1 0 0 ] \"float amount\" .25",
        "scale\" \"float scale\" .5",
        "marble\"",
        "wrinkled\"",
        "windy\"",
        "fbm\"",
        "checkerboard\" \"string mapping\" \"cylindrical\"",
    ];
    let materials = [
        "coateddiffuse\" \"texture reflectance\" \"s\" \"float roughness\" .1",
        "conductor\" \"texture reflectance\" \"s\" \"texture roughness\" \"f\"",
        "conductor\" \"float uroughness\" .1 \"float vroughness\" .3",
        "coatedconductor\" \"float conductor.roughness\" .2",
        "dielectric\" \"texture roughness\" \"f\"",
        "dielectric\" \"float roughness\" .2",
        "diffusetransmission\" \"texture transmittance\" \"s\"",
        "diffuse\" \"texture reflectance\" \"s\" \"texture displacement\" \"f\"",
        "thindielectric\" \"texture displacement\" \"f\"",
    ];
    for (i, spectrum) in spectra.iter().enumerate() {
        let material = materials[i % materials.len()];
        let text = format!(
            "Texture \"f\" \"float\" \"fbm\"\nTexture \"s\" \"spectrum\" \"{spectrum}\nMaterial \"{material}\n\
             AreaLightSource \"diffuse\" \"bool twosided\" true\n{SQUARE}"
        );
        let ([r, g, b], reported) = mean(folder.path(), &text);
        assert_eq!(reported, Vec::<String>::new(), "{text}");
        // It shines with 1 and is lit by 1.
        assert!([r, g, b].iter().all(|x| *x > 0.9 && *x < 2.2), "{text}: {r} {g} {b}");
    }
}

#[test]
fn light_is_what_closed_forms_say() {
    let folder = tempfile::tempdir().expect("a folder");
    // Shares of light that a coat of index 1.5 mirrors: seen from the front, and diffuse light from within.
    let (fresnel, inner) = (0.04, 1.0 - (1.0 - 0.0918) / 2.25);
    let coated = |r: f32| fresnel + (1.0 - fresnel) * (1.0 - inner) * r / (1.0 - r * inner);
    let cases = [
        ("Material \"diffuse\" \"rgb reflectance\" [ .2 .4 .6 ]", [0.2, 0.4, 0.6]),
        (
            "Material \"diffusetransmission\" \"rgb reflectance\" [ .1 .2 .3 ] \"rgb transmittance\" [ .1 .2 .3 ]",
            [0.2, 0.4, 0.6],
        ),
        (
            "Material \"coateddiffuse\" \"rgb reflectance\" [ .2 .4 .6 ]",
            [coated(0.2), coated(0.4), coated(0.6)],
        ),
        ("Material \"conductor\" \"rgb reflectance\" [ .2 .4 .6 ]", [0.2, 0.4, 0.6]),
        ("Material \"thindielectric\"", [1.0; 3]),
        (
            "MakeNamedMaterial \"a\" \"string type\" \"diffuse\" \"rgb reflectance\" [ 1 0 0 ]\n\
             MakeNamedMaterial \"b\" \"string type\" \"diffuse\" \"rgb reflectance\" [ 0 1 0 ]\n\
             MakeNamedMaterial \"m\" \"string type\" \"mix\" \"string materials\" [ \"a\" \"b\" ] \"float amount\" .25\n\
             NamedMaterial \"m\"",
            [0.75, 0.25, 0.0],
        ),
    ];
    for (material, expected) in cases {
        let (found, reported) = mean(folder.path(), &format!("{material}\n{SQUARE}"));
        assert!(reported.is_empty(), "{reported:?}");
        let near = (0..3).all(|k| (found[k] - expected[k]).abs() < 0.01);
        assert!(near, "{material}: {found:?} instead of {expected:?}");
    }
}

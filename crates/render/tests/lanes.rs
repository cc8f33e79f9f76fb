// SPDX-License-Identifier: GPL-3.0-or-later
//! Paths that take steps one by one, as on CPUs with narrow registers, against paths that take them side by side: the same bits, for
//! every kind of surface and light.

use std::sync::Arc;

use crate::common::*;
use gnurt_image::{TexelData, Texels};
use gnurt_render::{
    Accumulation, CommitOptions, Integrator, RenderOptions, SceneCamera, ShaderTable, Silent, World, render,
};
use gnurt_scene::detail::{Anisotropy, DiffuseTransmission, Interior, Iridescence};
use gnurt_scene::material::{Alpha, Color, Opacity, OpacityChannel, Principled, TextureRef};
use gnurt_scene::texture::{Filter, Wrap};
use gnurt_scene::{Affine, Light, Material, MaterialId, Scene, Surface, Texture};
use gnurt_simd::Level;

/// The light in the room.
#[derive(Clone, Copy, PartialEq)]
enum Lit {
    /// Lights that no scattered ray meets.
    Points,
    /// A few lamps.
    Emitters,
    /// Many lamps, one of them a picture, and the sky.
    All,
}

/// A room of many things, of many materials.
fn scratch(lit: Lit) -> (World, SceneCamera) {
    let mut scene = Scene::new();
    let texel = |i: usize| [0.2 + 0.15 * (i % 5) as f32, 0.9 - 0.2 * (i % 4) as f32, 0.5, 1.0];
    let texels =
        Arc::new(Texels { width: 6, height: 5, data: TexelData::Float((0..30).map(texel).collect()) });
    let picture = scene.add_texture(Texture {
        name: String::new(),
        texels: texels.clone(),
        wrap: [Wrap::Repeat; 2],
        filter: Filter::Linear,
    });
    let material = |scene: &mut Scene, factor: [f32; 3], textured: bool, emission: [f32; 3]| -> MaterialId {
        let texture = textured.then(|| TextureRef::new(picture));
        let surface = Surface::Matte { base_color: Color { factor, texture } };
        let emission_texture = texture.filter(|_| emission != [0.0; 3]);
        scene.add_material(Material { emission, emission_texture, ..Material::of("", surface) })
    };
    let dark = [0.0; 3];
    let ground = material(&mut scene, [0.7, 0.6, 0.5], true, dark);
    put_mesh(&mut scene, quad([-5.0, -5.0, 0.0], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0], ground));
    let wall = material(&mut scene, [0.8; 3], false, dark);
    put_mesh(&mut scene, quad([-5.0, 5.0, 0.0], [10.0, 0.0, 0.0], [0.0, 0.0, 6.0], wall));
    // One object in many places, turned, stretched and mirrored.
    let red = material(&mut scene, [0.9, 0.2, 0.1], false, dark);
    let sides = [
        quad([0.0; 3], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], red),
        quad([0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], red),
        quad([0.0; 3], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0], ground),
        quad([1.0; 3], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], wall),
        quad([1.0; 3], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0], red),
    ];
    let meshes = sides.map(|side| scene.add_mesh(side));
    let thing = scene.add_object_of("", meshes.to_vec());
    for i in 0..12 {
        let x = f64::from(i);
        let stretch = [0.6 + 0.1 * x, 0.8, if i % 3 == 0 { -0.7 } else { 0.9 }];
        let at = [(x * 2.3) % 7.0 - 3.5, (x * 1.7) % 6.0 - 2.0, 0.2 * x];
        let turned = Affine::rotation([0.3, 0.2 * x, 1.0], x) * Affine::scale(stretch);
        scene.instantiate(thing, Affine::translation(at) * turned);
    }
    put_mesh(&mut scene, sphere([2.0, -2.0, 0.8], 0.8, 8, wall));
    let (base_color, tint) = (Color { factor: [0.8, 0.5, 0.3], texture: None }, [0.9, 0.8, 0.7]);
    let coated = Principled {
        base_color,
        metallic: 0.4,
        roughness: 0.5,
        clearcoat: 0.7,
        sheen_color: [0.3, 0.1, 0.2],
        sheen_roughness: 0.5,
        transmission: 0.3,
        ..Principled::default()
    };
    let plastic = Principled { base_color, roughness: 0.4, ..Principled::default() };
    let rough_glass = |thin| Surface::RoughDielectric {
        ior: 1.5,
        roughness: 0.4,
        reflectance: [1.0; 3],
        transmittance: tint,
        thin,
        interior: Default::default(),
    };
    let rare = Principled {
        metallic: 0.3,
        anisotropy: Anisotropy { strength: 0.8, rotation: 0.4, texture: None },
        iridescence: Iridescence { factor: 0.6, ior: 1.4, thickness: 350.0, ..Iridescence::default() },
        diffuse_transmission: DiffuseTransmission { factor: 0.5, color: tint },
        ..plastic.clone()
    };
    let interior = Interior {
        attenuation_color: [0.8, 0.5, 0.3],
        attenuation_distance: 0.5,
        dispersion: 2.0,
        ..Interior::default()
    };
    let surfaces = [
        Surface::Dielectric {
            ior: 1.5,
            reflectance: [1.0; 3],
            transmittance: tint,
            interior: Default::default(),
        },
        Surface::Mirror { reflectance: base_color },
        Surface::RoughMatte { base_color, roughness: 0.7 },
        Surface::Metal { eta: [0.2, 0.9, 1.1], k: [3.9, 2.4, 2.2], roughness: 0.5 },
        Surface::Principled(Box::new(plastic)),
        Surface::Principled(Box::new(coated)),
        rough_glass(false),
        rough_glass(true),
        Surface::Principled(Box::new(rare)),
        Surface::Dielectric { ior: 1.5, reflectance: [1.0; 3], transmittance: tint, interior },
    ];
    for (i, surface) in surfaces.into_iter().enumerate() {
        let mut made = Material::of("", surface);
        if i % 4 == 3 {
            let opacity = Opacity { factor: 0.7, texture: None, channel: OpacityChannel::Alpha };
            made.alpha = Alpha::Blend { opacity };
        }
        let made = scene.add_material(made);
        let at = [i as f32 * 1.1 - 4.0, -2.5 + 0.5 * (i % 3) as f32, 0.6];
        put_mesh(&mut scene, sphere(at, 0.55, 8, made));
    }
    if lit == Lit::Points {
        for i in 0..11 {
            let position = [i as f32 - 5.0, -3.0, 1.0 + 0.4 * i as f32];
            scene.add_light(Light::Point { position, intensity: [3.0, 2.0, 1.0], radius: 0.0 });
        }
        scene.add_light(Light::Directional { direction: [0.3, 0.4, -1.0], irradiance: [0.5; 3], angle: 0.0 });
    } else {
        let area_light = material(&mut scene, [0.1; 3], false, [9.0, 8.0, 7.0]);
        put_mesh(&mut scene, quad([-1.0, -1.0, 6.0], [0.0, 2.0, 0.0], [2.0, 0.0, 0.0], area_light));
    }
    if lit == Lit::All {
        let screen = material(&mut scene, [0.5; 3], true, [4.0; 3]);
        for i in 0..40 {
            let at = [(i % 8) as f32 - 4.0, (i / 8) as f32 - 2.0, 4.0 + 0.1 * (i % 7) as f32];
            put_mesh(&mut scene, quad(at, [0.0, 0.3, 0.1], [0.4, 0.0, 0.0], screen));
        }
        scene.add_light(environment([0.2, 0.3, 0.4]));
    }
    let mut world = World::new();
    world
        .commit(&scene, &ShaderTable::default(), &CommitOptions::default(), &pool(2))
        .expect("the scene is sound");
    (world, camera([0.5, -8.0, 3.5], [0.0, 0.0, 1.5], 45.0))
}

fn by_paths(max_depth: u32, spp: u32) -> RenderOptions {
    RenderOptions { integrator: Integrator::Path, max_depth, ..options(53, 39, spp) }
}

#[test]
fn how_many_at_once_does_not_matter() {
    for (lit, max_depth) in [(Lit::Emitters, 2), (Lit::Points, 7), (Lit::All, 9)] {
        let (world, camera) = scratch(lit);
        let options = RenderOptions { clamp: Some(20.0), ..by_paths(max_depth, 4) };
        let of = |level| {
            let options = RenderOptions { level, ..options.clone() };
            render(&world, &camera, &options, &pool(2), &Silent).expect("sound options").picture.color
        };
        let levels = Level::available();
        let one = of(levels[0]);
        let lit_pixels = one.iter().filter(|pixel| pixel[0] > 0.0).count();
        assert!(lit_pixels > 1000, "there is light: {lit_pixels} pixels");
        for &level in &levels[1..] {
            assert!(one == of(level), "{max_depth} edges: {level} gives other bits than {}", levels[0]);
        }
    }
}

#[test]
fn threads_do_not_matter() {
    let options = by_paths(9, 3);
    let (world, camera) = scratch(Lit::All);
    let of = |options: &RenderOptions, threads| {
        render(&world, &camera, options, &pool(threads), &Silent).expect("sound options").picture.color
    };
    let one = of(&options, 1);
    assert!(one == of(&options, 7), "seven threads give other bits");
}

#[test]
fn batches_do_not_matter() {
    let options = RenderOptions { aovs: true, ..by_paths(6, 21) };
    let (world, camera) = scratch(Lit::All);
    let at_once = render(&world, &camera, &options, &pool(2), &Silent).expect("sound options").picture;
    for samples in [1, 5] {
        let mut measured = Accumulation::new(options.clone()).expect("sound options");
        while !measured.is_complete() {
            measured.pass(&world, &camera, samples, &pool(2), &Silent);
        }
        let other = measured.picture();
        assert!(at_once.color == other.color, "passes of {samples} give other bits");
        assert!(at_once.layers == other.layers, "passes of {samples} give other layers");
    }
}

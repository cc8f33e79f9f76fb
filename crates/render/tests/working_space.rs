// SPDX-License-Identifier: GPL-3.0-or-later
//! Light in ACEScg: products of colours against their closed form, and the conversion of every kind of light.
//! A convex surface of albedo `a` under radiance `e` from everywhere shows `M⁻¹ (M a · M e)`.

use std::sync::Arc;

use crate::common::*;
use gnurt_image::{WorkingSpace, convert};
use gnurt_render::{CommitOptions, Integrator, RenderOptions, ShaderTable, Silent, World, render};
use gnurt_scene::material::{Color, TextureRef};
use gnurt_scene::texture::{Filter, TexelData, Texels, Texture, Wrap};
use gnurt_scene::{Affine, Light, MaterialId, MeshId, Scene, Surface};

const ALBEDO: [f32; 3] = [0.8, 0.2, 0.1];
const LIGHT: [f32; 3] = [0.2, 1.0, 3.0];

/// Mean colour of a small picture of the floor, in Rec. 709.
fn seen(scene: &Scene, space: WorkingSpace) -> [f64; 3] {
    let pool = pool(2);
    let mut world = World::new();
    let how = CommitOptions { space, ..CommitOptions::default() };
    world.commit(scene, &ShaderTable::default(), &how, &pool).expect("a scene");
    let options = RenderOptions {
        width: 8,
        height: 8,
        spp: 64,
        integrator: Integrator::Path,
        ..RenderOptions::default()
    };
    let camera = camera([0.1, 0.1, 5.0], [0.1, 0.1, 0.0], 1.0);
    let mut frame = render(&world, &camera, &options, &pool, &Silent).expect("a picture");
    frame.picture.convert_from(world.space());
    let sum = |k: usize| frame.picture.color.iter().map(|pixel| f64::from(pixel[k])).sum::<f64>() / 64.0;
    [sum(0), sum(1), sum(2)]
}

fn product(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] * b[0], a[1] * b[1], a[2] * b[2]]
}

/// The closed form.
fn expected(albedo: [f32; 3], light: [f32; 3]) -> [f32; 3] {
    let [there, back] = [WorkingSpace::AcesCg.from_rec709(), WorkingSpace::AcesCg.to_rec709()];
    let (there, back) = (there.expect("a matrix"), back.expect("a matrix"));
    convert(&back, product(convert(&there, albedo), convert(&there, light)))
}

#[track_caller]
fn assert_near(found: [f64; 3], expected: [f32; 3], what: &str) {
    for (a, b) in found.into_iter().zip(expected) {
        assert!(
            (a - f64::from(b)).abs() < 2e-3 + 5e-3 * f64::from(b).abs(),
            "{what}: {found:?}, {expected:?}"
        );
    }
}

fn texture(scene: &mut Scene, texel: [f32; 3]) -> gnurt_scene::TextureId {
    let [r, g, b] = texel;
    let data = TexelData::Float(vec![[r, g, b, 1.0]; 4]);
    let texels = Arc::new(Texels { width: 2, height: 2, data });
    let wrap = [Wrap::Repeat; 2];
    scene.add_texture(Texture { name: String::new(), texels, wrap, filter: Filter::Linear })
}

fn room(albedo: Color, light: Light) -> Scene {
    let mut scene = floor(0.5, 5.0);
    scene.edit_material(MaterialId(0)).surface = Surface::Matte { base_color: albedo };
    scene.add_light(light);
    scene
}

fn sky(radiance: [f32; 3]) -> Light {
    Light::Environment { radiance, texture: None, world_from_light: Affine::IDENTITY }
}

#[test]
fn products_are_those_of_the_working_space() {
    let scene = room(Color::constant(ALBEDO), sky(LIGHT));
    assert_near(seen(&scene, WorkingSpace::Rec709), product(ALBEDO, LIGHT), "Rec. 709");
    let acescg = expected(ALBEDO, LIGHT);
    assert_near(seen(&scene, WorkingSpace::AcesCg), acescg, "ACEScg");
    let apart =
        product(ALBEDO, LIGHT).into_iter().zip(acescg).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(apart > 0.1, "the spaces differ: {apart}");
}

/// White light shows a colour as it is described, whatever the space.
#[test]
fn white_light_changes_nothing() {
    let scene = room(Color::constant(ALBEDO), sky([1.0; 3]));
    assert_near(seen(&scene, WorkingSpace::AcesCg), ALBEDO, "white light");
}

/// Factor, texture and colours of vertices are multiplied in Rec. 709, as formats define them.
#[test]
fn factors_and_textures_are_multiplied_first() {
    let mut scene = room(Color::constant([1.0; 3]), sky(LIGHT));
    let texture = texture(&mut scene, [0.9, 0.4, 0.6]);
    let base_color = Color { factor: [0.9, 0.8, 0.3], texture: Some(TextureRef::new(texture)) };
    scene.edit_material(MaterialId(0)).surface = Surface::Matte { base_color };
    scene.edit_mesh(MeshId(0)).colors = vec![[0.5, 1.0, 0.7, 1.0]; 4];
    let albedo = product(product([0.9, 0.4, 0.6], [0.9, 0.8, 0.3]), [0.5, 1.0, 0.7]);
    assert_near(seen(&scene, WorkingSpace::AcesCg), expected(albedo, LIGHT), "textures");
}

#[test]
fn all_lights_are_converted() {
    let pi = std::f32::consts::PI;
    let down = [0.0, 0.0, -1.0];
    let directional = Light::Directional { direction: down, irradiance: LIGHT.map(|x| x * pi), angle: 0.0 };
    let height = 50.0;
    let position = [0.1, 0.1, height];
    let intensity = LIGHT.map(|x| x * pi * height * height);
    let point = Light::Point { position, intensity, radius: 0.0 };
    let spot = Light::Spot {
        position,
        direction: down,
        intensity,
        inner_angle: 0.4,
        outer_angle: 0.5,
        edge: gnurt_scene::ConeEdge::default(),
        radius: 0.0,
    };
    for light in [directional, point, spot] {
        let name = format!("{light:?}");
        let scene = room(Color::constant(ALBEDO), light);
        assert_near(seen(&scene, WorkingSpace::AcesCg), expected(ALBEDO, LIGHT), &name);
    }
    let mut scene = room(Color::constant(ALBEDO), sky([1.0; 3]));
    let picture = texture(&mut scene, LIGHT.map(|x| x / 2.0));
    let mut scene = {
        let mut other = floor(0.5, 5.0);
        other.edit_material(MaterialId(0)).surface = scene.material(MaterialId(0)).surface.clone();
        let picture = scene.texture(picture).clone();
        let texture = Some(other.add_texture(picture));
        other.add_light(Light::Environment {
            radiance: [2.0; 3],
            texture,
            world_from_light: Affine::IDENTITY,
        });
        other
    };
    assert_near(seen(&scene, WorkingSpace::AcesCg), expected(ALBEDO, LIGHT), "a picture around");
    // A surface that shines is seen in its own colour.
    scene.edit_material(MaterialId(0)).surface = Surface::Matte { base_color: Color::constant([0.0; 3]) };
    scene.edit_material(MaterialId(0)).emission = LIGHT;
    assert_near(seen(&scene, WorkingSpace::AcesCg), LIGHT, "emission");
    let texture = texture(&mut scene, [0.5, 0.25, 1.0]);
    scene.edit_material(MaterialId(0)).emission_texture = Some(TextureRef::new(texture));
    assert_near(seen(&scene, WorkingSpace::AcesCg), product(LIGHT, [0.5, 0.25, 1.0]), "its texture");
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! The lanes of the path tracer against its way by shaders: the same scene, with Lambert's reflectors that say what they
//! are and with such that keep it to themselves. Source: original.

mod common;

use std::sync::Arc;

use common::*;
use glam::Vec3;
use gnurt_image::{Picture, TexelData, Texels};
use gnurt_render::{
    Accumulation, CommitOptions, Integrator, PerspectiveCamera, RenderOptions, ShaderTable, Silent, World,
    render,
};
use gnurt_scene::material::{Color, TextureRef};
use gnurt_scene::texture::{Filter, Wrap};
use gnurt_scene::{Affine, Light, Material, MaterialId, Scene, Surface, Texture};
use gnurt_shading::bsdf::Scattering;
use gnurt_shading::materials::{Matte, TexturedColor};
use gnurt_shading::texture::TextureSampler;
use gnurt_shading::{SurfaceBatch, SurfaceShader, Tracer, Vec3s};
use gnurt_simd::Level;

/// A reflector that does not say that it is Lambert's.
struct Secret(Matte);

impl SurfaceShader for Secret {
    fn shade(&self, tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        self.0.shade(tracer, hits, out);
    }

    fn scatter(&self, hits: &SurfaceBatch, out: &mut Vec<Scattering>) -> bool {
        self.0.scatter(hits, out)
    }
}

/// What shines in the room.
#[derive(Clone, Copy, PartialEq)]
enum Lit {
    /// Lights that no scattered ray meets.
    Points,
    /// A few lamps.
    Lamps,
    /// Many lamps, one of them a picture, and the sky.
    All,
}

/// A room of many things, and its shaders if it is `secret`.
fn room(lit: Lit, secret: bool) -> (World, PerspectiveCamera) {
    let (mut scene, mut shaders) = (Scene::new(), ShaderTable::default());
    let texel = |i: usize| [0.2 + 0.15 * (i % 5) as f32, 0.9 - 0.2 * (i % 4) as f32, 0.5, 1.0];
    let texels =
        Arc::new(Texels { width: 6, height: 5, data: TexelData::Float((0..30).map(texel).collect()) });
    let picture = scene.add_texture(Texture {
        name: String::new(),
        texels: texels.clone(),
        wrap: [Wrap::Repeat; 2],
        filter: Filter::Linear,
    });
    let mut material =
        |scene: &mut Scene, factor: [f32; 3], textured: bool, emission: [f32; 3]| -> MaterialId {
            let texture = textured.then(|| TextureRef::new(picture));
            let surface = if secret {
                let texture = textured.then(|| TextureSampler::new(texels.clone()));
                let albedo = TexturedColor { factor: Vec3::from(factor), texture };
                shaders.surfaces.push(Arc::new(Secret(Matte { albedo })));
                Surface::Shader(shaders.surfaces.len() as u32 - 1)
            } else {
                Surface::Matte { base_color: Color { factor, texture } }
            };
            let emission_texture = texture.filter(|_| emission != [0.0; 3]);
            scene.add_material(Material { emission, emission_texture, ..Material::of("", surface) })
        };
    let dark = [0.0; 3];
    let ground = material(&mut scene, [0.7, 0.6, 0.5], true, dark);
    place(&mut scene, quad([-5.0, -5.0, 0.0], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0], ground));
    let wall = material(&mut scene, [0.8; 3], false, dark);
    place(&mut scene, quad([-5.0, 5.0, 0.0], [10.0, 0.0, 0.0], [0.0, 0.0, 6.0], wall));
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
    // Smooth normals and glass go by shaders in any case.
    place(&mut scene, sphere([2.0, -2.0, 0.8], 0.8, 8, wall));
    let glass = Surface::Dielectric { ior: 1.5, reflectance: [1.0; 3], transmittance: [0.9; 3] };
    let glass = scene.add_material(Material::of("", glass));
    place(&mut scene, sphere([-1.5, -2.5, 0.6], 0.6, 8, glass));
    if lit == Lit::Points {
        for i in 0..11 {
            let position = [i as f32 - 5.0, -3.0, 1.0 + 0.4 * i as f32];
            scene.add_light(Light::Point { position, intensity: [3.0, 2.0, 1.0] });
        }
        scene.add_light(Light::Directional { direction: [0.3, 0.4, -1.0], irradiance: [0.5; 3] });
    } else {
        let lamp = material(&mut scene, [0.1; 3], false, [9.0, 8.0, 7.0]);
        place(&mut scene, quad([-1.0, -1.0, 6.0], [0.0, 2.0, 0.0], [2.0, 0.0, 0.0], lamp));
    }
    if lit == Lit::All {
        let screen = material(&mut scene, [0.5; 3], true, [4.0; 3]);
        for i in 0..40 {
            let at = [(i % 8) as f32 - 4.0, (i / 8) as f32 - 2.0, 4.0 + 0.1 * (i % 7) as f32];
            place(&mut scene, quad(at, [0.0, 0.3, 0.1], [0.4, 0.0, 0.0], screen));
        }
        scene.add_light(environment([0.2, 0.3, 0.4]));
    }
    let mut world = World::new();
    world.commit(&scene, &shaders, &CommitOptions::default(), &pool(2)).expect("the scene is sound");
    (world, camera([0.5, -8.0, 3.5], [0.0, 0.0, 1.5], 45.0))
}

fn picture(lit: Lit, secret: bool, options: &RenderOptions) -> Picture {
    let (world, camera) = room(lit, secret);
    render(&world, &camera, options, &pool(2), &Silent).expect("sound options").picture
}

fn by_paths(max_depth: u32, spp: u32) -> RenderOptions {
    RenderOptions { integrator: Integrator::Path, max_depth, ..options(53, 39, spp) }
}

#[test]
fn points_lights_and_shadows_are_the_same_bits() {
    // Scattered rays find nothing: all light comes by samples of lights, at points that cameras see.
    let [lanes, shaders] = [false, true].map(|secret| picture(Lit::Points, secret, &by_paths(2, 4)));
    assert!(lanes.color == shaders.color, "direct light");
    let lit = lanes.color.iter().filter(|pixel| pixel[0] > 0.0).count();
    assert!(lit > 1000, "there is light: {lit} pixels");
}

#[test]
fn paths_are_the_same() {
    for (lit, max_depth) in [(Lit::Lamps, 2), (Lit::Points, 7), (Lit::Lamps, 9), (Lit::All, 9)] {
        let options = RenderOptions { clamp: Some(20.0), ..by_paths(max_depth, 4) };
        let [lanes, shaders] = [false, true].map(|secret| picture(lit, secret, &options));
        assert!(lanes.color == shaders.color, "{max_depth} edges");
    }
}

#[test]
fn levels_and_threads_do_not_matter() {
    let options = by_paths(9, 3);
    let (world, camera) = room(Lit::All, false);
    let of = |options: &RenderOptions, threads| {
        render(&world, &camera, options, &pool(threads), &Silent).expect("sound options").picture.color
    };
    let one = of(&options, 1);
    assert!(one == of(&options, 7), "seven threads give other bits");
    for level in Level::available() {
        assert!(one == of(&RenderOptions { level, ..options.clone() }, 2), "{level} gives other bits");
    }
}

#[test]
fn batches_do_not_matter() {
    let options = RenderOptions { aovs: true, ..by_paths(6, 21) };
    let (world, camera) = room(Lit::All, false);
    let at_once = render(&world, &camera, &options, &pool(2), &Silent).expect("sound options").picture;
    for samples in [1, 5] {
        let mut seen = Accumulation::new(options.clone()).expect("sound options");
        while !seen.is_complete() {
            seen.pass(&world, &camera, samples, &pool(2), &Silent);
        }
        let other = seen.picture();
        assert!(at_once.color == other.color, "passes of {samples} give other bits");
        assert!(at_once.layers == other.layers, "passes of {samples} give other layers");
    }
}

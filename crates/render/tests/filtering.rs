// SPDX-License-Identifier: GPL-3.0-or-later
//! Textures where a ray stands for many texels: pictures of one sample against many samples that read the picture itself.

use std::sync::Arc;

use crate::common::*;
use glam::Vec3;
use gnurt_image::{Picture, TexelData, Texels, TileCache, Weigh};
use gnurt_render::{CommitOptions, Integrator, RenderOptions, ShaderTable, Silent, World, render};
use gnurt_scene::material::{Color, TextureRef};
use gnurt_scene::texture::{Filter, Texture, Wrap};
use gnurt_scene::{Light, Material, MaterialId, Scene, Surface};
use gnurt_shading::bsdf::Principled;
use gnurt_shading::materials as shading;
use gnurt_shading::mipmap::{Minify, MipMap};
use gnurt_shading::texture::TextureSampler;
use gnurt_shading::{SurfaceBatch, SurfaceShader, Vec3s};

/// Black and white fields of eight texels, 64 by 64 texels in all.
fn checker() -> Arc<Texels> {
    let texel = |i: usize| if (i % 64 / 8 + i / 512).is_multiple_of(2) { [255; 4] } else { [0, 0, 0, 255] };
    Arc::new(Texels { width: 64, height: 64, data: TexelData::Linear8((0..64 * 64).map(texel).collect()) })
}

/// A reader that repeats the picture `times` along both coordinates; sharp, or filtered over the ray's
/// footprint.
fn reader(texels: &Arc<Texels>, times: f32, weigh: Option<Weigh>) -> TextureSampler {
    let mips = |weigh| Arc::new(MipMap::weighed(texels.clone(), weigh));
    TextureSampler {
        uv_from_mesh: [times, 0.0, 0.0, times, 0.0, 0.0],
        minify: weigh.map(|weigh| (Minify::Ellipse, mips(weigh))),
        ..TextureSampler::new(texels.clone())
    }
}

/// A surface that emits its texture and scatters nothing: no light is sampled, so that the noise comes from
/// the texture alone.
fn shining(texture: TextureSampler) -> Arc<dyn SurfaceShader> {
    Arc::new(shading::Material {
        surface: Arc::new(shading::Matte { albedo: shading::TexturedColor::constant(Vec3::ZERO) }),
        emission: Some(shading::Emission {
            texture: Some(texture),
            ..shading::Emission::constant(Vec3::ONE)
        }),
        coverage: None,
        bump: None,
        attributes: Vec::new(),
    })
}

/// A picture of a scene whose material 0 is a shader.
fn shown(
    scene: &Scene,
    shader: Arc<dyn SurfaceShader>,
    (eye, target, fov): View,
    options: &RenderOptions,
) -> Picture {
    let mut scene = scene.clone();
    scene.edit_material(MaterialId(0)).surface = Surface::Shader(0);
    let table = ShaderTable { surfaces: vec![shader], ..ShaderTable::default() };
    let mut world = World::new();
    world.commit(&scene, &table, &CommitOptions::default(), &pool(1)).expect("the scene is sound");
    render(&world, &camera(eye, target, fov), options, &pool(1), &Silent).expect("sound options").picture
}

type View = ([f32; 3], [f32; 3], f32);

/// Root of the mean square of the differences.
fn rms(a: &Picture, b: &Picture) -> f64 {
    let squares = a.color.iter().zip(&b.color).map(|(a, b)| f64::from(a[0] - b[0]).powi(2));
    (squares.sum::<f64>() / a.color.len() as f64).sqrt()
}

/// Noise of sharp samples relative to filtered ones; the means must agree.
fn gain(scene: &Scene, times: f32, view: View, depth: u32, what: &str) -> f64 {
    let of = |weigh, spp| {
        let options =
            RenderOptions { max_depth: depth, integrator: Integrator::Path, ..options(48, 32, spp) };
        shown(scene, shining(reader(&checker(), times, weigh)), view, &options)
    };
    let (truth, sharp, wide) = (of(None, 256), of(None, 1), of(Some(Weigh::Alike), 1));
    let (sharp, found) = (rms(&sharp, &truth), rms(&wide, &truth));
    let [wide, truth] = [mean(&wide)[0], mean(&truth)[0]];
    eprintln!("{what}: error {found:.4} against {sharp:.4}, mean {wide:.4} of {truth:.4}");
    assert_close(wide, truth, 0.05, what);
    found / sharp
}

#[test]
fn a_sample_reads_what_it_stands_for() {
    let plane = floor(0.5, 50.0);
    // To the horizon: fields of a pixel in the foreground, of a thousandth far away.
    let gained = gain(&plane, 100.0, ([0.0, -49.0, 1.5], [0.0, 0.0, 0.0], 50.0), 1, "a plane to the horizon");
    assert!(gained < 0.6, "a plane to the horizon: {gained}");
    let reflected = |surface: Surface| {
        let mut scene = floor(0.5, 20.0);
        let material = scene.add_material(Material::of("ball", surface));
        put_mesh(&mut scene, sphere([0.0, 0.0, 1.2], 1.0, 32, material));
        scene
    };
    let view = ([0.0, -8.0, 2.0], [0.0, 0.0, 1.1], 12.0);
    let mirror = reflected(Surface::Mirror { reflectance: Color::constant([1.0; 3]) });
    let gained = gain(&mirror, 30.0, view, 2, "by a mirror ball");
    assert!(gained < 0.75, "by a mirror ball: {gained}");
    let eta = [1.5; 3];
    let rough = reflected(Surface::Metal { eta, k: [7.0; 3], roughness: 0.4 });
    let gained = gain(&rough, 30.0, view, 2, "by a rough ball");
    assert!(gained < 0.95, "by a rough ball: {gained}");
}

#[test]
fn files_textures_are_read_so_too_and_samples_become_sharp() {
    let mut scene = floor(1.0, 50.0);
    let (texels, wrap) = (checker(), [Wrap::Repeat; 2]);
    let texture = scene.add_texture(Texture { name: String::new(), texels, wrap, filter: Filter::Linear });
    let texture = TextureRef { uv_from_mesh: [200.0, 0.0, 0.0, 200.0, 0.0, 0.0], ..TextureRef::new(texture) };
    scene.edit_material(MaterialId(0)).surface =
        Surface::Matte { base_color: Color { factor: [1.0; 3], texture: Some(texture) } };
    let view = camera([0.0, 0.0, 40.0], [0.0, 0.0, 0.0], 60.0);
    let of = |spp| {
        let options = RenderOptions { integrator: Integrator::Eyelight, ..options(32, 32, spp) };
        frame(&scene, &view, &options).picture
    };
    let first = of(1);
    let spread = |picture: &Picture| {
        let centre = picture.color[16 * 32 + 16][0];
        picture.color[14 * 32..18 * 32]
            .chunks(32)
            .flat_map(|row| &row[14..18])
            .map(|p| (p[0] - centre).abs())
            .fold(0.0, f32::max)
    };
    assert!(spread(&first) < 0.03, "alike: all pixels stand for several fields: {}", spread(&first));
    // Sixteen fields of a texture on two pixels: one is seen, if samples are finer than pixels.
    let near = camera([0.0, 0.0, 0.4], [0.02, 0.01, 0.0], 1.0);
    let options = RenderOptions { integrator: Integrator::Eyelight, ..options(2, 2, 256) };
    let sharp = frame(&scene, &near, &options).picture;
    assert!(sharp.color.iter().any(|p| p[0] > 0.98 || p[0] < 0.02), "as sharp as ever: {:?}", sharp.color);
}

#[test]
fn bumps_too_fine_to_be_seen_make_metal_rougher() {
    let texel = |i: usize| {
        let unit = |n: usize| ((i * n) % 251) as f32 / 251.0 - 0.5;
        let n = Vec3::new(0.5 * unit(97), 0.5 * unit(61), 1.0).normalize() * 0.5 + 0.5;
        [n.x, n.y, n.z, 1.0]
    };
    let bumps =
        Arc::new(Texels { width: 64, height: 64, data: TexelData::Float((0..64 * 64).map(texel).collect()) });
    let mut scene = floor(0.5, 5.0);
    scene.add_light(Light::Directional {
        direction: [0.0, -0.287_35, -0.957_83],
        irradiance: [1.0; 3],
        angle: 0.0,
    });
    let metal = |weigh| shading::MetallicRoughness {
        base_color: shading::TexturedColor::constant(Vec3::ONE),
        metallic: 1.0,
        roughness: 0.25,
        metallic_roughness_texture: None,
        ior: 1.5,
        normal_map: Some(shading::NormalMap { texture: reader(&bumps, 40.0, weigh), scale: 1.0 }),
        model: Principled::new(Vec3::ONE, 1.0, 0.25, 1.5),
        anisotropy: shading::Anisotropy::default(),
        absorption: Vec3::ZERO,
        layers: None,
    };
    let of = |weigh, spp| {
        let options = RenderOptions { max_depth: 2, ..options(8, 8, spp) };
        mean(&shown(&scene, Arc::new(metal(weigh)), ([0.0, -6.0, 20.0], [0.0; 3], 8.0), &options))[0]
    };
    let truth = of(None, 400);
    let bent = of(Some(Weigh::Directions), 1);
    eprintln!("bumps: {bent} by unit directions, truth {truth}");
    // Without them the mirror image would be eleven times as bright. Their slopes are not those of facets quite.
    assert!(bent < 1.6 * truth && truth < 1.6 * bent, "as rough as the bumps make it: {bent}, {truth}");
}

#[test]
fn readers_on_many_threads_share_few_tiles() {
    let cache = TileCache::new(0).expect("a file");
    let mixed = |i: u32| (i.wrapping_mul(0x9e37_79b9) ^ (i << 7)).to_le_bytes();
    let plain =
        Texels { width: 1024, height: 1024, data: TexelData::Srgb8((0..1 << 20).map(mixed).collect()) };
    let tiled = cache.keep(plain.clone()).expect("room on the disk");
    std::thread::scope(|scope| {
        for thread in 0..4_usize {
            let (tiled, plain) = (&tiled, &plain);
            scope.spawn(move || {
                let mut at = thread * 7919;
                for _ in 0..4_000 {
                    // Short walks from tile to tile, as rays go.
                    at = (at * 1_664_525 + 1_013_904_223) % (1 << 31);
                    for k in 0..4 {
                        let (x, y) = ((at + k) % 1024, (at / 1024) % 1024);
                        assert_eq!(tiled.texel(x, y), plain.texel(x, y), "thread {thread} at {x}, {y}");
                    }
                }
            });
        }
    });
    let counts = cache.counts();
    assert_eq!(counts.memory_bytes, 1 << 20, "no more than it may");
    assert!(counts.read > 500 && counts.failed == 0, "tiles come and go: {counts:?}");
}

#[test]
fn what_broad_lobes_see_is_read_from_the_nearest_level() {
    let texture = reader(&checker(), 1.0, Some(Weigh::Alike));
    // In the middle of a white field, over so many texels.
    let read = |depth, spread, texels: f32| {
        let one = |v: Vec3| Vec3s::splat(1, v);
        let points = SurfaceBatch {
            t: vec![1.0],
            texcoord: [vec![3.5 / 8.0], vec![4.5 / 8.0]],
            ng: one(Vec3::Z),
            ns: one(Vec3::Z),
            ray_dir: one(-Vec3::Z),
            dp_du: one(Vec3::X),
            dp_dv: one(Vec3::Y),
            footprint: vec![texels / 64.0],
            cone_spread: vec![spread],
            uv_per_length: vec![1.0],
            depth,
            ..SurfaceBatch::default()
        };
        texture.at_hit(&points, 0)[0]
    };
    let interpolated = 1.0 - 0.5 * 1.5_f32.log2();
    for (depth, spread) in [(0, 0.5), (1, 0.05)] {
        let found = read(depth, spread, 12.0);
        assert!(
            (found - interpolated).abs() < 1e-4,
            "depth {depth}, spread {spread}: between levels, {found}"
        );
    }
    let [small, field, more, all] = [0.5, 8.0, 12.0, 1e3].map(|texels| read(1, -0.5, texels));
    assert_eq!([small, field], [1.0; 2], "the picture itself, and the level of fields");
    assert!((more - 0.5).abs() < 1e-4 && (all - 0.5).abs() < 1e-4, "the next one: {more}, all of it: {all}");
}

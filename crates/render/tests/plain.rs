// SPDX-License-Identifier: GPL-3.0-or-later
//! Looks from the eye at plain colours against the way by batches of points: the same scene, with shaders that say that their
//! colours are plain and with such that keep it to themselves. Source: original.

mod common;

use std::sync::Arc;

use common::*;
use glam::Vec3;
use gnurt_image::{TexelData, Texels};
use gnurt_render::{CommitOptions, Integrator, RenderOptions, ShaderTable, Silent, World, render};
use gnurt_scene::{Affine, Material, MaterialId, Mesh, Scene, Surface};
use gnurt_shading::materials::{self, Dielectric, Matte, MetallicRoughness, Mirror, TexturedColor};
use gnurt_shading::texture::TextureSampler;
use gnurt_shading::{Detail, SurfaceBatch, SurfaceShader, Tracer, Vec3s};

/// A surface that does not say that its colour is plain.
struct Secret(Arc<dyn SurfaceShader>);

impl SurfaceShader for Secret {
    fn shade(&self, tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        self.0.shade(tracer, hits, out);
    }

    fn albedo(&self, hits: &SurfaceBatch, out: &mut Vec3s) {
        self.0.albedo(hits, out);
    }

    fn albedo_detail(&self) -> Detail {
        self.0.albedo_detail()
    }
}

/// One of each kind: all but the last are plain.
fn looks() -> Vec<Arc<dyn SurfaceShader>> {
    let color = |r, g, b| TexturedColor::constant(Vec3::new(r, g, b));
    let texel = |i: usize| [0.2 + 0.1 * (i % 5) as f32, 0.9 - 0.2 * (i % 4) as f32, 0.5, 1.0];
    let texels = Texels { width: 6, height: 5, data: TexelData::Float((0..30).map(texel).collect()) };
    let picture = TextureSampler::new(Arc::new(texels));
    let plastic = MetallicRoughness {
        base_color: color(0.3, 0.1, 0.7),
        metallic: 0.2,
        roughness: 0.5,
        metallic_roughness_texture: None,
        ior: 1.5,
        normal_map: None,
        layers: materials::Layers::default(),
    };
    let glass =
        Dielectric { ior: 1.5, reflectance: Vec3::new(0.9, 0.2, 0.3), transmittance: Vec3::splat(0.7) };
    let covered = materials::Material {
        surface: Arc::new(Matte { albedo: color(0.9, 0.8, 0.1) }),
        emission: None,
        coverage: None,
    };
    let textured = TexturedColor { factor: Vec3::new(0.8, 0.9, 1.0), texture: Some(picture) };
    vec![
        Arc::new(Matte { albedo: color(0.7, 0.6, 0.5) }),
        Arc::new(Mirror { reflectance: color(0.2, 0.9, 0.8) }),
        Arc::new(plastic),
        Arc::new(glass),
        Arc::new(covered),
        Arc::new(Matte { albedo: textured }),
    ]
}

/// Balls and quads: smooth, flat, in colours, with normals that are none; turned, stretched and mirrored.
fn scene() -> Scene {
    let mut scene = Scene::new();
    let ids: Vec<MaterialId> =
        (0..looks().len() as u32).map(|n| scene.add_material(Material::of("", Surface::Shader(n)))).collect();
    let tinted = |mut mesh: Mesh| {
        let color = |i: usize| [0.1 * (i % 7) as f32, 0.5, 1.0 - 0.1 * (i % 9) as f32, 1.0];
        mesh.colors = (0..mesh.positions.len()).map(color).collect();
        mesh
    };
    for (i, &material) in ids.iter().enumerate() {
        let mut some = sphere([0.0; 3], 0.7, 7, material);
        // Of any length, and some of none: triangles at those corners are flat.
        some.normals.iter_mut().enumerate().for_each(|(k, n)| *n = n.map(|x| x * (k % 5) as f32));
        let flat = Mesh { normals: Vec::new(), ..sphere([0.0; 3], 0.6, 5, material) };
        let smooth = sphere([0.0; 3], 0.8, 6, material);
        let with_coordinates = quad([-0.6, -0.6, 0.0], [1.2, 0.0, 0.3], [0.0, 1.2, 0.1], material);
        let kinds =
            [tinted(some), flat.clone(), smooth.clone(), tinted(flat), tinted(smooth), with_coordinates];
        for (j, mesh) in kinds.into_iter().enumerate() {
            let mesh = scene.add_mesh(mesh);
            let object = scene.add_object_of("", vec![mesh]);
            let [x, y] = [i, j].map(|k| 1.7 * k as f64 - 4.0);
            let turn = Affine::rotation([0.3, 0.2, 1.0], x + 2.0 * y);
            let stretch = Affine::scale([0.9, 0.7, if (i + j) % 3 == 0 { -0.8 } else { 0.6 }]);
            scene.instantiate(object, Affine::translation([x, y, 0.0]) * turn * stretch);
        }
    }
    scene
}

#[test]
fn plain_colours_are_those_of_batches() {
    let (scene, pool) = (scene(), pool(2));
    let camera = camera([0.5, -6.0, 13.0], [0.2, 0.3, 0.0], 40.0);
    let secret = |shader: Arc<dyn SurfaceShader>| -> Arc<dyn SurfaceShader> { Arc::new(Secret(shader)) };
    let pictures = [looks(), looks().into_iter().map(secret).collect()].map(|surfaces| {
        let mut world = World::new();
        let table = ShaderTable { surfaces, ..ShaderTable::default() };
        world.commit(&scene, &table, &CommitOptions::default(), &pool).expect("a sound scene");
        let options =
            RenderOptions { integrator: Integrator::Eyelight, pixel_centres: true, ..options(160, 120, 1) };
        render(&world, &camera, &options, &pool, &Silent).expect("sound options").picture
    });
    let [plain, asked] = &pictures;
    let lit = plain.color.iter().filter(|c| c[0] + c[1] + c[2] > 0.0).count();
    assert!(lit > 3500, "there is something to see: {lit} pixels");
    for (i, (a, b)) in plain.color.iter().zip(&asked.color).enumerate() {
        assert_eq!(a.map(f32::to_bits), b.map(f32::to_bits), "pixel {},{}: {a:?} {b:?}", i % 160, i / 160);
    }
}

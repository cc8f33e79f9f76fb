// SPDX-License-Identifier: GPL-3.0-or-later
//! A material of one's own: a checkerboard of matte and shiny squares, lit by all integrators.
//!
//! A surface shader writes a list of weighted lobes for each point of a batch. It draws no random numbers and sends no
//! rays; the integrators do that.
//!
//! `cargo run --release -p gnurt-examples --bin own_material [PICTURE]`

use std::sync::Arc;

use glam::Vec3;
use gnurt::image::WriteOptions;
use gnurt::render::{CommitOptions, RenderOptions, SceneCamera, ShaderTable, Silent, World, render};
use gnurt::scene::{MaterialId, Surface};
use gnurt::shading::bsdf::{ClosureBatch, Lobe};
use gnurt::shading::{SurfaceBatch, SurfaceShader};

/// Squares of `size` world units.
struct Checkerboard {
    size: f32,
}

impl SurfaceShader for Checkerboard {
    fn evaluate(&self, hits: &SurfaceBatch, out: &mut ClosureBatch) {
        for i in 0..hits.len() {
            let square = (hits.p.get(i) / self.size + 1e-3).floor();
            let is_shiny = (square.x + square.y + square.z) as i32 & 1 == 0;
            let lobe = if is_shiny {
                // Microfacets of gold's reflectance, roughness 0.2.
                Lobe::microfacets(0.04, Vec3::new(1.0, 0.78, 0.34), Vec3::ONE)
            } else {
                Lobe::lambert(Vec3::splat(0.2))
            };
            out.set(i, hits.scattering_ns(i), &[lobe]);
        }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let output = std::env::args().nth(1).unwrap_or_else(|| "own_material.png".into());
    let mut scene = gnurt::load_scene("builtin:cornell")?.scene;

    // The scene names the shader by its index in the shader table.
    let white =
        scene.materials().iter().position(|material| material.name == "white").ok_or("no white material")?;
    scene.edit_material(MaterialId(white as u32)).surface = Surface::Shader(0);
    let shaders =
        ShaderTable { surfaces: vec![Arc::new(Checkerboard { size: 0.25 })], ..ShaderTable::default() };

    let pool = gnurt::thread_pool(0)?;
    let mut world = World::new();
    world.commit(&scene, &shaders, &CommitOptions::default(), &pool)?;
    let camera = SceneCamera::new(&scene.cameras()[0]).ok_or("the camera has no view")?;
    let options = RenderOptions { width: 320, height: 240, spp: 64, ..RenderOptions::default() };
    let frame = render(&world, &camera, &options, &pool, &Silent)?;
    gnurt::image::write(&frame.picture, output.as_ref(), &WriteOptions::default())?;
    println!("wrote {output}");
    Ok(())
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! A first picture: loads a scene and renders it into a PNG file.
//!
//! `cargo run --release -p gnurt-examples --bin first_picture [SCENE [PICTURE]]`

use gnurt::image::WriteOptions;
use gnurt::render::{CommitOptions, RenderOptions, SceneCamera, ShaderTable, Silent, World, render};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let name = arguments.next().unwrap_or_else(|| "builtin:cornell".into());
    let output = arguments.next().unwrap_or_else(|| "first.png".into());

    // The description: meshes, materials, lights and cameras as plain data.
    let mut scene = gnurt::load_scene(&name)?.scene;
    gnurt::defaults::complete(&mut scene, 1.0); // adds a camera and lights if the scene has none

    // The world: trees, lights and shaders, made from the description.
    let pool = gnurt::thread_pool(0)?; // one thread per core
    let mut world = World::new();
    world.commit(&scene, &ShaderTable::default(), &CommitOptions::default(), &pool)?;

    let camera = SceneCamera::new(&scene.cameras()[0]).ok_or("the camera has no view")?;
    let options = RenderOptions { width: 320, height: 240, spp: 16, ..RenderOptions::default() };
    let frame = render(&world, &camera, &options, &pool, &Silent)?;
    gnurt::image::write(&frame.picture, output.as_ref(), &WriteOptions::default())?;
    println!(
        "wrote {output}: {} triangles, {}x{}",
        world.stats().instanced_triangles,
        options.width,
        options.height
    );
    Ok(())
}

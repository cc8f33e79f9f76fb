// SPDX-License-Identifier: GPL-3.0-or-later
//! GNU RT: a free ray tracing system, the open implementation of OpenRT.
//!
//! This crate is the public API: it re-exports the other crates and adds the steps from a name to a picture.
//! [`scene`] describes, [`accel`] answers ray queries, [`shading`] defines how light leaves surfaces.
//! [`render`] commits a description to a [`World`](render::World) and makes pictures of it, [`image`] holds
//! pictures and their files, [`denoise`] removes noise. [`simd`] chooses the CPU's instructions, [`osl`]
//! makes shaders of files in the shading language.
//!
//! # A picture
//!
//! ```
//! use gnurt::render::{CommitOptions, SceneCamera, RenderOptions, ShaderTable, Silent, World, render};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mut scene = gnurt::load_scene("builtin:cornell")?.scene;
//! gnurt::defaults::complete(&mut scene, 1.0); // a camera and lights, where a scene has none
//! let pool = gnurt::thread_pool(0)?; // one thread per core
//! let mut world = World::new();
//! world.commit(&scene, &ShaderTable::default(), &CommitOptions::default(), &pool)?;
//! let camera = SceneCamera::new(&scene.cameras()[0]).ok_or("the camera has no view")?;
//! let options = RenderOptions { width: 32, height: 32, spp: 4, ..RenderOptions::default() };
//! let frame = render(&world, &camera, &options, &pool, &Silent)?;
//! # let folder = tempfile::tempdir()?;
//! # std::env::set_current_dir(folder.path())?;
//! gnurt::image::write(&frame.picture, "cornell.png".as_ref(), &gnurt::image::WriteOptions::default())?;
//! # assert!(std::path::Path::new("cornell.png").exists(), "the picture is there");
//! # assert!(frame.picture.color.iter().any(|pixel| pixel[0] > 0.1), "there is light");
//! # Ok(())
//! # }
//! ```
//!
//! # Rays
//!
//! ```
//! use gnurt::accel::Ray;
//! use gnurt::render::{CommitOptions, ShaderTable, World};
//! use gnurt::scene::{Affine, Material, Mesh, Scene};
//!
//! # fn main() -> Result<(), gnurt::Error> {
//! let mut scene = Scene::new();
//! let material = scene.add_material(Material::matte("grey", [0.5; 3]));
//! let triangle = Mesh {
//!     positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
//!     indices: vec![[0, 1, 2]],
//!     material,
//!     ..Mesh::default()
//! };
//! let mesh = scene.add_mesh(triangle);
//! let object = scene.add_object_of("triangle", vec![mesh]);
//! scene.instantiate(object, Affine::translation([0.0, 0.0, -5.0]));
//!
//! let mut world = World::new();
//! let pool = gnurt::thread_pool(1)?;
//! world.commit(&scene, &ShaderTable::default(), &CommitOptions::default(), &pool)?;
//! let ray = Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, -1.0]);
//! let hit = world.intersect(&ray).expect("the triangle is in the way");
//! assert_eq!((hit.t, hit.prim_id), (5.0, 0));
//! assert!(!world.occluded(&ray.within(0.0, 4.9)));
//! # Ok(())
//! # }
//! ```
//!
//! # Conventions
//!
//! Right-handed space; triangles are counter-clockwise seen from the side of their geometric normal; surfaces scatter on
//! both sides, emission leaves the side of the normal only; colours are linear. Nothing is global: thread pools are
//! passed in. The same scene, options and seed give the same picture, bit for bit, on any number of threads
//! and at every instruction set.
//!
//! # Limits today
//!
//! * The integrators are `eyelight`, `normals`, `whitted` (direct light, mirrors, glass), `path` (all light) and `ir`, `bir`
//!   and `mir` (all light by virtual lights).
//! * Geometry is triangles and instances of them; no curves, no subdivision, no volumes. Scenes move by
//!   [`Scene::pose`](scene::Scene::pose), and are blurred by [`Scene::expose`](scene::Scene::expose).
//! * The API may change until version 1.0.
#![deny(unsafe_code)]

#[cfg(not(all(feature = "gltf", feature = "pbrt", feature = "usd")))]
mod absent;
#[cfg(all(test, feature = "osl"))]
#[expect(
    dead_code,
    unreachable_pub,
    unused_imports,
    reason = "its own tests run in builds with the language, too"
)]
mod absent_osl;
mod camera_rays;
pub mod defaults;
pub mod display_rules;
mod error;
#[expect(unsafe_code, reason = "a global allocator")]
mod ffi_heap;
mod film_motion;
pub mod layers;
mod load;
pub mod mattes;
pub mod memory;
mod named_shaders;
mod numbered;
#[cfg(not(feature = "osl"))]
#[path = "absent_osl.rs"]
pub mod osl;
pub mod relight;
mod script_sky;
mod size;
mod surroundings;
mod threads;
mod volumes;

pub use camera_rays::{camera_rays, camera_rays_along};
pub use error::Error;
pub use film_motion::FramePose;
pub use gnurt_accel as accel;
pub use gnurt_denoise as denoise;
pub use gnurt_image as image;
#[cfg(feature = "ocio")]
pub use gnurt_ocio as ocio;
pub use gnurt_render as render;
pub use gnurt_scene as scene;
pub use gnurt_scene::overrides::Override;
pub use gnurt_shading as shading;
pub use gnurt_simd as simd;
#[cfg(feature = "osl")]
pub use gnurt_sl_shading as osl;
pub use load::{
    BUILTIN, FORMATS, LoadOptions, Loaded, builtin_names, builtin_scenes, load_scene, load_scene_with,
};
pub use named_shaders::{NamedShaders, named_camera_shader, put_displacement, put_named_shaders};
pub use numbered::Numbered;
pub use rayon::ThreadPool;
pub use surroundings::Surroundings;
pub use threads::{JoinedPool, cores, thread_pool, workers};
pub use volumes::{Fog, VolumeFile, read_volume};

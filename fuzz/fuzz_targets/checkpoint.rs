// SPDX-License-Identifier: GPL-3.0-or-later
//! Any bytes as a checkpoint, with the right checksum: an error of one line, or an unfinished picture that
//! can be shown, saved, loaded again and continued. The first byte chooses the scene; the second, whether the
//! rest is the file, or the changes of a valid file.
#![no_main]

use std::sync::OnceLock;

use gnurt_render::{
    Accumulation, CommitOptions, SceneCamera, RenderOptions, ShaderTable, Silent, World,
};
use gnurt_scene::{Affine, Camera, Light, Material, Mesh, Scene};

#[path = "../../crates/render/tests/common/signed.rs"]
mod signed;

const FINGERPRINT: u64 = 7;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let [kind, way, rest @ ..] = bytes else { return };
    let studio = studio();
    let options = options(*kind);
    let mut file = if way % 2 == 0 { rest.to_vec() } else { changed(&options, studio, rest) };
    signed::sign(&mut file);
    match Accumulation::from_bytes(options.clone(), FINGERPRINT, &file) {
        Ok(picture) => go_on(picture, &options, studio),
        Err(error) => assert_eq!(error.to_string().lines().count(), 1, "an error is one line: {error}"),
    }
});

/// A world, a camera and options.
struct Studio {
    world: World,
    camera: SceneCamera,
    pool: rayon::ThreadPool,
}

fn studio() -> &'static Studio {
    static STUDIO: OnceLock<Studio> = OnceLock::new();
    STUDIO.get_or_init(|| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
        let mut scene = Scene::new();
        let material = scene.add_material(Material::matte("floor", [0.5; 3]));
        let mesh = scene.add_mesh(Mesh {
            positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]],
            indices: vec![[0, 1, 2]],
            material,
            ..Mesh::default()
        });
        let object = scene.add_object_of("", vec![mesh]);
        scene.instantiate(object, Affine::IDENTITY);
        scene.add_light(Light::Environment {
            radiance: [1.0; 3],
            texture: None,
            world_from_light: Affine::IDENTITY,
        });
        let mut world = World::new();
        world.commit(&scene, &ShaderTable::default(), &CommitOptions::default(), &pool).expect("it is sound");
        let view = Camera {
            name: String::new(),
            eye: [0.0, 0.0, 3.0],
            target: [0.0; 3],
            up: [0.0, 1.0, 0.0],
            fov_y: 40.0,
            ..Camera::default()
        };
        Studio { world, camera: SceneCamera::new(&view).expect("a view"), pool }
    })
}

fn options(kind: u8) -> RenderOptions {
    RenderOptions {
        width: 5,
        height: 4,
        spp: 4,
        aovs: kind & 1 != 0,
        heatmap: kind & 2 != 0,
        noise: (kind & 4 != 0).then_some(0.1),
        crop: (kind & 8 != 0).then_some([1, 1, 4, 3]),
        ..RenderOptions::default()
    }
}

/// A sound file, in which each ten bytes of `edits` put a word somewhere; fewer bytes at the end cut it.
fn changed(options: &RenderOptions, studio: &Studio, edits: &[u8]) -> Vec<u8> {
    let mut picture = Accumulation::new(options.clone()).expect("sound options");
    picture.pass(&studio.world, &studio.camera, 2, &studio.pool, &Silent);
    let mut file = picture.to_bytes(FINGERPRINT);
    let (edits, rest) = edits.as_chunks::<10>();
    for [low, high, word @ ..] in edits {
        let (parts, _) = file.as_chunks_mut::<8>();
        let at = usize::from(u16::from_le_bytes([*low, *high])) % parts.len();
        parts[at] = *word;
    }
    if rest.len() > 8 {
        file.truncate(file.len() - 8 * rest.len());
    }
    file
}

fn go_on(mut picture: Accumulation, options: &RenderOptions, studio: &Studio) {
    let file = picture.to_bytes(FINGERPRINT);
    let again = Accumulation::from_bytes(options.clone(), FINGERPRINT, &file).expect("it was just written");
    assert!(again.to_bytes(FINGERPRINT) == file, "word for word");
    let _ = (picture.samples(), picture.picture(), picture.is_complete());
    picture.pass(&studio.world, &studio.camera, 1, &studio.pool, &Silent);
    assert_eq!(picture.picture().pixel_count(), 20, "as large as it was asked for");
}

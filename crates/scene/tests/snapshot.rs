// SPDX-License-Identifier: GPL-3.0-or-later
//! Scenes as bytes: the scene of the bytes is the one that they were made of.

use std::sync::Arc;

use gnurt_image::TileCache;
use gnurt_scene::displacement::{Displacement, Offset, Refinement};
use gnurt_scene::labels::{ControlMesh, LightLinks, Shining};
use gnurt_scene::medium::{DensityGrid, Extent};
use gnurt_scene::snapshot::{from_bytes, to_bytes};
use gnurt_scene::texture::{Filter, TexelData, Texels, Wrap};
use gnurt_scene::{
    Affine, CameraId, InstanceId, LightId, MaterialId, Medium, ObjectId, RayMask, Scene, ShaderFile, Texture,
    builtin,
};

/// Each part of a scene is the other's.
fn assert_equal(a: &Scene, b: &Scene, name: &str) {
    assert!(a.meshes() == b.meshes(), "{name}: meshes");
    assert!(a.objects() == b.objects(), "{name}: objects");
    assert!(a.instances() == b.instances(), "{name}: instances");
    assert!(a.materials() == b.materials(), "{name}: materials");
    assert!(a.textures() == b.textures(), "{name}: textures");
    assert!(a.lights() == b.lights(), "{name}: lights");
    assert!(a.media() == b.media(), "{name}: media");
    assert!(a.cameras() == b.cameras(), "{name}: cameras");
    assert!(a.animation() == b.animation(), "{name}: animation");
    assert_eq!(a.labels(), b.labels(), "{name}: labels");
    assert!(a.shader_files().eq(b.shader_files()), "{name}: shaders of files");
    assert!(a.displacements().eq(b.displacements()), "{name}: displacements");
    for number in 0..a.cameras().len() {
        let id = CameraId(number as u32);
        assert_eq!(a.camera_file(id), b.camera_file(id), "{name}: shader of camera {number}");
    }
}

fn copy(scene: &Scene) -> Scene {
    from_bytes(&to_bytes(scene, &[]).expect("bytes")).expect("a scene").0
}

#[test]
fn builtin_scenes_come_back() {
    for builtin in builtin::ALL {
        let scene = builtin::load(builtin.name).expect("a scene");
        assert_equal(&scene, &copy(&scene), builtin.name);
    }
}

#[test]
fn all_that_files_may_say_comes_back() {
    let mut scene = builtin::load("cornell").expect("a scene");
    let text = Some("surface s () { Ci = diffuse (N); }".into());
    let parameters = vec![("scale".to_owned(), "2".to_owned())];
    let file = ShaderFile { file: "s.osl".into(), text, parameters, ..ShaderFile::default() };
    scene.set_shader_file(MaterialId(1), file.clone());
    scene.set_camera_file(CameraId(0), file);
    let refinement = Refinement::Edges(0.25);
    let displacement = Displacement { refinement, scale: 0.5, ..Displacement::new(Offset::Shader(3)) };
    scene.set_displacement(MaterialId(0), Some(displacement));
    scene.edit_instance(InstanceId(0)).mask = RayMask(5);
    let grid = DensityGrid {
        size: [2, 1, 1],
        density: vec![0.0, 0.1],
        emission: vec![],
        world_from_unit: Affine::translation([0.1, 0.2, 0.3]),
    };
    let extent = Extent::Around { centre: [0.1; 3], radius: f32::INFINITY };
    scene.add_medium(Medium { extent, grid: Some(Arc::new(grid)), priority: -3, ..Medium::default() });
    let labels = scene.labels_mut();
    labels.lights.insert(LightId(0), "key".into());
    labels.set_light_group(Shining::Material(MaterialId(2)), "warm");
    labels.holdouts.insert(InstanceId(0));
    labels.trace_sets.insert("set".into(), [InstanceId(0)].into());
    labels.times = Some([0.1, f64::INFINITY]);
    labels.resolution = Some([3, 2]);
    let links = LightLinks { lit: Some(vec![InstanceId(0)]), shadows: None };
    labels.light_links.insert(Shining::Light(LightId(0)), links);
    for (number, scheme) in ["catmullClark", "loop", "bilinear"].into_iter().enumerate() {
        labels
            .control_meshes
            .insert(ObjectId(number as u32), ControlMesh { scheme, level: 2, triangles: 12 });
    }
    assert_equal(&scene, &copy(&scene), "cornell");
}

#[test]
fn pictures_are_stored_once() {
    let data = TexelData::Float((0..64 * 64).map(|i| [i as f32, -0.0, f32::INFINITY, 0.1]).collect());
    let shared = Arc::new(Texels { width: 64, height: 64, data });
    let bytes = TexelData::Srgb8((0..6).map(|i| [i, 2, 3, 255 - i]).collect());
    let numbers = TexelData::Linear16((0..6).map(|i| [i, 512, 3, 65535 - i]).collect());
    let mut scene = Scene::new();
    let mut add = |texels: &Arc<Texels>, wrap| {
        let (texels, name) = (texels.clone(), "t".to_owned());
        scene.add_texture(Texture { name, texels, wrap: [wrap, Wrap::Repeat], filter: Filter::Nearest });
    };
    add(&shared, Wrap::ClampToEdge);
    add(&shared, Wrap::MirroredRepeat);
    for data in [bytes, numbers] {
        add(&Arc::new(Texels { width: 3, height: 2, data }), Wrap::Repeat);
    }
    let tiles = TileCache::new(1 << 20).expect("a cache");
    let tiled = Arc::new(tiles.keep((*shared).clone()).expect("tiles"));
    let written = to_bytes(&scene, &[tiled, shared.clone()]).expect("bytes");
    assert!(written.len() < 2 * 64 * 64 * 16 + 1000, "{} bytes", written.len());
    let (read, more) = from_bytes(&written).expect("a scene");
    assert_equal(&scene, &read, "pictures");
    assert!(
        Arc::ptr_eq(&read.textures()[0].texels, &read.textures()[1].texels),
        "one picture of two textures"
    );
    assert!(Arc::ptr_eq(&read.textures()[0].texels, &more[1]), "and of a shader");
    assert!(*more[0] == *shared, "tiles come back in memory");
}

#[test]
fn scenes_come_back_at_rest() {
    let mut scene = builtin::load("wind").expect("a scene");
    let still = scene.clone();
    scene.pose(0, 1.3);
    assert!(scene.instances() != still.instances() || scene.objects() != still.objects(), "the wind blows");
    scene.rest();
    let rest = scene.clone();
    scene.pose(0, 1.3);
    assert_equal(&rest, &copy(&scene), "wind");
    let (mut a, mut b) = (scene.clone(), copy(&scene));
    a.pose(0, 2.7);
    b.pose(0, 2.7);
    assert_equal(&a, &b, "later");
}

#[test]
fn damaged_bytes_are_errors() {
    let scene = builtin::load("cornell").expect("a scene");
    let good = to_bytes(&scene, &[]).expect("bytes");
    let fault = |bytes: &[u8]| from_bytes(bytes).expect_err("damaged").to_string();
    assert_eq!(fault(b"no scene"), "these are no bytes of a scene");
    for length in 12..good.len() {
        assert_eq!(fault(&good[..length]), "the bytes of a scene are damaged", "the first {length}");
    }
    for at in (12..good.len()).step_by(7) {
        let mut bad = good.clone();
        bad[at] ^= 0x10;
        assert!(fault(&bad).starts_with("the bytes of a scene are "), "byte {at}");
    }
    let mut other = good.clone();
    other[13] = b'9';
    assert!(fault(&other).contains("are of version 9"), "{}", fault(&other));
    let mut wrong = scene.clone();
    wrong.edit_instance(InstanceId(0)).object = ObjectId(99);
    let fault = to_bytes(&wrong, &[]).expect_err("a mistake").to_string();
    assert!(fault.contains("object 99 does not exist"), "{fault}");
}

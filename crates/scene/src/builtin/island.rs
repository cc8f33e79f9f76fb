// SPDX-License-Identifier: GPL-3.0-or-later
//! The showpiece: a wooded island with a lighthouse in a still sea, at evening.
//! Terrain after [Mus93] (ridged sums of noise). Two levels: thousands of trees and rocks are
//! instances of a few objects. Space: +Y up, sea level at y = 0; the island fits into a circle of radius [`REACH`].
//!
//! The sea is one sheet of glass with water's index of refraction: it mirrors like water, more the flatter one looks, and
//! what is refracted into it meets the environment's lower half, which has the colour of deep water.
//! Tests: `tests/builtin.rs::the_showpiece_is_large`.

mod cape;
mod lighthouse;
mod plants;
mod terrain;
mod wind;

use terrain::{REACH, Terrain};

use super::noise::hash;
use super::shapes::{quad, show};
use super::sky::EVENING;
use crate::affine::Affine;
use crate::animation::Trs;
use crate::camera::Camera;
use crate::id::{CameraId, InstanceId, MaterialId, ObjectId};
use crate::material::{Material, Surface};
use crate::ray_mask::RayMask;
use crate::scene::{Instance, Scene};
use crate::shader_file::ShaderFile;

/// Half the side of the sea's sheet.
const SEA: f32 = 400.0;

/// The island, seen from a boat.
pub(super) fn scene() -> Scene {
    island().0
}

/// The same with trees that move, seen from nearer, where the shader library shows what it can. From the boat that would cost a third of
/// the time of a picture, for little to see (bench/record/language-closing-2026-11-23.md).
pub(super) fn in_the_wind() -> Scene {
    let (mut scene, trees) = island();
    wind::blow(&mut scene, &trees);
    dress(&mut scene);
    *scene.edit_camera(CameraId(0)) = Camera {
        name: "on the shore".into(),
        eye: [2.05, 0.42, 3.35],
        target: [0.55, 0.62, 0.2],
        up: [0.0, 1.0, 0.0],
        fov_y: 26.0,
        ..Camera::default()
    };
    scene
}

fn island() -> (Scene, Vec<wind::Tree>) {
    let mut scene = Scene::new();
    let terrain = Terrain::new();
    let ground = scene.add_material(Material::matte("ground", [1.0; 3]));
    show(&mut scene, "island", terrain.mesh(), ground);
    add_sea(&mut scene);
    lighthouse::add(&mut scene, &terrain);
    let plants = plants::add_objects(&mut scene);
    let trees = scatter(&mut scene, &terrain, &plants);
    EVENING.add_to(&mut scene, Affine::IDENTITY);
    scene.add_camera(Camera {
        name: "from a boat".into(),
        eye: [1.6, 0.62, 11.4],
        target: [0.25, 0.72, 0.0],
        up: [0.0, 1.0, 0.0],
        fov_y: 29.0,
        ..Camera::default()
    });
    (scene, trees)
}

/// What materials are shown by where somebody compiles shaders: the shader's name and its parameters.
const DRESSES: [(&str, &str, &str); 5] = [
    (
        "ground",
        "terrain",
        "up=1 snow_line=9 beach=0.035 scale=3 steepness=0.2 relief=0.05 sand=0.62,0.5,0.34 grass=0.15,0.175,0.055 rock=0.29,0.262,0.237",
    ),
    ("bark", "wood", "axis=1 scale=40 early=0.13,0.085,0.05 late=0.07,0.045,0.03 varnish=0.7"),
    ("stone", "concrete", "cement=0.27,0.245,0.22 scale=1.5 stains=0.5 pores=0.2"),
    ("whitewash", "concrete", "cement=0.8,0.78,0.74 scale=8 stains=0.15 pores=0.1"),
    ("iron", "rust", "amount=0.3 scale=30 iron=0.2,0.2,0.22"),
];

fn dress(scene: &mut Scene) {
    for (name, shader, values) in DRESSES {
        let Some(location) = scene.materials().iter().position(|material| material.name == name) else {
            continue;
        };
        let parameters = values.split(' ').filter_map(|value| value.split_once('='));
        let parameters = parameters.map(|(name, value)| (name.into(), value.into())).collect();
        let file = format!("builtin/{shader}.osl").into();
        scene.set_shader_file(
            MaterialId(location as u32),
            ShaderFile { file, parameters, ..ShaderFile::default() },
        );
    }
}

fn add_sea(scene: &mut Scene) {
    let water = Surface::Dielectric {
        ior: 1.333,
        reflectance: [1.0; 3],
        transmittance: [1.0; 3],
        interior: Default::default(),
    };
    let water = scene.add_material(Material::of("water", water));
    show(scene, "sea", quad([-SEA, 0.0, SEA], [2.0 * SEA, 0.0, 0.0], [0.0, 0.0, -2.0 * SEA]), water);
}

/// Puts trees where there is grass and rocks where there is sand or scree, at hashed places of a fine grid. Returns the trees.
fn scatter(scene: &mut Scene, terrain: &Terrain, plants: &plants::Objects) -> Vec<wind::Tree> {
    let mut trees = Vec::new();
    const CELLS: i32 = 230;
    let step = 2.0 * REACH / CELLS as f32;
    for (i, j) in (0..CELLS).flat_map(|i| (0..CELLS).map(move |j| (i, j))) {
        let random = |seed: u32| hash(i, j, seed);
        let x = -REACH + (i as f32 + random(1)) * step;
        let z = -REACH + (j as f32 + random(2)) * step;
        let spot = terrain.spot(x, z);
        if cape::is_near(x, z) {
            continue;
        }
        let wooded = spot.wood > 0.35 + 0.5 * random(3);
        if wooded {
            let conifer = random(4) < 0.25 + 0.9 * spot.height;
            let kinds = if conifer { &plants.conifers[..] } else { &plants.broadleaf[..] };
            let kind = kinds[(random(5) * kinds.len() as f32) as usize % kinds.len()];
            let at = [x, spot.height - 0.01, z];
            let (id, rest) = put(scene, kind, at, 0.10 + 0.10 * random(6), random(7), 0.15 * random(8));
            trees.push((id, rest, conifer));
        } else if spot.height > -0.05 && spot.wood < 0.1 && random(9) < 0.05 {
            let kind = plants.rocks[(random(10) * plants.rocks.len() as f32) as usize % plants.rocks.len()];
            let size = 0.02 + 0.075 * random(11).powi(3);
            put(scene, kind, [x, spot.height - 0.2 * size, z], size, random(12), 0.0);
        }
    }
    trees
}

/// An instance on the ground: `size` high, turned by a share of the full circle, stretched upwards by a little. Returns how it
/// stands in three parts, too.
fn put(
    scene: &mut Scene,
    object: ObjectId,
    at: [f32; 3],
    size: f32,
    yaw: f32,
    stretch: f32,
) -> (InstanceId, Trs) {
    let size = f64::from(size);
    let (angle, scale) =
        (f64::from(yaw) * std::f64::consts::TAU, [size, size * (1.0 + f64::from(stretch)), size]);
    let world_from_object = Affine::translation(at.map(f64::from))
        * Affine::rotation([0.0, 1.0, 0.0], angle)
        * Affine::scale(scale);
    let (sin, cos) = (0.5 * angle).sin_cos();
    let rest = Trs { translation: at.map(f64::from), rotation: Some([0.0, sin, 0.0, cos]), scale };
    let name = scene.object(object).name.clone();
    let id =
        scene.add_instance(Instance { name, object, world_from_object, visible: true, mask: RayMask::ALL });
    (id, rest)
}

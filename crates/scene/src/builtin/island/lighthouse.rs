// SPDX-License-Identifier: GPL-3.0-or-later
//! The lighthouse on its cape: a striped tower, a gallery, a lit lantern under a red roof, a keeper's cottage.
//! Space: world; the tower is [`TALL`] high.

use super::super::shapes::{append, block, lathe, moved, sphere, transformed};
use super::cape::POSITION;
use super::terrain::Terrain;
use crate::affine::Affine;
use crate::material::Material;
use crate::mesh::Mesh;
use crate::scene::Scene;

const TALL: f32 = 1.0;
const SEGMENTS: u32 = 48;

pub(super) fn add(scene: &mut Scene, terrain: &Terrain) {
    let white = scene.add_material(Material::matte("whitewash", [0.80, 0.78, 0.74]));
    let red = scene.add_material(Material::matte("red paint", [0.50, 0.055, 0.04]));
    let dark = scene.add_material(Material::matte("iron", [0.035, 0.035, 0.04]));
    let mut flame = Material::matte("lamp", [0.0; 3]);
    flame.emission = [42.0, 27.0, 11.0];
    let flame = scene.add_material(flame);

    let (stripes, walls) = tower();
    let ground = terrain.spot(POSITION[0], POSITION[1]).height;
    let parts = [
        ("stripes", stripes, red),
        ("walls", walls, white),
        ("iron", iron(), dark),
        ("roofs", roofs(), red),
        ("lamp", moved(sphere(0.028, 12), [0.0, 0.83, 0.0]), flame),
    ];
    let meshes = parts
        .into_iter()
        .map(|(name, mesh, material)| scene.add_mesh(Mesh { name: name.into(), material, ..mesh }));
    let meshes = meshes.collect();
    let object = scene.add_object_of("lighthouse", meshes);
    let location = [POSITION[0], ground, POSITION[1]].map(f64::from);
    let size = f64::from(TALL);
    scene.instantiate(object, Affine::translation(location) * Affine::scale([size; 3]));
}

/// Radius of the tower at a height.
fn radius(y: f32) -> f32 {
    0.105 - 0.045 * (y / 0.74)
}

/// Red and white bands, and the white cottage.
fn tower() -> (Mesh, Mesh) {
    let (mut red, mut white) = (Mesh::default(), Mesh::default());
    const BANDS: usize = 5;
    for band in 0..BANDS {
        let [low, high] = [band, band + 1].map(|k| -0.06 + 0.80 * k as f32 / BANDS as f32);
        let ring = lathe(&[[radius(low), low], [radius(high), high]], SEGMENTS);
        append(if band % 2 == 1 { &mut red } else { &mut white }, &ring);
    }
    append(&mut white, &with_flat_normals(cottage_walls()));
    (red, white)
}

/// Gallery, railing posts and the frame of the lantern.
fn iron() -> Mesh {
    let mut mesh = lathe(&[[0.06, 0.735], [0.098, 0.74], [0.098, 0.757], [0.0, 0.757]], SEGMENTS);
    append(&mut mesh, &lathe(&[[0.095, 0.792], [0.098, 0.795], [0.095, 0.798]], SEGMENTS));
    for k in 0..12 {
        let (s, c) = (k as f32 / 12.0 * std::f32::consts::TAU).sin_cos();
        let post = lathe(&[[0.003, 0.757], [0.003, 0.797]], 6);
        append(&mut mesh, &moved(post, [0.095 * s, 0.0, 0.095 * c]));
        if k % 2 == 0 {
            let bar = lathe(&[[0.0035, 0.757], [0.0035, 0.885]], 6);
            append(&mut mesh, &moved(bar, [0.05 * s, 0.0, 0.05 * c]));
        }
    }
    mesh
}

/// The tower's cap with its ball, and the cottage's roof.
fn roofs() -> Mesh {
    let mut mesh =
        lathe(&[[0.0, 0.88], [0.064, 0.882], [0.060, 0.893], [0.012, 0.955], [0.0, 0.96]], SEGMENTS);
    append(&mut mesh, &moved(sphere(0.012, 8), [0.0, 0.968, 0.0]));
    append(&mut mesh, &with_flat_normals(cottage_roof()));
    mesh
}

fn at_cottage(mesh: Mesh) -> Mesh {
    let yaw = Affine::rotation([0.0, 1.0, 0.0], 0.5);
    transformed(mesh, Affine::translation([-0.27, 0.0, 0.03]) * yaw)
}

fn cottage_walls() -> Mesh {
    at_cottage(moved(
        block([[-0.11, -0.07], [-0.11, 0.07], [0.11, 0.07], [0.11, -0.07]], 0.15),
        [0.0, -0.05, 0.0],
    ))
}

/// A gabled roof that overhangs.
fn cottage_roof() -> Mesh {
    let (x, z, low, top) = (0.12, 0.085, 0.092, 0.165);
    let positions =
        vec![[-x, low, z], [x, low, z], [x, top, 0.0], [-x, top, 0.0], [x, low, -z], [-x, low, -z]];
    let indices = vec![[0, 1, 2], [0, 2, 3], [4, 5, 3], [4, 3, 2], [1, 4, 2], [5, 0, 3]];
    at_cottage(Mesh { positions, indices, ..Mesh::default() })
}

/// A mesh whose triangles share no vertex, each with its own normal, to be joined with meshes that have normals.
fn with_flat_normals(mesh: Mesh) -> Mesh {
    let corners: Vec<[f32; 3]> = mesh.indices.iter().flatten().map(|&i| mesh.positions[i as usize]).collect();
    let count = corners.len() as u32;
    // A zero normal requests flat shading; texture coordinates exist because the others have them.
    Mesh {
        normals: vec![[0.0; 3]; corners.len()],
        texcoords: vec![[0.0; 2]; corners.len()],
        positions: corners,
        indices: (0..count / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
        ..Mesh::default()
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Light for scenes that have none: a key light from over the camera's left shoulder and a grey background.
//! Source: original. Space: world; linear light. A white matte surface that faces the key light shows about 1.
//! Proof: `tests`.

use crate::scene::{Affine, Camera, Light, Scene};

/// Irradiance of the key light.
const KEY: f32 = 2.4;
/// Radiance of the background, from all sides.
const GREY: f32 = 0.25;

/// Whether anything gives light: a light, an environment, or a surface that emits and is used.
#[must_use]
pub fn shines(scene: &Scene) -> bool {
    let emits = |material: crate::scene::MaterialId| {
        scene.materials().get(material.index()).is_some_and(|m| m.emits())
    };
    let emitting_mesh = || scene.meshes().iter().any(|mesh| !mesh.indices.is_empty() && emits(mesh.material));
    !scene.lights().is_empty() || emitting_mesh()
}

/// The lights that suit `camera`.
#[must_use]
pub fn lit_from(camera: &Camera) -> [Light; 2] {
    let direction = match camera.frame() {
        Some(frame) => [0, 1, 2].map(|k| frame.forward[k] + 0.7 * frame.right[k] - 0.8 * frame.up[k]),
        None => [0.7, -0.8, -1.0],
    };
    [
        Light::Directional { direction, irradiance: [KEY; 3] },
        Light::Environment { radiance: [GREY; 3], texture: None, world_from_light: Affine::IDENTITY },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Material, Mesh};

    #[test]
    fn light_comes_over_the_left_shoulder() {
        let camera = Camera {
            name: String::new(),
            eye: [0.0; 3],
            target: [0.0, 0.0, -1.0],
            up: [0.0, 1.0, 0.0],
            fov_y: 45.0,
        };
        let [Light::Directional { direction: [x, y, z], .. }, Light::Environment { .. }] = lit_from(&camera)
        else {
            panic!("a key light and a background");
        };
        assert!(x > 0.0 && y < 0.0 && z < 0.0, "to the right, down and into the picture: {x} {y} {z}");
    }

    #[test]
    fn emitting_surfaces_are_light() {
        let mut scene = Scene::new();
        let dark = scene.add_material(Material::matte("dark", [0.5; 3]));
        let mut lamp = Material::matte("lamp", [0.5; 3]);
        lamp.emission = [0.0, 1.0, 0.0];
        let lamp = scene.add_material(lamp);
        assert!(!shines(&scene), "a material that nothing is made of gives no light");
        let mesh = Mesh {
            positions: vec![[0.0; 3]; 3],
            indices: vec![[0, 1, 2]],
            material: dark,
            ..Mesh::default()
        };
        let mesh = scene.add_mesh(mesh);
        assert!(!shines(&scene), "a dark surface");
        scene.edit_mesh(mesh).material = lamp;
        assert!(shines(&scene), "a shining one");
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! The element under the cursor: numbers and names of instance, object, mesh, triangle and material.
//! Space: world. Tests: `tests`.

use std::fmt;

use gnurt::accel::RayBatch;
use gnurt::camera_rays;
use gnurt::scene::Camera;
use gnurt::shading::CameraSamples;

use crate::stage::Stage;

/// Something that was hit.
#[derive(Clone, Debug, PartialEq)]
pub struct Pick {
    /// Number and name of the instance.
    pub instance: (u32, String),
    /// Number and name of the hit object: the instance's object, or one nested in it.
    pub object: (u32, String),
    /// The mesh, as an index within the object.
    pub mesh: u32,
    /// The triangle within the mesh.
    pub triangle: u32,
    /// Number and name of the material.
    pub material: (u32, String),
    /// Where.
    pub position: [f32; 3],
    /// Distance from the eye.
    pub distance: f32,
}

impl Pick {
    /// The element in the middle of a pixel of a picture of `size`; `None` if there is none.
    #[must_use]
    pub fn at(stage: &Stage, camera: &Camera, [x, y]: [u32; 2], [width, height]: [u32; 2]) -> Option<Self> {
        let rays = camera_rays(camera, stage.scripts.camera.as_ref(), [width, height])?;
        let middle = |at: u32, side: u32| (f64::from(at) + 0.5) / f64::from(side.max(1));
        let pixel_position = [middle(x, width) as f32, (1.0 - middle(y, height)) as f32];
        let mut batch = RayBatch::default();
        rays.rays(&CameraSamples::sharp(&[pixel_position]), width as f32 / height.max(1) as f32, &mut batch);
        let ray = batch.get(0);
        let hit = stage.world.intersect(&ray)?;
        let scene = &stage.scene;
        let instance = scene.instances().get(hit.inst_id as usize)?;
        // Within the instance's object, if that holds others.
        let object_id = stage.world.object_of(&hit);
        let object = scene.objects().get(object_id.index())?;
        let mesh = scene.meshes().get(object.meshes.get(hit.geom_id as usize)?.index())?;
        let material = scene.materials().get(mesh.material.index());
        Some(Self {
            instance: (hit.inst_id, instance.name.clone()),
            object: (object_id.0, object.name.clone()),
            mesh: hit.geom_id,
            triangle: hit.prim_id,
            material: (mesh.material.0, material.map(|material| material.name.clone()).unwrap_or_default()),
            position: [0, 1, 2].map(|k| ray.org[k] + hit.t * ray.dir[k]),
            distance: hit.t,
        })
    }

    /// A few short lines.
    #[must_use]
    pub fn lines(&self) -> [String; 4] {
        let named = |what: &str, (number, name): &(u32, String)| format!("{what} {number} '{name}'");
        let [x, y, z] = self.position;
        [
            named("instance", &self.instance),
            named("object", &self.object),
            format!("{}  mesh {}  triangle {}", named("material", &self.material), self.mesh, self.triangle),
            format!("at {x:.5} {y:.5} {z:.5}  distance {:.5}", self.distance),
        ]
    }
}

impl fmt::Display for Pick {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.lines().join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt::scene::{Affine, Material, Mesh, Scene};

    #[test]
    fn names_are_told() {
        let mut scene = Scene::new();
        scene.add_material(Material::matte("unused", [0.1; 3]));
        let material = scene.add_material(Material::matte("brick", [0.5; 3]));
        let mesh = scene.add_mesh(Mesh {
            positions: vec![[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [0.0, 9.0, 0.0], [0.0, 0.0, 5.0]],
            indices: vec![[0, 0, 3], [0, 1, 2]],
            material,
            ..Mesh::default()
        });
        let object = scene.add_object_of("wall", vec![mesh]);
        scene.instantiate(object, Affine::translation([0.0, 0.0, -70.0]));
        scene.instantiate(object, Affine::translation([0.0, 0.0, -5.0]));
        let pool = gnurt::thread_pool(1).expect("a thread");
        let stage = Stage::of(scene, &pool);
        let camera = |target| Camera {
            name: String::new(),
            eye: [0.0; 3],
            target,
            up: [0.0, 1.0, 0.0],
            fov_y: 45.0,
            ..Camera::default()
        };
        let pick =
            Pick::at(&stage, &camera([0.0, 0.0, -1.0]), [50, 50], [101, 101]).expect("a wall is ahead");
        assert_eq!(pick.instance, (1, "wall".into()), "the near one");
        assert_eq!((pick.mesh, pick.triangle), (0, 1), "the triangle that has an area");
        assert_eq!(pick.material, (1, "brick".into()), "its material");
        assert!((pick.distance - 5.0).abs() < 1e-5 && (pick.position[2] + 5.0).abs() < 1e-5, "{pick:?}");
        for word in ["instance 1", "'wall'", "triangle 1", "'brick'", "distance 5.0"] {
            assert!(pick.to_string().contains(word), "'{word}' in: {pick}");
        }
        assert_eq!(Pick::at(&stage, &camera([0.0, 0.0, 1.0]), [5, 5], [9, 9]), None, "nothing behind");
    }
}

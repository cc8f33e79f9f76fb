// SPDX-License-Identifier: GPL-3.0-or-later
//! The subject of a measurement: a scene as one mesh in world space, seen from one position, with one light.
//! The views are those of earlier measurements of other programs. Space: world.
//! Tests: `tests::instances_are_copied`.

use gnurt::accel::{Aabb, Triangles};
use gnurt::scene::{Camera, Scene};

use crate::vector::{V3, along, length, minus, unit};

/// A scene, ready to be measured.
#[derive(Clone, Debug)]
pub struct Subject {
    /// As reports name it.
    pub name: String,
    /// Vertices, and one more that no triangle uses: Embree reads 16 bytes where a vertex has 12.
    pub(crate) padded: Vec<[f32; 3]>,
    pub(crate) indices: Vec<[u32; 3]>,
    pub(crate) camera: Camera,
    pub(crate) light: V3,
    pub(crate) diagonal: f32,
}

/// A known view of a known scene.
struct View {
    /// Names of scenes: beginnings of file names without their extension.
    scene: &'static str,
    eye: V3,
    target: V3,
    up: V3,
    fov_y: f32,
    light: V3,
}

const Y: V3 = [0.0, 1.0, 0.0];
const Z: V3 = [0.0, 0.0, 1.0];

#[rustfmt::skip]
const VIEWS: [View; 6] = [
    View { scene: "conference", eye: [31.0, 3.5, 6.2], target: [14.0, 13.0, 2.2], up: Z, fov_y: 62.0, light: [18.0, 11.0, 7.5] },
    View { scene: "dragon", eye: [-0.006, 0.16, 0.32], target: [-0.006, 0.122, 0.0], up: Y, fov_y: 38.0, light: [0.2, 0.4, 0.3] },
    View { scene: "sponza", eye: [-13.0, -0.6, 3.2], target: [5.0, 0.8, 4.2], up: Z, fov_y: 65.0, light: [0.0, 0.0, 12.0] },
    View { scene: "office", eye: [-1.9, 2.9, -1.9], target: [0.6, 1.9, 0.8], up: Y, fov_y: 70.0, light: [0.1, 3.5, 0.2] },
    View { scene: "soda", eye: [2.4, 1.7, 5.9], target: [-0.8, 1.1, 0.0], up: Y, fov_y: 50.0, light: [0.5, 2.2, 1.5] },
    View { scene: "buddha", eye: [0.3, 0.3, 4.6], target: [-0.05, 0.0, 0.0], up: Y, fov_y: 27.0, light: [2.0, 3.0, 3.0] },
];

impl Subject {
    /// All visible instances of a scene as one mesh. `name` is its name in reports; a known name has its own
    /// view, other scenes use their first camera, or else one that shows all of them.
    #[must_use]
    pub fn new(name: &str, scene: &Scene) -> Self {
        let (mut padded, indices) = flattened(scene);
        let bounds = Aabb::around(&padded);
        padded.push([0.0; 3]);
        let known = VIEWS.iter().find(|view| name.starts_with(view.scene));
        let camera = match known {
            Some(view) => Camera {
                name: name.to_owned(),
                eye: view.eye,
                target: view.target,
                up: view.up,
                fov_y: view.fov_y,
                ..Camera::default()
            },
            None => scene
                .cameras()
                .first()
                .cloned()
                .unwrap_or_else(|| gnurt::defaults::framing(gnurt::defaults::bounds_of(scene), 1.0)),
        };
        let (low, high) = (bounds.min, bounds.max);
        let light = known.map_or_else(|| light_mesh(low, high, &camera), |view| view.light);
        Self { name: name.to_owned(), padded, indices, camera, light, diagonal: length(minus(high, low)) }
    }

    /// Its triangles.
    #[must_use]
    pub fn triangles(&self) -> Triangles<'_> {
        Triangles { positions: &self.padded[..self.padded.len() - 1], indices: &self.indices }
    }

    /// How many there are.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        self.indices.len()
    }
}

/// The light of an unknown scene: under its ceiling if the camera is inside, else near the camera.
fn light_mesh(low: V3, high: V3, camera: &Camera) -> V3 {
    let middle = [0, 1, 2].map(|k| 0.5 * (low[k] + high[k]));
    let up = unit(camera.up);
    let is_inside = (0..3).all(|k| low[k] < camera.eye[k] && camera.eye[k] < high[k]);
    let height: f32 = (0..3).map(|k| up[k].abs() * (high[k] - low[k])).sum();
    if is_inside {
        along(middle, 0.4 * height, up)
    } else {
        along(camera.eye, 0.5 * length(minus(camera.eye, middle)), up)
    }
}

/// Vertices and triangles of all visible instances, in world space.
fn flattened(scene: &Scene) -> (Vec<V3>, Vec<[u32; 3]>) {
    let (mut positions, mut indices): (Vec<V3>, Vec<[u32; 3]>) = (Vec::new(), Vec::new());
    for found in scene.occurrences() {
        for mesh in found.object.meshes.iter().filter_map(|id| scene.meshes().get(id.index())) {
            let first = positions.len() as u32;
            let to_world = |p: &V3| found.world_from_object.point(p.map(f64::from)).map(|x| x as f32);
            positions.extend(mesh.positions.iter().map(to_world));
            // Triangles with invalid vertices are dropped, as trees drop them.
            let whole =
                mesh.indices.iter().filter(|t| t.iter().all(|&i| (i as usize) < mesh.positions.len()));
            indices.extend(whole.map(|triangle| triangle.map(|i| first + i)));
        }
    }
    (positions, indices)
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt::scene::{Affine, Mesh};

    #[test]
    fn instances_are_copied() {
        let mut scene = Scene::new();
        let mesh = scene.add_mesh(Mesh {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]],
            indices: vec![[0, 1, 2], [0, 1, 9]],
            ..Mesh::default()
        });
        let object = scene.add_object_of("triangle", vec![mesh]);
        scene.instantiate(object, Affine::translation([10.0, 0.0, 0.0]));
        scene.instantiate(object, Affine::translation([20.0, 0.0, 0.0]));
        let subject = Subject::new("two", &scene);
        assert_eq!(subject.triangle_count(), 2, "one whole triangle per instance");
        let triangles = subject.triangles();
        let corner = triangles.positions[triangles.indices[1][1] as usize];
        assert_eq!(corner, [21.0, 0.0, 0.0], "in world space");
        assert_eq!(subject.padded.len(), 7, "one vertex more than there are");
    }
}

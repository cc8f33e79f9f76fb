// SPDX-License-Identifier: GPL-3.0-or-later
//! The box around a scene, from the description alone. Space: world; double precision.
//! Corners of triangles count, and balls around the vertices of curves and spheres: unused points and points that are not
//! finite are ignored.
//! Invariant: `min <= max` in each axis. Tests: `tests::counts_what_is_seen`.

use crate::scene::{Affine, Mesh, Primitives, Scene};

/// A box along the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Least coordinates.
    pub min: [f64; 3],
    /// Greatest coordinates.
    pub max: [f64; 3],
}

impl Bounds {
    /// The middle.
    #[must_use]
    pub fn center(&self) -> [f64; 3] {
        [0, 1, 2].map(|k| 0.5 * (self.min[k] + self.max[k]))
    }

    /// The eight corners.
    #[must_use]
    pub fn corners(&self) -> [[f64; 3]; 8] {
        std::array::from_fn(|i| [0, 1, 2].map(|k| if i >> k & 1 == 0 { self.min[k] } else { self.max[k] }))
    }

    /// Whether a point lies within, its faces excluded.
    #[must_use]
    pub fn contains(&self, p: [f64; 3]) -> bool {
        (0..3).all(|k| self.min[k] < p[k] && p[k] < self.max[k])
    }

    /// Its corners elsewhere.
    fn moved(self, to: Affine) -> [[f64; 3]; 8] {
        self.corners().map(|corner| to.point(corner))
    }

    fn around(points: impl IntoIterator<Item = [f64; 3]>) -> Option<Self> {
        let finite = points.into_iter().filter(|p| p.iter().all(|x| x.is_finite()));
        finite.fold(None, |bounds, p| {
            let Self { min, max } = bounds.unwrap_or(Self { min: p, max: p });
            Some(Self { min: [0, 1, 2].map(|k| min[k].min(p[k])), max: [0, 1, 2].map(|k| max[k].max(p[k])) })
        })
    }
}

/// The box around all visible instances; `None` if there is nothing to see.
///
/// An instance contributes the box of its object's box, which may be larger than the instance where it is
/// rotated.
#[must_use]
pub fn bounds_of(scene: &Scene) -> Option<Bounds> {
    let mut known = Known {
        meshes: scene.meshes().iter().map(|mesh| mesh_bounds(mesh)).collect(),
        objects: vec![None; scene.objects().len()],
        unfolds: scene.levels().is_ok(),
    };
    let visible = scene.instances().iter().filter(|instance| instance.visible);
    let corners = visible.flat_map(|instance| {
        let to = instance.world_from_object;
        known.boxes(scene, instance.object.index()).into_iter().flat_map(move |bounds| bounds.moved(to))
    });
    Bounds::around(corners)
}

/// Boxes of meshes, and of objects that hold others.
struct Known {
    meshes: Vec<Option<Bounds>>,
    /// `None` = not known yet.
    objects: Vec<Option<Option<Bounds>>>,
    /// Whether no object holds itself.
    unfolds: bool,
}

impl Known {
    /// Boxes around all of an object: those of its meshes, and one for each object in it.
    fn boxes(&mut self, scene: &Scene, object: usize) -> Vec<Bounds> {
        let Some(object) = scene.objects().get(object) else { return Vec::new() };
        let meshes = object.meshes.iter().filter_map(|id| self.meshes.get(id.index()).copied().flatten());
        let mut boxes: Vec<Bounds> = meshes.collect();
        let members = if self.unfolds { &object.members[..] } else { &[] };
        for member in members {
            let bounds = self.object(scene, member.object.index());
            boxes.extend(bounds.and_then(|bounds| Bounds::around(bounds.moved(member.object_from_member))));
        }
        boxes
    }

    /// The box of an object, computed once.
    fn object(&mut self, scene: &Scene, object: usize) -> Option<Bounds> {
        if let Some(known) = self.objects[object] {
            return known;
        }
        let boxes = self.boxes(scene, object);
        let found = Bounds::around(boxes.into_iter().flat_map(|bounds| [bounds.min, bounds.max]));
        self.objects[object] = Some(found);
        found
    }
}

/// Times at which a clip is sampled.
const LOOKS: u32 = 9;

/// The box around all visible instances while a clip is played, sampled at several times; the scene shows the
/// clip's first time afterwards. Panics if there is no such clip.
pub fn bounds_over(scene: &mut Scene, clip: usize) -> Option<Bounds> {
    let range = scene.animation().map(|animation| animation.clips[clip].range());
    let [first, last] = range.expect("the scene has an animation");
    let corners = (0..LOOKS).rev().flat_map(|i| {
        scene.pose(clip, first + (last - first) * f64::from(i) / f64::from(LOOKS - 1));
        bounds_of(scene).into_iter().flat_map(|bounds| [bounds.min, bounds.max])
    });
    Bounds::around(corners.collect::<Vec<_>>())
}

fn mesh_bounds(mesh: &Mesh) -> Option<Bounds> {
    let radii = match &mesh.primitives {
        Primitives::Triangles => {
            let corners = mesh.indices.iter().flatten().filter_map(|&i| mesh.positions.get(i as usize));
            return Bounds::around(corners.map(|p| p.map(f64::from)));
        }
        Primitives::Curves(curves) => &curves.radii,
        Primitives::Spheres(radii) => radii,
    };
    let balls = mesh.positions.iter().zip(radii).filter(|(_, radius)| **radius > 0.0);
    Bounds::around(
        balls.flat_map(|(p, &radius)| {
            [-1.0, 1.0].map(|side| p.map(|x| f64::from(x) + side * f64::from(radius)))
        }),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Member;

    #[test]
    fn counts_what_is_seen() {
        let mut scene = Scene::new();
        assert_eq!(bounds_of(&scene), None, "nothing to see");
        let stray = [f32::NAN, 9.0, 9.0];
        let mesh = scene.add_mesh(Mesh {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [99.0; 3], stray],
            indices: vec![[0, 1, 2], [0, 1, 4]],
            ..Mesh::default()
        });
        let object = scene.add_object_of("triangle", vec![mesh]);
        assert_eq!(bounds_of(&scene), None, "an object alone is not seen");
        scene.instantiate(object, Affine::translation([10.0, 0.0, 0.0]));
        let hidden = scene.instantiate(object, Affine::translation([-10.0, 0.0, 0.0]));
        scene.edit_instance(hidden).visible = false;
        let bounds = bounds_of(&scene).expect("a triangle is seen");
        assert_eq!(
            bounds,
            Bounds { min: [10.0, 0.0, 0.0], max: [11.0, 2.0, 0.0] },
            "strays and hidden ones do not count"
        );
        let far = [5.0, 7.0].map(|y| Member::new(object, Affine::translation([0.0, y, 0.0])));
        let pair = scene.add_object_of_members("pair", far.to_vec());
        scene.instantiate(pair, Affine::translation([11.0, 1.0, 0.0]));
        let bounds = bounds_of(&scene).expect("more triangles");
        assert_eq!(bounds.max, [12.0, 10.0, 0.0], "objects in objects count");
    }

    #[test]
    fn counts_radii() {
        let mut scene = Scene::new();
        let primitives = Primitives::Spheres(vec![2.0, 0.0]);
        let mesh =
            scene.add_mesh(Mesh { positions: vec![[1.0; 3], [9.0; 3]], primitives, ..Mesh::default() });
        let object = scene.add_object_of("ball", vec![mesh]);
        scene.instantiate(object, Affine::translation([0.0; 3]));
        assert_eq!(bounds_of(&scene), Some(Bounds { min: [-1.0; 3], max: [3.0; 3] }));
    }
}

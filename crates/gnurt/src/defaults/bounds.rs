// SPDX-License-Identifier: GPL-3.0-or-later
//! The box around a scene, from the description alone. Space: world; double precision.
//! Source: original. Corners of triangles only: points that no triangle uses do not count, nor does what is not finite.
//! Invariant: `min <= max` in each axis. Proof: `tests::counts_what_is_seen`.

use crate::scene::{Affine, Mesh, Scene};

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
/// An instance contributes the box of its object's box, which may be larger than the instance where it is turned.
#[must_use]
pub fn bounds_of(scene: &Scene) -> Option<Bounds> {
    let meshes: Vec<Option<Bounds>> = scene.meshes().iter().map(|mesh| mesh_bounds(mesh)).collect();
    let corners_of = |bounds: Option<Bounds>, to: Affine| {
        bounds.into_iter().flat_map(move |b| b.corners().map(|corner| to.point(corner)))
    };
    let visible = scene.instances().iter().filter(|instance| instance.visible);
    Bounds::around(visible.flat_map(|instance| {
        let object = scene.objects().get(instance.object.index());
        let boxes = object.into_iter().flat_map(|object| &object.meshes).map(|id| meshes.get(id.index()));
        boxes
            .flat_map(move |b| corners_of(b.copied().flatten(), instance.world_from_object))
            .collect::<Vec<_>>()
    }))
}

/// Moments at which a clip is looked at.
const LOOKS: u32 = 9;

/// The box around all visible instances while a clip is played, looked at from time to time; the scene shows the clip's first moment
/// afterwards. Panics if there is no such clip.
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
    let corners = mesh.indices.iter().flatten().filter_map(|&i| mesh.positions.get(i as usize));
    Bounds::around(corners.map(|p| p.map(f64::from)))
}

#[cfg(test)]
mod tests {
    use super::*;

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
    }
}

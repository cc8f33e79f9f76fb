// SPDX-License-Identifier: GPL-3.0-or-later
//! Points and normals of a mesh that something bends. Space: that of the skeleton. Tests: `tests/skeletons.rs`.

use gnurt_scene::subdivision::Faces;

use crate::attributes::{Attribute, Elements, Spread};

/// A mesh as something bends it.
#[derive(Clone, Debug)]
pub(crate) struct Bent {
    pub(crate) points: Vec<[f32; 3]>,
    /// By point: what turns normals; empty = nothing.
    pub(crate) rotations: Vec<[[f32; 3]; 3]>,
}

impl Bent {
    /// Turns normals with the points that they stand on.
    pub(crate) fn rotate(&self, faces: &Faces, normals: &mut Attribute) {
        if self.rotations.is_empty() {
            return;
        }
        let rotated = |element: u32, point: u32| {
            let n: [f32; 3] = normals.get(element, [0.0; 3]);
            let [a, b, c] = self.rotations[point as usize];
            [0, 1, 2].map(|k| a[k] * n[0] + b[k] * n[1] + c[k] * n[2])
        };
        let (values, spread): (Vec<[f32; 3]>, Spread) = match normals.is_of_points() {
            true => {
                let points = 0..faces.vertices() as u32;
                let elements = Elements::InOrder(points.len());
                let values = points.map(|point| rotated(normals.element(0, 0, point), point));
                (values.collect(), Spread::Points(elements, false))
            }
            false => {
                let corners =
                    (0..faces.len()).flat_map(|face| faces.range(face).map(move |corner| (face, corner)));
                let values = corners.map(|(face, corner)| {
                    let point = faces.corners()[corner];
                    rotated(normals.element(face, corner, point), point)
                });
                (values.collect(), Spread::Corners(Elements::InOrder(faces.corners().len())))
            }
        };
        *normals = Attribute { width: 3, values: values.into_flattened(), spread };
    }
}

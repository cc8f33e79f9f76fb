// SPDX-License-Identifier: GPL-3.0-or-later
//! The current normal, colour and texture coordinates, and how they become a vertex.
//! Source: OpenGL 1.x; normals go with the inverse transpose and are made unit per vertex.
//! Space: as given by the program; a vertex is in object space. Tests: tests/c/scene.c.

use super::enums::MatrixMode;
use super::geometry::Vertex;
use super::matrix::Matrix;
use super::stacks::Stacks;

/// Attributes of the next vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Current {
    /// Red, green, blue, alpha.
    pub(crate) color: [f32; 4],
    /// Any length.
    pub(crate) normal: [f64; 3],
    /// s, t, r, q.
    pub(crate) texcoord: [f64; 4],
}

impl Default for Current {
    fn default() -> Self {
        Self { color: [1.0; 4], normal: [0.0, 0.0, 1.0], texcoord: [0.0, 0.0, 0.0, 1.0] }
    }
}

/// The matrices that a block's vertices go through; `None` where one is the identity, as in most objects.
#[derive(Clone, Debug)]
pub(crate) struct Transforms {
    point: Option<Matrix>,
    normal: Option<[[f64; 3]; 3]>,
    texture: Option<Matrix>,
}

impl Transforms {
    /// The present tops of the stacks.
    #[must_use]
    pub(crate) fn of(stacks: &Stacks) -> Self {
        let top = |mode| Some(stacks.top(mode).matrix).filter(|matrix| *matrix != Matrix::IDENTITY);
        let point = top(MatrixMode::Modelview);
        Self { point, normal: point.map(|matrix| matrix.normal_matrix()), texture: top(MatrixMode::Texture) }
    }
}

impl Current {
    /// The vertex at `position`, with a normal if the program has given one.
    #[inline]
    #[must_use]
    pub(crate) fn vertex(&self, transforms: &Transforms, position: [f64; 4], has_normal: bool) -> Vertex {
        let [x, y, z] = homogeneous(transforms.point.as_ref(), position);
        let normal = if has_normal { self.unit_normal(transforms.normal.as_ref()) } else { [0.0; 3] };
        let texcoord = transforms.texture.as_ref().map_or(self.texcoord, |m| m.apply(self.texcoord));
        Vertex {
            position: [x as f32, y as f32, z as f32],
            normal,
            texcoord: texcoord.map(|x| x as f32),
            color: self.color,
        }
    }

    /// The normal in object space, of unit length; zero if it has no direction.
    #[inline]
    fn unit_normal(&self, matrix: Option<&[[f64; 3]; 3]>) -> [f32; 3] {
        let mut n = self.normal;
        if let Some([a, b, c]) = matrix {
            let along = |k: usize| a[k] * n[0] + b[k] * n[1] + c[k] * n[2];
            n = [along(0), along(1), along(2)];
        }
        let [x, y, z] = n;
        let squared = x * x + y * y + z * z;
        // Most programs give unit normals: one step of Newton's method is exact to single precision there, and cheaper.
        let scale = if (squared - 1.0).abs() < 1e-6 { 1.5 - 0.5 * squared } else { 1.0 / squared.sqrt() };
        // No direction: zero, or too long for a number.
        if scale > 0.0 && scale.is_finite() {
            [(x * scale) as f32, (y * scale) as f32, (z * scale) as f32]
        } else {
            [0.0; 3]
        }
    }
}

/// The point with w = 1.
#[inline]
fn homogeneous(matrix: Option<&Matrix>, point: [f64; 4]) -> [f64; 3] {
    let [x, y, z, w] = matrix.map_or(point, |matrix| matrix.apply(point));
    if w == 1.0 { [x, y, z] } else { [x / w, y / w, z / w] }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! The current normal, colour and texture coordinates, and how they become a vertex (rtNormal*, rtColor*, rtTexCoord*).
//! Source: OpenGL 1.x; normals go with the inverse transpose and are made unit per vertex.
//! Space: as given by the program; a vertex is in object space. Proof: tests/c/scene.c.

use crate::context::Context;
use crate::enums::MatrixMode;
use crate::geometry::Vertex;
use crate::matrix::Matrix;
use crate::stacks::Stacks;

/// What the next vertex takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Current {
    /// Red, green, blue, alpha.
    pub color: [f32; 4],
    /// Any length.
    pub normal: [f64; 3],
    /// s, t, r, q.
    pub texcoord: [f64; 4],
}

impl Default for Current {
    fn default() -> Self {
        Self { color: [1.0; 4], normal: [0.0, 0.0, 1.0], texcoord: [0.0, 0.0, 0.0, 1.0] }
    }
}

/// The matrices that a block's vertices go through.
#[derive(Clone, Debug)]
pub struct Transforms {
    /// None where it is the identity, as in most objects: the point stays as it is.
    point: Option<Matrix>,
    normal: [[f64; 3]; 3],
    /// None where it is the identity.
    texture: Option<Matrix>,
}

impl Transforms {
    /// The present tops of the stacks.
    #[must_use]
    pub fn of(stacks: &Stacks) -> Self {
        let point = stacks.top(MatrixMode::Modelview).matrix;
        let texture = stacks.top(MatrixMode::Texture).matrix;
        let texture = Some(texture).filter(|matrix| *matrix != Matrix::IDENTITY);
        let normal = point.normal_matrix();
        Self { point: Some(point).filter(|matrix| *matrix != Matrix::IDENTITY), normal, texture }
    }
}

impl Current {
    /// The vertex at `position`, with a normal if the program has given one.
    #[inline]
    #[must_use]
    pub fn vertex(&self, transforms: &Transforms, position: [f64; 4], has_normal: bool) -> Vertex {
        let [x, y, z, w] = transforms.point.map_or(position, |matrix| matrix.apply(position));
        let position = if w == 1.0 { [x, y, z] } else { [x / w, y / w, z / w] };
        let normal = if has_normal { self.unit_normal(&transforms.normal) } else { [0.0; 3] };
        let [s, t, _, q] = transforms.texture.map_or(self.texcoord, |matrix| matrix.apply(self.texcoord));
        let texcoord = if q == 1.0 { [s, t] } else { [s / q, t / q] };
        Vertex {
            position: position.map(|x| x as f32),
            normal,
            texcoord: texcoord.map(|x| x as f32),
            color: self.color,
        }
    }

    /// The normal in object space, of unit length; zero if it has no direction.
    #[inline]
    fn unit_normal(&self, [a, b, c]: &[[f64; 3]; 3]) -> [f32; 3] {
        let n = self.normal;
        let moved = [0, 1, 2].map(|k| a[k] * n[0] + b[k] * n[1] + c[k] * n[2]);
        let squared = moved.iter().map(|x| x * x).sum::<f64>();
        // Most programs give unit normals: one step of Newton's method is exact to single precision there, and cheaper.
        if (squared - 1.0).abs() < 1e-6 {
            return moved.map(|x| (x * (1.5 - 0.5 * squared)) as f32);
        }
        let length = squared.sqrt();
        let is_direction = length > 0.0 && length.is_finite();
        if is_direction { moved.map(|x| (x / length) as f32) } else { [0.0; 3] }
    }
}

impl Context {
    /// rtNormal*: legal everywhere.
    #[inline]
    pub fn normal(&mut self, normal: [f64; 3]) {
        self.current.normal = normal;
        // The unnamed object began before any object that is open: the normal came after both.
        self.unnamed.has_normals = true;
        if let Some(open) = &mut self.open {
            open.assembly.has_normals = true;
        }
    }

    /// rtTexCoord*: legal everywhere.
    #[inline]
    pub fn tex_coord(&mut self, texcoord: [f64; 4]) {
        self.current.texcoord = texcoord;
    }

    /// rtColor*: legal everywhere.
    #[inline]
    pub fn color(&mut self, color: [f32; 4]) {
        self.current.color = color;
    }
}

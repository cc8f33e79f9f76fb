// SPDX-License-Identifier: GPL-3.0-or-later
//! Triangle meshes as plain arrays.
//! Attribute rates after the paper's Figure 1 (parameters per triangle and per vertex).
//! Space: object. Invariant: after `Scene::check` every index is below `positions.len()` and optional arrays are empty or full.

use serde::{Deserialize, Serialize};

use crate::affine::Affine;
use crate::id::MaterialId;
use crate::primitives::Primitives;

/// Indexed triangles, curves or spheres with one material.
///
/// The geometric normal of a triangle is `(p1 - p0) x (p2 - p0)`: counter-clockwise vertices, right-hand rule.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Mesh {
    /// A label; need not be unique.
    pub name: String,
    /// Vertex positions.
    pub positions: Vec<[f32; 3]>,
    /// Shading normals per vertex, any length; empty = flat. A zero or non-finite normal makes its triangles flat.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates per vertex, v upwards (row 0 of a picture is at v = 1); empty = all (0, 0).
    pub texcoords: Vec<[f32; 2]>,
    /// Tangents per vertex, for normal maps: the first three numbers, of any length, point to where u grows; the fourth is 1 or -1,
    /// the side of `normal x tangent` to which v grows. Empty, or zero at a vertex = derived from the texture
    /// coordinates.
    pub tangents: Vec<[f32; 4]>,
    /// Colours per vertex, linear red, green, blue and opacity, multiplied to the base colour; empty = white.
    pub colors: Vec<[f32; 4]>,
    /// Vertices of each triangle.
    pub indices: Vec<[u32; 3]>,
    /// Curves or spheres over the vertices, in place of triangles.
    pub primitives: Primitives,
    /// Its material.
    pub material: MaterialId,
    /// Further values that shaders request by name.
    pub attributes: Vec<Attribute>,
}

/// Name of the attribute, two floats per vertex, with a third texture coordinate and the divisor of all
/// three. Where a mesh has it, its texture coordinates are those before the division, which is done where a
/// ray hits: as in OpenGL, a divisor that changes over a triangle makes a projection. Lists of lights ignore
/// it.
pub const TEXCOORD_RQ: &str = "texcoord_rq";

/// Name of the attribute, two floats per vertex, with a second set of texture coordinates, v upwards.
pub const TEXCOORD_1: &str = "texcoord_1";

/// A named value per triangle or per vertex.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Attribute {
    /// The name that a shader requests.
    pub name: String,
    /// How often the value changes over the surface.
    pub rate: Rate,
    /// Floats per value, 1 to 16.
    pub components: u32,
    /// `components` floats for each triangle or vertex, in order.
    pub data: Vec<f32>,
}

/// How often a value changes over a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Rate {
    /// One value per triangle, segment of a curve or sphere.
    Triangle,
    /// One value per vertex, interpolated barycentrically.
    Vertex,
}

impl Mesh {
    /// The divisors of the texture coordinates of these vertices, if any; see [`TEXCOORD_RQ`].
    #[must_use]
    pub fn texcoord_divisors(&self, vertices: [usize; 3]) -> Option<[f32; 3]> {
        let is_it = |a: &&Attribute| a.rate == Rate::Vertex && a.components == 2 && a.name == TEXCOORD_RQ;
        let data = &self.attributes.iter().find(is_it)?.data;
        Some(vertices.map(|i| data.get(2 * i + 1).copied().unwrap_or(1.0)))
    }

    /// The second set of texture coordinates, `[u, v]` after each other; empty where there is none.
    #[must_use]
    pub fn second_texcoords(&self) -> &[f32] {
        let is_it = |a: &&Attribute| a.rate == Rate::Vertex && a.components == 2 && a.name == TEXCOORD_1;
        self.attributes.iter().find(is_it).map_or(&[], |attribute| &attribute.data)
    }

    /// How many primitives it has.
    #[must_use]
    pub fn primitive_count(&self) -> usize {
        match &self.primitives {
            Primitives::Triangles => self.indices.len(),
            Primitives::Curves(curves) => curves.segments.len(),
            Primitives::Spheres(radii) => radii.len(),
        }
    }

    /// The area of its triangles, or of its spheres, where a transform puts them; of spheres it must be a similarity. Curves have none.
    #[must_use]
    pub fn area(&self, to: &Affine) -> f64 {
        match &self.primitives {
            Primitives::Triangles => {
                let corner = |i: u32| to.point(self.positions[i as usize].map(f64::from));
                let of = |triangle: &[u32; 3]| {
                    let [a, b, c] = triangle.map(corner);
                    let [u, v]: [[f64; 3]; 2] = [b, c].map(|p| std::array::from_fn(|k| p[k] - a[k]));
                    let cross =
                        [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
                    0.5 * cross.iter().map(|x| x * x).sum::<f64>().sqrt()
                };
                self.indices.iter().map(of).sum()
            }
            Primitives::Spheres(radii) => {
                let scale2 = to.columns[0].iter().map(|x| x * x).sum::<f64>();
                let squares = radii.iter().map(|&radius| f64::from(radius).powi(2)).sum::<f64>();
                4.0 * std::f64::consts::PI * scale2 * squares
            }
            Primitives::Curves(_) => 0.0,
        }
    }

    /// Whether it is made of triangles.
    #[must_use]
    pub fn has_triangles(&self) -> bool {
        self.primitives == Primitives::Triangles
    }

    /// The vertices whose values a primitive mixes, by the weights `1 - u - v`, `u` and `v` of a hit. Along a segment values
    /// change with `u` alone. `None` if there is no such primitive.
    #[must_use]
    #[inline]
    pub fn corners(&self, prim_id: usize) -> Option<[usize; 3]> {
        match &self.primitives {
            Primitives::Triangles => Some(self.indices.get(prim_id)?.map(|i| i as usize)),
            Primitives::Curves(curves) => {
                let first = *curves.segments.get(prim_id)?;
                let [a, b] = curves.basis.ends().map(|i| (first + i) as usize);
                Some([a, b, a])
            }
            Primitives::Spheres(_) => Some([prim_id; 3]),
        }
    }

    /// Bytes that its arrays hold.
    #[must_use]
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&self.positions[..])
            + size_of_val(&self.normals[..])
            + size_of_val(&self.texcoords[..])
            + size_of_val(&self.tangents[..])
            + size_of_val(&self.colors[..])
            + size_of_val(&self.indices[..])
            + self.primitives.memory_bytes()
            + self.attributes.iter().map(|a| size_of_val(&a.data[..])).sum::<usize>()
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Batches of surface points, as structures of arrays: what one call of a shader sees.
//! Source: original, shaped by the paper's section 8 (who writes a shader sees one point, the machine sees lanes).
//! Space: world. Invariant: all arrays of a batch have `len()` lanes, and every lane is live.

use glam::Vec3;

/// Three floats per lane: points, directions or colours.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Vec3s {
    /// First components.
    pub x: Vec<f32>,
    /// Second components.
    pub y: Vec<f32>,
    /// Third components.
    pub z: Vec<f32>,
}

impl Vec3s {
    /// `n` lanes of `value`.
    #[must_use]
    pub fn splat(n: usize, value: Vec3) -> Self {
        Self { x: vec![value.x; n], y: vec![value.y; n], z: vec![value.z; n] }
    }

    /// Number of lanes.
    #[must_use]
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// Whether there are no lanes.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// Lane `i`.
    #[must_use]
    pub fn get(&self, i: usize) -> Vec3 {
        Vec3::new(self.x[i], self.y[i], self.z[i])
    }

    /// Writes lane `i`.
    pub fn set(&mut self, i: usize, value: Vec3) {
        self.x[i] = value.x;
        self.y[i] = value.y;
        self.z[i] = value.z;
    }

    /// Adds to lane `i`.
    pub fn add(&mut self, i: usize, value: Vec3) {
        self.set(i, self.get(i) + value);
    }

    /// Appends a lane.
    pub fn push(&mut self, value: Vec3) {
        self.x.push(value.x);
        self.y.push(value.y);
        self.z.push(value.z);
    }

    /// Makes it `n` lanes of `value` and keeps the memory.
    pub fn reset(&mut self, n: usize, value: Vec3) {
        for (array, v) in [(&mut self.x, value.x), (&mut self.y, value.y), (&mut self.z, value.z)] {
            array.clear();
            array.resize(n, v);
        }
    }
}

/// Which sample of which pixel a lane belongs to: the key of its random numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SampleKey {
    /// Pixel, row by row from the upper left one.
    pub pixel: u32,
    /// Sample within the pixel, from 0.
    pub sample: u32,
    /// Hash of the path so far (0 for camera rays), so that two branches draw different numbers.
    pub branch: u32,
}

/// Surface points that share one shader, world space.
#[derive(Clone, Debug, Default)]
pub struct SurfaceBatch {
    /// Points.
    pub p: Vec3s,
    /// Unit geometric normals, counter-clockwise, as the mesh has them: not flipped.
    pub ng: Vec3s,
    /// Unit shading normals, interpolated, as the mesh has them: not flipped; the geometric one where the mesh has none.
    pub ns: Vec3s,
    /// Unit directions of the rays that came here.
    pub ray_dir: Vec3s,
    /// Distances they came, world units.
    pub t: Vec<f32>,
    /// Barycentric weights of the second vertices.
    pub u: Vec<f32>,
    /// Barycentric weights of the third vertices.
    pub v: Vec<f32>,
    /// Texture coordinates, v upwards.
    pub texcoord: [Vec<f32>; 2],
    /// Change of the position per texture u, world units, not unit; zero where the mesh has no texture coordinates.
    pub dp_du: Vec3s,
    /// Vertex colours, linear; white where the mesh has none.
    pub color: Vec3s,
    /// Vertex opacities; 1 where the mesh has none.
    pub alpha: Vec<f32>,
    /// Triangles within their meshes.
    pub prim_id: Vec<u32>,
    /// Meshes within their objects.
    pub geom_id: Vec<u32>,
    /// Instances.
    pub inst_id: Vec<u32>,
    /// How many bounces the rays had behind them: 0 for camera rays.
    pub depth: u32,
    /// Keys of the lanes' random numbers.
    pub key: Vec<SampleKey>,
    /// Values of the attributes that the shader asked for, in its order: component k of lane i is `[k * len + i]`.
    pub attributes: Vec<Vec<f32>>,
}

impl SurfaceBatch {
    /// Number of lanes.
    #[must_use]
    pub fn len(&self) -> usize {
        self.t.len()
    }

    /// Whether there are no lanes.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.t.is_empty()
    }

    /// Geometric normal of lane `i`, turned towards where the ray came from.
    #[must_use]
    pub fn facing_ng(&self, i: usize) -> Vec3 {
        let (ng, dir) = (self.ng.get(i), self.ray_dir.get(i));
        if ng.dot(dir) > 0.0 { -ng } else { ng }
    }

    /// Whether the ray of lane `i` came from the side that the geometric normal points to.
    #[must_use]
    pub fn front(&self, i: usize) -> bool {
        self.ng.get(i).dot(self.ray_dir.get(i)) <= 0.0
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! The island's ground: a height field with colours by height and steepness.
//! Source: after [Mus93]. Space: world, sea level at y = 0. Tests: `tests/builtin.rs`.

use super::super::noise::{ridged, rolling, smoothstep, value};
use super::cape;
use crate::mesh::Mesh;

/// Radius beyond which all is sea.
pub(super) const REACH: f32 = 6.0;
/// Samples of the height field along each side.
const SAMPLES: usize = 400;
/// Ground deeper than this is left out, because it is never visible.
const DEEPEST: f32 = -0.06;

/// The height field.
pub(super) struct Terrain {
    heights: Vec<f32>,
}

/// Properties of a point on the ground.
#[derive(Clone, Copy)]
pub(super) struct Spot {
    /// World y.
    pub(super) height: f32,
    /// 0 = bare, 1 = the heart of the wood.
    pub(super) wood: f32,
}

impl Terrain {
    pub(super) fn new() -> Self {
        let location = |i: usize| (i as f32 / (SAMPLES - 1) as f32 * 2.0 - 1.0) * REACH;
        let heights =
            (0..SAMPLES * SAMPLES).map(|k| height(location(k % SAMPLES), location(k / SAMPLES))).collect();
        Self { heights }
    }

    /// Properties of the ground at a position, directly from the noise.
    pub(super) fn spot(&self, x: f32, z: f32) -> Spot {
        let h = height(x, z);
        let steep = steepness(x, z);
        let grove = smoothstep(-0.55, 0.05, rolling(0.55 * x + 9.0, 0.55 * z, 3, 71));
        let wood =
            smoothstep(0.07, 0.16, h) * smoothstep(1.5, 0.95, h) * smoothstep(1.2, 0.65, steep) * grove;
        Spot { height: h, wood }
    }

    /// The part above (and a little below) the sea.
    pub(super) fn mesh(&self) -> Mesh {
        let mut mesh = Mesh::default();
        let step = 2.0 * REACH / (SAMPLES - 1) as f32;
        for (k, &h) in self.heights.iter().enumerate() {
            let (x, z) = ((k % SAMPLES) as f32 * step - REACH, (k / SAMPLES) as f32 * step - REACH);
            let slope = |di: isize, dj: isize| self.at(k, di, dj) - self.at(k, -di, -dj);
            let normal = [-slope(1, 0), 2.0 * step, -slope(0, 1)];
            let length = normal.iter().map(|n| n * n).sum::<f32>().sqrt();
            mesh.positions.push([x, h, z]);
            mesh.normals.push(normal.map(|n| n / length));
            mesh.colors.push(color(x, z, h, normal[1] / length));
        }
        for j in 0..SAMPLES - 1 {
            for i in 0..SAMPLES - 1 {
                let [a, b, c, d] =
                    [(i, j), (i, j + 1), (i + 1, j + 1), (i + 1, j)].map(|(i, j)| j * SAMPLES + i);
                if [a, b, c, d].iter().any(|&k| self.heights[k] > DEEPEST) {
                    let [a, b, c, d] = [a, b, c, d].map(|k| k as u32);
                    mesh.indices.extend([[a, b, c], [a, c, d]]);
                }
            }
        }
        mesh.drop_unused_vertices();
        mesh
    }

    /// The height at a neighbour of sample `k`, or at the edge.
    fn at(&self, k: usize, di: isize, dj: isize) -> f32 {
        let neighbour = |p: usize, d: isize| p.saturating_add_signed(d).min(SAMPLES - 1);
        self.heights[neighbour(k / SAMPLES, dj) * SAMPLES + neighbour(k % SAMPLES, di)]
    }
}

/// Height above the sea.
fn height(x: f32, z: f32) -> f32 {
    let distance = (x * x + 1.25 * z * z).sqrt();
    // Bays and capes: the coast is pushed in and out.
    let coast = 4.1 + 1.25 * rolling(0.42 * x + 3.1, 0.42 * z - 1.7, 4, 5);
    let inland = smoothstep(coast + 0.6, coast - 2.9, distance);
    let crests = ridged(0.34 * x + 1.3, 0.34 * z + 0.4, 6, 23);
    let summit = (-((x + 0.9).powi(2) + (z + 0.9).powi(2)) / 3.6).exp();
    let hills = 0.16 + 0.5 * crests * crests + 1.05 * summit * (0.45 + 0.9 * crests * crests);
    let h = inland * hills + 0.04 * rolling(2.5 * x, 2.5 * z, 4, 41) * inland - 0.13 * (1.0 - inland);
    cape::shape_ground(x, z, h)
}

/// Rise over run.
fn steepness(x: f32, z: f32) -> f32 {
    const D: f32 = 0.03;
    let slope_x = height(x + D, z) - height(x - D, z);
    let slope_z = height(x, z + D) - height(x, z - D);
    (slope_x * slope_x + slope_z * slope_z).sqrt() / (2.0 * D)
}

/// Sand, grass, rock; `up` is the normal's y.
fn color(x: f32, z: f32, h: f32, up: f32) -> [f32; 4] {
    let patch = 0.5 + 0.5 * value(3.0 * x, 3.0 * z, 91);
    let fine = 0.85 + 0.3 * (0.5 + 0.5 * value(23.0 * x, 23.0 * z, 92));
    let mix = |a: [f32; 3], b: [f32; 3], t: f32| [0, 1, 2].map(|k| a[k] + (b[k] - a[k]) * t);
    let sand = mix([0.62, 0.50, 0.34], [0.34, 0.26, 0.18], smoothstep(0.02, -0.01, h));
    let grass = mix([0.105, 0.155, 0.045], [0.22, 0.215, 0.075], patch);
    let rock = mix([0.23, 0.205, 0.185], [0.36, 0.33, 0.30], patch);
    let ground = mix(sand, grass, smoothstep(0.045, 0.10, h + 0.03 * (patch - 0.5)));
    let bare = smoothstep(0.86, 0.72, up - 0.12 * smoothstep(0.9, 1.5, h)) * smoothstep(0.03, 0.08, h);
    let [r, g, b] = mix(ground, rock, bare).map(|c| c * fine);
    [r, g, b, 1.0]
}

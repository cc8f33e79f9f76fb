// SPDX-License-Identifier: GPL-3.0-or-later
//! The Utah teapot: Martin Newell's 32 bicubic Bezier patches.
//! Source: the numbers that M. E. Newell published in 1975, in the form that OpenGL programs draw: three
//! quarters as high as his first ones, with a bottom. Rim, body, lid and bottom are a quarter each, rotated;
//! handle and spout a half, mirrored.
//! Space: Newell's z is up; the caller gets y up and the middle of the height at the origin.
//! Tests: `tests::{patches_fit, points_outwards}`; the pictures of examples/c.

use crate::grid::emit;
use crate::sink::{Sink, Vertex};

/// Four points of a profile, from the middle of the top downwards: radius, height, and the radius times 0.56
/// (0.45 / 0.8 once) that makes a cubic close to a quarter of a circle.
type Profile = [[f64; 3]; 4];

const PROFILES: [Profile; 6] = [
    // Rim.
    [[1.4, 2.4, 0.784], [1.3375, 2.53125, 0.749], [1.4375, 2.53125, 0.805], [1.5, 2.4, 0.84]],
    // Body.
    [[1.5, 2.4, 0.84], [1.75, 1.875, 0.98], [2.0, 1.35, 1.12], [2.0, 0.9, 1.12]],
    [[2.0, 0.9, 1.12], [2.0, 0.45, 1.12], [1.5, 0.225, 0.84], [1.5, 0.15, 0.84]],
    // Lid.
    [[0.0, 3.15, 0.0], [0.8, 3.15, 0.45], [0.0, 2.85, 0.0], [0.2, 2.7, 0.112]],
    [[0.2, 2.7, 0.112], [0.4, 2.55, 0.224], [1.3, 2.55, 0.728], [1.3, 2.4, 0.728]],
    // Bottom.
    [[1.5, 0.15, 0.84], [1.5, 0.075, 0.84], [1.425, 0.0, 0.798], [0.0, 0.0, 0.0]],
];

/// A half of a tube: along it four cross-sections; of each the x and z of its inner and its outer edge and its half width.
type Tube = [[f64; 5]; 4];

const TUBES: [Tube; 4] = [
    // Handle, from the top.
    [
        [-1.6, 2.025, -1.5, 2.25, 0.3],
        [-2.3, 2.025, -2.5, 2.25, 0.3],
        [-2.7, 2.025, -3.0, 2.25, 0.3],
        [-2.7, 1.8, -3.0, 1.8, 0.3],
    ],
    [
        [-2.7, 1.8, -3.0, 1.8, 0.3],
        [-2.7, 1.575, -3.0, 1.35, 0.3],
        [-2.5, 1.125, -2.65, 0.9375, 0.3],
        [-2.0, 0.9, -1.9, 0.6, 0.3],
    ],
    // Spout, from the body.
    [
        [1.7, 1.425, 1.7, 0.6, 0.66],
        [2.6, 1.425, 3.1, 0.825, 0.66],
        [2.3, 2.1, 2.4, 2.025, 0.25],
        [2.7, 2.4, 3.3, 2.4, 0.25],
    ],
    [
        [2.7, 2.4, 3.3, 2.4, 0.25],
        [2.8, 2.475, 3.525, 2.49375, 0.25],
        [2.9, 2.475, 3.45, 2.5125, 0.15],
        [2.8, 2.4, 3.2, 2.4, 0.15],
    ],
];

/// Control points of a patch: `[along t][along s]`. ds x dt points outwards.
type Patch = [[[f64; 3]; 4]; 4];

/// Quads along the side of a patch.
const CELLS: u32 = 10;

/// rtutTeapot; nothing unless `size` is positive and finite.
pub fn teapot(sink: &mut dyn Sink, size: f64) {
    if !(size > 0.0 && size.is_finite()) {
        return;
    }
    for patch in patches() {
        emit(sink, CELLS, CELLS, |s, t| {
            let (position, normal) = (point(&patch, s, t), normal(&patch, s, t));
            let scale = size * 0.5;
            Vertex {
                position: [scale * position[0], scale * (position[2] - 1.5), -scale * position[1]],
                normal: [normal[0], normal[2], -normal[1]],
                texcoord: [s, t],
            }
        });
    }
}

/// All 32.
fn patches() -> impl Iterator<Item = Patch> {
    let turned = PROFILES.iter().flat_map(|profile| (0..4).map(move |quarter| revolved(profile, quarter)));
    turned.chain(TUBES.iter().flat_map(|tube| [half_tube(tube, -1.0), half_tube(tube, 1.0)]))
}

/// A quarter of a body of revolution, `quarter` right angles around the axis.
fn revolved(profile: &Profile, quarter: usize) -> Patch {
    let turn = |[x, y, z]: [f64; 3]| match quarter {
        0 => [x, y, z],
        1 => [-y, x, z],
        2 => [-x, -y, z],
        _ => [y, -x, z],
    };
    // Bottom row first, so that t points up where the outside is seen.
    std::array::from_fn(|row| {
        let [radius, z, inner] = profile[3 - row];
        [[radius, 0.0, z], [radius, inner, z], [inner, radius, z], [0.0, radius, z]].map(turn)
    })
}

/// The half of a tube on one side of the plane y = 0.
fn half_tube(tube: &Tube, side: f64) -> Patch {
    std::array::from_fn(|row| {
        let [x0, z0, x1, z1, width] = tube[row];
        let y = side * width;
        let mut section = [[x0, 0.0, z0], [x0, y, z0], [x1, y, z1], [x1, 0.0, z1]];
        if side > 0.0 {
            section.reverse();
        }
        section
    })
}

/// Bernstein's cubics.
fn weights(x: f64) -> [f64; 4] {
    let y = 1.0 - x;
    [y * y * y, 3.0 * x * y * y, 3.0 * x * x * y, x * x * x]
}

/// Their derivatives.
fn slopes(x: f64) -> [f64; 4] {
    let y = 1.0 - x;
    [-3.0 * y * y, 3.0 * y * y - 6.0 * x * y, 6.0 * x * y - 3.0 * x * x, 3.0 * x * x]
}

fn blend(patch: &Patch, along_s: [f64; 4], along_t: [f64; 4]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (row, wt) in patch.iter().zip(along_t) {
        for (control, ws) in row.iter().zip(along_s) {
            (0..3).for_each(|k| sum[k] += ws * wt * control[k]);
        }
    }
    sum
}

fn point(patch: &Patch, s: f64, t: f64) -> [f64; 3] {
    blend(patch, weights(s), weights(t))
}

/// Where an edge has shrunk to a point, the normal a little further inside is taken.
fn normal(patch: &Patch, s: f64, t: f64) -> [f64; 3] {
    let mut at = [s, t];
    loop {
        let [s, t] = at;
        let (a, b) = (blend(patch, slopes(s), weights(t)), blend(patch, weights(s), slopes(t)));
        let n = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
        let length = n.iter().map(|x| x * x).sum::<f64>().sqrt();
        if length > 1e-6 || at == [0.5; 2] {
            return n.map(|x| x / length.max(f64::MIN_POSITIVE));
        }
        at = if (t - 0.5).abs() > 0.49 { [s, t + (0.5 - t) * 0.01] } else { [0.5; 2] };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sink::tests::Mesh;

    #[test]
    fn patches_fit() {
        assert_eq!(patches().count(), 32, "Newell's 32");
        let [rim, body] = [revolved(&PROFILES[0], 1), revolved(&PROFILES[1], 1)];
        assert_eq!(rim[0], body[3], "the body goes on where the rim ends");
        let mut mesh = Mesh::default();
        teapot(&mut mesh, 1.0);
        // The lid's top and the bottom's middle are points: half of a row of quads is nothing there, for four patches each.
        assert_eq!(mesh.triangles.len(), 32 * 200 - 8 * 10, "triangles");
        let heights = || mesh.triangles.iter().flatten().map(|v| v.position[1]);
        let (low, high) = (heights().fold(9.0, f64::min), heights().fold(-9.0, f64::max));
        assert!((low + 0.75).abs() < 1e-9 && (high - 0.825).abs() < 1e-9, "from {low} to {high}");
    }

    #[test]
    fn points_outwards() {
        let mut mesh = Mesh::default();
        teapot(&mut mesh, 2.0);
        mesh.check_normals();
        // Seen from its own middle, a part's outside is away from it: its volume is positive. Only the rim
        // has none.
        let body = [0.0, 0.0, 1.0];
        for (what, first, count, middle) in [
            ("body", 4, 8, body),
            ("lid", 12, 8, body),
            ("bottom", 20, 4, body),
            ("handle", 24, 4, [-2.4, 0.0, 1.6]),
            ("spout", 28, 4, [2.4, 0.0, 1.6]),
        ] {
            let mut part = Mesh::default();
            for patch in patches().skip(first).take(count) {
                emit(&mut part, CELLS, CELLS, |s, t| {
                    let p = point(&patch, s, t);
                    let position = std::array::from_fn(|k| p[k] - middle[k]);
                    Vertex { position, normal: normal(&patch, s, t), texcoord: [s, t] }
                });
            }
            assert!(part.volume() > 0.1, "the {what} is right side out: {}", part.volume());
        }
    }

    #[test]
    fn bad_sizes_give_nothing() {
        for size in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let mut mesh = Mesh::default();
            teapot(&mut mesh, size);
            assert!(mesh.triangles.is_empty(), "{size}");
        }
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Cut surfaces: no cracks, every vertex computed once, parameters of cells.

use std::collections::HashMap;

use gnurt_subdivision::{Boundary, Cage, Faces, Scheme, Surface, Tessellation, TooManyCells};

/// A prism over a pentagon and one over a triangle: quadrangles and others.
fn prism(n: i32) -> (Faces, Vec<f64>) {
    let mut counts = vec![4; n as usize];
    let mut corners: Vec<i32> = (0..n).flat_map(|i| [i, (i + 1) % n, n + (i + 1) % n, n + i]).collect();
    counts.extend([n, n]);
    corners.extend((0..n).rev().chain(n..2 * n));
    let at = |i: i32| {
        let angle = f64::from(i % n) / f64::from(n) * std::f64::consts::TAU;
        [angle.cos(), angle.sin(), f64::from(i / n)]
    };
    let faces = Faces::new(&counts, &corners, 2 * n as usize).expect("a prism");
    (faces, (0..2 * n).flat_map(at).collect())
}

fn cage(faces: Faces) -> Cage {
    let (creases, corners) = (Vec::new(), Vec::new());
    Cage::new(Surface { scheme: Scheme::CatmullClark, boundary: Boundary::EdgeOnly, faces, creases, corners })
}

fn positions(cage: &Cage, cut: &Tessellation, control: &[f64]) -> Vec<Option<[f64; 3]>> {
    let mut positions = vec![None; cut.vertices()];
    for patch in 0..cut.patches() {
        let points = cut.points(cage, patch);
        let places: Vec<[f64; 2]> = points.iter().map(|&(_, at)| at).collect();
        let mut fill =
            |vertex: u32, values: &mut [f64]| values.copy_from_slice(&control[3 * vertex as usize..][..3]);
        cage.evaluate(cut.place(patch), &places, 3, false, &mut fill, &mut |i, jet| {
            let at = &mut positions[points[i].0 as usize];
            assert_eq!(*at, None, "vertex {} is computed once", points[i].0);
            *at = Some([jet[0], jet[1], jet[2]]);
        });
    }
    positions
}

#[test]
fn cells_meet_without_cracks() {
    let rates: [fn(usize) -> f32; 5] = [
        |_| 1.0,
        |_| 4.0,
        |corner| [1.0, 3.2, 7.0, 2.0, 5.0][corner % 5],
        |corner| (corner as f32 * 1.7) % 9.0,
        |corner| if corner % 2 == 0 { f32::NAN } else { -3.0 },
    ];
    for (i, rate) in rates.into_iter().enumerate() {
        for n in [3, 4, 5] {
            let (faces, control) = prism(n);
            let cage = cage(faces);
            let cut = Tessellation::new(&cage, rate, 1 << 20).expect("few cells");
            let (cells, positions) = (cut.cells(&cage), positions(&cage, &cut, &control));
            assert_eq!(cells.len(), cut.len(), "as many cells as were said");
            let mut ways: HashMap<[u32; 2], u32> = HashMap::new();
            for cell in &cells {
                for k in 0..4 {
                    let way = [cell[k], cell[(k + 1) % 4]];
                    *ways.entry(way).or_default() += u32::from(way[0] != way[1]);
                }
            }
            for (&[a, b], &times) in &ways {
                let back = ways.get(&[b, a]).copied().unwrap_or_default();
                assert_eq!(times, back, "rate {i}, {n} sides: {a} to {b} there and back");
            }
            // What a cell says of its vertices is where these are.
            for (number, cell) in cells.iter().enumerate() {
                let (place, corners) = cut.find(&cage, number as u32);
                let places = corners.map(|at| at.map(f64::from));
                let mut fill = |vertex: u32, values: &mut [f64]| {
                    values.copy_from_slice(&control[3 * vertex as usize..][..3])
                };
                cage.evaluate(place, &places, 3, false, &mut fill, &mut |k, jet| {
                    let there = positions[cell[k] as usize].expect("a computed vertex");
                    let off = (0..3).map(|k| (there[k] - jet[k]).abs()).fold(0.0, f64::max);
                    assert!(off < 1e-5, "rate {i}, {n} sides, cell {number} at {:?}: {off} off", places[k]);
                });
            }
        }
    }
}

#[test]
fn edges_have_their_greatest_level() {
    let (faces, _) = prism(4);
    let cage = cage(faces);
    // One face asks for 6 along one of its edges.
    let cut =
        Tessellation::new(&cage, |corner| if corner == 0 { 6.0 } else { 2.0 }, 1 << 20).expect("few cells");
    assert_eq!(cut.len(), 4 * 4 + 2 * 6 * 2, "both faces of that edge have 6 columns");
    let many = Tessellation::new(&cage, |_| 5000.0, 1_000_000);
    assert_eq!(many.err(), Some(TooManyCells(1_000_000)), "4096 squared cells of each face");
}

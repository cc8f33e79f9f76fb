// SPDX-License-Identifier: GPL-3.0-or-later
//! Points of limit surfaces, against even refinement, which ends on the limit by other code, and finite differences.

use gnurt_subdivision::{Boundary, Cage, Channel, Faces, Place, Scheme, Surface, boundary_vertices, refine};

/// Faces, positions, sharp edges and sharp vertices.
struct Mesh {
    faces: Faces,
    positions: Vec<f32>,
    creases: Vec<([u32; 2], f32)>,
    corners: Vec<(u32, f32)>,
}

fn cube() -> Mesh {
    let corners = [0, 3, 2, 1, 4, 5, 6, 7, 0, 1, 5, 4, 2, 3, 7, 6, 0, 4, 7, 3, 1, 2, 6, 5];
    let bit = |i: usize, k: usize| if i >> k & 1 == 1 { 1.0 } else { -1.0 };
    let positions = [0, 1, 3, 2, 4, 5, 7, 6].iter().flat_map(|&i| [bit(i, 0), 2.0 * bit(i, 1), bit(i, 2)]);
    let faces = Faces::new(&[4; 6], &corners, 8).expect("a cube");
    Mesh { faces, positions: positions.collect(), creases: Vec::new(), corners: Vec::new() }
}

/// An open sheet of quadrangles with a triangle, a pentagon and a valence of five.
fn sheet() -> Mesh {
    let (n, at) = (5, |x: i32, y: i32| 6 * y + x);
    let (mut counts, mut corners) = (Vec::new(), Vec::new());
    for i in 0..n * n {
        let (x, y) = (i % n, i / n);
        let quad = [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)];
        match (x, y) {
            // Cut in two.
            (1, 1) => {
                counts.extend([3, 3]);
                corners.extend([quad[0], quad[1], quad[2], quad[0], quad[2], quad[3]]);
            }
            // Without a face.
            (4, 4) => {}
            _ => {
                counts.push(4);
                corners.extend(quad);
            }
        }
    }
    // Beside a side of the sheet, with two more vertices.
    counts.push(5);
    corners.extend([at(1, 0), at(0, 0), 36, 37, at(2, 0)]);
    let height = |i: i32| (0.7 * (i % 6) as f32).sin() + (0.3 * (i * i % 7) as f32);
    let positions = (0..36).flat_map(|i| [(i % 6) as f32, (i / 6) as f32, height(i)]);
    let positions = positions.chain([0.0, -1.0, 0.5, 2.0, -1.0, 0.2]).collect();
    let faces = Faces::new(&counts, &corners, 38).expect("a sheet");
    Mesh { faces, positions, creases: Vec::new(), corners: Vec::new() }
}

fn surface(mesh: &Mesh, scheme: Scheme, boundary: Boundary) -> Surface {
    let (creases, corners) = (mesh.creases.clone(), mesh.corners.clone());
    Surface { scheme, boundary, faces: mesh.faces.clone(), creases, corners }
}

fn places(cage: &Cage) -> Vec<Place> {
    let of_face = |(face, corners): (usize, &[u32])| {
        let parts = if corners.len() == 4 { 1 } else { corners.len() as u32 };
        (0..parts).map(move |part| Place { face: face as u32, part })
    };
    cage.faces().iter().enumerate().filter(|&(face, _)| !cage.is_hidden(face)).flat_map(of_face).collect()
}

fn jets(
    cage: &Cage,
    mesh: &Mesh,
    place: Place,
    points: &[[f64; 2]],
    has_derivatives: bool,
) -> Vec<[[f64; 3]; 6]> {
    let mut jets = vec![[[f64::NAN; 3]; 6]; points.len()];
    let mut fill = |vertex: u32, values: &mut [f64]| {
        for (k, value) in values.iter_mut().enumerate() {
            *value = f64::from(mesh.positions[3 * vertex as usize + k]);
        }
    };
    cage.evaluate(place, points, 3, has_derivatives, &mut fill, &mut |i, jet| {
        jets[i] = std::array::from_fn(|j| std::array::from_fn(|k| jet[3 * j + k]));
    });
    jets
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// All points at multiples of 1/8 are the vertices of three steps, and these are all of them.
fn agrees_with_refinement(mesh: &Mesh, scheme: Scheme, boundary: Boundary, what: &str) {
    let level = 3;
    let surface = surface(mesh, scheme, boundary);
    let channel = Channel { width: 3, values: mesh.positions.clone(), corners: None, is_linear: false };
    let refined = refine(&surface, vec![channel], level);
    let at = |&i: &u32| [0, 1, 2].map(|k| f64::from(refined.channels[0].values[3 * i as usize + k]));
    let mut vertices: Vec<u32> = refined.faces.corners().to_vec();
    vertices.sort_unstable();
    vertices.dedup();
    let vertices: Vec<[f64; 3]> = vertices.iter().map(at).collect();
    let mut is_found = vec![false; vertices.len()];
    let cage = Cage::new(surface);
    for place in places(&cage) {
        // A part of a face was cut once already.
        let is_quad = cage.faces().range(place.face as usize).len() == 4;
        let n = if is_quad { 1 << level } else { 1 << (level - 1) };
        let points: Vec<[f64; 2]> =
            (0..=n).flat_map(|j| (0..=n).map(move |i| [i, j].map(|x| f64::from(x) / f64::from(n)))).collect();
        let jets = jets(&cage, mesh, place, &points, false);
        for (point, jet) in points.iter().zip(&jets) {
            let near = vertices.iter().enumerate().map(|(i, &v)| (distance(v, jet[0]), i));
            let (off, nearest) = near.min_by(|a, b| a.0.total_cmp(&b.0)).expect("vertices");
            assert!(off < 2e-6, "{what}: {place:?} at {point:?}: {:?} is {off} off", jet[0]);
            is_found[nearest] = true;
        }
    }
    let missed = is_found.iter().filter(|&&found| !found).count();
    assert_eq!(missed, 0, "{what}: vertices that no point reaches, of {}", vertices.len());
}

#[test]
fn points_are_those_of_even_refinement() {
    let (cube, sheet) = (cube(), sheet());
    agrees_with_refinement(&cube, Scheme::CatmullClark, Boundary::EdgeOnly, "a cube");
    for boundary in [Boundary::EdgeOnly, Boundary::EdgeAndCorner, Boundary::None] {
        agrees_with_refinement(&sheet, Scheme::CatmullClark, boundary, "a sheet");
    }
    agrees_with_refinement(&sheet, Scheme::Bilinear, Boundary::EdgeOnly, "a flat sheet");
    let mut pinned = self::sheet();
    pinned.corners =
        boundary_vertices(&pinned.faces).into_iter().map(|vertex| (vertex, f32::INFINITY)).collect();
    agrees_with_refinement(&pinned, Scheme::CatmullClark, Boundary::EdgeOnly, "a pinned sheet");
    for sharpness in [0.7, 2.3, f32::INFINITY] {
        let mut sharp = self::sheet();
        // Through the sheet, with a corner in it, and one that ends inside, for which even refinement has its limit later.
        let through = [[12, 13], [13, 14], [14, 15], [15, 21], [21, 27], [27, 33]];
        let ending = if sharpness.is_finite() { vec![[20, 26], [13, 7]] } else { Vec::new() };
        sharp.creases = through.into_iter().chain(ending).map(|ends| (ends, sharpness)).collect();
        sharp.corners = vec![(8, sharpness), (28, 0.5 * sharpness)];
        agrees_with_refinement(&sharp, Scheme::CatmullClark, Boundary::EdgeOnly, "a sharp sheet");
        let mut sharp = self::cube();
        let ending = if sharpness.is_finite() { vec![[4, 5]] } else { Vec::new() };
        let around = [[0, 1], [1, 2], [2, 3], [0, 3]].into_iter().chain(ending);
        sharp.creases = around.map(|ends| (ends, sharpness)).collect();
        agrees_with_refinement(&sharp, Scheme::CatmullClark, Boundary::EdgeOnly, "a sharp cube");
    }
}

#[test]
fn derivatives_are_those_of_differences() {
    let mut mesh = sheet();
    mesh.creases = [[13, 14], [14, 15], [15, 16]].map(|ends| (ends, f32::INFINITY)).to_vec();
    for scheme in [Scheme::CatmullClark, Scheme::Bilinear] {
        let cage = Cage::new(surface(&mesh, scheme, Boundary::EdgeOnly));
        let h = 1.0 / 1024.0;
        for place in places(&cage) {
            for [u, v] in [[0.3, 0.6], [0.55, 0.13], [0.8, 0.9]] {
                let around = [[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1], [1, 1], [-1, -1], [1, -1], [-1, 1]];
                let points = around.map(|[i, j]| [u + f64::from(i) * h, v + f64::from(j) * h]);
                let jets = jets(&cage, &mesh, place, &points, true);
                for k in [0, 1, 2] {
                    let p = |i: usize| jets[i][0][k];
                    let found = [
                        (p(1) - p(2)) / (2.0 * h),
                        (p(3) - p(4)) / (2.0 * h),
                        (p(1) - 2.0 * p(0) + p(2)) / (h * h),
                        (p(3) - 2.0 * p(0) + p(4)) / (h * h),
                        (p(5) + p(6) - p(7) - p(8)) / (4.0 * h * h),
                    ];
                    for (i, found) in found.into_iter().enumerate() {
                        let given = jets[0][i + 1][k];
                        let off = if i < 2 { 1e-4 } else { 0.15 };
                        assert!(
                            (given - found).abs() < off * (1.0 + found.abs()),
                            "{scheme:?} {place:?} at {u}, {v}: derivative {i} of {k}: {given}, by differences {found}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn normals_are_there_at_irregular_corners() {
    let mesh = cube();
    let cage = Cage::new(surface(&mesh, Scheme::CatmullClark, Boundary::EdgeOnly));
    let mut normals: Vec<([f64; 3], [f64; 3])> = Vec::new();
    for place in places(&cage) {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        for jet in jets(&cage, &mesh, place, &corners, true) {
            let [p, a, b] = [jet[0], jet[1], jet[2]];
            let across = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
            let length = across.iter().map(|x| x * x).sum::<f64>().sqrt();
            assert!(length > 1e-3, "{place:?} has a normal");
            let normal = across.map(|x| x / length);
            if let Some((_, other)) = normals.iter().find(|(at, _)| distance(*at, p) < 1e-5) {
                assert!(distance(normal, *other) < 0.01, "one normal of three faces: {normal:?}, {other:?}");
            }
            normals.push((p, normal));
        }
    }
}

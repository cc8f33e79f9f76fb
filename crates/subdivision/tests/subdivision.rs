// SPDX-License-Identifier: GPL-3.0-or-later
//! Subdivision surfaces: closed forms of limits, invariants of refinement.

use gnurt_subdivision::{
    Boundary, Channel, Faces, FacesError, Scheme, Surface, affordable_level, refine, smooth_normals,
};

const CUBE_COUNTS: [i32; 6] = [4; 6];
const CUBE: [i32; 24] = [0, 3, 2, 1, 4, 5, 6, 7, 0, 1, 5, 4, 2, 3, 7, 6, 0, 4, 7, 3, 1, 2, 6, 5];

fn cube_points() -> Vec<f32> {
    let bit = |i: usize, k: usize| if i >> k & 1 == 1 { 1.0 } else { -1.0 };
    let order = [0, 1, 3, 2, 4, 5, 7, 6];
    order.iter().flat_map(|&i| [bit(i, 0), bit(i, 1), bit(i, 2)]).collect()
}

fn positions(values: Vec<f32>) -> Channel {
    Channel { width: 3, values, corners: None, is_linear: false }
}

fn surface(scheme: Scheme, faces: Faces) -> Surface {
    Surface { scheme, boundary: Boundary::default(), faces, creases: Vec::new(), corners: Vec::new() }
}

fn cube(scheme: Scheme) -> Surface {
    surface(scheme, Faces::new(&CUBE_COUNTS, &CUBE, 8).expect("a cube"))
}

fn points(channel: &Channel) -> Vec<[f32; 3]> {
    channel.values.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect()
}

fn grid(n: i32) -> (Faces, Vec<f32>) {
    let at = |x: i32, y: i32| y * (n + 1) + x;
    let face =
        |i: i32| [at(i % n, i / n), at(i % n + 1, i / n), at(i % n + 1, i / n + 1), at(i % n, i / n + 1)];
    let corners: Vec<i32> = (0..n * n).flat_map(face).collect();
    let points =
        (0..(n + 1) * (n + 1)).flat_map(|i| [(i % (n + 1)) as f32, (i / (n + 1)) as f32, 0.0]).collect();
    (Faces::new(&vec![4; (n * n) as usize], &corners, ((n + 1) * (n + 1)) as usize).expect("a grid"), points)
}

#[test]
fn a_cubes_corners_end_where_the_masks_say() {
    // One step: face points at 1, edge points at (1 + 1/2) / 2 = 3/4, vertex points at 5/9.
    let one = refine(&Surface { ..cube(Scheme::Bilinear) }, vec![positions(cube_points())], 1);
    assert_eq!(one.faces.len(), 24, "a quadrangle at each corner");
    assert_eq!(points(&one.channels[0])[20], [0.0, 0.0, -1.0], "the middle of the first face");
    let smooth = refine(&cube(Scheme::CatmullClark), vec![positions(cube_points())], 1);
    // The limit of a vertex of valence 3 is (9 v + 4 sum e + sum f) / 24 of the refined points.
    // With v = 5/9, e = 3/4 twice and 0, f = 1 once, it is (5 + 4 (3/4 + 3/4) + 1) / 24 = 1/2.
    let corner = points(&smooth.channels[0])[0];
    assert!(corner.iter().all(|x| (x + 0.5).abs() < 1e-6), "{corner:?}");
    // The limit does not depend on the level.
    let deeper = refine(&cube(Scheme::CatmullClark), vec![positions(cube_points())], 4);
    let same = points(&deeper.channels[0])[0];
    assert!(same.iter().all(|x| (x + 0.5).abs() < 1e-5), "{same:?}");
    assert!(
        deeper.parents.iter().all(|&parent| parent < 6) && deeper.faces.len() == 6 * 256,
        "faces of the cube"
    );
}

#[test]
fn flat_and_linear_things_stay() {
    let (faces, values) = grid(4);
    let texcoords = Channel {
        width: 2,
        values: values.chunks_exact(3).flat_map(|p| [p[0], p[1]]).collect(),
        corners: Some(faces.corners().to_vec()),
        is_linear: false,
    };
    let refined = refine(&surface(Scheme::CatmullClark, faces), vec![positions(values), texcoords], 3);
    let all = points(&refined.channels[0]);
    assert!(all.iter().all(|p| p[2] == 0.0 && (0.0..=4.0).contains(&p[0])), "in its plane and its boundary");
    assert!(all.contains(&[0.0, 0.0, 0.0]) && all.contains(&[4.0, 4.0, 0.0]), "corners stay");
    // Texture coordinates were the places: linear precision inside; at the boundary both follow the same curve.
    let corners = refined.channels[1].corners.as_ref().expect("by corner");
    for (place, &vertex) in refined.faces.corners().iter().enumerate() {
        let uv = &refined.channels[1].values[2 * corners[place] as usize..][..2];
        let p = all[vertex as usize];
        assert!((uv[0] - p[0]).abs() < 0.2 && (uv[1] - p[1]).abs() < 0.2, "{uv:?} at {p:?}");
    }
}

#[test]
fn creases_keep_edges() {
    let sharp = |sharpness: f32| {
        let mut surface = cube(Scheme::CatmullClark);
        let edges =
            [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]];
        surface.creases = edges.map(|edge| (edge, sharpness)).to_vec();
        let refined = refine(&surface, vec![positions(cube_points())], 2);
        // Where the corner at (1, 1, 1) ends.
        points(&refined.channels[0])[6][0]
    };
    let (none, half, one, forever) = (sharp(0.0), sharp(0.5), sharp(1.0), sharp(10.0));
    assert_eq!(forever, 1.0, "a cube");
    assert!(none < half && half < one && one < forever, "{none} {half} {one} {forever}");
    let mut cornered = cube(Scheme::CatmullClark);
    cornered.corners = vec![(6, 10.0)];
    let refined = refine(&cornered, vec![positions(cube_points())], 3);
    assert!(points(&refined.channels[0]).contains(&[1.0, 1.0, 1.0]), "the sharp corner stays");
}

#[test]
fn boundaries() {
    let (faces, values) = grid(3);
    let with = |boundary| {
        let surface = Surface { boundary, ..surface(Scheme::CatmullClark, faces.clone()) };
        refine(&surface, vec![positions(values.clone())], 2)
    };
    assert_eq!(with(Boundary::None).faces.len(), 16, "the middle face alone");
    let least = |refined: &gnurt_subdivision::Refined| {
        refined
            .faces
            .corners()
            .iter()
            .map(|&v| points(&refined.channels[0])[v as usize])
            .map(|p| p[0] + p[1])
            .fold(9.0, f32::min)
    };
    assert_eq!(least(&with(Boundary::EdgeAndCorner)), 0.0, "the corner");
    assert!(least(&with(Boundary::EdgeOnly)) > 0.1, "it is round");
}

#[test]
fn loop_makes_triangles_smooth() {
    // An octahedron: vertices of valence 4.
    let corners = [0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5];
    let faces = Faces::new(&[3; 8], &corners, 6).expect("an octahedron");
    let values = vec![1., 0., 0., -1., 0., 0., 0., 1., 0., 0., -1., 0., 0., 0., 1., 0., 0., -1.];
    let limit = |level| {
        let refined = refine(&surface(Scheme::Loop, faces.clone()), vec![positions(values.clone())], level);
        assert_eq!(refined.faces.len(), 8 << (2 * level), "four of each");
        points(&refined.channels[0])[0]
    };
    let (one, three) = (limit(1), limit(3));
    assert!((one[0] - three[0]).abs() < 1e-5 && one[1].abs() < 1e-6, "the limit is one: {one:?} {three:?}");
    // beta = (5/8 - (3/8)^2) / 4, the limit's own share 1 - 4 / (4 + 3 / (8 beta)); the neighbours cancel out.
    let beta = (0.625 - 0.375_f64.powi(2)) / 4.0;
    let expected = 1.0 - 4.0 / (4.0 + 3.0 / (8.0 * beta));
    assert!((f64::from(three[0]) - expected).abs() < 1e-5, "{three:?}, expected {expected}");
}

#[test]
fn normals_break_at_sharp_edges() {
    let faces = Faces::new(&CUBE_COUNTS, &CUBE, 8).expect("a cube");
    let points: Vec<[f32; 3]> = cube_points().chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect();
    let (_, smooth) = smooth_normals(&faces, &points, &[]);
    assert_eq!(smooth.len(), 8, "one for each corner of the cube");
    assert!(
        smooth.iter().all(|n| n.iter().all(|x| (x.abs() - 1.0 / 3.0_f32.sqrt()).abs() < 1e-6)),
        "{smooth:?}"
    );
    let top = [[4, 5], [5, 6], [6, 7], [7, 4]].map(|edge| (edge, 10.0));
    let (corners, cut) = smooth_normals(&faces, &points, &top);
    assert_eq!(cut.len(), 12, "the upper face has its own");
    assert_eq!(cut[corners[4] as usize], [0.0, 0.0, 1.0], "straight up");
}

#[test]
fn faces_are_checked_and_levels_bounded() {
    assert_eq!(Faces::new(&[2], &[0, 1], 9), Err(FacesError::TooFew(0)));
    assert_eq!(Faces::new(&[3], &[0, 1], 9), Err(FacesError::Corners { needed: 3, given: 2 }));
    assert_eq!(
        Faces::new(&[3, 3], &[0, 1, 2, 0, 1, -1], 9),
        Err(FacesError::OutOfRange { face: 1, point: -1, points: 9 })
    );
    let (faces, _) = grid(100);
    assert_eq!(affordable_level(&faces, 2, u64::MAX), 2, "as asked");
    // 40,000 corners: 80,000 triangles at level 1, 320,000 at level 2.
    assert_eq!(affordable_level(&faces, 5, 100_000), 1, "as much as fits");
    assert_eq!(affordable_level(&faces, 5, 10), 0, "nothing");
}

#[test]
fn odd_surfaces_end() {
    // Three faces at an edge, a face that touches in one vertex, an unused vertex, an edge to itself.
    let corners = [0, 1, 2, 0, 1, 3, 0, 1, 4, 2, 5, 6, 7, 7, 0];
    let faces = Faces::new(&[3; 5], &corners, 9).expect("faces");
    let values: Vec<f32> = (0..27).map(|i| (i * 7 % 11) as f32).collect();
    for scheme in [Scheme::CatmullClark, Scheme::Loop, Scheme::Bilinear] {
        let refined = refine(&surface(scheme, faces.clone()), vec![positions(values.clone())], 2);
        let used = refined.faces.corners().iter().map(|&v| points(&refined.channels[0])[v as usize]);
        assert!(used.flatten().all(f32::is_finite), "{scheme:?}");
    }
}

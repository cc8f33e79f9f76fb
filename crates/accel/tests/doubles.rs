// SPDX-License-Identifier: GPL-3.0-or-later
//! Scenes in double precision against exact arithmetic: coordinates are whole multiples of a power of two, from the offset on, so
//! that 128-bit integers decide everything.

use std::sync::Arc;

use gnurt_accel::doubles::{DoubleError, DoubleInstance, DoubleMesh, DoubleRay, DoubleScene};
use gnurt_accel::{BuildOptions, Memory, Quality, Side, Threads};
use gnurt_testkit::{Random, closed};

/// Units of coordinates to 1.
const UNITS: f64 = (1 << 20) as f64;

type P = [i128; 3];

/// A closed mesh in units; corners are even, so that middles of edges are whole.
struct Mesh {
    corners: Vec<P>,
    faces: Vec<[u32; 3]>,
}

impl Mesh {
    fn torus(n: u32) -> Self {
        let soup = closed::torus(n);
        let even = |x: f32| 2 * (f64::from(x) * UNITS / 2.0).round() as i128;
        Self { corners: soup.positions.iter().map(|at| at.map(even)).collect(), faces: soup.indices }
    }

    fn positions(&self, offset: f64) -> Vec<[f64; 3]> {
        self.corners.iter().map(|at| at.map(|x| offset + x as f64 / UNITS)).collect()
    }

    fn face(&self, i: usize) -> [P; 3] {
        self.faces[i].map(|corner| self.corners[corner as usize])
    }
}

fn minus(a: P, b: P) -> P {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: P, b: P) -> P {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: P, b: P) -> i128 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The parameter at which a ray meets a triangle, edges and corners included, as a quotient with a positive divisor.
fn meets([a, b, c]: [P; 3], org: P, dir: P) -> Option<(i128, i128)> {
    let n = cross(minus(b, a), minus(c, a));
    let (mut depth, mut slope) = (dot(n, minus(a, org)), dot(n, dir));
    let edge = |p: P, q: P| dot(dir, cross(minus(p, org), minus(q, p))).signum();
    let signs = [edge(b, c), edge(c, a), edge(a, b)];
    if slope == 0 || (signs.contains(&1) && signs.contains(&-1)) {
        return None;
    }
    if slope < 0 {
        (depth, slope) = (-depth, -slope);
    }
    (depth >= 0).then_some((depth, slope))
}

/// The first hit's parameter, how many triangles the ray touches, and whether it passes inside of all of them.
fn by_hand(mesh: &Mesh, org: P, dir: P) -> (Option<f64>, usize) {
    let hits: Vec<(i128, i128)> =
        (0..mesh.faces.len()).filter_map(|i| meets(mesh.face(i), org, dir)).collect();
    let first = hits.iter().map(|&(depth, slope)| depth as f64 / slope as f64).min_by(f64::total_cmp);
    (first, hits.len())
}

/// Rays from lattice points to insides, edges and corners.
fn rays(mesh: &Mesh, random: &mut Random, count: usize) -> Vec<(P, P)> {
    let mut whole = |span: i128| (random.bits() as i128).rem_euclid(2 * span) - span;
    (0..count)
        .map(|i| {
            let org = [whole(5 << 20), whole(5 << 20), whole(5 << 20)];
            let [a, b, c] = mesh.face(whole(1 << 40).unsigned_abs() as usize % mesh.faces.len());
            let to = match i % 3 {
                0 => a,
                1 => [0, 1, 2].map(|k| (a[k] + b[k]) / 2),
                _ => [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3),
            };
            (org, minus(to, org))
        })
        .collect()
}

fn scene(mesh: &Mesh, offset: f64, options: &BuildOptions) -> DoubleScene {
    let positions = mesh.positions(offset);
    let meshes = [DoubleMesh::new(&positions, &mesh.faces)];
    DoubleScene::build(&meshes, &[], options, Threads::Single).expect("a sound mesh")
}

fn ray(org: P, dir: P, offset: f64) -> DoubleRay {
    DoubleRay::new(org.map(|x| offset + x as f64 / UNITS), dir.map(|x| x as f64 / UNITS))
}

#[test]
fn every_ray_is_decided_as_by_integers() {
    let mesh = Mesh::torus(12);
    let mut random = Random::new(33);
    for offset in [0.0, 1e4, 1e6, 1e8] {
        for (memory, quality) in [(Memory::default(), Quality::default()), (Memory::Compact, Quality::Fast)] {
            let scene = scene(&mesh, offset, &BuildOptions { memory, quality, ..BuildOptions::default() });
            let mut hits = Vec::new();
            for (org, dir) in rays(&mesh, &mut random, 1500) {
                let asked = ray(org, dir, offset);
                let (expected, touched) = by_hand(&mesh, org, dir);
                let found = scene.intersect(&asked).map(|hit| hit.t);
                match (expected, found) {
                    (Some(a), Some(b)) => assert!((a - b).abs() <= 1e-13 * a, "{a} is not {b} at {offset}"),
                    _ => assert_eq!(expected, found, "{org:?} {dir:?} at {offset}"),
                }
                assert_eq!(scene.occluded(&asked), expected.is_some(), "any hit at {offset}");
                scene.first_hits(&asked, usize::MAX, &mut hits);
                assert_eq!(hits.len(), touched, "all hits of {org:?} {dir:?} at {offset}");
                scene.crossing_hits(&asked, &mut hits);
                assert_eq!(hits.len(), scene.crossings(&asked) as usize, "as many as are counted");
                let is_inside = scene.contains(asked.org, !0);
                assert_eq!(hits.len() % 2 == 1, is_inside, "odd from inside, even from outside, at {offset}");
            }
        }
    }
}

#[test]
fn batches_are_as_single_rays() {
    let mesh = Mesh::torus(12);
    let mut random = Random::new(35);
    let scene = scene(&mesh, 1e6, &BuildOptions::default());
    // Runs of rays side by side, which meet the same triangle, then one that is cut short before it.
    let mut asked = Vec::new();
    for (org, dir) in rays(&mesh, &mut random, 2000) {
        let first = ray(org, dir, 1e6);
        for i in 0..4 {
            asked.push(DoubleRay { org: first.org.map(|x| x + 1e-4 * f64::from(i)), ..first });
        }
        let t = scene.intersect(&first).map_or(0.5, |hit| hit.t);
        asked.push(first.within(0.0, 0.999 * t));
        asked.push(DoubleRay { dir: first.dir.map(|x| -x), ..first });
    }
    let occluded: Vec<bool> = asked.iter().map(|ray| scene.occluded(ray)).collect();
    let hits: Vec<_> = asked.iter().map(|ray| scene.intersect(ray)).collect();
    let met = occluded.iter().filter(|hit| **hit).count();
    assert!(met > asked.len() / 4 && met < 3 * asked.len() / 4, "some meet it: {met} of {}", asked.len());
    assert!(scene.occluded_batch(&asked, Threads::Single) == occluded, "any hit");
    assert!(scene.intersect_batch(&asked, Threads::Single) == hits, "closest hits");
}

/// 64 rays from about one place to about another, side by side.
fn bundle(random: &mut Random, offset: f64, org: P, to: P, spread: f64) -> Vec<DoubleRay> {
    let middle = ray(org, minus(to, org), offset);
    let mut near = |x: f64| x + spread * f64::from(random.unit() - 0.5);
    (0..64).map(|_| DoubleRay { dir: middle.dir.map(&mut near), ..middle }).collect()
}

#[test]
fn rays_side_by_side_are_as_single_rays() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("threads start");
    let mesh = Mesh::torus(24);
    let mut random = Random::new(36);
    for offset in [0.0, 1e6, 1e8] {
        let scene = scene(&mesh, offset, &BuildOptions::default());
        let (mut asked, mut alike) = (Vec::new(), 0);
        for (i, (org, dir)) in rays(&mesh, &mut random, 300).into_iter().enumerate() {
            let to = [0, 1, 2].map(|k| org[k] + dir[k]);
            // From one ray 64 times, aimed at an edge or a corner, to a fan wider than the mesh.
            let spread = [0.0, 1e-9, 0.01, 0.3, 4.0][i % 5];
            let mut tile = bundle(&mut random, offset, org, to, spread);
            for (k, ray) in tile.iter_mut().enumerate() {
                match i % 7 {
                    // Of several origins, which go elsewhere into the tree.
                    1 => ray.org[k % 3] += 1e-3 * k as f64,
                    2 if k % 3 == 0 => *ray = ray.within(0.1, 0.999),
                    3 => ray.org = ray.org.map(|x| x - 1e4 * (x - offset)),
                    4 if k == 40 => ray.dir = [f64::NAN; 3],
                    5 if k % 2 == 0 => ray.dir = ray.dir.map(|x| x * 1e-12),
                    _ => {}
                }
            }
            let signs = |ray: &DoubleRay| ray.dir.map(f64::is_sign_negative);
            alike += usize::from(tile.iter().all(|ray| signs(ray) == signs(&tile[0])));
            asked.append(&mut tile);
        }
        assert!(alike > 150, "{alike} of 300 go side by side");
        asked.truncate(asked.len() - 20);
        let hits: Vec<_> = asked.iter().map(|ray| scene.intersect(ray)).collect();
        let met = hits.iter().flatten().count();
        assert!(met > asked.len() / 4 && met < asked.len(), "some meet it: {met} of {}", asked.len());
        for threads in [Threads::Single, Threads::Pool(&pool)] {
            let found = scene.intersect_batch(&asked, threads);
            assert_eq!(found.len(), hits.len());
            let differ = found.iter().zip(&hits).position(|(a, b)| a != b);
            assert_eq!(differ.map(|i| (i, asked[i], found[i], hits[i])), None, "at {offset}");
        }
    }
}

#[test]
fn the_lowest_number_counts_at_one_place() {
    let mesh = Mesh::torus(12);
    let mut random = Random::new(34);
    // Each triangle twice, the second time with other corners first.
    let turned = mesh.faces.iter().map(|&[a, b, c]| [b, c, a]);
    let faces: Vec<[u32; 3]> = mesh.faces.iter().copied().chain(turned).collect();
    for offset in [0.0, 1e8] {
        let positions = mesh.positions(offset);
        let meshes = [DoubleMesh::new(&positions, &faces)];
        let options = BuildOptions::default();
        let scene = DoubleScene::build(&meshes, &[], &options, Threads::Single).expect("a sound mesh");
        let unit = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]];
        let shown = DoubleInstance { shown: Arc::new(scene.clone()), placement: unit, mask: !0 };
        let placed = DoubleScene::build(&[], &[shown], &options, Threads::Single).expect("an instance");
        for (org, dir) in rays(&mesh, &mut random, 3000) {
            // The first by integers: `a / b < c / d` as `a * d < c * b`.
            let hits = (0..mesh.faces.len()).filter_map(|i| meets(mesh.face(i), org, dir).map(|at| (at, i)));
            let is_before = |(a, b): (i128, i128), (c, d): (i128, i128)| {
                (a as f64 / b as f64 - c as f64 / d as f64).abs() > 1e-12
                    && a as f64 / (b as f64) < c as f64 / d as f64
            };
            let first = hits.reduce(|best, hit| if is_before(hit.0, best.0) { hit } else { best });
            let expected = first.map(|(_, i)| i as u32);
            for scene in [&scene, &placed] {
                let found = scene.intersect(&ray(org, dir, offset)).map(|hit| hit.prim_id);
                assert_eq!(found, expected, "{org:?} {dir:?} at {offset}");
            }
        }
    }
}

#[test]
fn far_origins_lose_nothing() {
    let mesh = Mesh::torus(8);
    let scene = scene(&mesh, 0.0, &BuildOptions::default());
    let mut random = Random::new(4);
    for (org, dir) in rays(&mesh, &mut random, 600) {
        // From a million times farther away, in integers.
        let far = [0, 1, 2].map(|k| org[k] - 1_000_000 * dir[k]);
        let asked = ray(far, dir, 0.0);
        let (expected, _) = by_hand(&mesh, far, dir);
        let found = scene.intersect(&asked).map(|hit| hit.t);
        let is_right = expected.zip(found).map_or(expected == found, |(a, b)| (a - b).abs() <= 1e-13 * a);
        assert!(is_right, "{expected:?} is not {found:?} from {far:?}");
    }
}

#[test]
fn instances_are_as_exact() {
    let mesh = Mesh::torus(8);
    let inner = Arc::new(scene(&mesh, 0.0, &BuildOptions::default()));
    // Whole numbers: images are lattice points.
    let place = [[0.0, 2.0, 0.0], [-3.0, 0.0, 1.0], [0.0, 0.0, 1.0], [1e6, -2e6, 4.0]];
    let instance = DoubleInstance { shown: Arc::clone(&inner), placement: place, mask: 1 };
    let (options, threads) = (BuildOptions::default(), Threads::Single);
    let pair = [
        instance.clone(),
        DoubleInstance {
            placement: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [50.0, 0.0, 0.0]],
            mask: 2,
            ..instance
        },
    ];
    let outer = DoubleScene::build(&[], &pair, &options, threads).expect("sound");
    let nested = DoubleInstance {
        shown: Arc::new(outer),
        placement: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 1e6]],
        mask: !0,
    };
    let scene = DoubleScene::build(&[], &[nested], &options, threads).expect("sound");
    let image = |p: P| {
        let [x, y, z] = p;
        let units = UNITS as i128;
        [-3 * y + 1_000_000 * units, 2 * x - 2_000_000 * units, y + z + 1_000_004 * units]
    };
    let moved =
        Mesh { corners: mesh.corners.iter().map(|&at| image(at)).collect(), faces: mesh.faces.clone() };
    let mut random = Random::new(9);
    for (org, to) in rays(&mesh, &mut random, 1200) {
        let target = image([0, 1, 2].map(|k| org[k] + to[k]));
        let org = image(org);
        let dir = minus(target, org);
        let asked = DoubleRay { mask: 1, ..ray(org, dir, 0.0) };
        let (expected, _) = by_hand(&moved, org, dir);
        let found = scene.intersect(&asked);
        let t = found.map(|hit| hit.t);
        let is_right = expected.zip(t).map_or(expected == t, |(a, b)| (a - b).abs() <= 1e-13 * a);
        assert!(is_right, "{expected:?} is not {t:?} from {org:?}");
        assert!(
            found.is_none_or(|hit| scene.path(hit.leaf_id) == [0, 0] && hit.inst_id == 0),
            "the way there"
        );
        let count = scene.crossings(&asked);
        assert_eq!(count % 2 == 1, scene.contains(asked.org, 1), "odd from inside only");
    }
    let away = DoubleRay { mask: 4, ..DoubleRay::new([1e6, -2e6, 0.0], [0.0, 0.0, 1.0]) };
    assert!(!scene.occluded(&away), "masked");
}

#[test]
fn points_are_as_far_as_by_hand() {
    let mesh = Mesh::torus(10);
    let mut random = Random::new(2);
    let near = scene(&mesh, 0.0, &BuildOptions::default());
    let far = scene(&mesh, 1e8, &BuildOptions::default());
    for (org, _) in rays(&mesh, &mut random, 400) {
        let point = org.map(|x| x as f64 / UNITS);
        let there = point.map(|x| x + 1e8);
        let (a, b) = (near.signed_distance(point, !0), far.signed_distance(there, !0));
        assert!((a - b).abs() <= 1e-13 * a.abs(), "{a} is not {b} far away");
        let found = near.closest_point(point, f64::INFINITY, !0).expect("a surface");
        let corners = near.normal(0, 0, found.prim_id);
        let along: f64 = (0..3).map(|k| corners[k] * (point[k] - found.point[k])).sum();
        assert!(along.abs() <= found.distance * (1.0 + 1e-12), "the normal is of unit length");
        assert!(near.closest_point(point, found.distance * 0.999, !0).is_none(), "nothing is nearer");
        let least = mesh
            .corners
            .iter()
            .map(|corner| (0..3).map(|k| (corner[k] as f64 / UNITS - point[k]).powi(2)).sum::<f64>().sqrt());
        let nearest_corner = least.fold(f64::INFINITY, f64::min);
        assert!(found.distance <= nearest_corner, "{} is beyond a corner", found.distance);
    }
    let corner = mesh.positions(1e8)[3];
    assert_eq!((far.side(corner, !0), far.signed_distance(corner, !0)), (Side::Surface, 0.0), "on it");
    assert!(far.signed_distance([f64::NAN; 3], !0).is_nan(), "no point");
}

#[test]
fn folds_that_floats_make_are_not_there() {
    // A box a thousandth of a float's step thick: in floats both sides fall together or cross.
    let (base, thin) = (1_234.567_8, 3e-8);
    let at =
        |i: usize| [base + (i & 1) as f64, base + (i >> 1 & 1) as f64, base + thin * (i >> 2 & 1) as f64];
    let positions: Vec<[f64; 3]> = (0..8).map(at).collect();
    let faces = [
        [0, 2, 1],
        [1, 2, 3],
        [4, 5, 6],
        [5, 7, 6],
        [0, 1, 4],
        [1, 5, 4],
        [2, 6, 3],
        [3, 6, 7],
        [0, 4, 2],
        [2, 4, 6],
        [1, 3, 5],
        [3, 7, 5],
    ];
    let meshes = [DoubleMesh::new(&positions, &faces)];
    let scene = DoubleScene::build(&meshes, &[], &BuildOptions::default(), Threads::Single).expect("sound");
    let through = DoubleRay::new([base + 0.5, base + 0.5, base - 5.0], [0.0, 0.0, 1.0]);
    let mut hits = Vec::new();
    scene.crossing_hits(&through, &mut hits);
    assert_eq!(hits.len(), 2, "in and out");
    assert!(hits[0].t < hits[1].t, "in this order: {hits:?}");
    assert!(scene.contains([base + 0.5, base + 0.5, base + 0.5 * thin], !0), "the middle is inside");
    assert!(!scene.contains([base + 0.5, base + 0.5, base + 2.0 * thin], !0), "beyond is outside");
}

#[test]
fn bad_input_is_counted_or_refused() {
    let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [f64::NAN, 0.0, 0.0], [2.0, 0.0, 0.0]];
    let faces = [[0, 1, 2], [0, 1, 9], [0, 1, 3], [0, 1, 4]];
    let (options, threads) = (BuildOptions::default(), Threads::Single);
    let mesh = DoubleMesh::new(&positions, &faces);
    let scene = DoubleScene::build(&[mesh], &[], &options, threads).expect("the rest is sound");
    let bad = scene.bad();
    assert_eq!((bad.bad_index, bad.nan, bad.zero_area), (1, 1, 1), "each by its fault");
    assert_eq!(scene.stats().primitives, 1, "one is left");
    for dir in [[0.0; 3], [f64::NAN, 0.0, 1.0], [f64::INFINITY, 0.0, 0.0]] {
        assert!(!scene.occluded(&DoubleRay::new([0.2, 0.2, -1.0], dir)), "{dir:?} is no direction");
    }
    for step in [4e-309, 1e-200, 1e200] {
        let hit = scene.intersect(&DoubleRay::new([0.2, 0.2, -0.01], [0.0, 0.0, step]));
        let t = hit.expect("directions may have any length").t;
        assert!((t - 0.01 / step).abs() <= 1e-13 * t, "{t} for steps of {step}");
    }
    let in_plane = DoubleRay::new([-1.0, 0.2, 0.0], [1.0, 0.0, 0.0]);
    assert!(!scene.occluded(&in_plane) && scene.crossings(&in_plane) == 0, "edge on");
    let flat = DoubleInstance { shown: Arc::new(scene), placement: [[0.0; 3]; 4], mask: !0 };
    assert_eq!(DoubleScene::build(&[], &[flat], &options, threads).err(), Some(DoubleError::Singular(0)));
    let nothing = DoubleScene::build(&[], &[], &options, threads).expect("nothing is fine");
    assert!(!nothing.occluded(&DoubleRay::new([0.0; 3], [1.0; 3])), "nothing is hit");
    assert_eq!(nothing.signed_distance([0.0; 3], !0), f64::INFINITY, "nor near");
}

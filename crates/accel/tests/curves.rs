// SPDX-License-Identifier: GPL-3.0-or-later
//! Curves of all bases and forms, at every level and in every way to ask: tubes and oriented ribbons equal their fine
//! tessellations, ribbons that face rays the nearest of many samples, cones of spheres the march along their distances.

use std::sync::Arc;

use crate::common::{QueryTarget, WATERTIGHT, options, run_queries, scene_of};
use gnurt_accel::{
    BuildOptions, CurveBasis, CurveForm, Curves, Geometry, Hit, Instance, ObjectTree, PrimitiveId, Query,
    Ray, RayBatch, Threads, Triangles,
};
use gnurt_testkit::Random;

const BASES: [CurveBasis; 5] = [
    CurveBasis::Linear,
    CurveBasis::Bezier,
    CurveBasis::BSpline,
    CurveBasis::CatmullRom,
    CurveBasis::Hermite,
];

/// Random curves that bend less than they are wide.
#[derive(Clone, Debug, Default)]
struct Hair {
    vertices: Vec<[f32; 4]>,
    tangents: Vec<[f32; 4]>,
    normals: Vec<[f32; 3]>,
    normal_tangents: Vec<[f32; 3]>,
    indices: Vec<u32>,
}

impl Hair {
    fn random(basis: CurveBasis, seed: u64, n: usize) -> Self {
        let mut random = Random::new(seed);
        let mut hair = Self::default();
        let order = if matches!(basis, CurveBasis::Linear | CurveBasis::Hermite) { 2 } else { 4 };
        for _ in 0..n {
            hair.indices.push(hair.vertices.len() as u32);
            let (mut at, mut towards) = (random.point(), random.point());
            let (normal, radius) = (random.point(), random.between(0.02, 0.08));
            for _ in 0..order {
                let width = radius * random.between(0.7, 1.3);
                hair.vertices.push([at[0], at[1], at[2], width]);
                hair.tangents.push([0.4 * towards[0], 0.4 * towards[1], 0.4 * towards[2], 0.1 * radius]);
                let turned = random.point();
                hair.normals.push([0, 1, 2].map(|k| normal[k] + 0.2 * turned[k]));
                hair.normal_tangents.push(turned.map(|x| 0.2 * x));
                at = [0, 1, 2].map(|k| at[k] + 0.4 * towards[k]);
                let turn = random.point();
                towards = [0, 1, 2].map(|k| towards[k] + 0.4 * turn[k]);
            }
        }
        hair
    }

    fn curves(&self, basis: CurveBasis, form: CurveForm) -> Curves<'_> {
        Curves {
            tangents: &self.tangents,
            normals: &self.normals,
            normal_tangents: &self.normal_tangents,
            ..Curves::new(basis, form, &self.vertices, &self.indices)
        }
    }

    /// Rays from anywhere to anywhere near a curve, some from inside.
    fn rays(&self, curves: &Curves, seed: u64, n: usize) -> RayBatch {
        let mut random = Random::new(seed);
        let ray = |_| {
            let curve = random.below(self.indices.len()) as u32;
            let at = curves.point(curve, f64::from(random.unit())).expect("a curve").map(|x| x as f32);
            let off = random.point();
            let to = [0, 1, 2].map(|k| at[k] + 0.07 * off[k]);
            let far = random.point();
            let org = [0, 1, 2].map(|k| to[k] + 3.0 * far[k]);
            let scale = random.between(0.1, 4.0);
            Ray::new(org, [0, 1, 2].map(|k| scale * (to[k] - org[k])))
        };
        (0..n).map(ray).collect()
    }
}

type V = [f64; 3];

fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(a: V) -> V {
    let length = dot(a, a).sqrt();
    a.map(|x| x / length)
}

fn add(a: V, t: f64, b: V) -> V {
    [0, 1, 2].map(|k| a[k] + t * b[k])
}

fn place(p: [f64; 4]) -> V {
    [p[0], p[1], p[2]]
}

fn build(geometry: Geometry, kind: usize) -> ObjectTree {
    ObjectTree::build_from(&[geometry], &options(WATERTIGHT[kind]), Threads::Single)
}

/// A grid of points as a mesh: `rows` of equal length.
fn mesh(rows: &[Vec<V>]) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let width = rows[0].len() as u32;
    let positions = rows.iter().flatten().map(|p| p.map(|x| x as f32)).collect();
    let corner = |row: u32, i: u32| row * width + i;
    let quads = (0..rows.len() as u32 - 1).flat_map(|row| (0..width - 1).map(move |i| (row, i)));
    let indices = quads.flat_map(|(row, i)| {
        let [a, b, c, d] = [corner(row, i), corner(row, i + 1), corner(row + 1, i), corner(row + 1, i + 1)];
        [[a, b, c], [b, d, c]]
    });
    (positions, indices.collect())
}

/// Fine tessellations of tubes and of oriented ribbons: one mesh for each curve.
fn tessellated(curves: &Curves, normal: &dyn Fn(u32, f64) -> V) -> ObjectTree {
    let is_round = curves.form == CurveForm::Round;
    let (steps, around) = if is_round { (200, 96) } else { (800, 8) };
    let meshes: Vec<_> = (0..curves.indices.len() as u32)
        .map(|curve| {
            let row = |i: u32| -> Vec<V> {
                let u = f64::from(i) / f64::from(steps);
                let (point, tangent) =
                    (curves.point(curve, u).expect("it"), curves.tangent(curve, u).expect("it"));
                let (center, radius) = (place(point), point[3]);
                if !is_round {
                    let side = unit(cross(normal(curve, u), tangent));
                    let at =
                        |j: u32| add(center, radius * (2.0 * f64::from(j) / f64::from(around) - 1.0), side);
                    return (0..=around).map(at).collect();
                }
                let axis = unit(tangent);
                let helper = if axis[0].abs() < 0.8 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
                let x = unit(cross(axis, helper));
                let y = cross(axis, x);
                let at = |j: u32| {
                    let (sin, cos) =
                        (std::f64::consts::TAU * f64::from(j % around) / f64::from(around)).sin_cos();
                    add(add(center, radius * cos, x), radius * sin, y)
                };
                (0..=around).map(at).collect()
            };
            mesh(&(0..=steps).map(row).collect::<Vec<_>>())
        })
        .collect();
    let triangles: Vec<Triangles> =
        meshes.iter().map(|(positions, indices)| Triangles { positions, indices }).collect();
    ObjectTree::build(&triangles, &BuildOptions::default(), Threads::Single)
}

/// Compares closest hits: where both hit the same curve, the parameter; elsewhere only rims may differ, which few rays meet.
fn assert_alike(hits: &[Option<Hit>], oracle: &[Option<(f64, u32)>], rays: &RayBatch, off: f64, what: &str) {
    let (mut same, mut differ) = (0, 0);
    for (i, (hit, other)) in hits.iter().zip(oracle).enumerate() {
        let length = dot(rays.get(i).dir.map(f64::from), rays.get(i).dir.map(f64::from)).sqrt();
        match (hit, other) {
            (None, None) => same += 1,
            (Some(hit), Some((t, curve)))
                if hit.prim_id == *curve && (f64::from(hit.t) - t).abs() * length < off =>
            {
                same += 1;
            }
            _ => differ += 1,
        }
    }
    let hit = hits.iter().flatten().count();
    assert!(hit * 4 > hits.len(), "{what}: {hit} of {} hit", hits.len());
    assert!(differ * 100 <= hits.len(), "{what}: {differ} differ, {same} do not");
}

#[test]
fn tubes_equal_their_tessellations() {
    for (seed, basis) in (1..).zip(&BASES[1..]) {
        let hair = Hair::random(*basis, seed, 12);
        let curves = hair.curves(*basis, CurveForm::Round);
        let rays = hair.rays(&curves, seed + 50, 3000);
        let hits = run_queries(&build(curves.into(), seed as usize % 3), &rays);
        let fine = tessellated(&curves, &|_, _| [0.0; 3]);
        let oracle: Vec<_> = (0..rays.len())
            .map(|i| fine.intersect(&rays.get(i)).map(|hit| (f64::from(hit.t), hit.geom_id)))
            .collect();
        assert_alike(&hits, &oracle, &rays, 5e-3, &format!("{basis:?}"));
    }
}

/// The normal of an oriented curve, from the definition of its basis.
fn normal_at(hair: &Hair, basis: CurveBasis, curve: u32, u: f64) -> V {
    let first = hair.indices[curve as usize] as usize;
    let n = |i: usize| hair.normals[first + i].map(f64::from);
    let (u2, u3) = (u * u, u * u * u);
    let sum = |weights: &[f64]| (0..).zip(weights).fold([0.0; 3], |all, (i, &w)| add(all, w, n(i)));
    match basis {
        CurveBasis::Linear => sum(&[1.0 - u, u]),
        CurveBasis::Bezier => {
            let s = 1.0 - u;
            sum(&[s * s * s, 3.0 * s * s * u, 3.0 * s * u2, u3])
        }
        CurveBasis::BSpline => sum(&[
            (1.0 - 3.0 * u + 3.0 * u2 - u3) / 6.0,
            (4.0 - 6.0 * u2 + 3.0 * u3) / 6.0,
            (1.0 + 3.0 * u + 3.0 * u2 - 3.0 * u3) / 6.0,
            u3 / 6.0,
        ]),
        CurveBasis::CatmullRom => sum(&[
            0.5 * (-u + 2.0 * u2 - u3),
            0.5 * (2.0 - 5.0 * u2 + 3.0 * u3),
            0.5 * (u + 4.0 * u2 - 3.0 * u3),
            0.5 * (u3 - u2),
        ]),
        CurveBasis::Hermite => {
            let t = |i: usize| hair.normal_tangents[first + i].map(f64::from);
            let ends = sum(&[1.0 - 3.0 * u2 + 2.0 * u3, 3.0 * u2 - 2.0 * u3]);
            add(add(ends, u - 2.0 * u2 + u3, t(0)), u3 - u2, t(1))
        }
    }
}

#[test]
fn oriented_ribbons_equal_their_tessellations() {
    for (seed, basis) in (1..).zip(BASES) {
        let hair = Hair::random(basis, seed, 12);
        let curves = hair.curves(basis, CurveForm::Oriented);
        let rays = hair.rays(&curves, seed + 50, 3000);
        let object = build(curves.into(), seed as usize % 3);
        let hits = run_queries(&object, &rays);
        let fine = tessellated(&curves, &|curve, u| normal_at(&hair, basis, curve, u));
        let oracle: Vec<_> = (0..rays.len())
            .map(|i| fine.intersect(&rays.get(i)).map(|hit| (f64::from(hit.t), hit.geom_id)))
            .collect();
        assert_alike(&hits, &oracle, &rays, 5e-3, &format!("{basis:?}"));
        for (i, hit) in hits.iter().enumerate().filter_map(|(i, hit)| Some((i, (*hit)?))) {
            let (ray, u) = (rays.get(i), f64::from(hit.u));
            let (point, tangent) =
                (curves.point(hit.prim_id, u).expect("it"), curves.tangent(hit.prim_id, u).expect("it"));
            let side = unit(cross(normal_at(&hair, basis, hit.prim_id, u), tangent));
            let at = add(place(point), point[3] * (2.0 * f64::from(hit.v) - 1.0), side);
            let met = ray.at(hit.t).map(f64::from);
            let off = add(at, -1.0, met);
            assert!(dot(off, off).sqrt() < 1e-4, "{basis:?}: u and v of {hit:?} name {at:?}, not {met:?}");
        }
    }
}

/// The nearest hit of a ray with ribbons that face it: from samples, refined by thirds.
fn facing(curves: &Curves, ray: &Ray) -> Option<(f64, u32)> {
    let (org, dir) = (ray.org.map(f64::from), ray.dir.map(f64::from));
    let length = dot(dir, dir).sqrt();
    let mut best: Option<(f64, u32)> = None;
    for curve in 0..curves.indices.len() as u32 {
        let seen = |u: f64| {
            let point = curves.point(curve, u).expect("it");
            let from = add(place(point), -1.0, org);
            let t = dot(from, dir) / (length * length);
            let off = add(from, -t, dir);
            (dot(off, off).sqrt(), t, point[3])
        };
        let n = 500;
        let at = |i: i32| seen(f64::from(i) / f64::from(n)).0;
        let is_line = curves.basis == CurveBasis::Linear;
        for i in 0..=n {
            let is_end = i == 0 || i == n;
            if is_end && !is_line || i > 0 && at(i - 1) < at(i) || i < n && at(i + 1) < at(i) {
                continue;
            }
            let (mut a, mut b) =
                (f64::from((i - 1).max(0)) / f64::from(n), f64::from((i + 1).min(n)) / f64::from(n));
            for _ in 0..80 {
                let (c, d) = (a + (b - a) / 3.0, b - (b - a) / 3.0);
                if seen(c).0 < seen(d).0 { b = d } else { a = c }
            }
            let (off, t, radius) = seen(0.5 * (a + b));
            if off <= radius && t >= 0.0 && best.is_none_or(|(before, _)| t < before) {
                best = Some((t, curve));
            }
        }
    }
    best
}

#[test]
fn ribbons_that_face_rays_equal_samples() {
    for (seed, basis) in (1..).zip(BASES) {
        let hair = Hair::random(basis, seed, 8);
        let curves = hair.curves(basis, CurveForm::Flat);
        let rays = hair.rays(&curves, seed + 50, 400);
        let hits = run_queries(&build(curves.into(), seed as usize % 3), &rays);
        let oracle: Vec<_> = (0..rays.len()).map(|i| facing(&curves, &rays.get(i))).collect();
        assert_alike(&hits, &oracle, &rays, 1e-4, &format!("{basis:?}"));
    }
}

/// Rays through and beside the joints of curves: none is missed.
#[test]
fn wide_strands_have_no_gaps() {
    let vertices: Vec<[f32; 4]> = (0..7).map(|i| [3.0 * i as f32 - 9.0, 0.0, 0.0, 1.0]).collect();
    for basis in [CurveBasis::Linear, CurveBasis::Bezier, CurveBasis::BSpline, CurveBasis::CatmullRom] {
        let indices: Vec<u32> = match basis {
            CurveBasis::Linear => (0..6).collect(),
            CurveBasis::Bezier => vec![0, 3],
            _ => (0..4).collect(),
        };
        for form in [CurveForm::Flat, CurveForm::Round] {
            let curves = Curves::new(basis, form, &vertices, &indices);
            let mut random = Random::new(7);
            let mut ray = |i: usize| {
                // Joints, and places between them; exactly there, and nearer and nearer to them.
                let size = [0.0, 1e-6, 1e-5, 1e-4, 1e-3, 0.3][i % 6];
                let x = [-3.0, 0.0, 3.0, -4.5, 1.0][i / 6 % 5] + random.between(-size, size);
                let y = [-0.9, 0.0, 0.6, 0.0][i / 30 % 4] + random.between(-0.1 * size, 0.1 * size);
                let aside = [0; 2].map(|_| random.between(-size, size).clamp(-1e-4, 1e-4));
                Ray::new([x, y, 5.0], [aside[0], aside[1], -1.0])
            };
            let rays: RayBatch = (0..3000).map(&mut ray).collect();
            let hits = run_queries(&build(curves.into(), 0), &rays);
            for (i, hit) in hits.iter().enumerate() {
                let y = rays.get(i).org[1];
                let depth = if form == CurveForm::Flat { 5.0 } else { 5.0 - (1.0 - y * y).sqrt() };
                let is_there = hit.is_some_and(|hit| (hit.t - depth).abs() < 2e-3);
                assert!(is_there, "{basis:?} {form:?}: {:?}, {hit:?}", rays.get(i));
            }
        }
    }
}

/// A chain of straight curves with one radius a vertex.
fn chain(seed: u64, n: usize) -> (Vec<[f32; 4]>, Vec<u32>) {
    let mut random = Random::new(seed);
    let vertices: Vec<[f32; 4]> = (0..n)
        .map(|_| {
            let [x, y, z] = random.point();
            [x, y, z, random.between(0.02, 0.15)]
        })
        .collect();
    // Strands of three curves, and two apart.
    let indices = (0..n as u32 - 1).filter(|i| i % 4 != 3).collect();
    (vertices, indices)
}

/// The distance to the nearest of all spheres along all curves.
fn distance(vertices: &[[f32; 4]], indices: &[u32], p: V) -> f64 {
    let to_curve = |&i: &u32| {
        let [a, b] = [0, 1].map(|k| vertices[i as usize + k].map(f64::from));
        let at = |u: f64| {
            let off = [0, 1, 2].map(|k| a[k] + u * (b[k] - a[k]) - p[k]);
            dot(off, off).sqrt() - (a[3] + u * (b[3] - a[3]))
        };
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let (c, d) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
            if at(c) < at(d) { high = d } else { low = c }
        }
        at(0.5 * (low + high))
    };
    indices.iter().map(to_curve).fold(f64::INFINITY, f64::min)
}

#[test]
fn cones_of_spheres_equal_a_march_and_are_closed() {
    let (vertices, indices) = chain(3, 24);
    let curves = Curves::new(CurveBasis::Linear, CurveForm::Round, &vertices, &indices);
    let object = build(curves.into(), 0);
    let mut random = Random::new(9);
    let rays: RayBatch = (0..600)
        .map(|_| {
            let (from, to) = (random.point(), random.point());
            let org = unit(from.map(f64::from)).map(|x| (4.0 * x) as f32);
            Ray::new(org, [0, 1, 2].map(|k| to[k] - org[k]))
        })
        .collect();
    let hits = run_queries(&object, &rays);
    let mut differ = 0;
    for (i, hit) in hits.iter().enumerate() {
        let ray = rays.get(i);
        let (org, dir) = (ray.org.map(f64::from), ray.dir.map(f64::from));
        let length = dot(dir, dir).sqrt();
        let (mut t, mut met) = (0.0, None);
        while t * length < 9.0 {
            let d = distance(&vertices, &indices, add(org, t, dir));
            if d < 1e-6 {
                met = Some(t);
                break;
            }
            t += d / length;
        }
        match (hit, met) {
            (Some(hit), Some(t)) if (f64::from(hit.t) - t).abs() * length < 1e-3 => {}
            (None, None) => {}
            _ => differ += 1,
        }
        let all = object.all(&ray);
        assert_eq!(all.len() % 2, 0, "{ray:?} goes in as often as out: {all:?}");
        assert_eq!(object.crossings(&ray) as usize, all.len(), "crossings of {ray:?}");
        for hit in all {
            let at = [0, 1, 2].map(|k| org[k] + f64::from(hit.t) * dir[k]);
            // Strands may be in one another.
            let own: Vec<u32> =
                indices.iter().copied().filter(|i| i.abs_diff(indices[hit.prim_id as usize]) < 2).collect();
            let off = distance(&vertices, &own, at);
            assert!(off.abs() < 1e-5, "{hit:?} is {off} off the surface");
        }
    }
    assert!(differ <= 3, "{differ} differ");
    let [inside, outside] = [[0.0f64; 3], [3.0; 3]].map(|p| object.closest_point(p, f64::INFINITY));
    for (p, near) in [([0.0; 3], inside), ([3.0; 3], outside)] {
        let (near, expected) = (near.expect("it is there"), distance(&vertices, &indices, p));
        assert!((near.distance - expected.abs()).abs() < 1e-7 || expected < 0.0, "{near:?}, {expected}");
    }
}

#[test]
fn the_nearest_point_is_that_of_samples() {
    for (seed, basis) in (1..).zip(BASES) {
        for form in [CurveForm::Round, CurveForm::Flat] {
            let hair = Hair::random(basis, seed, 30);
            let curves = hair.curves(basis, form);
            let object = build(curves.into(), 0);
            let mut random = Random::new(seed);
            for _ in 0..50 {
                let p = random.point().map(|x| 1.5 * f64::from(x));
                let found = object.closest_point(p, f64::INFINITY).expect("all is near enough");
                let mut best = f64::INFINITY;
                for curve in 0..30 {
                    for i in 0..=2000 {
                        let point = curves.point(curve, f64::from(i) / 2000.0).expect("it");
                        let off = add(place(point), -1.0, p);
                        let axis = dot(off, off).sqrt();
                        best = best.min(if form == CurveForm::Round { axis - point[3] } else { axis });
                    }
                }
                if best > 0.0 {
                    assert!(
                        (found.distance - best).abs() < 1e-5,
                        "{basis:?} {form:?}: {found:?}, not {best}"
                    );
                }
            }
        }
    }
}

#[test]
fn curves_are_saved_refitted_and_placed() {
    for (seed, basis) in (1..).zip(BASES) {
        for form in [CurveForm::Flat, CurveForm::Round, CurveForm::Oriented] {
            let hair = Hair::random(basis, seed, 40);
            let curves = hair.curves(basis, form);
            let rays = hair.rays(&curves, seed, 200);
            for kind in [0, 5] {
                let object = build(curves.into(), kind);
                assert_eq!(object.stats().primitives, 40, "each is there once");
                let hits = run_queries(&object, &rays);
                let mut file = Vec::new();
                object.save(&mut file).expect("memory takes all");
                let loaded = ObjectTree::load(&mut &file[..]).expect("it was saved");
                assert!(loaded.same_tree(&object), "node for node");
                assert_eq!(loaded.stats(), object.stats(), "measured alike");
                assert_eq!(run_queries(&loaded, &rays), hits, "{basis:?} {form:?}");

                let mut moved = hair.clone();
                moved.vertices.iter_mut().for_each(|p| (p[0], p[3]) = (p[0] + 0.5 * p[1], 0.5 * p[3]));
                let curves = moved.curves(basis, form);
                let (there, rays) = (build(curves.into(), kind), moved.rays(&curves, seed, 200));
                let refitted = object.refit_from(&[curves.into()], Threads::Single).expect("as many");
                let bits = |object: &ObjectTree| {
                    run_queries(object, &rays)
                        .iter()
                        .map(|hit| hit.map(|h| (h.t, h.prim_id)))
                        .collect::<Vec<_>>()
                };
                assert_eq!(bits(&refitted), bits(&there), "{basis:?} {form:?} refitted");
                let mut instance = Instance::identity(Arc::new(there));
                instance.world_from_object[3] = [4.0, 0.0, 0.0];
                let scene = scene_of(&[instance]);
                let shifted: RayBatch = (0..rays.len())
                    .map(|i| {
                        let ray = rays.get(i);
                        Ray { org: [ray.org[0] + 4.0, ray.org[1], ray.org[2]], ..ray }
                    })
                    .collect();
                let found = run_queries(&scene, &shifted).iter().flatten().count();
                let expected = bits(&refitted).iter().flatten().count();
                assert!(found.abs_diff(expected) <= 2, "{found} hits of an instance, not {expected}");
            }
        }
    }
}

#[test]
fn bad_curves_are_counted() {
    let nan = f32::NAN;
    let vertices = [
        [0.0, 0.0, 0.0, 0.1],
        [1.0, 0.0, 0.0, 0.1],
        [1.0, 0.0, 0.0, 0.1],
        [nan, 0.0, 0.0, 0.1],
        [2.0, 0.0, 0.0, 0.0],
        [3.0, 0.0, 0.0, 0.0],
        [4.0, 0.0, 0.0, -1.0],
        [5.0, 0.0, 0.0, 1.0],
        [1e19, 0.0, 0.0, 1.0],
    ];
    let indices = [0, 1, 2, 4, 6, 7, 8, u32::MAX];
    let curves = Curves::new(CurveBasis::Linear, CurveForm::Flat, &vertices, &indices);
    let object = build(curves.into(), 0);
    let bad = object.bad_primitives();
    assert_eq!((bad.nan, bad.zero_area, bad.too_large, bad.bad_index), (1, 3, 1, 2), "{bad:?}");
    assert_eq!(object.stats().primitives, 1, "one is left");
    // One point is a ball where straight curves are round.
    let round = Curves { form: CurveForm::Round, indices: &[1], ..curves };
    let hit = build(round.into(), 0).intersect(&Ray::new([1.0, 0.0, 5.0], [0.0, 0.0, -1.0]));
    assert!(hit.is_some_and(|hit| (hit.t - 4.9).abs() < 1e-5), "{hit:?}");
    // No normals, no oriented ribbon.
    let oriented = Curves { form: CurveForm::Oriented, ..curves };
    assert_eq!(build(oriented.into(), 0).bad_primitives().bad_index, 8, "none has normals");
}

#[test]
fn boxes_and_normals_of_curves() {
    let vertices = [[0.0, 0.0, 0.0, 0.2], [1.0, 0.0, 0.0, 0.2], [2.0, 0.0, 0.0, 0.2], [3.0, 0.0, 0.0, 0.2]];
    let curves = Curves::new(CurveBasis::Bezier, CurveForm::Round, &vertices, &[0]);
    let tube = build(curves.into(), 0);
    let ray = Ray::new([1.5, 0.1, -5.0], [0.0, 0.0, 1.0]);
    let hit = tube.intersect(&ray).expect("it aims at the tube");
    let depth = 0.03f32.sqrt();
    assert!((hit.t - (5.0 - depth)).abs() < 1e-5 && (hit.u - 0.5).abs() < 1e-6 && hit.v == 0.0, "{hit:?}");
    let normal = tube.normal_at(&hit, ray.at(hit.t).map(f64::from)).expect("outwards");
    let off = [0, 1, 2].map(|k| f64::from(normal[k] - [0.0, 0.5, -5.0 * depth][k]));
    assert!(dot(off, off) < 1e-8, "{normal:?}");
    assert_eq!(tube.all(&ray).len(), 2, "in and out");
    assert_eq!(tube.intersect(&Ray::new([-5.0, 0.05, 0.0], [1.0, 0.0, 0.0])), None, "its ends are open");

    let flat = build(Curves { form: CurveForm::Flat, ..curves }.into(), 0);
    let hit = flat.intersect(&ray).expect("it aims at the ribbon");
    assert!(hit.t == 5.0 && (hit.v - 0.5).abs() < 1e-6, "{hit:?}");
    assert_eq!(flat.normal(&hit), None, "it faces the ray");

    let normals = [[0.0, 0.0, 1.0]; 4];
    let oriented = build(Curves { form: CurveForm::Oriented, ..curves }.with_normals(&normals).into(), 0);
    let hit = oriented.intersect(&ray).expect("it aims at the ribbon");
    assert!(hit.t == 5.0 && (hit.v - 0.75).abs() < 1e-6, "{hit:?}");
    assert_eq!(oriented.normal(&hit), Some([0.0, 0.0, 1.0]), "as it came");
    let mut ids: Vec<PrimitiveId> = Vec::new();
    for (low, high, touched) in
        [([1.0, 0.1, -1.0], [1.1, 0.3, 1.0], 1), ([1.0, 0.3, -1.0], [1.1, 0.4, 1.0], 0)]
    {
        tube.touching_box(&Query::default(), low, high, &mut ids);
        assert_eq!(ids.len(), touched, "{low:?} to {high:?}");
    }
}

#[test]
fn many_curves_in_one_leaf_are_all_tested() {
    // More than wait for their vertices at a time, at the same place but for the depth.
    let n = 200;
    let vertices: Vec<[f32; 4]> = (0..n)
        .flat_map(|i| (0..4).map(move |k| [k as f32, 0.2 * (k % 2) as f32, 1e-4 * i as f32, 0.1]))
        .collect();
    let indices: Vec<u32> = (0..n).map(|i| 4 * i).collect();
    for (form, of_each) in [(CurveForm::Flat, 1), (CurveForm::Round, 2)] {
        let object = build(Curves::new(CurveBasis::Bezier, form, &vertices, &indices).into(), 0);
        for (ray, nearest) in [
            (Ray::new([1.5, 0.1, -5.0], [0.0, 0.0, 1.0]), 0),
            (Ray::new([1.5, 0.1, 5.0], [0.0, 0.0, -1.0]), n - 1),
        ] {
            assert_eq!(object.all(&ray).len(), of_each * n as usize, "{form:?}: each is met");
            let hit = object.intersect(&ray).expect("there are many");
            assert_eq!(hit.prim_id, nearest, "{form:?}: the first of them is the closest");
            assert!(object.occluded(&ray), "{form:?}: there are many");
        }
    }
}

#[test]
fn scattered_rays_through_many_curves_have_the_hits_of_single_rays() {
    let mut hair = Hair::random(CurveBasis::BSpline, 12, 40_000);
    hair.vertices.iter_mut().for_each(|vertex| vertex[3] *= 0.1);
    let mut random = Random::new(3);
    let mut ray = |_| {
        let (from, to) = (random.point(), random.point());
        Ray::new(from, [0, 1, 2].map(|k| to[k] - from[k])).within(0.0, random.between(0.05, 1.0))
    };
    // With some that are irregular, and some that are not active.
    let rays: RayBatch = (0..1500)
        .map(&mut ray)
        .enumerate()
        .map(|(i, ray)| match i % 50 {
            7 => Ray::new(ray.org, ray.dir.map(|x| 1e-30 * x)),
            9 => ray.within(1.0, 0.0),
            _ => ray,
        })
        .collect();
    for form in [CurveForm::Flat, CurveForm::Round] {
        let object = build(hair.curves(CurveBasis::BSpline, form).into(), 0);
        // Smaller trees are in the cache, and rays go one by one.
        assert!(
            object.stats().tree_bytes + object.stats().primitive_bytes > 5_000_000,
            "{:?}",
            object.stats()
        );
        let hits = run_queries(&object, &rays);
        let count = hits.iter().flatten().count();
        assert!((300..1450).contains(&count), "{form:?}: {count} hit");
        for (i, hit) in hits.iter().enumerate() {
            assert_eq!(*hit, object.intersect(&rays.get(i)), "{form:?}, ray {i}: as by itself");
        }
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Vectors and matrices: their laws, and derivatives against differences.

use gnurt_sl_lib::Dual;
use gnurt_sl_lib::math::vectors::*;
use gnurt_sl_lib::matrix::{self, Matrix, Spaces};
use proptest::prelude::*;

fn vector() -> impl Strategy<Value = [f32; 3]> {
    prop::array::uniform3(-4.0_f32..4.0)
}

fn close(a: [f32; 3], b: [f32; 3], by: f32) -> bool {
    distance(a, b) <= by * (1.0 + length(a) + length(b))
}

/// The determinant by Laplace's rule.
fn laplace(rows: &[Vec<f64>]) -> f64 {
    let [first, rest @ ..] = rows else { return 1.0 };
    let minor = |k: usize| -> Vec<Vec<f64>> {
        rest.iter()
            .map(|row| row.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, x)| *x).collect())
            .collect()
    };
    first
        .iter()
        .enumerate()
        .map(|(k, x)| if k % 2 == 0 { x * laplace(&minor(k)) } else { -x * laplace(&minor(k)) })
        .sum()
}

proptest! {
    #[test]
    fn products_keep_their_laws(a in vector(), b in vector(), c in vector()) {
        prop_assert!(dot(a, cross(a, b)).abs() < 1e-4 && dot(b, cross(a, b)).abs() < 1e-4);
        let identity = dot(a, a) * dot(b, b) - dot(a, b) * dot(a, b);
        prop_assert!((dot(cross(a, b), cross(a, b)) - identity).abs() < 1e-2);
        let n = normalize(a);
        prop_assert!((length(n) - 1.0).abs() < 1e-6 && close(scale(n, length(a)), a, 1e-6));
        // The distance to a segment is the least of those to its points.
        let least = (0..=400).map(|i| distance(c, add(a, scale(subtract(b, a), i as f32 / 400.0)))).fold(f32::MAX, f32::min);
        prop_assert!((distance_to_segment(a, b, c) - least).abs() < 2e-2);
    }

    #[test]
    fn light_obeys_snell_and_loses_nothing(i in vector(), n in vector(), eta in 0.4_f32..2.5) {
        let (i, n) = (normalize(i), normalize(n));
        let n = if dot(i, n) > 0.0 { scale(n, -1.0) } else { n };
        let light = fresnel(i, n, eta);
        prop_assert!((length(light.reflection) - 1.0).abs() < 1e-5);
        prop_assert!((dot(light.reflection, n) + dot(i, n)).abs() < 1e-5, "angles are equal");
        if length(light.refraction) > 0.0 {
            let (before, behind) = (length(cross(i, n)), length(cross(light.refraction, n)));
            prop_assert!((behind - eta * before).abs() < 1e-4, "sines are as the indices");
            let kept = light.reflected + light.transmitted / (eta * eta);
            prop_assert!((kept - 1.0).abs() < 1e-4 && light.reflected >= 0.0);
            // The mean of the two polarisations.
            let (c, d) = (-f64::from(dot(i, n)), -f64::from(dot(light.refraction, n)));
            let e = f64::from(eta);
            let (s, p) = ((e * c - d) / (e * c + d), (c - e * d) / (c + e * d));
            prop_assert!((f64::from(light.reflected) - 0.5 * (s * s + p * p)).abs() < 2e-3);
        } else {
            prop_assert_eq!((light.reflected, light.transmitted), (1.0, 0.0));
        }
    }

    #[test]
    fn turns_keep_lengths_and_add(p in vector(), a in vector(), b in vector(), angle in -3.0_f32..3.0) {
        prop_assume!(distance(a, b) > 0.1);
        let turned = rotate(p, angle, a, b);
        prop_assert!((distance(turned, a) - distance(p, a)).abs() < 1e-4);
        prop_assert!(close(rotate(turned, -angle, a, b), p, 1e-5));
        prop_assert!(close(rotate(a, angle, a, b), a, 1e-5), "the axis stays");
    }

    #[test]
    fn matrices_have_inverses(m in prop::array::uniform16(-2.0_f32..2.0), p in vector(), n in vector()) {
        let m: Matrix = std::array::from_fn(|i| std::array::from_fn(|k| m[4 * i + k] + if i == k { 3.0 } else { 0.0 }));
        let rows: Vec<Vec<f64>> = m.iter().map(|row| row.iter().map(|x| f64::from(*x)).collect()).collect();
        let expected = laplace(&rows);
        prop_assert!((f64::from(matrix::determinant(&m)) - expected).abs() < 1e-4 * (1.0 + expected.abs()));
        prop_assume!(expected.abs() > 0.5);
        let product = matrix::multiply(&m, &matrix::inverse(&m));
        for (i, row) in product.iter().enumerate() {
            for (k, x) in row.iter().enumerate() {
                prop_assert!((x - f32::from(i == k)).abs() < 1e-3, "{product:?}");
            }
        }
        let affine: Matrix = m.map(|row| [row[0], row[1], row[2], 0.0]);
        let affine = [affine[0], affine[1], affine[2], [1.0, 2.0, 3.0, 1.0]];
        prop_assume!(matrix::determinant(&affine).abs() > 0.5);
        let there = matrix::transform_point(&affine, p);
        prop_assert!(close(matrix::transform_point(&matrix::inverse(&affine), there), p, 1e-3));
        // A normal stays across all directions that it was across.
        let across = cross(n, p);
        let product = dot(matrix::transform_normal(&affine, n), matrix::transform_vector(&affine, across));
        prop_assert!(product.abs() < 1e-2, "{product}");
    }

    #[test]
    fn derivatives_go_along(p in vector(), q in vector(), d in vector(), m in prop::array::uniform16(-1.0_f32..1.0)) {
        prop_assume!(length(p) > 0.5 && distance(p, q) > 0.5);
        type F = fn([Dual<f32>; 3], [Dual<f32>; 3]) -> [Dual<f32>; 3];
        let m: Matrix = std::array::from_fn(|i| std::array::from_fn(|k| m[4 * i + k] * 0.1 + if i == k { 1.0 } else { 0.0 }));
        let functions: [(&str, F); 6] = [
            ("normalize", |p, _| normalize(p)),
            ("cross", cross),
            ("length", |p, q| [length(p), distance(p, q), dot(p, q)]),
            ("reflect", |p, q| reflect(p, q)),
            ("rotate", |p, q| rotate(p, q[0], [0.0.into(); 3], [1.0.into(), 0.5.into(), 0.0.into()])),
            ("faceforward", |p, q| faceforward(p, q, p)),
        ];
        let at = |s: f32| -> [Dual<f32>; 3] { std::array::from_fn(|i| Dual::new(p[i] + s * d[i], d[i], 0.0)) };
        let q = q.map(Dual::from);
        let h = 1e-2;
        let check = |name: &str, f: &dyn Fn([Dual<f32>; 3]) -> [Dual<f32>; 3]| {
            for ((found, before), after) in f(at(0.0)).into_iter().zip(f(at(-h))).zip(f(at(h))) {
                let expected = (after.value - before.value) / (2.0 * h);
                let bend = (after.value - 2.0 * found.value + before.value).abs() / h;
                assert!((found.dx - expected).abs() < 0.02 * (1.0 + expected.abs()) + bend, "{name}: {} not {expected}", found.dx);
            }
        };
        for (name, f) in functions {
            check(name, &|p| f(p, q));
        }
        check("transform", &|p| matrix::transform_point(&m, p));
        check("transform of normals", &|p| matrix::transform_normal(&m, p));
    }
}

#[test]
fn what_has_no_direction_becomes_zero() {
    assert_eq!(normalize([0.0; 3]), [0.0; 3]);
    assert_eq!(refract([0.8, 0.0, -0.6], [0.0, 0.0, 1.0], 2.0), [0.0; 3], "all is reflected");
    assert_eq!(matrix::inverse(&matrix::diagonal(0.0)), matrix::IDENTITY, "as with OSL");
    assert_eq!(matrix::transform_point(&[[0.0; 4]; 4], [1.0, 2.0, 3.0]), [0.0; 3]);
    assert_eq!(distance_to_segment([1.0; 3], [1.0; 3], [1.0, 1.0, 3.0]), 2.0, "a segment that is a point");
    assert_eq!(calculatenormal([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], true), [0.0, 0.0, -1.0]);
    assert_eq!(area([2.0, 0.0, 0.0], [0.0, 3.0, 0.0]), 6.0);
}

#[test]
fn named_spaces_are_joined_through_the_common_one() {
    struct Room;
    impl Spaces for Room {
        fn common_from(&self, space: &str) -> Option<Matrix> {
            let moved =
                |x| [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [x, 0.0, 0.0, 1.0]];
            match space {
                "object" => Some(moved(2.0)),
                "shader" => Some(moved(5.0)),
                _ => None,
            }
        }
    }
    let at = |from, to| {
        matrix::transform_between(&Room, from, to)
            .map(|m| matrix::transform_point(&m, [1.0_f32, 0.0, 0.0])[0])
    };
    assert_eq!(at("object", "common"), Ok(3.0));
    assert_eq!(at("common", "shader"), Ok(-4.0));
    assert_eq!(at("object", "shader"), Ok(-2.0));
    assert_eq!(at("common", "common"), Ok(1.0));
    assert_eq!(at("nowhere", "common"), Err("nowhere"));
    assert_eq!(at("object", "nowhere"), Err("nowhere"));
}

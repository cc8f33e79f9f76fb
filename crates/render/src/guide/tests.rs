// SPDX-License-Identifier: GPL-3.0-or-later
//! Maps of the sphere, densities, mixtures, trails and shares.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};
use gnurt_shading::SampleKey;
use gnurt_shading::bsdf::{Bsdf, Lobe, Prepared};
use gnurt_shading::real::Vector;
use gnurt_shading::sampling::octahedron::{direction_of, stretch};
use gnurt_shading::sampling::{Draws, hash_combine, uniform_sphere};

use super::directions::{Sample, Trees};
use super::mixture::Mixture;
use super::recorder::{Recorder, Vertex};
use super::share::{self, HeldOut};
use super::space::{Cell, Guide};
use crate::space_tree::{SpaceTree, class_of};

/// The centres of a grid of `n` times `n` parts of the square.
fn grid(n: u32) -> impl Iterator<Item = Vec2> {
    let at = move |k: u32| (k as f32 + 0.5) / n as f32;
    (0..n * n).map(move |k| Vec2::new(at(k % n), at(k / n)))
}

fn numbers(k: u32) -> [f32; 3] {
    Draws::new(7, SampleKey { pixel: 1, sample: k, branch: 0 }, 1).triple(1)
}

/// A narrow light from one side, a wide one from the other, and a sample from anywhere.
fn trees() -> (Trees, u32) {
    let narrow = Vec3::new(0.48, 0.6, 0.64);
    let samples = (0..20_000).map(|k| {
        let [x, y, choice] = numbers(k);
        let wide = uniform_sphere([x, y]);
        let dir = if choice < 0.5 { (narrow + wide * 0.1).normalize() } else { wide };
        let light = if choice < 0.5 { 1.0 } else { (-wide.x).max(0.0) };
        Sample::new(dir, light)
    });
    let mut trees = Trees::default();
    let root = trees.build(&mut samples.collect::<Vec<_>>()).expect("there is light");
    (trees, root)
}

#[test]
fn densities_integrate_to_one() {
    let (trees, root) = trees();
    assert!(trees.len() > 20, "the narrow light is resolved: {} nodes", trees.len());
    let n = 1024;
    let sum: f64 = grid(n)
        .map(|square| {
            let dir = direction_of(square.into());
            f64::from(trees.pdf(root, dir) * stretch(dir))
        })
        .sum();
    let integral = sum / f64::from(n * n);
    assert!((integral - 1.0).abs() < 1e-4, "over the sphere: {integral}");
}

/// Chi-square over parts of the sphere: cosines times azimuths.
fn chi_square(pdf: impl Fn(Vec3) -> f32, samples: impl Iterator<Item = Vec3>) -> (f64, f64) {
    let (rows, columns) = (24, 48);
    let part = |dir: Vec3| {
        let row = ((dir.z * 0.5 + 0.5) * rows as f32).clamp(0.0, rows as f32 - 1.0) as usize;
        let column = (dir.y.atan2(dir.x) / TAU + 0.5).clamp(0.0, 1.0) * columns as f32;
        row * columns + (column as usize).min(columns - 1)
    };
    let (mut seen, mut count) = (vec![0.0_f64; rows * columns], 0.0);
    for dir in samples {
        seen[part(dir)] += 1.0;
        count += 1.0;
    }
    let (mut expected, fine) = (vec![0.0_f64; rows * columns], 24);
    for (k, expected) in expected.iter_mut().enumerate() {
        let (row, column) = ((k / columns) as f32, (k % columns) as f32);
        for sub in grid(fine) {
            let z = (row + sub.y) / rows as f32 * 2.0 - 1.0;
            let azimuth = ((column + sub.x) / columns as f32 - 0.5) * TAU;
            let r = (1.0 - z * z).max(0.0).sqrt();
            let dir = Vec3::new(r * azimuth.cos(), r * azimuth.sin(), z);
            let area = 4.0 * PI / (rows * columns) as f32 / (fine * fine) as f32;
            *expected += f64::from(pdf(dir) * area) * count;
        }
    }
    // Parts of few samples together.
    let (mut sum, mut degrees, mut pooled) = (0.0, -1.0, [0.0; 2]);
    for (seen, expected) in seen.iter().zip(&expected) {
        if *expected >= 20.0 {
            sum += (seen - expected).powi(2) / expected;
            degrees += 1.0;
        } else {
            pooled = [pooled[0] + seen, pooled[1] + expected];
        }
    }
    if pooled[1] >= 5.0 {
        sum += (pooled[0] - pooled[1]).powi(2) / pooled[1];
        degrees += 1.0;
    }
    (sum, degrees)
}

/// The chi-square that one of a million exceeds, by Wilson and Hilferty.
fn bound(degrees: f64) -> f64 {
    let of_normal = 4.75;
    let spread = 2.0 / (9.0 * degrees);
    degrees * (1.0 - spread + of_normal * spread.sqrt()).powi(3)
}

#[test]
fn samples_have_their_density() {
    let (trees, root) = trees();
    let samples = (0..200_000).map(|k| {
        let [x, y, _] = numbers(hash_combine(k, 3));
        trees.sample(root, [x, y])
    });
    let (sum, degrees) = chi_square(|dir| trees.pdf(root, dir), samples);
    // The reference is a quadrature over parts that cut through those of the tree.
    assert!(sum < 1.1 * bound(degrees), "{sum} with {degrees} degrees of freedom");
}

/// A map that is the same everywhere.
fn guide(share: f32) -> Guide {
    let (trees, root) = trees();
    let normals = [Vec3::X, Vec3::Y, Vec3::Z].into_iter().flat_map(|axis| [axis, -axis]);
    let points: Vec<_> = normals.map(|normal| (Vec3::ZERO, class_of(normal))).collect();
    let (tree, cells) = SpaceTree::build(&points, 1);
    Guide { tree, trees, cells: vec![Cell { root, share }; cells.len()], ..Guide::default() }
}

#[test]
fn mixtures_have_their_density() {
    let guide = guide(0.6);
    let bsdf = Bsdf::new(Vec3::Z, Lobe::lambert(Vec3::splat(0.5)));
    let wo = Vec3::new(0.6, 0.0, 0.8);
    let prepared: Prepared<f32> = bsdf.prepared_for(wo, Vec3::ONE);
    let at = [Vector::from(Vec3::ZERO), Vector::from(Vec3::Z)];
    let mixture = Mixture::new(&guide, true, at, &prepared);
    let pdf = |dir: Vec3| mixture.pdf(true, dir.into(), prepared.eval_pdf(dir.into()).1);
    let mut values = 0.0_f64;
    let n = 200_000;
    let samples = (0..n).map(|k| {
        let [x, y, choice] = numbers(hash_combine(k, 5));
        let (chosen, of_lobes) = mixture.sample(&prepared, [choice, x, y]);
        let dir = Vec3::from(chosen.wi);
        assert!(
            (chosen.pdf - mixture.pdf(true, chosen.wi, of_lobes)).abs() <= 1e-4 * chosen.pdf,
            "the density of {dir}"
        );
        if chosen.found {
            values += f64::from(Vec3::from(chosen.weight).x);
        }
        dir
    });
    let (sum, degrees) = chi_square(pdf, samples.collect::<Vec<_>>().into_iter());
    assert!(sum < 1.1 * bound(degrees), "{sum} with {degrees} degrees of freedom");
    let albedo = values / f64::from(n);
    assert!((albedo - 0.5).abs() < 5e-3, "the mean weight is the albedo: {albedo}");
}

#[test]
fn mirrors_are_not_guided() {
    let guide = guide(0.6);
    let bsdf = Bsdf::new(Vec3::Z, Lobe::mirror(Vec3::splat(0.5)));
    let prepared: Prepared<f32> = bsdf.prepared_for(Vec3::new(0.6, 0.0, 0.8), Vec3::ONE);
    let mixture = Mixture::new(&guide, true, [Vector::from(Vec3::ZERO), Vector::from(Vec3::Z)], &prepared);
    for k in 0..64 {
        let (chosen, _) = mixture.sample(&prepared, numbers(k));
        let alone = Vec3::from(prepared.sample(numbers(k)).weight);
        assert!(chosen.delta && Vec3::from(chosen.weight) == alone, "the mirror alone");
    }
}

#[test]
fn light_goes_to_all_vertices_of_a_trail() {
    let mut recorder = Recorder::new(2);
    let vertex = |before| Vertex {
        p: Vec3::ZERO,
        dir: Vec3::Z,
        pdf: 1.0,
        pdf_of_lobes: 1.0,
        guidable: 1.0,
        throughput: 1.0,
        light: 0.0,
        class: class_of(Vec3::NEG_Y),
        before,
    };
    let first = recorder.scatter(vertex(0));
    let second = recorder.scatter(vertex(first));
    recorder.found(second, Vec3::splat(1.0));
    recorder.found(first, Vec3::new(3.0, 0.0, 3.0));
    recorder.found(0, Vec3::ONE);
    let light: Vec<f32> = recorder.vertices.iter().map(|vertex| vertex.light).collect();
    assert_eq!(light, [3.0, 1.0], "later light counts for earlier vertices");
    assert_eq!(recorder.scatter(vertex(second)), second, "beyond the limit the trail stays");
    assert_eq!(recorder.vertices.len(), 2, "the limit holds");
    assert_eq!(recorder.vertices[0].class, 3, "downwards along y");
}

#[test]
fn shares_follow_what_helps() {
    let sample = |of_tree| HeldOut { pdf: 1.0, of_lobes: 1.0, of_tree, guidable: 1.0, square: 1.0 };
    let helps = share::moments([sample(4.0), sample(3.0)].into_iter());
    assert_eq!(share::SHARES[share::best(&helps)], 0.85, "where the tree is denser");
    let harms = share::moments([sample(4.0), sample(0.1)].into_iter());
    assert_eq!(share::best(&harms), 0, "where some light would be missed");
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Densities of the light set against its samples, sums against closed forms, powers against integrals.

use std::f32::consts::PI;
use std::sync::Arc;

use glam::{Mat3, Vec3};
use gnurt_accel::Threads;
use gnurt_image::{TexelData, Texels};
use gnurt_simd::{Level, Simd, dispatch_wide, f32x16, prelude::*};

use super::*;
use crate::batch::SampleKey;
use crate::lanes::{LANES, Mask, Vec3x16};
use crate::materials::Emission;
use crate::sampling::{sample_pair, uniform_sphere};
use crate::texture::TextureSampler;

fn numbers(sample: u32) -> [f32; 3] {
    let draw = |purpose| sample_pair(11, SampleKey { pixel: 5, sample, branch: 0 }, 0, purpose);
    let ([a, b], [c, _]) = (draw(0), draw(1));
    [c, a, b]
}

fn triangles(corners: &[[Vec3; 3]], radiance: &[f32]) -> Option<Arc<ShapeLights>> {
    shapes(corners.iter().map(|&p| Outline::Triangle(p)), radiance)
}

fn shapes(outlines: impl Iterator<Item = Outline>, radiance: &[f32]) -> Option<Arc<ShapeLights>> {
    beams(outlines, radiance, |_| None)
}

/// A beam around a direction for every shape that has one.
fn beams(
    outlines: impl Iterator<Item = Outline>,
    radiance: &[f32],
    axis: impl Fn(usize) -> Option<Vec3>,
) -> Option<Arc<ShapeLights>> {
    let beam = |outline: &Outline, axis: Vec3| {
        let bright = |dir: Vec3| (dir.dot(axis) - 0.7).max(0.0);
        let normal = matches!(outline, Outline::Triangle(_)).then(|| outline.normal_at([0.0; 2]));
        let bright: Vec<f32> = Beam::directions().map(bright).collect();
        Some(Arc::new(Beam::new(&bright, normal.map(|normal| (normal, 0.1)))?.0))
    };
    let emitter = |&x: &f32| {
        let emission = Emission::constant(Vec3::new(x, 2.0 * x, 3.0 * x));
        Arc::new(Emitter::new(emission, None))
    };
    let emitters: Vec<_> = radiance.iter().map(emitter).collect();
    let list = outlines.enumerate().map(|(i, outline)| EmissiveShape {
        beam: axis(i).and_then(|axis| beam(&outline, axis)),
        is_turned: false,
        opacity: [1.0; 3],
        outline,
        uv: [[0.0; 2]; 3],
        emitter: (i % radiance.len()) as u32,
        brightness: emitters[i % radiance.len()].mean_over(&[[0.0; 2]; 3], [1.0; 3]),
    });
    ShapeLights::new(list.collect(), emitters.clone(), None).map(Arc::new)
}

fn set(parts: LightParts) -> LightSet {
    let shape_ids =
        Arc::new((0..parts.shapes.as_ref().map_or(0, |t| t.len() as u32)).map(|i| [0, 0, i]).collect());
    LightSet::new(
        LightParts { shape_ids, bounds: [Vec3::splat(-2.0), Vec3::splat(2.0)], ..parts },
        Threads::Single,
    )
}

/// A 2 x 2 square at height 1 that emits downwards.
fn square() -> Vec<[Vec3; 3]> {
    let corner = |x, y| Vec3::new(x, y, 1.0);
    let [a, b, c, d] = [corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)];
    vec![[a, b, c], [a, c, d]]
}

fn picture() -> EnvironmentLight {
    let texel = |i: u32| match (i % 16, i / 16) {
        (12, 2) => [50.0, 20.0, 10.0, 1.0],
        _ => [0.1, 0.1, 0.3, 1.0],
    };
    let data = TexelData::Float((0..128).map(texel).collect());
    let texture = TextureSampler::new(Arc::new(Texels { width: 16, height: 8, data }));
    let rotation = Mat3::from_rotation_x(0.4) * Mat3::from_rotation_y(1.1);
    let picture = PictureEnvironment::new(texture, Vec3::ONE, rotation, Threads::Single);
    EnvironmentLight::Picture(Arc::new(picture.expect("it shines")))
}

fn irradiance(lights: &LightSet, p: Vec3, up: Vec3, n: u32) -> Vec3 {
    let sum = (0..n).fold(Vec3::ZERO, |sum, i| {
        let lit = lights.sample(p, up, numbers(i));
        sum + lit.map_or(Vec3::ZERO, |s| s.radiance * s.dir.dot(up).max(0.0) / s.pdf)
    });
    sum / n as f32
}

/// Lights of many sizes and directions, a light without extent of each kind, and the sky.
fn everything() -> LightSet {
    let emissive_shape = |i: usize| {
        let middle = Vec3::new((i % 8) as f32 - 3.5, (i / 8) as f32 - 3.0, [1.0, 2.0, -0.5][i % 3]);
        let size = 0.1 + 0.1 * (i % 7) as f32;
        let p = [middle, middle + Vec3::Y * size, middle + Vec3::X * size];
        match i % 8 {
            5 => Outline::Sphere { center: middle, radius: 0.5 * size },
            0 | 1 | 2 | 4 | 6 => Outline::Triangle(p),
            _ => Outline::Triangle([p[0], p[2], p[1]]),
        }
    };
    set(LightParts {
        shapes: shapes((0..48).map(emissive_shape), &[1.0, 5.0, 20.0]),
        points: vec![
            PointLight::new(Vec3::new(0.5, 0.0, 2.0), Vec3::ONE),
            PointLight {
                cone: Cone::new(-Vec3::Z, 0.3, 0.6, ConeEdge::Squared),
                radius: 0.2,
                ..PointLight::new(Vec3::new(0.0, 1.0, 2.0), Vec3::ONE)
            },
        ],
        directionals: DirectionalLight::new(-Vec3::Z, Vec3::ONE, 0.0).into_iter().collect(),
        environment: Some(picture()),
        ..LightParts::default()
    })
}

#[test]
fn rectangle_has_its_closed_form() {
    let lights = set(LightParts { shapes: triangles(&square(), &[1.0]), ..LightParts::default() });
    let corner = 1.0_f64 / 2.0_f64.sqrt();
    let exact = 4.0 * corner * corner.atan();
    let found = irradiance(&lights, Vec3::ZERO, Vec3::Z, 1 << 14);
    assert!((f64::from(found.x) / exact - 1.0).abs() < 2e-3, "{} instead of {exact}", found.x);
    assert!((found.z / found.x - 3.0).abs() < 1e-4, "in all colours");
    let behind = irradiance(&lights, Vec3::new(0.0, 0.0, 2.0), -Vec3::Z, 256);
    assert_eq!(behind, Vec3::ZERO, "light leaves one side only");
}

/// The irradiance of a sphere above the horizon is pi L (r / d)² cos; through the horizon its sum over points in the cone.
#[test]
fn sphere_has_its_closed_form() {
    let of = |center, radius| {
        let sphere = Outline::Sphere { center, radius };
        set(LightParts { shapes: shapes([sphere].into_iter(), &[2.0]), ..LightParts::default() })
    };
    for (center, radius) in [
        (Vec3::new(0.0, 0.0, 3.0), 1.0),
        (Vec3::new(2.0, -1.0, 1.0), 0.9),
        (Vec3::new(50.0, 0.0, 60.0), 0.01),
    ] {
        let exact = 2.0 * PI * radius * radius / center.length_squared() * (center.z / center.length());
        let found = irradiance(&of(center, radius), Vec3::ZERO, Vec3::Z, 1 << 14);
        assert!((found.x / exact - 1.0).abs() < 1e-3, "{center}: {} instead of {exact}", found.x);
        assert!((found.z / found.x - 3.0).abs() < 1e-3, "in all colours");
    }
    // Half below: the closed form of a sphere whose centre is on the horizon, (asin(s) - s sqrt(1 - s²)) L with s = r / d.
    let s = 0.5_f32;
    let exact = 2.0 * (s.asin() - s * (1.0 - s * s).sqrt());
    let found = irradiance(&of(Vec3::new(2.0, 0.0, 0.0), 1.0), Vec3::ZERO, Vec3::Z, 1 << 16).x;
    assert!((found / exact - 1.0).abs() < 5e-3, "{found} instead of {exact}");
    assert_eq!(
        irradiance(&of(-3.0 * Vec3::Z, 1.0), Vec3::ZERO, Vec3::Z, 256),
        Vec3::ZERO,
        "below the horizon"
    );
    assert_eq!(irradiance(&of(Vec3::ZERO, 1.0), Vec3::ZERO, Vec3::Z, 256), Vec3::ZERO, "inside");
}

#[test]
fn lights_without_extent_and_constant_skies_have_closed_forms() {
    let lights = set(LightParts {
        points: vec![PointLight::new(Vec3::new(0.0, 0.0, 2.0), Vec3::splat(8.0))],
        directionals: DirectionalLight::new(-Vec3::Z, Vec3::splat(3.0), 0.0).into_iter().collect(),
        environment: Some(EnvironmentLight::Constant(Arc::new(ConstantEnvironment { radiance: Vec3::ONE }))),
        ..LightParts::default()
    });
    let found = irradiance(&lights, Vec3::ZERO, Vec3::Z, 1 << 14).x;
    let exact = 8.0 / 4.0 + 3.0 + PI;
    assert!((found / exact - 1.0).abs() < 2e-3, "{found} instead of {exact}");
}

/// Each light by itself is the oracle of a tree of one; all together must bring their sum.
#[test]
fn many_emitters_add_up() {
    let emissive_triangle = |i: usize| {
        let middle = Vec3::new((i % 10) as f32 - 4.5, (i / 10) as f32 - 2.0, [1.0, 3.0, -0.5][i % 3]);
        let size = 0.05 + 0.02 * (i % 7) as f32;
        let p = [middle, middle + Vec3::Y * size, middle + Vec3::X * size];
        if i % 4 < 2 { p } else { [p[0], p[2], p[1]] }
    };
    let emissive_triangles: Vec<_> = (0..50).map(emissive_triangle).collect();
    let radiance = [1.0, 5.0, 40.0, 2.0, 0.1];
    for (p, up) in [(Vec3::ZERO, Vec3::Z), (Vec3::new(3.0, 1.0, 0.5), Vec3::new(0.6, 0.0, 0.8))] {
        let all =
            set(LightParts { shapes: triangles(&emissive_triangles, &radiance), ..LightParts::default() });
        let joint = irradiance(&all, p, up, 1 << 15).x;
        let one = |i: usize| {
            let single = triangles(&emissive_triangles[i..=i], &radiance[i % 5..=i % 5]);
            irradiance(&set(LightParts { shapes: single, ..LightParts::default() }), p, up, 1 << 10).x
        };
        let exact: f32 = (0..50).map(one).sum();
        assert!((joint / exact - 1.0).abs() < 5e-3, "{joint} instead of {exact}");
        // The benefit of the tree: most samples reach a light that counts, and bring about the same.
        let brought: Vec<f32> = (0..4096)
            .map(|i| {
                let lit = all.sample(p, up, numbers(i));
                lit.map_or(0.0, |s| s.radiance.x * s.dir.dot(up).max(0.0) / s.pdf)
            })
            .collect();
        let variance = brought.iter().map(|x| (x / exact - 1.0).powi(2)).sum::<f32>() / 4096.0;
        assert!(variance < 3.0, "relative variance {variance} of one sample at {p}");
    }
}

/// Samples have the density that is looked up for a ray that hits the light.
#[test]
fn densities_are_those_of_samples() {
    let lights = everything();
    for (p, n) in [(Vec3::ZERO, Vec3::Z), (Vec3::new(1.0, 0.0, 0.5), Vec3::ZERO), (Vec3::Y, Vec3::X)] {
        let mut hits_by_kind = [0_u32; 5];
        for s in (0..4096).filter_map(|i| lights.sample(p, n, numbers(i))) {
            let reported = match lights.kind(s.light) {
                LightKind::Shape(i) => {
                    hits_by_kind[0] += 1;
                    lights.pdf_shape(p, n, i, s.dir, s.dist)
                }
                LightKind::Environment => {
                    hits_by_kind[1] += 1;
                    // On the edge between two cells rounding may give the other one's.
                    let on_edge =
                        [s.dir + 1e-5, s.dir - 1e-5].map(|d| lights.pdf_environment(p, n, d.normalize()));
                    if (on_edge[0] - on_edge[1]).abs() > 1e-4 {
                        s.pdf
                    } else {
                        lights.pdf_environment(p, n, s.dir)
                    }
                }
                LightKind::Point(i) => {
                    hits_by_kind[2 + i as usize] += 1;
                    s.pdf
                }
                LightKind::Directional(_) => {
                    hits_by_kind[4] += 1;
                    s.pdf
                }
            };
            assert!(
                (reported / s.pdf - 1.0).abs() < 1e-3,
                "{:?}: {reported}, sampled with {}",
                lights.kind(s.light),
                s.pdf
            );
        }
        assert!(
            hits_by_kind[..2].iter().all(|&count| count > 100),
            "all kinds are sampled: {hits_by_kind:?}"
        );
    }
}

/// The choice between groups has the shares that are looked up, which follow contributions.
#[test]
fn groups_are_chosen_by_contribution() {
    let lights = everything();
    for (p, n) in [(Vec3::ZERO, Vec3::Z), (Vec3::new(1.0, 0.0, 0.5), Vec3::ZERO), (Vec3::Y, -Vec3::Z)] {
        const N: u32 = 4096;
        let mut counts = [0.0; 3];
        for u in (0..N).map(|i| (i as f32 + 0.5) / N as f32) {
            let group = lights.choose_group(p, n, u).expect("the sky is everywhere");
            assert_eq!(group.probability, lights.group_share(group.index, p, n), "one probability");
            assert!((0.0..1.0).contains(&group.rest), "the rest is a number in [0, 1): {}", group.rest);
            counts[group.index] += 1.0 / N as f32;
        }
        for (index, count) in counts.into_iter().enumerate() {
            let share = lights.group_share(index, p, n);
            assert!((count - share).abs() < 1e-3, "group {index}: {count} of choices, share {share}");
        }
    }
    // A sun of irradiance 3 and a sky of irradiance pi, without and with the sun below the horizon: scattered rays find
    // light that is the same from everywhere as well.
    let lights = set(LightParts {
        directionals: DirectionalLight::new(-Vec3::Z, Vec3::splat(3.0), 0.0).into_iter().collect(),
        environment: Some(EnvironmentLight::Constant(Arc::new(ConstantEnvironment { radiance: Vec3::ONE }))),
        ..LightParts::default()
    });
    assert_eq!(lights.split_groups(), 1..2, "no light has a position, and the sky is not worth a ray");
    assert_eq!(lights.pdf_environment_in_group(Vec3::Z, Vec3::Z), 0.0, "it is left to scattered rays");
    let sky = |n| lights.group_share(2, Vec3::ZERO, n);
    // A twentieth of the sky; the sun, and a sixteenth of it below the horizon.
    for (normal, sun) in [(Vec3::Z, 3.0), (-Vec3::Z, 3.0 / 16.0)] {
        let left = 0.05 * PI;
        let expected = 0.75 * left / (left + sun) + 0.25 * 0.05 / 1.05;
        assert!((sky(normal) - expected).abs() < 1e-6, "facing {normal}: {}, not {expected}", sky(normal));
    }
}

/// Groups that are sampled one by one bring what one sample of all brings.
#[test]
fn groups_add_up() {
    let lights = everything();
    let (p, up) = (Vec3::new(0.3, 0.2, 0.0), Vec3::new(0.0, 0.6, 0.8));
    let all = irradiance(&lights, p, up, 1 << 16).x;
    let of_group = |group| {
        const N: u32 = 1 << 14;
        let brought = |i| {
            let lit = lights.sample_among(Some(group), p, up, numbers(i));
            lit.map_or(0.0, |s| s.radiance.x * s.dir.dot(up).max(0.0) / s.pdf) / N as f32
        };
        (0..N).map(brought).sum::<f32>()
    };
    assert_eq!(lights.split_groups(), 0..3, "all groups shine");
    let sum: f32 = lights.split_groups().map(of_group).sum();
    assert!((sum / all - 1.0).abs() < 0.01, "{sum} one by one, {all} together");
}

/// Chi-square: directions to a square of two triangles over a grid on the square, expected counts by quadrature.
#[test]
fn directions_follow_their_density() {
    let lights = set(LightParts { shapes: triangles(&square(), &[1.0]), ..LightParts::default() });
    let (p, n) = (Vec3::new(0.4, -0.3, 0.2), Vec3::new(0.0, 0.6, 0.8));
    const CELLS: usize = 8;
    const N: u32 = 40_000;
    let mut counts = [0.0_f64; CELLS * CELLS];
    let cell = |q: Vec3| {
        let [i, j] = [q.x, q.y].map(|x| (((x + 1.0) * 0.5 * CELLS as f32) as usize).min(CELLS - 1));
        CELLS * i + j
    };
    for s in (0..N).filter_map(|i| lights.sample(p, n, numbers(i))) {
        counts[cell(p + s.dir * s.dist)] += 1.0;
    }
    let mut expected = [0.0_f64; CELLS * CELLS];
    const STEPS: usize = 400;
    for (i, j) in (0..STEPS).flat_map(|i| (0..STEPS).map(move |j| (i, j))) {
        let [x, y] = [i, j].map(|k| 2.0 * (k as f32 + 0.5) / STEPS as f32 - 1.0);
        let offset = Vec3::new(x, y, 1.0) - p;
        let (dist, dir) = (offset.length(), offset.normalize());
        // The first triangle has the corners with y > x; on the diagonal lies half of each.
        let pdf_of = |triangle| lights.pdf_shape(p, n, triangle, dir, dist);
        let pdf = if i == j { 0.5 * (pdf_of(0) + pdf_of(1)) } else { pdf_of(u32::from(j < i)) };
        let solid_angle = dir.z / (dist * dist) * (2.0 / STEPS as f32).powi(2);
        expected[cell(Vec3::new(x, y, 1.0))] += f64::from(pdf * solid_angle) * f64::from(N);
    }
    let sum: f64 = expected.iter().sum();
    assert!((sum / f64::from(N) - 1.0).abs() < 1e-3, "the density is one: {}", sum / f64::from(N));
    let chi_square: f64 = counts.iter().zip(expected).map(|(c, e)| (c - e).powi(2) / e).sum();
    // 63 degrees of freedom: random numbers exceed 104 once in a thousand runs, stratified ones stay far below.
    assert!(chi_square < 104.0, "chi-square {chi_square}");
}

#[test]
fn emission_adds_up_to_the_power() {
    let far = (4.0 * 3.0_f32.sqrt() / 2.0 * 1.001).powi(2) * PI;
    let cone = |edge| Cone::new(-Vec3::Z, 0.3, 0.6, edge);
    let spot = |edge| PointLight { cone: cone(edge), ..PointLight::new(Vec3::Z, Vec3::splat(2.0)) };
    // A square between the cones has a third of the cosines' difference, a smooth step half.
    let (inner, outer) = (0.3_f32.cos(), 0.6_f32.cos());
    let cases = [
        (LightParts { shapes: triangles(&square(), &[1.0]), ..LightParts::default() }, 4.0 * PI, "square"),
        (
            LightParts {
                shapes: shapes([Outline::Sphere { center: Vec3::X, radius: 0.5 }].into_iter(), &[1.0]),
                ..LightParts::default()
            },
            PI * PI,
            "sphere",
        ),
        (
            LightParts {
                points: vec![PointLight::new(Vec3::ONE, Vec3::splat(2.0))],
                ..LightParts::default()
            },
            8.0 * PI,
            "point",
        ),
        (
            LightParts { points: vec![spot(ConeEdge::Squared)], ..LightParts::default() },
            4.0 * PI * (1.0 - inner + (inner - outer) / 3.0),
            "spot",
        ),
        (
            LightParts {
                points: vec![PointLight { radius: 0.3, ..spot(ConeEdge::Smooth) }],
                ..LightParts::default()
            },
            4.0 * PI * (1.0 - inner + (inner - outer) / 2.0),
            "smooth spot with a radius",
        ),
        (
            LightParts {
                directionals: DirectionalLight::new(Vec3::X, Vec3::ONE, 0.0).into_iter().collect(),
                ..LightParts::default()
            },
            far,
            "sun",
        ),
        (
            LightParts {
                environment: Some(EnvironmentLight::Constant(Arc::new(ConstantEnvironment {
                    radiance: Vec3::ONE,
                }))),
                ..LightParts::default()
            },
            4.0 * PI * far,
            "sky",
        ),
    ];
    const N: u32 = 1 << 13;
    for (parts, exact, name) in cases {
        let lights = set(parts);
        let sum = (0..N).fold(0.0, |sum, i| {
            let [a, b, c] = numbers(i);
            let d = sample_pair(3, SampleKey { pixel: 1, sample: i, branch: 0 }, 0, 0);
            let Some(ray) = lights.emit(c, [a, b], d) else { return sum };
            let cos = if ray.is_surface { ray.normal.dot(ray.dir) } else { 1.0 };
            let again = ray.emitted.x * cos / (ray.pdf_pos * ray.pdf_dir);
            assert!(
                (again / ray.radiance_over_pdf.x - 1.0).abs() < 1e-3,
                "{name}: the densities are its own"
            );
            sum + f64::from(ray.radiance_over_pdf.x) / f64::from(N)
        });
        assert!((sum as f32 / exact - 1.0).abs() < 2e-3, "{name}: {sum} instead of {exact}");
    }
}

#[test]
fn light_paths_share_out_by_power() {
    let lights = everything();
    const N: u32 = 1 << 14;
    let mut counts = vec![0.0_f64; lights.len()];
    for i in 0..N {
        let [a, b, c] = numbers(i);
        if let Some(ray) = lights.emit(c, [a, b], [a, b]) {
            assert_eq!(ray.kind, lights.kind(ray.light), "the kind is the light's");
            counts[ray.light.0 as usize] += 1.0 / f64::from(N);
            if let LightKind::Shape(i) = ray.kind {
                assert!(
                    (lights.pdf_emit_position(i) / ray.pdf_pos - 1.0).abs() < 1e-5,
                    "its density is known"
                );
            }
        }
    }
    let power = lights.power().expect("it shines");
    for (i, count) in counts.iter().enumerate() {
        let exact = f64::from(power.probability(i));
        assert!((count - exact).abs() < 2e-3, "light {i}: {count} instead of {exact}");
    }
}

#[test]
fn what_was_hit_is_found() {
    let lights = everything();
    assert_eq!(lights.shape([0, 0, 17], Vec3::Z), Some(17), "a triangle that shines");
    assert_eq!(lights.shape([0, 1, 17], Vec3::Z), None, "one that does not");
    assert_eq!(lights.kind(LightId(48)), LightKind::Point(0), "points come after shapes");
    assert_eq!(lights.kind(LightId(51)), LightKind::Environment, "the environment comes last");
    assert!(
        set(LightParts::default()).sample(Vec3::ZERO, Vec3::Z, [0.5; 3]).is_none(),
        "no light, no sample"
    );
}

type Requests = [(Vec3, Vec3, [f32; 3]); LANES];

#[inline(always)]
fn in_lanes<S: Simd>(
    simd: S,
    lights: &LightSet,
    requests: &Requests,
    (group, active): (Option<usize>, u64),
) -> [Option<LightSample>; LANES] {
    let lanes = |f: &dyn Fn(usize) -> f32| f32x16::from_fn(simd, f);
    let vectors = |f: &dyn Fn(usize) -> Vec3| {
        let [x, y, z] = [0, 1, 2].map(|k| lanes(&|i| f(i)[k]));
        Vec3x16::new(x, y, z)
    };
    let (p, ns) = (vectors(&|i| requests[i].0), vectors(&|i| requests[i].1));
    let u = [0, 1, 2].map(|k| lanes(&|i| requests[i].2[k]));
    let all_sides = (0..LANES).fold(0, |bits, i| bits | u64::from(requests[i].1 == Vec3::ZERO) << i);
    let masks = [active, all_sides].map(|bits| Mask::from_bitmask(simd, bits));
    let found = lights.sample_x16(group, masks, [p, ns], u);
    std::array::from_fn(|i| {
        let bit = |mask: Mask<S>| mask.to_bitmask() >> i & 1 == 1;
        bit(found.found).then(|| LightSample {
            dir: found.dir.get(i),
            dist: found.dist[i],
            radiance: found.radiance.get(i),
            pdf: found.pdf[i],
            delta: bit(found.delta),
            light: LightId(0),
        })
    })
}

#[test]
fn lanes_choose_as_points_do() {
    let emissive_triangle = |i: usize| {
        let spread = |m: usize| ((i * m) % 101) as f32 / 25.0 - 2.0;
        let middle = Vec3::new(spread(37), spread(53), spread(71));
        let size = 0.1 + 0.1 * (i % 7) as f32;
        [middle, middle + Vec3::new(0.0, size, 0.3), middle + Vec3::new(size, -0.2, 0.1)]
    };
    let emissive_triangles =
        |n: usize| triangles(&(0..n).map(emissive_triangle).collect::<Vec<_>>(), &[1.0, 5.0, 20.0]);
    let of = |n| set(LightParts { shapes: emissive_triangles(n), ..LightParts::default() });
    // Of spheres, and of both.
    let mixed = |n: usize, every: usize| {
        let outline = |i: usize| {
            let p = emissive_triangle(i);
            if i.is_multiple_of(every) {
                Outline::Sphere { center: p[0], radius: 0.1 }
            } else {
                Outline::Triangle(p)
            }
        };
        set(LightParts { shapes: shapes((0..n).map(outline), &[1.0, 5.0, 20.0]), ..LightParts::default() })
    };
    // Some of them with beams.
    let beamed = |n: usize| {
        let outline = |i: usize| match emissive_triangle(i) {
            [center, ..] if i.is_multiple_of(3) => Outline::Sphere { center, radius: 0.1 },
            p => Outline::Triangle(p),
        };
        let axis = |i: usize| (i % 4 < 2).then(|| Vec3::new(0.5 - (i % 2) as f32, 0.4, -0.6).normalize());
        set(LightParts {
            shapes: beams((0..n).map(outline), &[1.0, 5.0, 20.0], axis),
            ..LightParts::default()
        })
    };
    // Points, some with a radius, some with a cone, beside triangles.
    let points = |n: usize, triangles: usize| {
        let point = |i: usize| {
            let edge = [ConeEdge::Smooth, ConeEdge::Squared][i % 2];
            let cone = Cone::new(Vec3::new(0.3, 0.5 - (i % 2) as f32, -1.0), 0.2, 0.9, edge);
            PointLight {
                radius: 0.2 * (i % 3) as f32,
                cone: cone.filter(|_| i % 4 > 1),
                ..PointLight::new(emissive_triangle(i + 7)[0], Vec3::new(1.0, 2.0, 1.0 + i as f32))
            }
        };
        set(LightParts {
            shapes: emissive_triangles(triangles).filter(|_| triangles > 0),
            points: (0..n).map(point).collect(),
            ..LightParts::default()
        })
    };
    let with_sky = set(LightParts {
        shapes: emissive_triangles(30),
        directionals: DirectionalLight::new(-Vec3::Z, Vec3::ONE, 0.4).into_iter().collect(),
        environment: Some(picture()),
        ..LightParts::default()
    });
    let sets = [
        of(0),
        of(1),
        of(7),
        of(11),
        of(60),
        of(500),
        with_sky,
        everything(),
        mixed(1, 1),
        mixed(40, 1),
        mixed(9, 2),
        mixed(90, 3),
        beamed(3),
        beamed(9),
        beamed(80),
        points(1, 0),
        points(7, 1),
        points(13, 0),
        points(50, 0),
        points(20, 40),
    ];
    for (which, lights) in sets.iter().enumerate() {
        let (mut lit, mut dark) = (0, 0);
        for round in 0..200_u32 {
            let active = u64::from(round.wrapping_mul(2_654_435_761) >> 7) & 0xffff;
            let requests: Requests = std::array::from_fn(|i| {
                let draw = |n| {
                    sample_pair(3, SampleKey { pixel: round, sample: i as u32, branch: 0 }, which as u32, n)
                };
                let ([a, b], [c, d]) = (draw(7), draw(8));
                // Some at one position, some at a light's corner.
                let near = if round % 3 == 0 { 0.0 } else { 4.0 };
                let p = Vec3::new(a - 0.5, b - 0.5, c - 0.5) * near;
                // No lane, some, or all of them lit from all sides.
                let has_horizon = [true, i % 3 > 0, false][round as usize % 3];
                let n = if has_horizon { uniform_sphere([d, (a * 17.0).fract()]) } else { Vec3::ZERO };
                let [u, v, w] = numbers(16 * round + i as u32);
                (if i == 3 { emissive_triangle(0)[0] } else { p }, n, [u, v, w])
            });
            // Every other round among the lights of one group.
            let split = lights.split_groups();
            let group = (round % 2 == 1)
                .then(|| split.clone().nth(round as usize / 2 % split.len().max(1)))
                .flatten();
            let found = dispatch_wide!(Level::default(), simd => in_lanes(simd, lights, &requests, (group, active)), else return);
            for (i, (&(p, n, u), found)) in requests.iter().zip(found).enumerate() {
                let exact = lights.sample_among(group, p, n, u).filter(|_| active >> i & 1 == 1);
                let exact = exact.map(|sample| LightSample { light: LightId(0), ..sample });
                assert_eq!(found, exact, "set {which}, from {p} facing {n} with {u:?}");
                if exact.is_some() { lit += 1 } else { dark += 1 }
            }
        }
        assert!(dark > 100 && (lit > 500 || which < 2), "set {which}: {lit} lit, {dark} not");
    }
}

#[test]
fn places_are_on_near_lights() {
    let points = vec![PointLight::new(Vec3::new(9.0, 0.0, 0.0), Vec3::splat(8.0))];
    let lights = set(LightParts { shapes: triangles(&square(), &[1.0]), points, ..LightParts::default() });
    assert_eq!(lights.near_count(), 3);
    let count = |p: Vec3| {
        let places: Vec<Vec3> = (0..512).filter_map(|i| lights.near_place(p, numbers(i))).collect();
        assert_eq!(places.len(), 512, "one for each");
        let on_square = |q: &&Vec3| (q.z - 1.0).abs() < 1e-6 && q.x.abs().max(q.y.abs()) <= 1.0 + 1e-6;
        let square = places.iter().filter(on_square).count();
        let point = places.iter().filter(|q| **q == Vec3::new(9.0, 0.0, 0.0)).count();
        assert_eq!(square + point, 512, "nowhere else");
        let middle = places.iter().filter(on_square).sum::<Vec3>() / square.max(1) as f32;
        assert!(square < 100 || middle.distance(Vec3::Z) < 0.1, "all over the square: {middle}");
        square
    };
    let [near, far] = [Vec3::ZERO, Vec3::new(8.5, 0.0, 0.0)].map(count);
    assert!(near > 400 && far < 100, "the nearer one more often: {near}, {far}");
    let none = set(LightParts::default());
    assert!(none.near_count() == 0 && none.near_place(Vec3::ZERO, [0.5; 3]).is_none());
}

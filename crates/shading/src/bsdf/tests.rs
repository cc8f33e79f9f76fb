// SPDX-License-Identifier: GPL-3.0-or-later
//! What every BSDF must keep: samples follow the density, densities and values integrate to what is said, energy is not
//! made, and white surfaces lose none. Source: \[PJH23\] section 9.8 (chi-square test of samples); original.

use std::f64::consts::{PI, TAU};

use glam::Vec3;

use super::*;
use crate::batch::SampleKey;
use crate::sampling::sample_pair;

/// Models under test, white where a colour is free.
fn models() -> Vec<(String, Model)> {
    let white = Vec3::ONE;
    let mut models: Vec<(String, Model)> = vec![("lambert".into(), Model::Lambert { albedo: white })];
    let mut add = |name: String, model| models.push((name, model));
    for alpha in [0.1, 0.4, 1.0] {
        let metal = Conductor::new(alpha, Reflectance::Schlick { f0: white });
        add(format!("conductor {alpha}"), Model::Lobe(Lobe::Conductor(metal)));
        add(
            format!("half conductor {alpha}, half lambert"),
            Model::Mix { a: Lobe::Conductor(metal), b: Lobe::Lambert { albedo: white }, share_b: 0.5 },
        );
    }
    for roughness in [0.3, 1.0] {
        add(format!("oren-nayar {roughness}"), Model::Lobe(Lobe::OrenNayar { albedo: white, roughness }));
    }
    for (alpha, eta, thin) in [(0.15, 0.66, false), (0.5, 1.5, false), (1.0, 0.75, false), (0.3, 0.66, true)]
    {
        let glass = RoughDielectric::new(alpha, eta, white, white, thin);
        add(format!("glass {alpha} {eta} {thin}"), Model::Lobe(Lobe::RoughDielectric(glass)));
    }
    for (metallic, roughness) in [(0.0, 0.3), (0.0, 1.0), (1.0, 0.5), (1.0, 1.0), (0.5, 0.6)] {
        let plain = Principled::new(white, metallic, roughness, 1.5);
        add(format!("principled {metallic} {roughness}"), Model::Principled(plain));
        if (metallic, roughness) == (0.0, 1.0) || (metallic, roughness) == (1.0, 0.5) {
            continue;
        }
        let coated = Principled { coat: 1.0, coat_alpha: 0.15, ..plain };
        add(format!("coated {metallic} {roughness}"), Model::Principled(coated));
        let cloth = Principled { sheen: white, sheen_roughness: 0.6, ..plain };
        add(format!("cloth {metallic} {roughness}"), Model::Principled(cloth));
        let glass = Principled { transmission: 0.7, ..plain };
        add(format!("glassy {metallic} {roughness}"), Model::Principled(glass));
    }
    models
}

fn views() -> impl Iterator<Item = Vec3> {
    [0.05_f32, 0.6, 1.1, 1.45].into_iter().map(|angle| Vec3::new(angle.sin(), 0.0, angle.cos()))
}

fn around_z(model: Model) -> Bsdf {
    Bsdf { basis: Basis { tangent: Vec3::X, bitangent: Vec3::Y, normal: Vec3::Z }, model }
}

fn randoms(n: u32) -> impl Iterator<Item = [f32; 3]> {
    (0..n).map(|sample| {
        let pair = |purpose| sample_pair(1, SampleKey { pixel: 5, sample, branch: 0 }, 0, purpose);
        let ([a, _], [b, c]) = (pair(0), pair(1));
        [a, b, c]
    })
}

const RINGS: usize = 160;
const SECTORS: usize = 128;

/// Midpoint rule over the whole sphere: narrow rings near the poles, narrow sectors opposite to the views, where lobes are.
fn integrate(mut f: impl FnMut(Vec3) -> f64) -> f64 {
    let mut sum = 0.0;
    for ring in 0..2 * RINGS {
        let edge = |k: usize| {
            let x = k as f64 / RINGS as f64 - 1.0;
            x.signum() * (1.0 - (1.0 - x.abs()).powi(2))
        };
        let (a, b) = (edge(ring), edge(ring + 1));
        let z = 0.5 * (a + b);
        let r = (1.0 - z * z).sqrt();
        for sector in 0..SECTORS {
            let edge = |k: usize| PI * (2.0 * k as f64 / SECTORS as f64 - 1.0).powi(3) + PI;
            let (from, to) = (edge(sector), edge(sector + 1));
            let (s, c) = (0.5 * (from + to)).sin_cos();
            sum += f(glam::DVec3::new(r * c, r * s, z).as_vec3()) * (b - a) * (to - from);
        }
    }
    sum
}

#[test]
fn samples_follow_the_density() {
    const CELLS: [usize; 2] = [16, 16];
    const N: u32 = 1 << 15;
    for (name, model) in models() {
        let bsdf = around_z(model);
        for wo in views() {
            let cell = |w: Vec3| {
                let ring = ((w.z * 0.5 + 0.5) * CELLS[0] as f32).min(CELLS[0] as f32 - 1.0) as usize;
                let turn = f64::from(w.y.atan2(w.x)) / TAU + 0.5;
                ring * CELLS[1] + ((turn * CELLS[1] as f64) as usize).min(CELLS[1] - 1)
            };
            let mut wanted = vec![0.0; CELLS[0] * CELLS[1]];
            let mut counts = wanted.clone();
            fine(|w, area| wanted[cell(w)] += f64::from(bsdf.pdf(wo, w)) * area);
            for u in randoms(N) {
                let Some(sample) = bsdf.sample(wo, u) else { continue };
                assert!((sample.wi.length() - 1.0).abs() < 1e-5, "{name}: unit directions");
                counts[cell(sample.wi)] += 1.0;
                let pdf = bsdf.pdf(wo, sample.wi);
                assert!((sample.pdf - pdf).abs() <= 2e-3 * pdf, "{name}: {} is {pdf}", sample.pdf);
                let value = bsdf.eval(wo, sample.wi);
                let off = (sample.weight * sample.pdf - value).abs().max_element();
                assert!(
                    off <= 2e-3 * value.max_element() + 1e-7,
                    "{name}: weight times density is the value"
                );
                assert_eq!(sample.transmitted, sample.wi.z < 0.0, "{name}: which side");
            }
            let (mut chi_square, mut cells) = (0.0, 0);
            let (mut rest_wanted, mut rest_counts) = (0.0, 0.0);
            for (w, c) in wanted.iter().map(|w| w * f64::from(N)).zip(&counts) {
                if w < 8.0 {
                    rest_wanted += w;
                    rest_counts += c;
                } else {
                    chi_square += (c - w).powi(2) / w;
                    cells += 1;
                }
            }
            assert!((rest_wanted - rest_counts).abs() < 6.0 * rest_wanted.sqrt() + 8.0, "{name}: rare cells");
            // Stratified samples stay far below what chance allows; the quadrature's error needs the rest.
            let bound = f64::from(cells) + 4.0 * f64::from(2 * cells).sqrt();
            assert!(chi_square < bound, "{name} seen from {wo}: chi-square {chi_square} in {cells} cells");
        }
    }
}

/// Calls `f(direction, solid angle)` over the sphere: within each of 16 by 16 cells, rings that are narrow at the poles and
/// sectors that are narrow opposite to the views, where lobes are.
fn fine(mut f: impl FnMut(Vec3, f64)) {
    let to_edge = |t: f64, at_start: bool, at_end: bool| match (at_start, at_end) {
        (true, _) => t * t,
        (_, true) => 1.0 - (1.0 - t) * (1.0 - t),
        _ => t,
    };
    let (rings, sectors) = (48, 32);
    for (cell, ring) in (0..16).flat_map(|cell| (0..rings).map(move |ring| (cell, ring))) {
        let edge = |k: usize| {
            let t = to_edge(k as f64 / f64::from(rings), cell == 0, cell == 15);
            2.0 * (f64::from(cell) + t) / 16.0 - 1.0
        };
        let (a, b) = (edge(ring as usize), edge(ring as usize + 1));
        let z = 0.5 * (a + b);
        let r = (1.0 - z * z).sqrt();
        for (slice, sector) in (0..16).flat_map(|slice| (0..sectors).map(move |sector| (slice, sector))) {
            let edge = |k: usize| {
                let t = to_edge(k as f64 / f64::from(sectors), slice == 8, slice == 7);
                TAU * (f64::from(slice) + t) / 16.0
            };
            let (from, to) = (edge(sector as usize), edge(sector as usize + 1));
            let (s, c) = (0.5 * (from + to)).sin_cos();
            f(glam::DVec3::new(r * c, r * s, z).as_vec3(), (b - a) * (to - from));
        }
    }
}

#[test]
fn densities_and_values_integrate() {
    for (name, model) in models() {
        let bsdf = around_z(model);
        for wo in views() {
            let density = integrate(|wi| f64::from(bsdf.pdf(wo, wi)));
            assert!(density < 1.01 && density > 0.3, "{name} from {wo}: density {density}");
            let value = integrate(|wi| f64::from(bsdf.eval(wo, wi).x));
            let said = f64::from(bsdf.albedo(wo).x);
            // Coat and sheen take a little more of gloss below them than they send back, where two directions differ.
            let lost = match name.split(' ').next() {
                Some("coated") => 0.03,
                Some("cloth") => 0.14,
                _ => 0.015,
            };
            assert!((value - said).abs() < lost + 0.015, "{name} from {wo}: albedo {value}, said {said}");
            assert!(value < 1.01, "{name} from {wo}: makes energy: {value}");
            assert!(value > 1.0 - lost, "{name} from {wo}: white surfaces keep light: {value}");
        }
    }
}

/// Fibres that nearly stand send back all light of grazing views and next to none of others: what they leave is the body's.
#[test]
fn smooth_cloth_keeps_light() {
    for sheen_roughness in [0.0, 0.15, 0.25, 0.5] {
        let matte = Principled { f0: Vec3::ZERO, f90: 0.0, ..Principled::new(Vec3::ONE, 0.0, 1.0, 1.5) };
        let bsdf = around_z(Model::Principled(Principled { sheen: Vec3::ONE, sheen_roughness, ..matte }));
        for cos in [0.02_f32, 0.06, 0.1, 0.2, 0.5, 0.9] {
            let wo = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
            let mut value = 0.0;
            fine(|wi, area| value += f64::from(bsdf.eval(wo, wi).x) * area);
            assert!((value - 1.0).abs() < 0.008, "{sheen_roughness} from {cos}: {value} of 1 comes back");
        }
    }
}

#[test]
fn light_may_go_both_ways() {
    for (name, model) in models() {
        let bsdf = around_z(model);
        // The same surface met from the other side, in the same frame.
        let behind = around_z(match model {
            Model::Lobe(Lobe::RoughDielectric(glass)) => {
                Model::Lobe(Lobe::RoughDielectric(glass.turned_over()))
            }
            Model::Principled(p) => Model::Principled(Principled { eta: 1.0 / p.eta, ..p }),
            other => other,
        });
        let eta = bsdf.eta();
        for (wo, u) in views().flat_map(|wo| randoms(64).map(move |u| (wo, u))) {
            let Some(BsdfSample { wi, .. }) = bsdf.sample(wo, u).filter(|s| s.wi.z.abs() > 0.01) else {
                continue;
            };
            let there = bsdf.eval(wo, wi) / wi.z.abs();
            let over = Vec3::new(1.0, 1.0, -1.0);
            let back = if wi.z > 0.0 {
                bsdf.eval(wi, wo) / wo.z
            } else {
                behind.eval(wi * over, wo * over) / (wo.z * eta * eta)
            };
            let off = (there - back).abs().max_element();
            assert!(off <= 4e-3 * there.max_element() + 1e-5, "{name} {wo} {wi}: {there} and {back}");
        }
    }
}

#[test]
fn delta_lobes_keep_all_light() {
    let glass = |thin, eta| {
        Lobe::Dielectric(Dielectric { eta, reflectance: Vec3::ONE, transmittance: Vec3::ONE, thin })
    };
    let lobes = [
        Lobe::Mirror { reflectance: Vec3::ONE },
        glass(false, 1.0 / 1.5),
        glass(false, 1.5),
        glass(true, 0.7),
    ];
    for (lobe, wo) in lobes.iter().flat_map(|lobe| views().map(move |wo| (lobe, wo))) {
        let bsdf = around_z(Model::Lobe(*lobe));
        let branches: Vec3 = bsdf.delta_branches(wo).iter().flatten().map(|s| s.weight).sum();
        assert!((branches - Vec3::ONE).length() < 1e-5, "{lobe:?}: branches {branches}");
        assert!((bsdf.albedo(wo) - Vec3::ONE).length() < 1e-5, "{lobe:?}: albedo");
        let n = 4096;
        let share = |s: &BsdfSample| f64::from(u8::from(s.transmitted)) / f64::from(n);
        let through: f64 = randoms(n)
            .filter_map(|u| bsdf.sample(wo, u))
            .map(|s| {
                assert!(s.delta && s.pdf.is_infinite(), "a delta says so");
                assert!((s.weight - Vec3::ONE).length() < 1e-4, "chosen by its share: {}", s.weight);
                share(&s)
            })
            .sum();
        let wanted = bsdf.delta_branches(wo)[1].map_or(0.0, |s| f64::from(s.weight.x));
        assert!((through - wanted).abs() < 0.01, "{lobe:?}: {through} goes through, not {wanted}");
        assert!(!bsdf.is_smooth() && bsdf.eval(wo, wo) == Vec3::ZERO, "light samples bring nothing");
    }
}

#[test]
fn narrow_and_wide_lobes_make_the_whole() {
    for (name, model) in models() {
        let bsdf = around_z(model);
        let [narrow, wide] = bsdf.split_at(0.3);
        for (wo, u) in views().flat_map(|wo| randoms(16).map(move |u| (wo, u))) {
            let Some(BsdfSample { wi, .. }) = bsdf.sample(wo, u) else { continue };
            let (whole, parts) = (bsdf.eval(wo, wi), narrow.eval(wo, wi) + wide.eval(wo, wi));
            assert!((whole - parts).length() <= 1e-4 * whole.length() + 1e-7, "{name}: {whole}, {parts}");
        }
    }
}

/// A path carried from the light has the value that the path from the eye has, shading normal or not.
#[test]
fn light_paths_are_corrected() {
    let (ng, ns) = (Vec3::Z, Vec3::new(0.3, -0.2, 0.9).normalize());
    let bsdf = Bsdf::new(ns, Model::Lambert { albedo: Vec3::ONE });
    let (eye, light) = (Vec3::new(0.5, 0.1, 0.8).normalize(), Vec3::new(-0.4, 0.3, 0.7).normalize());
    let from_eye = bsdf.eval(eye, light).x;
    // What a light path scatters is counted per area across its way: ng's cosines stand for the surface.
    let from_light = bsdf.eval(light, eye).x * bsdf.adjoint_correction(light, eye, ng);
    let wanted = from_eye * (ng.dot(eye) / ng.dot(light)).abs();
    assert!((from_light - wanted).abs() < 1e-5, "{from_light}, not {wanted}");
    assert_eq!(bsdf.adjoint_correction(Vec3::new(0.0, 0.9, 0.05), eye, ng), 0.0, "light from below");
    let glass = Dielectric { eta: 1.0 / 1.5, reflectance: Vec3::ONE, transmittance: Vec3::ONE, thin: false };
    let glass = around_z(Model::Lobe(Lobe::Dielectric(glass)));
    let [_, through] = glass.delta_branches(light);
    let wi = through.expect("light enters").wi;
    let correction = glass.adjoint_correction(light, wi, ng);
    assert!((correction - 1.0 / 2.25).abs() < 1e-5, "refraction: {correction}");
}

#[test]
fn silhouettes_are_not_black() {
    // Seen from below the shading normal, though from above the facet.
    let wo = Vec3::new(0.9, 0.0, -0.02).normalize();
    for (name, model) in models() {
        let bsdf = around_z(model);
        let light: Vec3 = randoms(256).filter_map(|u| bsdf.sample(wo, u)).map(|s| s.weight / 256.0).sum();
        assert!(light.x > 0.9 && light.x < 1.04, "{name}: {light}");
    }
}

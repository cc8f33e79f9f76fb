// SPDX-License-Identifier: GPL-3.0-or-later
//! Properties of every BSDF: samples follow the density, densities and values have the stated integrals,
//! energy is not created, and white surfaces lose none. Source: \[PJH23\] section 9.8 (chi-square test of
//! samples); original.

use std::f64::consts::{PI, TAU};

use glam::{Vec2, Vec3};

use super::*;
use crate::batch::{SampleKey, SurfaceBatch, Vec3s};
use crate::lanes::{LANES, Vec3x16};
use crate::real::Vector;
use crate::sampling::{sample_pair, uniform_sphere};
use gnurt_simd::{Level, Simd, dispatch_wide, f32x16, prelude::*};

/// Models under test, white where a colour is free.
pub(super) fn models() -> Vec<(String, Lobes)> {
    let white = Vec3::ONE;
    let lambert = Lobe::lambert(white);
    let mut models: Vec<(String, Lobes)> = vec![("lambert".into(), lambert.into())];
    let mut add = |name: String, lobes| models.push((name, lobes));
    for alpha in [0.1, 0.4, 1.0] {
        let metal = Lobe::microfacets(alpha, white, white);
        add(format!("conductor {alpha}"), metal.into());
        add(format!("half conductor {alpha}, half lambert"), Lobes::from(metal).mixed(lambert, 0.5));
    }
    for roughness in [0.3, 1.0] {
        add(format!("oren-nayar {roughness}"), Lobe::oren_nayar(white, roughness).into());
    }
    add("dim oren-nayar".into(), Lobe::oren_nayar_once(white, 0.7).into());
    add("dim burley".into(), Lobe::burley(white, 0.8).into());
    for (alpha, eta, thin) in [(0.15, 0.66, false), (0.5, 1.5, false), (1.0, 0.75, false), (0.3, 0.66, true)]
    {
        add(format!("glass {alpha} {eta} {thin}"), Lobe::rough_glass(alpha, eta, white, white, thin).into());
    }
    for (metallic, roughness) in [(0.0, 0.3), (0.0, 1.0), (1.0, 0.5), (1.0, 1.0), (0.5, 0.6)] {
        let plain = Principled::new(white, metallic, roughness, 1.5);
        add(format!("principled {metallic} {roughness}"), plain.into());
        if (metallic, roughness) == (0.0, 1.0) || (metallic, roughness) == (1.0, 0.5) {
            continue;
        }
        let coated = Principled { coat: 1.0, coat_alpha: 0.15, ..plain };
        add(format!("coated {metallic} {roughness}"), coated.into());
        let cloth = Principled { sheen: white, sheen_roughness: 0.6, ..plain };
        add(format!("cloth {metallic} {roughness}"), cloth.into());
        let glass = Principled { transmission: 0.7, ..plain };
        add(format!("glassy {metallic} {roughness}"), glass.into());
    }
    add("metal 0.3".into(), white_metal(0.3).into());
    add("sheen".into(), Lobe::sheen(white, 0.5).into());
    for (roughness, alpha) in [(0.3, 0.2), (0.8, 0.8)] {
        let cloth = Lobes::from(Lobe::sheen(white, roughness)).over(white_metal(alpha));
        add(format!("cloth metal {roughness} {alpha}"), cloth);
    }
    add("coated metal".into(), Lobes::from(Lobe::coat(0.2)).over(white_metal(0.6)));
    let rare = rare_models();
    models.extend(rare.into_iter().map(|(name, lobes)| (name.to_owned(), lobes)));
    models
}

fn white_metal(alpha: f32) -> Lobe {
    Lobe::metal(alpha, Vec3::splat(0.1), Vec3::splat(20.0))
}

/// Rare ones, white where a colour is free.
fn rare_models() -> Vec<(&'static str, Lobes)> {
    let (white, slant) = (Vec3::ONE, Vec3::new(0.8, 0.6, 0.3).normalize());
    let film = Film { share: 1.0, ior: 1.33, thickness: 350.0 };
    let plain = Principled::new(white, 0.0, 0.5, 1.5);
    let scaled = |alpha| Lobe::microfacets(alpha, white, white).between_facets(BetweenFacets::Scaled);
    let rough_glass = |alpha, eta| Lobe::rough_glass(alpha, eta, white, white, false);
    let schlick = |alpha, eta, reflectances, power| {
        let part = |through| Lobe::schlick_glass(alpha, eta, reflectances, power, through);
        Lobes::from(part(false).brushed(slant, 0.2)).plus(part(true).brushed(slant, 0.2))
    };
    let fibre = |term, alpha| {
        Lobe::rough_fibre(term, Vec3::Y, Vec3::ZERO, [alpha, 1.55, 0.05, 0.7], Vec2::new(0.8, 0.6), 0.3)
    };
    vec![
        ("brushed conductor", Lobe::microfacets(0.6, white, white).brushed(slant, 0.1).into()),
        ("brushed across", Lobe::microfacets(0.2, white, white).brushed(slant, 0.7).into()),
        ("brushed plastic", Principled { tangent: slant, across: 0.6, ..plain }.into()),
        ("brushed glass in", rough_glass(0.6, 0.66).brushed(slant, 0.2).into()),
        ("brushed glass out", rough_glass(0.15, 1.5).brushed(slant, 0.5).into()),
        ("brushed pane", Lobe::rough_glass(0.5, 0.66, white, white, true).brushed(slant, 0.2).into()),
        ("risen facets", Lobe::microfacets(0.4, white, white).risen(2.0).into()),
        ("filmed conductor", Lobe::microfacets(0.4, white, white).filmed(film).into()),
        ("filmed plastic", Principled { film, ..plain }.into()),
        ("filmed glass in", rough_glass(0.3, 0.66).filmed(film).into()),
        ("filmed glass out", rough_glass(0.3, 1.5).filmed(film).into()),
        ("filmed pane", Lobe::rough_glass(0.3, 0.66, white, white, true).filmed(film).into()),
        ("dispersed glass in", rough_glass(0.2, 0.6).dispersed(0.2).into()),
        ("dispersed glass out", rough_glass(0.4, 1.6).brushed(slant, 0.2).filmed(film).dispersed(0.2).into()),
        ("scaled conductor", scaled(0.8).into()),
        (
            "scaled brushed metal",
            white_metal(0.4).brushed(slant, 0.9).between_facets(BetweenFacets::Scaled).into(),
        ),
        (
            "scaled facets as seen",
            Lobe::microfacets(0.6, white, white).between_facets(BetweenFacets::Seen).into(),
        ),
        (
            "dark brushed metal scaled as seen",
            white_metal(0.7).brushed(slant, 0.2).filmed(film).between_facets(BetweenFacets::Seen).into(),
        ),
        ("scaled facets and body", Lobes::from(scaled(1.0)).mixed(Lobe::lambert(white), 0.5)),
        ("cloth scaled", Lobes::from(Lobe::sheen(white, 0.3)).over(scaled(0.6))),
        ("dark facets", Lobe::microfacets(0.7, white, white).between_facets(BetweenFacets::Lost).into()),
        ("dark phong", Lobe::phong(60.0).into()),
        ("dark ward", Lobe::ward(0.5).brushed(slant, 0.2).into()),
        ("dim beckmann", Lobe::beckmann(0.3, 0.0, white, white).into()),
        ("dim brushed beckmann in", Lobe::beckmann(0.5, 0.66, white, white).brushed(slant, 0.2).into()),
        ("dark fibres", Lobe::fibres(white, 0.4).into()),
        ("schlick in", schlick(0.3, 0.66, [Vec3::splat(0.04), white], 5.0)),
        ("schlick out", schlick(0.3, 1.5, [Vec3::new(0.1, 0.02, 0.0), white], 3.0)),
        ("schlick of much out", schlick(0.5, 5.0, [Vec3::splat(0.45), Vec3::new(1.0, 0.5, 0.8)], 5.0)),
        ("dark fibre that reflects", fibre(0, 0.3).into()),
        ("dark fibre that is clear", fibre(1, 0.4).into()),
        ("dark fibre that shines from within", fibre(2, 0.6).into()),
        ("translucent", Lobe::translucent(white).into()),
        ("translucent plastic", Principled { translucence: 0.6, ..plain }.into()),
        (
            "coated brushed metal",
            Principled {
                metallic: 1.0,
                tangent: slant,
                across: 0.6,
                film: Film { share: 0.5, ..film },
                coat: 1.0,
                coat_alpha: 0.1,
                ..plain
            }
            .into(),
        ),
    ]
}

pub(super) fn views() -> impl Iterator<Item = Vec3> {
    [0.05_f32, 0.6, 1.1, 1.45].into_iter().map(|angle| Vec3::new(angle.sin(), 0.0, angle.cos()))
}

pub(super) fn around_z(lobes: impl Into<Lobes>) -> Bsdf {
    Bsdf::new(Vec3::Z, lobes)
}

/// The same surface met from the other side, in the same frame.
pub(super) fn turned_over(lobes: &Lobes) -> Lobes {
    let mut over = lobes.clone();
    let scales = |lobe: &&mut Lobe| matches!(lobe.kind, Kind::Glass | Kind::SchlickGlass);
    over.as_mut_slice().iter_mut().filter(|lobe| lobe.kind == Kind::Beckmann && lobe.eta > 0.0).for_each(
        |lobe| {
            lobe.eta = 1.0 / lobe.eta;
        },
    );
    over.as_mut_slice().iter_mut().filter(scales).for_each(|lobe| {
        let other = Lobe::rough_glass(lobe.alpha, 1.0 / lobe.eta, lobe.a, lobe.b, false);
        let other = if lobe.across > 0.0 { other.brushed(lobe.tangent, lobe.across) } else { other };
        (lobe.eta, lobe.c) = (other.eta, other.c);
    });
    // The frame is flipped, too.
    over.as_mut_slice().iter_mut().for_each(|lobe| lobe.tangent.z = -lobe.tangent.z);
    over
}

pub(super) fn randoms(n: u32) -> impl Iterator<Item = [f32; 3]> {
    (0..n).map(|sample| {
        let pair = |purpose| sample_pair(1, SampleKey { pixel: 5, sample, branch: 0 }, 0, purpose);
        let ([a, _], [b, c]) = (pair(0), pair(1));
        [a, b, c]
    })
}

const RINGS: usize = 160;
const SECTORS: usize = 128;

/// Midpoint rule over the whole sphere: narrow rings near the poles, narrow sectors opposite to the views, where lobes are.
fn integrate(mut f: impl FnMut(Vec3) -> [f64; 2]) -> [f64; 2] {
    let mut sums = [0.0; 2];
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
            let found = f(glam::DVec3::new(r * c, r * s, z).as_vec3());
            sums.iter_mut().zip(found).for_each(|(sum, x)| *sum += x * (b - a) * (to - from));
        }
    }
    sums
}

#[test]
fn samples_follow_the_density() {
    samples_of(models().into_iter().step_by(2));
}

/// In two tests, which run side by side: they take longer than others.
#[test]
fn samples_of_more_models_follow_the_density() {
    samples_of(models().into_iter().skip(1).step_by(2));
}

fn samples_of(models: impl Iterator<Item = (String, Lobes)>) {
    const CELLS: [usize; 2] = [16, 16];
    const N: u32 = 1 << 15;
    for (name, model) in models {
        let bsdf = around_z(model);
        // Rare lobes are slow, and wide enough for half of the points.
        let is_rare = bsdf.lobes().as_slice().iter().any(|lobe| lobe.rare() != 0);
        let grid = if is_rare { [24, 16] } else { [24, 24] };
        for wo in views().skip(usize::from(is_rare)).step_by(1 + usize::from(is_rare)) {
            let cell = |w: Vec3| {
                let ring = ((w.z * 0.5 + 0.5) * CELLS[0] as f32).min(CELLS[0] as f32 - 1.0) as usize;
                let azimuth = f64::from(w.y.atan2(w.x)) / TAU + 0.5;
                ring * CELLS[1] + ((azimuth * CELLS[1] as f64) as usize).min(CELLS[1] - 1)
            };
            let mut expected = vec![0.0; CELLS[0] * CELLS[1]];
            let mut counts = expected.clone();
            let prepared = bsdf.prepared(wo);
            fine(grid, |w, area| expected[cell(w)] += f64::from(prepared.eval_pdf(w.into()).1) * area);
            for u in randoms(N) {
                let Some(sample) = bsdf.sample(wo, u) else { continue };
                assert!((sample.wi.length() - 1.0).abs() < 1e-5, "{name}: unit directions");
                counts[cell(sample.wi)] += 1.0;
                let (value, pdf) = bsdf.eval_pdf(wo, sample.wi);
                assert!((sample.pdf - pdf).abs() <= 2e-3 * pdf, "{name}: {} is {pdf}", sample.pdf);
                let off = (sample.weight * sample.pdf - value).abs().max_element();
                assert!(
                    off <= 2e-3 * value.max_element() + 1e-7,
                    "{name}: weight times density is the value"
                );
                assert_eq!(sample.transmitted, sample.wi.z < 0.0, "{name}: which side");
            }
            let (mut chi_square, mut cells) = (0.0, 0);
            let (mut rest_expected, mut rest_counts) = (0.0, 0.0);
            for (w, c) in expected.iter().map(|w| w * f64::from(N)).zip(&counts) {
                if w < 8.0 {
                    rest_expected += w;
                    rest_counts += c;
                } else {
                    chi_square += (c - w).powi(2) / w;
                    cells += 1;
                }
            }
            assert!(
                (rest_expected - rest_counts).abs() < 6.0 * rest_expected.sqrt() + 8.0,
                "{name}: rare cells"
            );
            // Stratified samples stay far below the random bound; the quadrature's error needs the rest.
            let bound = f64::from(cells) + 4.0 * f64::from(2 * cells).sqrt();
            assert!(chi_square < bound, "{name} seen from {wo}: chi-square {chi_square} in {cells} cells");
        }
    }
}

/// Calls `f(direction, solid angle)` over the sphere: within each of 16 by 16 cells, rings that are narrow at the poles and
/// sectors that are narrow opposite to the views, where lobes are.
fn fine([rings, sectors]: [i32; 2], mut f: impl FnMut(Vec3, f64)) {
    let to_edge = |t: f64, at_start: bool, at_end: bool| match (at_start, at_end) {
        (true, _) => t * t,
        (_, true) => 1.0 - (1.0 - t) * (1.0 - t),
        _ => t,
    };
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
            let prepared = bsdf.prepared(wo);
            let [value, density] = integrate(|wi| {
                let (value, pdf) = prepared.eval_pdf(wi.into());
                [f64::from(value.x), f64::from(pdf)]
            });
            assert!(density < 1.01 && density > 0.3, "{name} from {wo}: density {density}");
            let reported = f64::from(bsdf.albedo(wo).x);
            // Coat and sheen take a little more of gloss below them than they send back, where two directions differ.
            let lost: f64 = match name.split(' ').next() {
                Some("coated") => 0.03,
                Some("cloth") => 0.14,
                // A film's share is that of the mean microfacet, not the mean of all microfacets' shares.
                Some("filmed") => 0.03,
                // Models that lose light.
                Some("dim") => 0.35,
                // The same, nearly all of it at grazing views.
                Some("dark") => 1.0,
                // All of it, seen head on.
                Some("sheen") => 1.0,
                _ => 0.015,
            };
            assert!(
                (value - reported).abs() < lost.min(0.14) + 0.015,
                "{name} from {wo}: albedo {value}, said {reported}"
            );
            // Tables are of Fresnel's equations.
            let most = if name.starts_with("schlick") { 1.02 } else { 1.01 };
            assert!(value < most, "{name} from {wo}: makes energy: {value}");
            assert!(value > 1.0 - lost, "{name} from {wo}: white surfaces keep light: {value}");
        }
    }
}

/// A layer over white microfacets: they lose the larger loss of both directions, and no light is created.
#[test]
fn facets_lose_the_larger_share_below_layers() {
    let white = Vec3::ONE;
    let sheens = [0.1, 0.4, 1.0].map(|roughness| Lobe::sheen(white, roughness));
    let tops = sheens.into_iter().chain([0.15, 0.6].map(Lobe::coat));
    let bases = [0.15, 0.5, 1.0].map(|alpha| Lobe::microfacets(alpha, white, white));
    let mut least = 1.0_f64;
    for (top, base) in tops.flat_map(|top| bases.map(|base| (top, base))) {
        let [above, below] = [top, base].map(around_z);
        let both = around_z(Lobes::from(top).over(base));
        for wo in views() {
            let [both, below, scalar] = [&both, &below, &above].map(|bsdf| bsdf.prepared(wo));
            let back = above.albedo(wo).x;
            let (mut found, mut expected) = (0.0, 0.0);
            fine([12, 12], |wi, area| {
                let value = |prepared: &Prepared<f32>| prepared.eval_pdf(wi.into()).0.x;
                let value_below = value(&below);
                found += f64::from(value(&both)) * area;
                let lost = if value_below > 0.0 { back.max(above.albedo(wi).x) } else { 0.0 };
                expected += f64::from(value(&scalar) + value_below * (1.0 - lost)) * area;
            });
            let of = format!("{:?} {} over facets {} from {wo}", top.kind, top.alpha, base.alpha);
            assert!((found - expected).abs() < 0.01, "{of}: {found}, not {expected}");
            assert!(found < 1.01, "{of} makes energy: {found}");
            least = least.min(found);
        }
    }
    assert!(least > 0.8, "no more than that is lost: {least} comes back");
}

/// Nearly upright fibres reflect all light at grazing views and next to none at others: the body gets the
/// rest.
#[test]
fn smooth_cloth_keeps_light() {
    for sheen_roughness in [0.0, 0.15, 0.25, 0.5] {
        let matte = Principled { f0: Vec3::ZERO, f90: 0.0, ..Principled::new(Vec3::ONE, 0.0, 1.0, 1.5) };
        let bsdf = around_z(Principled { sheen: Vec3::ONE, sheen_roughness, ..matte });
        for cos in [0.02_f32, 0.06, 0.1, 0.2, 0.5, 0.9] {
            let wo = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
            let (prepared, mut value) = (bsdf.prepared(wo), 0.0);
            fine([48, 32], |wi, area| value += f64::from(prepared.eval_pdf(wi.into()).0.x) * area);
            assert!((value - 1.0).abs() < 0.008, "{sheen_roughness} from {cos}: {value} of 1 comes back");
        }
    }
}

#[test]
fn reflectances_rise_by_their_power() {
    let of = |power: f32| {
        around_z(Lobe::microfacets(0.05, Vec3::new(0.1, 0.5, 1.0), Vec3::new(1.0, 0.2, 1.0)).risen(power))
    };
    for (power, angle) in [(1.0_f32, 0.3_f32), (2.0, 1.2), (5.0, 1.0), (9.0, 1.4)] {
        let wo = Vec3::new(angle.sin(), 0.0, angle.cos());
        let found = of(power).eval(wo, wo * Vec3::new(-1.0, 1.0, 1.0));
        let rise = (1.0 - angle.cos()).powf(power);
        for (channel, [f0, f90]) in [[0.1, 1.0], [0.5, 0.2]].into_iter().enumerate() {
            let (found, expected) = (found[channel] / found.z, f0 + (f90 - f0) * rise);
            assert!((found - expected).abs() < 0.01, "power {power} at {angle}: {found}, not {expected}");
        }
    }
    assert_eq!(
        Lobe::microfacets(0.3, Vec3::ZERO, Vec3::ONE).risen(5.0),
        Lobe::microfacets(0.3, Vec3::ZERO, Vec3::ONE)
    );
}

#[test]
fn light_may_go_both_ways() {
    // Models of fibres and of scaled microfacets have their own numbers for each view.
    let one_way = |name: &str| name.starts_with("dark fibre") || name.contains("scaled");
    for (name, model) in models().into_iter().filter(|(name, _)| !one_way(name)) {
        let bsdf = around_z(model.clone());
        let behind = around_z(turned_over(&model));
        let etas = bsdf.etas();
        for (wo, u) in views().flat_map(|wo| randoms(64).map(move |u| (wo, u))) {
            let Some(BsdfSample { wi, .. }) = bsdf.sample(wo, u).filter(|s| s.wi.z.abs() > 0.01) else {
                continue;
            };
            let there = bsdf.eval(wo, wi) / wi.z.abs();
            let over = Vec3::new(1.0, 1.0, -1.0);
            let back = if wi.z > 0.0 {
                bsdf.eval(wi, wo) / wo.z
            } else {
                behind.eval(wi * over, wo * over) / (etas * etas * wo.z)
            };
            let off = (there - back).abs().max_element();
            assert!(off <= 4e-3 * there.max_element() + 1e-5, "{name} {wo} {wi}: {there} and {back}");
        }
    }
}

/// Reflection on top takes its light from the layers below.
#[test]
fn what_is_mirrored_above_does_not_reach_below() {
    let body = Lobe::lambert(Vec3::ONE);
    for top in [
        Lobe::glass(1.0 / 1.5, Vec3::ONE, Vec3::ZERO, false),
        Lobe::rough_glass(0.3, 1.0 / 1.5, Vec3::ONE, Vec3::ZERO, false),
        Lobe::beckmann(0.3, 1.0 / 1.5, Vec3::ONE, Vec3::ZERO),
        Lobe::schlick_glass(0.3, 1.0 / 1.5, [Vec3::splat(0.04), Vec3::ONE], 5.0, false),
        Lobe::phong(20.0),
        Lobe::ward(0.2),
        Lobe::fibres(Vec3::ONE, 0.4),
    ] {
        let bsdf = around_z(Lobes::from(top).over(body));
        for wo in views() {
            let n = 2048;
            let back: f32 =
                randoms(n).filter_map(|u| bsdf.sample(wo, u)).map(|s| s.weight.x / n as f32).sum();
            assert!(back > 0.8 && back < 1.04, "{:?} from {wo}: {back} of 1 comes back", top.kind);
        }
    }
}

/// A white body below microfacets that mirror by Fresnel's equations returns what they leave, to each view.
#[test]
fn white_bodies_keep_all_light_below_glass() {
    for (alpha, eta, share) in [
        (0.1, 1.0 / 1.5, 1.0),
        (0.25, 1.0 / 1.5, 0.7),
        (1.0, 1.0 / 1.5, 0.6),
        (0.5, 0.5, 1.0),
        (1.0, 1.4, 1.0),
    ] {
        let top = Lobes::from(Lobe::rough_glass(alpha, eta, Vec3::ONE, Vec3::ZERO, false));
        let bsdf = around_z(top.times(Vec3::splat(share)).over(Lobe::lambert(Vec3::ONE)));
        for wo in views() {
            let prepared = bsdf.prepared(wo);
            let mut back = 0.0;
            fine([12, 12], |wi, area| back += f64::from(prepared.eval_pdf(wi.into()).0.x) * area);
            assert!((back - 1.0).abs() < 0.01, "{share} of {alpha}, {eta} from {wo}: {back} of 1 comes back");
        }
    }
}

/// Transmission on top takes light from below, too: no light is created.
#[test]
fn what_goes_through_above_does_not_reach_below() {
    let body = Lobe::lambert(Vec3::ONE);
    let tint = Vec3::new(1.0, 0.5, 0.25);
    let schlick = |through| Lobe::schlick_glass(0.3, 1.0 / 1.5, [Vec3::splat(0.04), Vec3::ONE], 5.0, through);
    for (top, least) in [
        (Lobes::from(Lobe::glass(1.0 / 1.5, Vec3::ONE, tint, false)), 0.99),
        (Lobes::from(Lobe::rough_glass(0.3, 1.0 / 1.5, Vec3::ONE, tint, true)), 0.9),
        (Lobes::from(Lobe::beckmann(0.2, 1.0 / 1.5, Vec3::ONE, tint)), 0.5),
        (Lobes::from(schlick(false)).plus(schlick(true)), 0.9),
        (Lobes::from(Lobe::translucent(tint)), 0.99),
        (Lobes::from(Lobe::translucent(tint)).times(Vec3::splat(0.5)), 0.99),
    ] {
        let bsdf = around_z(top.clone().over(body));
        for wo in views() {
            let n = 2048;
            let back: f32 =
                randoms(n).filter_map(|u| bsdf.sample(wo, u)).map(|s| s.weight.x / n as f32).sum();
            assert!(back > least && back < 1.03, "{top:?} from {wo}: {back} of 1 goes on");
        }
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

#[test]
fn silhouettes_are_not_black() {
    // From below the shading normal, though from above the face.
    let wo = Vec3::new(0.9, 0.0, -0.02).normalize();
    for (name, model) in models() {
        let bsdf = around_z(model);
        let light: Vec3 = randoms(256).filter_map(|u| bsdf.sample(wo, u)).map(|s| s.weight / 256.0).sum();
        let least = match name.split(' ').next() {
            Some("dim") => 0.5,
            Some("dark") => 0.0,
            _ => 0.9,
        };
        assert!(light.x > least && light.x < 1.04, "{name}: {light}");
    }
}

/// Value, density, and the sample, as bits.
type Found = (Vec3, f32, Option<BsdfSample>, Vec3);

#[inline(always)]
fn in_lanes<S: Simd>(
    simd: S,
    closures: &ClosureBatch,
    wo: Vec3,
    wi: Vec3,
    u: &[[f32; 3]; LANES],
) -> [Found; LANES] {
    let light = Vec3x16::splat(simd, Vec3::ONE);
    let mut prepared = Prepared::none(light.x);
    closures.prepare(simd, 0, (Vec3x16::splat(simd, wo), light), &mut prepared);
    let (value, pdf) = prepared.eval_pdf(Vec3x16::splat(simd, wi));
    let s = prepared.sample([0, 1, 2].map(|k| f32x16::from_fn(simd, |i| u[i][k])));
    let (found, delta, through) = (s.found.to_bitmask(), s.delta.to_bitmask(), s.transmitted.to_bitmask());
    let wide = s.wide.to_bitmask();
    std::array::from_fn(|i| {
        let has = |bits: u64| bits >> i & 1 != 0;
        let sample = BsdfSample {
            wi: s.wi.get(i),
            weight: s.weight.get(i),
            pdf: s.pdf[i],
            delta: has(delta),
            transmitted: has(through),
            wide: has(wide),
        };
        (value.get(i), pdf[i], has(found).then_some(sample), prepared.albedo().get(i))
    })
}

#[test]
fn sixteen_points_have_the_bits_of_one_at_every_level() {
    let mut models = models();
    let tint = Vec3::new(0.9, 0.4, 0.2);
    let smooth =
        Lobes::from(Lobe::glass(0.7, tint, Vec3::ONE, false)).mixed(Lobe::oren_nayar(tint, 0.4), 0.3);
    let turned = Lobe { normal: Vec3::new(0.6, 0.0, 0.8), ..Lobe::microfacets(0.2, tint, Vec3::ONE) };
    for (name, lobes) in [
        ("nothing", Lobes::default()),
        ("metal", Lobe::metal(0.3, tint * 2.0, tint * 5.0).into()),
        ("mirror under cloth", Lobes::from(Lobe::sheen(tint, 0.3)).over(Lobe::mirror(tint))),
        ("smooth metal", Lobe::metal(0.0, tint * 2.0, tint * 5.0).into()),
        ("smooth plastic", Principled::new(tint, 0.3, 0.0, 1.5).into()),
        (
            "smooth filmed facets under cloth",
            Lobes::from(Lobe::sheen(tint, 0.3)).over(
                Lobe::microfacets(0.0, tint, Vec3::ONE).risen(3.0).filmed(Film {
                    share: 0.7,
                    ior: 1.4,
                    thickness: 400.0,
                }),
            ),
        ),
        ("glass and dust", smooth),
        ("pane", Lobe::glass(0.7, tint, tint, true).into()),
        (
            "filmed metal",
            Lobe::metal(0.3, tint * 2.0, tint * 5.0)
                .filmed(Film { share: 0.7, ior: 1.4, thickness: 400.0 })
                .into(),
        ),
        ("diamond", Lobe::glass(1.0 / 2.4, tint, Vec3::ONE, false).dispersed(0.1).into()),
        (
            "soap",
            Lobe::glass(0.75, tint, tint, true)
                .filmed(Film { share: 1.0, ior: 1.33, thickness: 300.0 })
                .into(),
        ),
        ("two normals", Lobes::from(turned).plus(Lobe::lambert(tint))),
    ] {
        models.push((name.into(), lobes));
    }
    let mut samples = 0;
    for round in 0..400_u32 {
        let draw = |n| sample_pair(3, SampleKey { pixel: round, sample: 0, branch: 0 }, 0, n);
        let (normal, wo, wi) = (uniform_sphere(draw(0)), uniform_sphere(draw(1)), uniform_sphere(draw(2)));
        let mut closures = ClosureBatch::default();
        closures.reset(LANES);
        // Of one kind, as most are, or of any.
        let first = if round % 2 == 0 { round as usize } else { (draw(3)[0] * 1000.0) as usize };
        let model = |i: usize| &models[(first + if round % 2 == 0 { 0 } else { 5 * i }) % models.len()];
        (0..LANES).for_each(|i| closures.set(i, normal, model(i).1.as_slice()));
        let u = std::array::from_fn(|i| {
            let pair = |n| sample_pair(4, SampleKey { pixel: round, sample: i as u32, branch: 0 }, 0, n);
            [pair(0)[0], pair(1)[0], pair(1)[1]]
        });
        for level in Level::available() {
            let found = dispatch_wide!(level, simd => in_lanes(simd, &closures, wo, wi, &u), else continue);
            for (i, (value, pdf, sample, albedo)) in found.into_iter().enumerate() {
                let (name, bsdf) = (&model(i).0, closures.point(i).bsdf);
                assert_eq!(bsdf.eval_pdf(wo, wi), (value, pdf), "{name} at {level}");
                assert_eq!(bsdf.sample(wo, u[i]), sample, "{name} at {level}");
                assert_eq!(bsdf.albedo(wo), albedo, "{name} at {level}");
                samples += u32::from(sample.is_some());
            }
        }
    }
    assert!(samples > 4000 || Level::available().len() < 3, "the test has something to test: {samples}");
}

/// Directions in lanes, as cached lobes are evaluated.
#[inline(always)]
fn of_kept<S: Simd>(
    simd: S,
    (retained, prepared): (&CachedLobes, &Prepared<f32>),
    wi: &[Vec3; LANES],
) -> [[(Vec3, f32); LANES]; 2] {
    let row = |k: usize| f32x16::from_fn(simd, |i| wi[i][k]);
    let wi = Vec3x16::new(row(0), row(1), row(2));
    [retained.eval_pdf(0, wi), prepared.eval_pdf_all(wi)]
        .map(|(value, pdf)| std::array::from_fn(|i| (value.get(i), pdf[i])))
}

#[test]
fn kept_copies_have_the_bits_of_what_is_seen() {
    let mut models = models();
    let tilted = |lobe: Lobe| Lobe { normal: Vec3::new(0.6, 0.0, 0.8), ..lobe };
    let (phong, body) = (tilted(Lobe::phong(20.0)), Lobe::lambert(Vec3::ONE));
    models.push(("tilted over another".into(), Lobes::from(phong).over(body)));
    models.push(("film over fibres".into(), Lobes::from(Lobe::coat(0.2)).over(Lobe::fibres(Vec3::ONE, 0.6))));
    let draw = |round: u32, n| sample_pair(6, SampleKey { pixel: round, sample: 0, branch: 0 }, 0, n);
    let mut lit = 0;
    for round in 0..400_u32 {
        let (normal, wo) = (uniform_sphere(draw(round, 0)), uniform_sphere(draw(round, 1)));
        // Of one kind, as most neighbours are, or of any.
        let step = if round % 2 == 0 { 0 } else { 5 };
        let name = |i: usize| &models[(round as usize + step * i) % models.len()].0;
        let points: [Bsdf; LANES] = std::array::from_fn(|i| {
            Bsdf::new(normal, models[(round as usize + step * i) % models.len()].1.clone())
        });
        let retained = CachedLobes::new(points.iter().map(|bsdf| (bsdf, wo)));
        let prepared = points.each_ref().map(|bsdf| bsdf.prepared(wo));
        // Some of them where narrow lobes are.
        let wi = std::array::from_fn(|i| {
            let u = draw(round, 2 + i as u32);
            let chosen = points[i].sample(wo, [u[0], u[1], (u[0] * 37.0).fract()]);
            chosen.filter(|_| i % 2 == 0).map_or_else(|| uniform_sphere(u), |sample| sample.wi)
        });
        let expected: [(Vec3, f32); LANES] = std::array::from_fn(|i| points[i].eval_pdf(wo, wi[i]));
        for (i, expected) in expected.iter().enumerate() {
            let (value, pdf) = retained.eval_pdf(i, Vector::from(wi[i]));
            assert_eq!((Vec3::from(value), pdf), *expected, "{} alone among sixteen", name(i));
            let (value, pdf) = prepared[i].eval_pdf_all(Vector::from(wi[i]));
            assert_eq!((Vec3::from(value), pdf), *expected, "{} alone", name(i));
            lit += u32::from(expected.0 != Vec3::ZERO);
        }
        for level in Level::available() {
            let [by_kept, _] =
                dispatch_wide!(level, simd => of_kept(simd, (&retained, &prepared[0]), &wi), else continue);
            assert_eq!(by_kept, expected, "{} and others at {level}", name(0));
            let [_, of_one] =
                dispatch_wide!(level, simd => of_kept(simd, (&retained, &prepared[0]), &wi), else continue);
            let expected: [(Vec3, f32); LANES] = std::array::from_fn(|i| points[0].eval_pdf(wo, wi[i]));
            assert_eq!(of_one, expected, "{} for many directions at {level}", name(0));
        }
    }
    assert!(lit > 2000, "the test has something to test: {lit}");
}

#[test]
fn layers_are_as_they_are_put_together() {
    let tint = Vec3::new(0.8, 0.5, 0.3);
    let plain = Principled::new(tint, 0.3, 0.5, 1.5);
    // Coloured sheen takes as much of all colours here, as glTF has it, and by colours there.
    let sheen = Vec3::splat(0.7);
    let p =
        Principled { coat: 0.6, coat_alpha: 0.1, sheen, sheen_roughness: 0.4, transmission: 0.25, ..plain };
    let plastic = Lobes::from(Lobe::microfacets(p.alpha, p.f0, Vec3::splat(p.f90))).over(Lobe::lambert(tint));
    let glass = Lobes::from(Lobe::rough_glass(p.alpha, p.eta, Vec3::ONE, tint, p.thin));
    let metal = Lobes::from(Lobe::microfacets(p.alpha, tint, Vec3::ONE));
    let by = |lobes: Lobes, share: f32| lobes.times(Vec3::splat(share));
    let rest = 1.0 - p.metallic;
    let body = by(plastic, rest * (1.0 - p.transmission)).plus(by(metal, p.metallic));
    let body = body.plus(by(glass, rest * p.transmission));
    let cloth = Lobes::from(Lobe::sheen(sheen, p.sheen_roughness)).over(body);
    let coated = by(Lobe::coat(p.coat_alpha).into(), p.coat).over(cloth);
    assert_eq!(Lobes::from(p), coated, "the same lobes, one below the other");
}

/// Also into memory that has held other lobes, and for blocks that are not full.
#[test]
fn lambertians_at_once_are_those_one_by_one() {
    let draw =
        |n: u32, i: u32| uniform_sphere(sample_pair(9, SampleKey { pixel: i, ..Default::default() }, 0, n));
    let count = 21;
    let all = |n: u32| {
        let mut vectors = Vec3s::default();
        (0..count).for_each(|i| vectors.push(draw(n, i)));
        vectors
    };
    let flat = SurfaceBatch {
        t: vec![1.0; count as usize],
        ng: all(0),
        ns: all(1),
        ray_dir: all(2),
        ..SurfaceBatch::default()
    };
    let bumpy = SurfaceBatch { bent: all(3), ..flat.clone() };
    let albedo = |i: usize| Vec3::splat(0.03 * i as f32);
    let mut at_once = ClosureBatch::default();
    at_once.reset(32);
    let brushed = Lobe::microfacets(0.6, Vec3::ONE, Vec3::ONE).brushed(Vec3::X, 0.1);
    (0..32).for_each(|i| at_once.set(i, Vec3::Z, Lobes::from(Lobe::coat(0.2)).over(brushed).as_slice()));
    for hits in [flat, bumpy] {
        at_once.reset(hits.len());
        at_once.set_lambertian(&hits, albedo);
        let mut one_by_one = ClosureBatch::default();
        one_by_one.reset(hits.len());
        for i in 0..hits.len() {
            one_by_one.set(i, hits.facing_ns(i), &[Lobe::lambert(albedo(i))]);
        }
        for i in 0..hits.len() {
            let [found, expected] = [&at_once, &one_by_one].map(|batch| batch.point(i).bsdf);
            assert_eq!(found.normal(), expected.normal(), "point {i}");
            assert_eq!(found.lobes(), expected.lobes(), "point {i}");
        }
        assert_eq!([0, 16].map(|i| at_once.kinds(i)), [Kind::Diffuse.bit(); 2], "nothing else is left");
    }
}

#[test]
fn lobes_are_equal_whatever_was_in_their_place() {
    let lobe = Lobe::lambert(Vec3::ONE);
    let mut used = Lobes::from(lobe).over(Lobe::lambert(Vec3::splat(0.5)));
    used.clear();
    used.push(lobe);
    assert_eq!(used, Lobes::from(lobe), "two lay there before");
    assert_ne!(used, Lobes::default(), "one is not none");
}

#[test]
fn lists_of_any_length_keep_their_lobes() {
    let lobe = |k: usize| Lobe { alpha: k as f32, ..Lobe::lambert(Vec3::ONE) };
    let mut used = Lobes::default();
    for _ in 0..2 {
        used.clear();
        for k in 0..MOST + 2 {
            used.push(lobe(k));
            let expected: Vec<Lobe> = (0..MOST.min(k + 1)).map(lobe).collect();
            assert_eq!(used.as_slice(), expected, "{} lobes", k + 1);
            let (copy, halved) = (used.clone(), used.clone().times(Vec3::splat(0.5)));
            assert_eq!(copy.as_slice(), expected, "a copy of them");
            assert!(
                halved.as_slice().iter().all(|lobe| lobe.weight == Vec3::splat(0.5)),
                "half of each of {}",
                k + 1
            );
            assert_eq!(used.as_slice(), expected, "whoever halves a copy");
        }
    }
    assert_eq!(Lobes::from(lobe(0)).lambertian(), Some(Vec3::ONE), "around the point's normal");
    let turned = Lobe { normal: Vec3::X, ..lobe(0) };
    assert_eq!(Lobes::from(turned).lambertian(), None, "around another, which only it knows");
}

#[test]
fn lists_of_many_points_are_those_of_each() {
    let mut state = 1_u32;
    let mut dice = |sides: u32| {
        state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        (state >> 16) % sides
    };
    let slant = Vec3::new(0.8, 0.6, 0.3).normalize();
    for azimuth in 0..200 {
        let mut batch = ClosureBatch::default();
        batch.reset(LANES);
        let mut lists = Lists::of(&mut batch, 0);
        let mut expected: [Lobes; LANES] = Default::default();
        let lobe = |dice: &mut dyn FnMut(u32) -> u32| {
            let x = (1 + dice(9)) as f32 * 0.1;
            match dice(7) {
                0 => Lobe::lambert(Vec3::new(x, 0.5, 0.25)),
                1 => Lobe::microfacets(x, Vec3::splat(0.04), Vec3::ONE),
                2 => Lobe::microfacets(x, Vec3::splat(x), Vec3::ONE).brushed(slant, 0.05),
                3 => Lobe::metal(x, Vec3::splat(0.2), Vec3::splat(3.0)),
                4 => Lobe::rough_glass(x, 1.5, Vec3::ONE, Vec3::splat(x), false),
                5 => Lobe::sheen(Vec3::splat(x), 0.5),
                _ => Lobe::mirror(Vec3::splat(x)),
            }
        };
        for _ in 0..3 {
            let lanes = if dice(2) == 0 { 0xffff } else { dice(1 << 16) };
            let weight = [0, 1, 2].map(|k: usize| std::array::from_fn(|i| ((i + k) % 5) as f32 * 0.3));
            let top = lists.ends();
            let mut parts: [[Lobes; LANES]; 2] = Default::default();
            let mut base = top;
            for (part, count) in [dice(3), dice(3)].into_iter().enumerate() {
                for _ in 0..count {
                    let some = lanes & if dice(2) == 0 { 0xffff } else { dice(1 << 16) };
                    let all: [Lobe; LANES] = match dice(2) {
                        0 => [lobe(&mut dice); LANES],
                        _ => std::array::from_fn(|_| lobe(&mut dice)),
                    };
                    if all.iter().all(|one| *one == all[0]) {
                        lists.push(some, &all[0]);
                    } else {
                        (0..LANES).filter(|i| some >> i & 1 != 0).for_each(|i| lists.push_to(i, &all[i]));
                    }
                    for i in (0..LANES).filter(|i| some >> i & 1 != 0) {
                        parts[part][i].push(all[i]);
                    }
                }
                if part == 0 {
                    base = lists.ends();
                }
            }
            lists.layer(lanes, &top, &base);
            lists.times(lanes, &top, &weight);
            for i in (0..LANES).filter(|i| lanes >> i & 1 != 0) {
                let weight = Vec3::new(weight[0][i], weight[1][i], weight[2][i]);
                let [top, base] = [&parts[0][i], &parts[1][i]].map(Lobes::clone);
                expected[i] = expected[i].clone().plus(top.over(base).times(weight));
            }
        }
        for (i, expected) in expected.iter().enumerate() {
            assert_eq!(lists.lobes(i), *expected, "turn {azimuth}, point {i}");
        }
        (0..LANES).for_each(|i| lists.face(i, Vec3::Y, |n| n));
        for (i, expected) in expected.iter().enumerate() {
            let found = batch.point(i).bsdf;
            assert_eq!(found.normal(), Vec3::Y, "turn {azimuth}, point {i}");
            // Positions that other points need stay empty.
            let found = found.lobes().as_slice();
            let count = expected.as_slice().len();
            assert_eq!(found[..count], *expected.as_slice(), "turn {azimuth}, point {i}");
            assert!(found[count..].iter().all(|lobe| lobe.kind == Kind::None), "turn {azimuth}, point {i}");
        }
    }
}

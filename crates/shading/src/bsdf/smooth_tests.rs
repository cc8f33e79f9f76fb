// SPDX-License-Identifier: GPL-3.0-or-later
//! Lobes that reflect and refract in one direction each, beside their narrowest facets. Original.

use glam::Vec3;

use super::tests::{around_z, randoms, views};
use super::*;

#[test]
fn delta_lobes_keep_all_light() {
    let glass = |thin, eta| Lobe::glass(eta, Vec3::ONE, Vec3::ONE, thin);
    let facets = Lobe::microfacets(0.0, Vec3::ONE, Vec3::ONE);
    let lobes =
        [Lobe::mirror(Vec3::ONE), facets, glass(false, 1.0 / 1.5), glass(false, 1.5), glass(true, 0.7)];
    for (lobe, wo) in lobes.iter().flat_map(|lobe| views().map(move |wo| (lobe, wo))) {
        let bsdf = around_z(*lobe);
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
        let expected = bsdf.delta_branches(wo)[1].map_or(0.0, |s| f64::from(s.weight.x));
        assert!((through - expected).abs() < 0.01, "{lobe:?}: {through} goes through, not {expected}");
        assert!(!bsdf.is_smooth() && bsdf.eval(wo, wo) == Vec3::ZERO, "light samples bring nothing");
    }
}

/// Facets without roughness are mirrors that reflect and cover as their smallest ones do.
#[test]
fn smooth_facets_are_as_the_smallest() {
    let (tint, film) = (Vec3::new(0.9, 0.6, 0.2), Film { share: 0.8, thickness: 400.0, ior: 1.4 });
    let facets = |alpha| Lobe::microfacets(alpha, tint * 0.1, Vec3::ONE);
    let metal = |alpha| Lobe::metal(alpha, tint * 2.0, tint * 5.0);
    let plain = Principled::new(tint, 0.0, 0.0, 1.5);
    let models: [(&str, &dyn Fn(f32) -> Lobes); 8] = [
        ("facets", &|alpha| facets(alpha).into()),
        ("risen", &|alpha| facets(alpha).risen(2.0).into()),
        ("filmed", &|alpha| facets(alpha).filmed(film).into()),
        ("metal", &|alpha| metal(alpha).into()),
        ("filmed metal", &|alpha| metal(alpha).filmed(film).into()),
        ("scaled metal", &|alpha| metal(alpha).between_facets(BetweenFacets::Scaled).into()),
        ("plastic", &|alpha| Principled { alpha, ..plain }.into()),
        ("coat", &|alpha| Principled { alpha: 0.1, coat: 0.7, coat_alpha: alpha, ..plain }.into()),
    ];
    for (name, of) in models {
        let (smooth, rough) = (around_z(of(1e-3)), around_z(of(1.01e-3)));
        assert!(smooth.has_deltas() && !rough.has_deltas(), "{name}: deltas, and facets");
        for cos in [1.0_f32, 0.85, 0.5, 0.2] {
            let wo = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
            // That of rough metal by its index is a mean over directions.
            let differ = (smooth.albedo(wo) - rough.albedo(wo)).abs().max_element();
            assert!(differ < 0.01 || name.contains("metal"), "{name} {cos}: albedo off by {differ}");
            let mirrored = Vec3::new(-wo.x, 0.0, wo.z);
            let n = 8192;
            let by = |bsdf: &Bsdf| {
                let samples = randoms(n).filter_map(|u| bsdf.sample(wo, u));
                let near = samples.filter(|s| s.wi.distance(mirrored) < 0.02);
                near.map(|s| s.weight / n as f32).sum::<Vec3>()
            };
            let branch = smooth.delta_branches(wo)[0].map_or(Vec3::ZERO, |to| to.weight);
            let (found, expected) = (by(&smooth), by(&rough));
            assert!((found - expected).abs().max_element() < 0.03, "{name} {cos}: {found}, not {expected}");
            assert!((found - branch).abs().max_element() < 0.03, "{name} {cos}: {found}, not {branch}");
            let aside = Vec3::new(-0.3, 0.5, 0.812_4);
            let (value, other) = (smooth.eval(wo, aside), rough.eval(wo, aside));
            assert!((value - other).abs().max_element() < 0.01, "{name} {cos}: {value} aside, not {other}");
        }
    }
    let brushed = facets(0.0).brushed(Vec3::X, 0.3);
    assert_eq!(brushed.kind, Kind::Microfacets, "wide across it");
}

/// glTF's glass without roughness has the shares of its smallest microfacets.
#[test]
fn smooth_principled_glass_is_as_its_smallest_facets() {
    let base = Vec3::new(0.9, 0.7, 0.4);
    let film = Film { share: 0.8, thickness: 400.0, ior: 1.4 };
    for (thin, eta, film) in [
        (true, 1.0 / 1.5, Film::default()),
        (false, 1.0 / 1.5, Film::default()),
        (false, 1.5, Film::default()),
        (true, 1.0 / 1.5, film),
        (false, 1.0 / 1.5, film),
    ] {
        let glass = |alpha| Principled {
            transmission: 1.0,
            alpha,
            thin,
            eta,
            film,
            ..Principled::new(base, 0.0, 0.0, 1.5)
        };
        let (smooth, rough) = (around_z(glass(1e-3)), around_z(glass(1.01e-3)));
        assert!(!smooth.is_smooth() && rough.is_smooth(), "deltas, and facets");
        for cos in [1.0_f32, 0.85, 0.5] {
            let wo = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
            let expected = smooth.delta_branches(wo).map(|to| to.map_or(Vec3::ZERO, |to| to.weight));
            let n = 4096;
            let mut found = [Vec3::ZERO; 2];
            for u in randoms(n) {
                if let Some(sample) = rough.sample(wo, u) {
                    found[usize::from(sample.transmitted)] += sample.weight / n as f32;
                }
            }
            for (found, expected) in found.into_iter().zip(expected) {
                assert!(
                    (found - expected).abs().max_element() < 0.03,
                    "{thin} {eta} {cos}: {found}, not {expected}"
                );
            }
        }
    }
}

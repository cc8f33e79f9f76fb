// SPDX-License-Identifier: GPL-3.0-or-later
//! Microfacets whose light of further bounces is in their own lobe, or lost, against definitions. Original.

use glam::Vec3;

use super::tests::around_z;
use super::*;

fn view(angle: f32) -> Vec3 {
    Vec3::new(angle.sin(), 0.0, angle.cos())
}

/// The mean reflectance of microfacets under Schlick's reflectances, weighted by cosine.
fn schlick_mean(f0: Vec3, f90: Vec3) -> Vec3 {
    f0 + (f90 - f0) / 21.0
}

/// The values are those of one bounce, times 1 + F W / (1 - F (1 - W)) (1 - E) / E of the view. E is the albedo of white facets of one
/// bounce, W its mean. F is the mean reflectance.
#[test]
fn scaled_facets_are_those_of_one_bounce_times_a_factor() {
    let (f0, f90) = (Vec3::new(0.9, 0.5, 0.2), Vec3::ONE);
    for alpha in [0.2, 0.6, 1.0] {
        let of = |f0, f90, light| around_z(Lobe::microfacets(alpha, f0, f90).between_facets(light));
        let (once, scaled) = (of(f0, f90, BetweenFacets::Lost), of(f0, f90, BetweenFacets::Scaled));
        let white = of(Vec3::ONE, Vec3::ONE, BetweenFacets::Lost);
        // Midpoints of the squares of the sines.
        let n = 400;
        let angles = (0..n).map(|i| ((i as f32 + 0.5) / n as f32).sqrt().asin());
        let mean = angles.map(|angle| white.albedo(view(angle)).x / n as f32).sum::<f32>();
        for wo in [0.1, 0.9, 1.4].map(view) {
            let kept = white.albedo(wo).x;
            let per_bounce = schlick_mean(f0, f90).map(|f| f * mean / (1.0 - f * (1.0 - mean)));
            let factor = per_bounce * ((1.0 - kept) / kept) + Vec3::ONE;
            for wi in [view(0.3), view(-0.7), Vec3::new(0.2, 0.7, 0.3).normalize()] {
                let (found, expected) = (scaled.eval(wo, wi), once.eval(wo, wi) * factor);
                let off = (found - expected).abs().max_element();
                assert!(off <= 1e-3 * expected.max_element(), "{alpha} {wo} {wi}: {found}, not {expected}");
            }
        }
    }
}

/// The same with the reflectance of the facet that light met: 1 + F (1 - E) / E.
#[test]
fn facets_as_seen_are_those_of_one_bounce_times_a_factor() {
    let (f0, f90) = (Vec3::new(0.9, 0.5, 0.2), Vec3::new(0.3, 0.5, 1.0));
    for alpha in [0.2, 0.6, 1.0] {
        let of =
            |f0, f90, light| around_z(Lobe::microfacets(alpha, f0, f90).risen(3.0).between_facets(light));
        let (once, seen) = (of(f0, f90, BetweenFacets::Lost), of(f0, f90, BetweenFacets::Seen));
        let white = of(Vec3::ONE, Vec3::ONE, BetweenFacets::Lost);
        for wo in [0.1, 0.9, 1.4].map(view) {
            let kept = white.albedo(wo).x;
            for wi in [view(0.3), view(-0.7), Vec3::new(0.2, 0.7, 0.3).normalize()] {
                let rise = (1.0 - wo.dot((wo + wi).normalize())).powi(3);
                let factor = (f0 + (f90 - f0) * rise) * ((1.0 - kept) / kept) + Vec3::ONE;
                let (found, expected) = (seen.eval(wo, wi), once.eval(wo, wi) * factor);
                let off = (found - expected).abs().max_element();
                assert!(off <= 1e-3 * expected.max_element(), "{alpha} {wo} {wi}: {found}, not {expected}");
            }
        }
    }
}

/// In a white furnace, facets that lose light lose it, and scaled ones do not, as the sum over many directions has it.
#[test]
fn white_scaled_facets_keep_all_light() {
    let sum = |bsdf: &Bsdf, wo| {
        let n = 200;
        let mut sum = 0.0;
        for (ring, sector) in (0..n).flat_map(|ring| (0..n).map(move |sector| (ring, sector))) {
            let (z, turn) = ((ring as f32 + 0.5) / n as f32, (sector as f32 + 0.5) / n as f32);
            let (s, c) = (std::f32::consts::TAU * turn).sin_cos();
            let r = (1.0 - z * z).sqrt();
            sum += bsdf.eval(wo, Vec3::new(r * c, r * s, z)).x;
        }
        sum * std::f32::consts::TAU / (n * n) as f32
    };
    for alpha in [0.5, 0.8, 1.0] {
        let facets = Lobe::microfacets(alpha, Vec3::ONE, Vec3::ONE);
        let metal = Lobe::metal(alpha, Vec3::splat(1e-3), Vec3::splat(1e4));
        for (lobe, wo) in [facets, metal].into_iter().flat_map(|lobe| [0.2, 1.0].map(|a| (lobe, view(a)))) {
            let [scaled, seen, lost] = [BetweenFacets::Scaled, BetweenFacets::Seen, BetweenFacets::Lost]
                .map(|light| sum(&around_z(lobe.between_facets(light)), wo));
            assert!((scaled - 1.0).abs() < 0.01, "{alpha} {wo}: {scaled}");
            assert!((seen - 1.0).abs() < 0.01, "{alpha} {wo}: {seen}");
            assert!(lost < 0.97, "{alpha} {wo}: {lost} is too much");
        }
    }
}

/// Other lobes have no microfacets that reflect.
#[test]
fn other_lobes_stay() {
    let glass = Lobe::rough_glass(0.3, 0.7, Vec3::ONE, Vec3::ONE, false);
    assert_eq!(glass.between_facets(BetweenFacets::Scaled), glass);
    let facets = Lobe::microfacets(0.3, Vec3::ONE, Vec3::ONE);
    assert_eq!(facets.between_facets(BetweenFacets::Lost).between_facets(BetweenFacets::Spread), facets);
}

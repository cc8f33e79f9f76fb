// SPDX-License-Identifier: GPL-3.0-or-later
//! Properties of BSDFs with any parameters, between any two directions: values and densities are finite and
//! not negative, samples agree with `eval` and `pdf`, reflection is reciprocal, and no light is created. Mean
//! properties (chi-square, furnaces) are in `bsdf::tests`, for chosen parameters.

use glam::Vec3;
use gnurt_shading::bsdf::{Bsdf, BsdfSample, Film, Kind, Lobe, Lobes, Principled};
use proptest::prelude::*;

fn color() -> impl Strategy<Value = Vec3> {
    [0.0_f32..=1.0, 0.0_f32..=1.0, 0.0_f32..=1.0].prop_map(Vec3::from)
}

fn metal() -> impl Strategy<Value = Lobe> {
    let schlick = (0.001_f32..=1.0, color()).prop_map(|(alpha, f0)| Lobe::microfacets(alpha, f0, Vec3::ONE));
    let index = (0.001_f32..=1.0, color(), color())
        .prop_map(|(alpha, eta, k)| Lobe::metal(alpha, eta * 4.0 + 0.05, k * 8.0));
    // Brushed or under a film, or not.
    let brushed = (direction(), 0.001_f32..=1.0, any::<bool>());
    (prop_oneof![schlick, index], brushed, film()).prop_map(|(lobe, (along, across, is_brushed), film)| {
        let lobe = if is_brushed { lobe.brushed(along, across) } else { lobe };
        lobe.filmed(film)
    })
}

/// Of no share, or some.
fn film() -> impl Strategy<Value = Film> {
    (0.0_f32..=1.0, any::<bool>(), 1.0_f32..2.0, 0.0_f32..1000.0).prop_map(
        |(share, is_there, ior, thickness)| Film {
            share: if is_there { share } else { 0.0 },
            ior,
            thickness,
        },
    )
}

fn lobe() -> impl Strategy<Value = Lobe> {
    let diffuse = (color(), 0.0_f32..=1.0, 0..3).prop_map(|(albedo, roughness, which)| match which {
        0 => Lobe::oren_nayar(albedo, roughness),
        1 => Lobe::oren_nayar_once(albedo, roughness),
        _ => Lobe::burley(albedo, roughness),
    });
    let sheen = (color(), 0.0_f32..=1.0).prop_map(|(color, roughness)| Lobe::sheen(color, roughness));
    let glass = (0.001_f32..=1.0, 0.3_f32..3.0, color(), color(), any::<bool>())
        .prop_map(|(alpha, eta, r, t, thin)| Lobe::rough_glass(alpha, eta, r, t, thin));
    let smooth = (0.3_f32..3.0, color(), color(), any::<bool>())
        .prop_map(|(eta, r, t, thin)| Lobe::glass(eta, r, t, thin));
    let rare = |glass: Lobe, film: Film, spread: f32| glass.filmed(film).dispersed(spread.max(0.0));
    let glass =
        (glass, film(), -0.2_f32..0.4).prop_map(move |(glass, film, spread)| rare(glass, film, spread));
    let smooth =
        (smooth, film(), -0.2_f32..0.4).prop_map(move |(glass, film, spread)| rare(glass, film, spread));
    prop_oneof![
        color().prop_map(Lobe::lambert),
        color().prop_map(Lobe::mirror),
        color().prop_map(Lobe::translucent),
        diffuse,
        sheen,
        metal(),
        glass,
        smooth
    ]
}

fn layered() -> impl Strategy<Value = Lobes> {
    let base = (color(), 0.0_f32..=1.0, 0.0_f32..=1.0, 1.0_f32..2.5);
    let coat = (0.0_f32..=1.0, 0.001_f32..=1.0);
    let sheen = (color(), 0.0_f32..=1.0);
    let rare = (film(), 0.0_f32..=1.0, color());
    (base, coat, sheen, (0.0_f32..=1.0, any::<bool>()), rare).prop_map(
        |(
            (base, metallic, roughness, ior),
            (coat, coat_alpha),
            (sheen, sheen_roughness),
            (transmission, thin),
            (film, translucence, beyond),
        )| {
            let mut layers = Principled::new(base, metallic, roughness, ior);
            (layers.coat, layers.coat_alpha) = (coat, coat_alpha);
            (layers.sheen, layers.sheen_roughness) = (sheen, sheen_roughness);
            (layers.transmission, layers.thin) = (transmission, thin);
            (layers.film, layers.translucence, layers.beyond) = (film, translucence, beyond);
            layers.into()
        },
    )
}

fn model() -> impl Strategy<Value = Lobes> {
    let mix = (lobe(), lobe(), 0.0_f32..=1.0).prop_map(|(a, b, share)| Lobes::from(a).mixed(b, share));
    let layers = (lobe(), lobe()).prop_map(|(top, base)| Lobes::from(top).over(base));
    prop_oneof![lobe().prop_map(Lobes::from), mix, layers, layered()]
}

/// A unit vector; for views only the upper half is meant.
fn direction() -> impl Strategy<Value = Vec3> {
    (-1.0_f32..=1.0, 0.0_f32..std::f32::consts::TAU).prop_map(|(z, rotation)| {
        let r = (1.0 - z * z).max(0.0).sqrt();
        Vec3::new(r * rotation.cos(), r * rotation.sin(), z)
    })
}

fn numbers() -> impl Strategy<Value = [f32; 3]> {
    [0.0_f32..1.0, 0.0_f32..1.0, 0.0_f32..1.0]
}

fn is_light(value: Vec3) -> bool {
    value.is_finite() && value.min_element() >= 0.0
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn values_and_densities_are_sound(model in model(), wo in direction(), wi in direction()) {
        let bsdf = Bsdf::new(Vec3::Z, model);
        let (value, pdf) = (bsdf.eval(wo, wi), bsdf.pdf(wo, wi));
        prop_assert!(is_light(value), "value {value}");
        prop_assert!(pdf.is_finite() && pdf >= 0.0, "density {pdf}");
        let albedo = bsdf.albedo(wo);
        prop_assert!(is_light(albedo) && albedo.max_element() <= 1.01, "albedo {albedo}");
    }

    #[test]
    fn samples_say_what_values_and_densities_say(model in model(), wo in direction(), u in numbers()) {
        let bsdf = Bsdf::new(Vec3::Z, model);
        let Some(BsdfSample { wi, weight, pdf, delta, transmitted, .. }) = bsdf.sample(wo, u) else { return Ok(()) };
        prop_assert!((wi.length() - 1.0).abs() < 1e-4, "unit: {wi}");
        prop_assert!(is_light(weight), "weight {weight}");
        prop_assert!(transmitted == (wi.z < 0.0) || wi.z.abs() < 1e-5, "which side: {wi}");
        if delta {
            prop_assert!(pdf.is_infinite(), "a delta says so");
            // A mix chooses its parts by their brightest channels.
            // One of its colours is a third of three.
            let most = if bsdf.lobes().as_slice().iter().any(Lobe::is_dispersed) { 9.01 } else { 3.001 };
            prop_assert!(weight.max_element() <= most, "weight {weight}");
        } else {
            prop_assert!(pdf > 0.0 && pdf.is_finite(), "density {pdf}");
            // Values in the narrowest peaks depend on the last bits of directions.
            let again = bsdf.pdf(wo, wi);
            prop_assert!(pdf > 1e3 || (pdf - again).abs() <= 0.02 * pdf + 1e-5, "{pdf}, and asked again {again}");
            let (value, expected) = (bsdf.eval(wo, wi), weight * pdf);
            let off = (value - expected).abs().max_element();
            prop_assert!(pdf > 1e3 || off <= 0.02 * expected.max_element() + 1e-5, "{value}, by the sample {expected}");
        }
    }

    #[test]
    fn reflection_goes_both_ways(model in model(), wo in direction(), wi in direction()) {
        let (wo, wi) = (wo.with_z(wo.z.abs()), wi.with_z(wi.z.abs()));
        prop_assume!(wo.z > 0.01 && wi.z > 0.01);
        let bsdf = Bsdf::new(Vec3::Z, model);
        let (there, back) = (bsdf.eval(wo, wi) / wi.z, bsdf.eval(wi, wo) / wo.z);
        let off = (there - back).abs().max_element();
        prop_assert!(off <= 0.01 * there.max_element() + 1e-4, "{there} and {back}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn no_light_is_made(model in model(), wo in direction(), shift in numbers()) {
        // Nearer to the horizon a sample of a rough diffuse surface weighs up to one over the cosine: too few of them would be
        // too many.
        let wo = wo.with_z(wo.z.abs());
        prop_assume!(wo.z > 0.05);
        let bsdf = Bsdf::new(Vec3::Z, model);
        // Cloth seen at grazing angles is drawn by the cosine, which does not know its narrow rim.
        let has_rim = bsdf.lobes().as_slice().iter().any(|lobe| lobe.kind == Kind::Sheen);
        let (most, all) = if has_rim { (1000.0, 1.15) } else { (50.0, 1.03) };
        let n = 4096_u32;
        let mut sum = Vec3::ZERO;
        for i in 0..n {
            // A lattice of low discrepancy, shifted.
            let step = [0.819_172_5_f64, 0.671_043_6, 0.549_700_5];
            let u = [0, 1, 2].map(|k| ((f64::from(i) * step[k] + f64::from(shift[k])).fract() as f32).min(0.999_999_9));
            if let Some(sample) = bsdf.sample(wo, u) {
                prop_assert!(sample.weight.max_element() < most, "weight {}", sample.weight);
                sum += sample.weight / n as f32;
            }
        }
        prop_assert!(sum.max_element() < all, "{sum} of 1 comes back");
    }
}

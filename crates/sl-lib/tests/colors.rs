// SPDX-License-Identifier: GPL-3.0-or-later
//! Colours: known conversions, ways there and back, derivatives, black bodies against an integral in `f64`.

use gnurt_sl_lib::Dual;
use gnurt_sl_lib::color::ColorSystem;
use proptest::prelude::*;

const SPACES: [&str; 8] = ["rgb", "linear", "hsv", "hsl", "YIQ", "XYZ", "xyY", "sRGB"];

fn near(found: [f32; 3], expected: [f32; 3], by: f32, what: &str) {
    for (found, expected) in found.into_iter().zip(expected) {
        assert!((found - expected).abs() <= by * (1.0 + expected.abs()), "{what}: {found}, not {expected}");
    }
}

#[test]
fn known_colors_convert() {
    let system = ColorSystem::default();
    let to = |space, c: [f32; 3]| system.transform("rgb", space, c).expect("a known space");
    // Values printed by OSL's test suite, to three digits.
    let lime = [0.5, 1.0, 0.0];
    near(to("hsv", lime), [0.25, 1.0, 1.0], 5e-4, "hsv");
    near(to("hsl", lime), [0.25, 1.0, 0.5], 5e-4, "hsl");
    near(to("YIQ", lime), [0.737, 0.023, -0.417], 5e-4, "YIQ");
    near(to("XYZ", lime), [0.564, 0.822, 0.129], 5e-4, "XYZ");
    near(to("xyY", lime), [0.372, 0.543, 0.822], 5e-4, "xyY");
    near(to("sRGB", lime), [0.735, 1.0, 0.0], 5e-4, "sRGB");
    near(to("hsv", [0.5; 3]), [0.0, 0.0, 0.5], 5e-4, "grey");
    let aces = ColorSystem::named("ACEScg").expect("a known system");
    let xyz = aces.transform("RGB", "XYZ", [0.1, 0.7, 0.2]).expect("a known space");
    near(xyz, [0.191_286, 0.509_818, 0.204_353], 3e-6, "ACEScg in XYZ");
    near(aces.blackbody(1500.0), [75.0559, 22.3461, 2.222_19], 3e-6, "a black body in ACEScg");
    near(aces.wavelength_color(500.0), [0.0, 0.207_563, 0.105_645], 3e-6, "500 nm in ACEScg");
    let error = system.transform("rgb", "nowhere", lime).expect_err("an unknown space");
    assert_eq!(error.to_string(), "Unknown color space transformation \"rgb\" -> \"nowhere\"");
}

#[test]
fn systems_are_white_where_they_should_be() {
    for name in ColorSystem::names() {
        let system = ColorSystem::named(name).expect("its own name");
        assert_eq!(system.name(), name);
        let sum: f32 = system.luminance_weights().iter().sum();
        assert!((sum - 1.0).abs() < 1e-5, "{name}: {sum}");
        let [x, y, luminance] = system.transform("rgb", "xyY", [1.0; 3]).expect("a known space");
        assert!(
            (luminance - 1.0).abs() < 1e-4 && x > 0.3 && y > 0.3 && x + y < 0.67,
            "{name}: {x} {y} {luminance}"
        );
        assert!((system.luminance([1.0, 1.0, 1.0]) - 1.0).abs() < 1e-5);
    }
    assert!(ColorSystem::named("nothing").is_none());
    near(ColorSystem::default().luminance_weights(), [0.2126, 0.7152, 0.0722], 1e-3, "Rec. 709");
}

#[test]
fn black_bodies_shine_by_planck() {
    let system = ColorSystem::default();
    for kelvin in [2000.0, 3000.0, 5000.0, 6500.0, 11_999.0, 12_001.0, 20_000.0] {
        // XYZ's Y of the same radiation, by the definition.
        let luminance = f64::from(system.luminance(system.blackbody(kelvin)));
        // The eye's curve as one bell, 1.019 exp(-285.4 (l - 0.559)^2) with l in micrometres.
        let exitance: f64 = (380..780)
            .map(|nm| {
                let l = (f64::from(nm) + 0.5) * 1e-9;
                let eye = 1.019 * (-285.4 * (l * 1e6 - 0.559).powi(2)).exp();
                3.741_83e-16 / (l.powi(5) * (1.4388e-2 / (l * f64::from(kelvin))).exp_m1()) * eye * 1e-9
            })
            .sum();
        assert!((luminance / exitance - 1.0).abs() < 0.07, "{kelvin} K: {luminance} instead of {exitance}");
    }
    assert_eq!(system.blackbody(500.0), [1e-6, 0.0, 0.0]);
    assert_eq!(system.blackbody(f32::NAN), [1e-6, 0.0, 0.0]);
    assert_eq!([system.wavelength_color(300.0), system.wavelength_color(f32::NAN)], [[0.0; 3]; 2]);
    let [r, g, b] = system.wavelength_color(540.0);
    assert!(g > r && g > b && g <= 1.0, "540 nm is green: {r} {g} {b}");
}

proptest! {
    #[test]
    fn ways_lead_back(c in prop::array::uniform3(0.05_f32..1.0), d in prop::array::uniform3(-1.0_f32..1.0)) {
        let system = ColorSystem::default();
        for from in SPACES {
            for to in SPACES {
                // Hues of grey are lost, and so are lightnesses above 1.
                prop_assume!(c[0] != c[1] || c[1] != c[2]);
                let start = system.transform("rgb", from, c).expect("known");
                let back = system.transform(to, from, system.transform(from, to, start).expect("known")).expect("known");
                near(system.transform(from, "rgb", back).expect("known"), c, 2e-3, &format!("{from} to {to} and back"));
            }
            let at = |s: f32| -> [Dual<f32>; 3] { std::array::from_fn(|i| Dual::new(c[i] + s * d[i], d[i], 0.0)) };
            let there = |s: f32| system.transform("rgb", from, at(s)).expect("known");
            let h = 1e-3;
            for ((found, before), after) in there(0.0).into_iter().zip(there(-h)).zip(there(h)) {
                let expected = (after.value - before.value) / (2.0 * h);
                let bend = (after.value - 2.0 * found.value + before.value).abs() / h;
                prop_assert!((found.dx - expected).abs() < 0.01 * (1.0 + expected.abs()) + 2.0 * bend,
                    "{from} of {c:?} along {d:?}: {} not {expected}", found.dx);
            }
        }
    }
}

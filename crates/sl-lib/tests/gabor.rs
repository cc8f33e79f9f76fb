// SPDX-License-Identifier: GPL-3.0-or-later
//! Gabor noise against numbers that OSL's own code gave at the same points, its derivatives, and noise by name.

use gnurt_sl_lib::Dual;
use gnurt_sl_lib::noise::*;
use proptest::prelude::*;

type D = Dual<f32>;

fn point() -> [D; 3] {
    [Dual::new(1.25, 0.25, 0.0), Dual::new(-0.5, 0.0, 0.25), Dual::new(2.75, 0.125, 0.0)]
}

fn near(found: D, expected: [u32; 3], what: &str) {
    // The system's exp and cos may differ by a rounding from the one's that was asked.
    for (found, expected) in [found.value, found.dx, found.dy].into_iter().zip(expected.map(f32::from_bits)) {
        assert!(
            (found - expected).abs() <= 1e-5 * (1.0 + expected.abs()),
            "{what}: {found} instead of {expected}"
        );
    }
}

#[test]
fn gabor_noise_is_osls() {
    let plain = GaborOptions::default();
    near(gabor(point(), None, &plain), [0xbcd0_8866, 0x3d01_97c0, 0xbdee_f68b], "filtered");
    let third = gabor3(point(), None, &plain)[2].value;
    near(third.into(), [0xbe5e_cd3b, 0, 0], "the third of three");
    let mut options = GaborOptions { do_filter: false, ..plain };
    near(gabor(point(), None, &options), [0x3c9c_998a, 0x3d33_29de, 0xbe0c_166c], "not filtered");
    options =
        GaborOptions { anisotropic: 1, bandwidth: 2.0, impulses: 8.0, direction: [0.0, 2.0, 0.0], ..options };
    let periodic = gabor(point(), Some([2.0, 3.0, 4.0]), &options);
    near(periodic, [0xbce5_74d4, 0xbd77_bcb1, 0xbf2f_8473], "along a direction, periodic");
    options.anisotropic = 2;
    near(gabor(point(), None, &options), [0x3d1b_70c2, 0x3e2e_4f89, 0xbdb6_8032], "in a plane");
}

#[test]
fn gabor_noise_slopes_as_it_should() {
    let options = GaborOptions { do_filter: false, ..GaborOptions::default() };
    let mut right = 0;
    for i in 0..40 {
        let at = |s: f32| {
            let start = [i as f32 * 0.37, i as f32 * -0.21, i as f32 * 0.11];
            let along = [0.6, -0.3, 0.4];
            gabor(std::array::from_fn(|k| Dual::new(start[k] + s * along[k], along[k], 0.0)), None, &options)
        };
        let h = 0.002;
        let (found, expected) = (at(0.0).dx, (at(h).value - at(-h).value) / (2.0 * h));
        right += u32::from((found - expected).abs() < 0.05);
        assert_eq!(at(0.0).dy, 0.0, "nothing changes in y");
    }
    // A bell that begins or ends between the two places makes a step of its truncation.
    assert!(right >= 30, "only {right} of 40 slopes agree with differences");
}

proptest! {
    #[test]
    fn any_input_ends(p in prop::array::uniform9(any::<f32>()), bandwidth in any::<f32>(), impulses in any::<f32>()) {
        let p = std::array::from_fn(|i| Dual::new(p[i], p[i + 3], p[i + 6]));
        let options = GaborOptions { bandwidth, impulses, ..GaborOptions::default() };
        let _ = gabor(p, None, &options);
        let _ = gabor(p, Some([bandwidth, impulses, 0.0]), &options);
    }
}

#[test]
fn names_choose_the_kind() {
    let options = GaborOptions::default();
    let one = |name: &str| {
        let kind = NoiseKind::named(name).unwrap_or_else(|| panic!("{name} is a kind of noise"));
        (kind.noise(&point(), None, &options), kind.noise3(&point()[..2], None, &options))
    };
    let (p3, p2) = (point(), [point()[0], point()[1]]);
    assert_eq!(one("perlin"), (snoise(p3), snoise3(p2)));
    assert_eq!(one("snoise"), one("perlin"));
    assert_eq!(one("uperlin"), (noise(p3), noise3(p2)));
    assert_eq!(one("simplex"), (simplex(p3), simplex3(p2)));
    assert_eq!(one("usimplex"), (usimplex(p3), usimplex3(p2)));
    assert_eq!(one("cell").0, cellnoise(p3.map(|x| x.value)).into());
    assert_eq!(one("hash").0, hashnoise(p3.map(|x| x.value)).into());
    assert_eq!(one("gabor").0, gabor(p3, None, &options));
    assert_eq!((one("null").0, one("unull").0), (0.0.into(), 0.5.into()));
    assert!(NoiseKind::named("voronoi").is_none());
    let periodic = NoiseKind::Perlin.noise(&point(), Some(&[2.0, 3.0, 4.0]), &options);
    assert_eq!(periodic, psnoise(p3, [2.0, 3.0, 4.0]));
    let names = ["perlin", "uperlin", "cell", "hash", "gabor", "simplex"];
    let repeat = names.map(|name| NoiseKind::named(name).is_some_and(NoiseKind::can_repeat));
    assert_eq!(repeat, [true, true, true, true, true, false]);
}

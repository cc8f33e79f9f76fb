// SPDX-License-Identifier: GPL-3.0-or-later
//! Noise against numbers that OSL's own code gave at the same points (commit ad63273a, compiled without fused operations), to
//! the bit, and its properties.

use gnurt_sl_lib::noise::*;
use proptest::prelude::*;

/// Where OSL was asked.
const P: [f32; 4] = [1.7, -2.3, 113.625, 0.9];
const PERIOD: [f32; 4] = [3.0, 2.9, 4.0, 5.0];

/// A kind of noise at `P`'s first 1, 2, 3 and 4 coordinates: one number of each, then the last of three.
struct Known {
    name: &'static str,
    found: [[f32; 4]; 2],
    bits: [[u32; 4]; 2],
}

macro_rules! known {
    ($name:literal, $one:ident, $three:ident, $bits:expr) => {
        Known {
            name: $name,
            found: [
                [$one([P[0]]), $one([P[0], P[1]]), $one([P[0], P[1], P[2]]), $one(P)],
                [$three([P[0]])[2], $three([P[0], P[1]])[2], $three([P[0], P[1], P[2]])[2], $three(P)[2]],
            ],
            bits: $bits,
        }
    };
    ($name:literal, periodic $one:ident, $three:ident, $bits:expr) => {{
        let [x, y, z, w] = PERIOD;
        Known {
            name: $name,
            found: [
                [
                    $one([P[0]], [x]),
                    $one([P[0], P[1]], [x, y]),
                    $one([P[0], P[1], P[2]], [x, y, z]),
                    $one(P, [x, y, z, w]),
                ],
                [
                    $three([P[0]], [x])[2],
                    $three([P[0], P[1]], [x, y])[2],
                    $three([P[0], P[1], P[2]], [x, y, z])[2],
                    $three(P, [x, y, z, w])[2],
                ],
            ],
            bits: $bits,
        }
    }};
}

#[test]
fn noise_has_the_bits_of_osls() {
    let all = [
        known!(
            "snoise",
            snoise,
            snoise3,
            [
                [0x3f07db5d, 0xbe70b48b, 0xbedc6516, 0x3e408034],
                [0xbdaf2c16, 0xbf2ea5eb, 0x3e81fcef, 0x3e1511ff]
            ]
        ),
        known!(
            "noise",
            noise,
            noise3,
            [
                [0x3f43edae, 0x3ec3d2dd, 0x3e91cd75, 0x3f181006],
                [0x3eea1a7d, 0x3e22b42a, 0x3f207f3c, 0x3f12a240]
            ]
        ),
        known!(
            "cellnoise",
            cellnoise,
            cellnoise3,
            [
                [0x3e95af8d, 0x3e5689a2, 0x3e791f10, 0x3f525785],
                [0x3d81be5d, 0x3f560297, 0x3f510b2f, 0x3ed1dab7]
            ]
        ),
        known!(
            "hashnoise",
            hashnoise,
            hashnoise3,
            [
                [0x3f493c26, 0x3eac33c0, 0x3dc98141, 0x3f67ac78],
                [0x3e440790, 0x3eca94ff, 0x3c169eea, 0x3f549586]
            ]
        ),
        known!(
            "simplex",
            simplex,
            simplex3,
            [
                [0x3dc69be2, 0xbe827bae, 0xbf0b1c6e, 0x3ea61006],
                [0x3ef4f904, 0xbd5b3b14, 0xbf4659a9, 0xbe0167b0]
            ]
        ),
        known!(
            "usimplex",
            usimplex,
            usimplex3,
            [
                [0x3f0c69be, 0x3ebec229, 0x3e69c724, 0x3f298402],
                [0x3f3d3e41, 0x3ef24c4f, 0x3de6995c, 0x3edfa614]
            ]
        ),
        known!("psnoise", periodic psnoise, psnoise3, [[0x3f07db5d, 0xbe72ff1b, 0xbef55157, 0xbdb08470], [0xbdaf2c16, 0x3e2cdfd8, 0x3db91d3d, 0xbee14299]]),
        known!("pnoise", periodic pnoise, pnoise3, [[0x3f43edae, 0x3ec34039, 0x3e855754, 0x3ee9ef72], [0x3eea1a7d, 0x3f159bfb, 0x3f0b91d4, 0x3e8f5eb4]]),
        known!("pcellnoise", periodic pcellnoise, pcellnoise3, [[0x3e95af8d, 0x3e77439f, 0x3e1973b0, 0x3f13af1b], [0x3d81be5d, 0x3f7bee0d, 0x3e8a7153, 0x3f29c40c]]),
        known!("phashnoise", periodic phashnoise, phashnoise3, [[0x3f493c26, 0x3e5ffbe3, 0x3f6a3dbb, 0x3f220957], [0x3e440790, 0x3f614479, 0x3f1db399, 0x3f7c727a]]),
    ];
    for Known { name, found, bits } in all {
        assert_eq!(found.map(|f| f.map(f32::to_bits)), bits, "{name} of 1 to 4 dimensions: {found:?}");
    }
}

#[test]
fn hashes_have_the_bits_of_osls() {
    assert_eq!(hash_int(42), 778167589);
    assert_eq!(hash_floats([P[0]]), -918804910);
    assert_eq!(hash_floats([P[0], P[1]]), 1444536348);
    assert_eq!(hash_floats([P[0], P[1], P[2]]), 422586390);
    assert_eq!(hash_floats(P), -408127529);
}

proptest! {
    #[test]
    fn noise_keeps_to_its_range(p in prop::array::uniform4(-1e3_f32..1e3)) {
        for (name, x, low) in [
            ("snoise", snoise(p), -1.01), ("noise", noise(p), -0.01), ("simplex", simplex(p), -1.01),
            ("usimplex", usimplex(p), -0.01), ("cell", cellnoise(p), 0.0), ("hash", hashnoise(p), 0.0),
        ] {
            prop_assert!((low..=1.01).contains(&x), "{name} at {p:?} is {x}");
        }
    }

    #[test]
    fn periodic_noise_repeats(p in prop::array::uniform3(0_u32..1000), period in prop::array::uniform3(1_u32..9), turns in 0_u32..9) {
        // Quarters, so that sums are exact.
        let at = p.map(|x| x as f32 * 0.25);
        let later = std::array::from_fn(|i| at[i] + (turns * period[i]) as f32);
        let period = period.map(|x| x as f32);
        prop_assert_eq!(psnoise(at, period), psnoise(later, period));
        prop_assert_eq!(pcellnoise3(at, period), pcellnoise3(later, period));
        prop_assert_eq!(phashnoise(at, period), phashnoise(later, period));
        // A period that holds all points changes nothing.
        prop_assert_eq!(pnoise3(at, [4096.0; 3]), noise3(at));
    }

    #[test]
    fn coordinates_beyond_whole_numbers_do_no_harm(p in prop::array::uniform4(any::<f32>())) {
        let _ = (snoise3(p), simplex3(p), cellnoise3(p), psnoise3(p, p), pcellnoise(p, p), hashnoise3(p));
    }
}

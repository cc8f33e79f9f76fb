// SPDX-License-Identifier: GPL-3.0-or-later
//! Sixteen lanes against one: the same bits, at every level, for every wide function, with derivatives and without.

use gnurt_simd::Level;
use gnurt_sl_lib::LANES;
use gnurt_sl_lib::spline::Basis;
use gnurt_sl_lib::wide::{Function, Row, Wide};

/// Numbers of all sizes, with those at which functions change their ways.
fn rows(seed: u32, count: usize) -> Vec<Row> {
    const SPECIAL: [f32; 14] = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        0.5,
        2.0,
        f32::MAX,
        f32::MIN_POSITIVE,
        1e-40,
        -3.0,
        f32::INFINITY,
        16_777_216.0,
        4.294_967_3e9,
        -2.5e9,
    ];
    let mut state = seed.wrapping_mul(2_654_435_761) | 1;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        state
    };
    let mut number = || {
        let word = next();
        let unit = (word >> 8) as f32 / 8_388_608.0 - 1.0;
        match word % 16 {
            0 => SPECIAL[(word >> 8) as usize % SPECIAL.len()],
            1..6 => unit,
            6..12 => unit * 20.0,
            12..14 => unit * 1e4,
            _ => unit * (unit * 40.0).exp2(),
        }
    };
    (0..count).map(|_| std::array::from_fn(|_| number())).collect()
}

fn same(a: &[Row], b: &[Row]) -> Result<(), String> {
    for (i, (a, b)) in a.iter().zip(b).enumerate() {
        for lane in 0..LANES {
            // A NaN is a NaN: CPUs differ in its bits.
            if a[lane].to_bits() != b[lane].to_bits() && !(a[lane].is_nan() && b[lane].is_nan()) {
                return Err(format!("row {i}, lane {lane}: {} instead of {}", a[lane], b[lane]));
            }
        }
    }
    Ok(())
}

#[test]
fn every_lane_has_the_bits_of_one_alone() {
    let alone = Wide::new(Level::Scalar);
    for level in Level::available() {
        let wide = Wide::new(level);
        for &function in Function::ALL {
            for derivatives in [false, true] {
                let each = if derivatives { 3 } else { 1 };
                for seed in 0..24 {
                    let input = rows(seed, each * function.arguments());
                    let mut found = vec![[7.0; LANES]; each * function.results()];
                    let mut wanted = found.clone();
                    wide.function(function, derivatives)(wide.token(), &input, &mut found);
                    alone.function(function, derivatives)(alone.token(), &input, &mut wanted);
                    if let Err(difference) = same(&found, &wanted) {
                        panic!(
                            "{function:?} at {level}, derivatives {derivatives}: {difference}; input {input:?}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn lanes_alone_are_the_functions_themselves() {
    let alone = Wide::new(Level::Scalar);
    let input = rows(1, 3);
    let mut found = [[0.0; LANES]];
    alone.function(Function::Snoise3, false)(alone.token(), &input, &mut found);
    for lane in 0..LANES {
        let wanted = gnurt_sl_lib::noise::snoise([input[0][lane], input[1][lane], input[2][lane]]);
        assert_eq!(found[0][lane].to_bits(), wanted.to_bits());
    }
}

#[test]
fn splines_of_lanes_are_those_of_one() {
    let alone = Wide::new(Level::Scalar);
    let knots: Vec<f32> = (0..10).map(|i| ((i * i) as f32).sin()).collect();
    for level in Level::available() {
        let wide = Wide::new(level);
        for name in ["catmull-rom", "bezier", "bspline", "hermite", "linear", "constant"] {
            for derivatives in [false, true] {
                let each = if derivatives { 3 } else { 1 };
                for seed in 0..8 {
                    let (input, basis) = (rows(seed, each), Basis::named(name));
                    let mut found = vec![[7.0; LANES]; each];
                    let mut wanted = found.clone();
                    wide.spline(derivatives)(wide.token(), basis, &knots, &input, &mut found);
                    alone.spline(derivatives)(alone.token(), basis, &knots, &input, &mut wanted);
                    assert_eq!(same(&found, &wanted), Ok(()), "{name} at {level}, derivatives {derivatives}");
                }
            }
        }
    }
}

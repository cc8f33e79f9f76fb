// SPDX-License-Identifier: GPL-3.0-or-later
//! Numbers as text, against C's and read back.

use gnurt_sl::format::general;

#[test]
fn as_in_c() {
    // printf("%g") and printf("%.9g") of C.
    for (value, digits, expected) in [
        (0.0, 6, "0"),
        (-0.0, 6, "-0"),
        (1.0, 6, "1"),
        (0.1, 6, "0.1"),
        (1e6, 6, "1e+06"),
        (999_999.5, 6, "1e+06"),
        (123_456.0, 6, "123456"),
        (0.0001, 6, "0.0001"),
        (0.000_01, 6, "1e-05"),
        (f64::from(1.0_f32 / 3.0), 9, "0.333333343"),
        (1e300, 6, "1e+300"),
        (f64::INFINITY, 6, "inf"),
    ] {
        assert_eq!(general(value, digits), expected, "{value} with {digits} digits");
    }
}

#[test]
fn nine_digits_are_read_back() {
    let mut bits = 0x3f80_0001_u32;
    for _ in 0..2000 {
        bits = bits.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let value = f32::from_bits(bits);
        if value.is_finite() {
            let text = general(f64::from(value), 9);
            assert_eq!(text.parse::<f32>().map(f32::to_bits), Ok(bits), "{text}");
        }
    }
}

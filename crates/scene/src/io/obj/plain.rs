// SPDX-License-Identifier: GPL-3.0-or-later
//! Numbers and corners as nearly all files write them, read from bytes; `None` leaves the others to the standard library.
//! Source: [Cli90] (W. Clinger, How to read floating point numbers accurately): a whole number below 2^53 times or over
//! a power of ten up to 10^22 is rounded once, and so is the nearest double. Tests: `tests`.

/// Powers of ten that doubles hold exactly.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18,
    1e19, 1e20, 1e21, 1e22,
];

/// Digits that a number of 64 bits holds.
const DIGITS: usize = 19;

/// A decimal number: `-12.5`, `3`, `.5e-3`.
pub(super) fn double(token: &[u8]) -> Option<f64> {
    let (is_negative, token) = match token {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, token),
    };
    let mut whole = 0_u64;
    let (mut digits, mut behind) = (0, 0);
    let mut at = 0;
    let mut point = None;
    while let Some(&byte) = token.get(at) {
        match byte {
            b'0'..=b'9' => {
                whole = whole.wrapping_mul(10).wrapping_add(u64::from(byte - b'0'));
                digits += 1;
            }
            b'.' if point.is_none() => point = Some(digits),
            _ => break,
        }
        at += 1;
    }
    if digits == 0 || digits > DIGITS || whole >= 1 << 53 {
        return None;
    }
    if let Some(point) = point {
        behind = digits - point;
    }
    let mut power = -(behind as i64);
    if let [b'e' | b'E', rest @ ..] = &token[at..] {
        power += integer(rest)?;
    } else if at != token.len() {
        return None;
    }
    let scale = *POWERS.get(usize::try_from(power.unsigned_abs()).ok()?)?;
    let value = if power < 0 { whole as f64 / scale } else { whole as f64 * scale };
    Some(if is_negative { -value } else { value })
}

/// A whole number of a few digits, with or without a sign.
fn integer(text: &[u8]) -> Option<i64> {
    let (sign, text) = match text {
        [b'-', rest @ ..] => (-1, rest),
        [b'+', rest @ ..] => (1, rest),
        _ => (1, text),
    };
    let is_short = (1..=DIGITS - 1).contains(&text.len());
    let number = |number: i64, byte: &u8| byte.is_ascii_digit().then(|| number * 10 + i64::from(byte - b'0'));
    if is_short { text.iter().try_fold(0, number).map(|number| sign * number) } else { None }
}

/// `v`, `v/t`, `v//n` or `v/t/n` as written.
pub(super) fn corner(token: &[u8]) -> Option<[Option<i64>; 3]> {
    let mut indices = [None; 3];
    let mut parts = token.split(|&byte| byte == b'/');
    for (k, slot) in indices.iter_mut().enumerate() {
        match parts.next() {
            Some([]) if k > 0 => {}
            Some(part) => *slot = Some(integer(part)?),
            None => break,
        }
    }
    parts.next().is_none().then_some(indices)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_those_of_the_standard_library() {
        let mut random = 7_u64;
        let mut next = |count: u64| {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (random >> 33) % count
        };
        let (mut read, all) = (0, 200_000);
        for _ in 0..all {
            let digits = next(12) + 1;
            let mut text: String = (0..digits).map(|_| char::from(b'0' + next(10) as u8)).collect();
            if next(4) > 0 {
                text.insert(next(digits + 1) as usize, '.');
            }
            text.insert_str(0, ["", "-", "+"][next(3) as usize]);
            match next(6) {
                0 => text += &format!("e{}", next(60) as i64 - 30),
                1 => text += &format!("E+{}", next(30)),
                2 => text += ["", "e", "x", "-", "."][next(5) as usize],
                _ => {}
            }
            if let Some(value) = double(text.as_bytes()) {
                read += 1;
                let expected: f64 = text.parse().expect("the library reads it too");
                assert_eq!(value.to_bits(), expected.to_bits(), "{text}");
            }
        }
        assert!(read > all / 2, "most of them: {read}");
        for text in [
            "",
            "-",
            ".",
            "e5",
            "1e",
            "0x1",
            "nan",
            "1.#IND",
            "12345678901234567890",
            "1.2.3",
            "--1",
            "1e400",
        ] {
            assert_eq!(double(text.as_bytes()), None, "{text}");
        }
        assert_eq!(double(b"-0").map(f64::to_bits), Some((-0.0_f64).to_bits()), "its sign");
        assert_eq!(double(b"5."), Some(5.0));
    }

    #[test]
    fn corners_in_all_forms() {
        let of = |text: &str| corner(text.as_bytes());
        assert_eq!(of("1"), Some([Some(1), None, None]));
        assert_eq!(of("1/-2"), Some([Some(1), Some(-2), None]));
        assert_eq!(of("1//3"), Some([Some(1), None, Some(3)]));
        assert_eq!(of("-1/+2/3"), Some([Some(-1), Some(2), Some(3)]));
        assert_eq!(of("7/"), Some([Some(7), None, None]));
        for text in ["", "/1", "1/2/3/4", "1/x", "1.5", "99999999999999999999"] {
            assert_eq!(of(text), None, "{text}");
        }
    }
}

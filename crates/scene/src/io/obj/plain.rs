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

/// Bytes of a line, read from left to right.
#[derive(Clone, Copy)]
pub(super) struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Cursor<'a> {
    /// At the first byte.
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    /// Bytes behind.
    pub(super) fn at(&self) -> usize {
        self.at
    }

    #[inline(always)]
    fn peek(&self) -> u8 {
        // The end of the bytes ends the last line.
        self.bytes.get(self.at).copied().unwrap_or(b'\n')
    }

    /// Steps over these bytes.
    #[inline(always)]
    pub(super) fn word(&mut self, word: &[u8]) -> Option<()> {
        self.bytes[self.at..].starts_with(word).then(|| self.at += word.len())
    }

    /// Steps over blanks; `None` where there is none.
    #[inline(always)]
    pub(super) fn blanks(&mut self) -> Option<()> {
        let before = self.at;
        while is_blank(self.peek()) {
            self.at += 1;
        }
        (self.at > before).then_some(())
    }

    /// Steps over blanks and the end of the line; `None`, and over blanks only, if there is more.
    #[inline(always)]
    pub(super) fn end(&mut self) -> Option<()> {
        let _ = self.blanks();
        match self.peek() {
            b'\n' => self.at = (self.at + 1).min(self.bytes.len()),
            b'\r' => self.at += if self.bytes.get(self.at + 1) == Some(&b'\n') { 2 } else { 1 },
            _ => return None,
        }
        Some(())
    }

    /// Whether blanks or the end of the line are next.
    #[inline(always)]
    fn is_behind_word(&self) -> bool {
        let next = self.peek();
        is_blank(next) || next == b'\n' || next == b'\r'
    }

    /// A decimal number that is a word: `-12.5`, `3`, `.5e-3`.
    #[inline]
    pub(super) fn double(&mut self) -> Option<f64> {
        let is_negative = self.sign();
        let (whole, mut digits) = self.digits(0);
        let (mut whole, mut power) = (whole, 0_i64);
        if self.peek() == b'.' {
            self.at += 1;
            let behind;
            (whole, behind) = self.digits(whole);
            digits += behind;
            power = -(behind as i64);
        }
        if digits == 0 || digits > DIGITS || whole >= 1 << 53 {
            return None;
        }
        if matches!(self.peek(), b'e' | b'E') {
            self.at += 1;
            power += self.integer()?;
        }
        if !self.is_behind_word() {
            return None;
        }
        let scale = *POWERS.get(usize::try_from(power.unsigned_abs()).ok()?)?;
        let value = if power < 0 { whole as f64 / scale } else { whole as f64 * scale };
        Some(if is_negative { -value } else { value })
    }

    /// Appends digits to a number; returns their count as well.
    #[inline(always)]
    fn digits(&mut self, mut whole: u64) -> (u64, usize) {
        let before = self.at;
        while let Some(digit) = digit(self.peek()) {
            whole = whole.wrapping_mul(10).wrapping_add(digit);
            self.at += 1;
        }
        (whole, self.at - before)
    }

    /// A whole number of a few digits, with or without a sign.
    #[inline(always)]
    fn integer(&mut self) -> Option<i64> {
        let is_negative = self.sign();
        let (number, digits) = self.digits(0);
        let number = (1..DIGITS).contains(&digits).then_some(number as i64)?;
        Some(if is_negative { -number } else { number })
    }

    #[inline(always)]
    fn sign(&mut self) -> bool {
        let sign = self.peek();
        self.at += usize::from(sign == b'-' || sign == b'+');
        sign == b'-'
    }

    /// `v`, `v/t`, `v//n` or `v/t/n` as written; 31 bits are enough for nearly all files.
    #[inline]
    pub(super) fn corner(&mut self) -> Option<PlainCorner> {
        let mut indices = [MISSING; 3];
        for (k, slot) in indices.iter_mut().enumerate() {
            if k > 0 {
                if self.peek() != b'/' {
                    break;
                }
                self.at += 1;
                if self.peek() == b'/' || self.is_behind_word() {
                    continue;
                }
            }
            *slot = i32::try_from(self.integer()?).ok().filter(|&index| index != MISSING)?;
        }
        self.is_behind_word().then_some(indices)
    }
}

/// Indices of a corner's position, texture coordinate and normal, or [`MISSING`].
pub(super) type PlainCorner = [i32; 3];

/// An index that is not written.
pub(super) const MISSING: i32 = i32::MIN;

#[inline(always)]
fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\x0c')
}

#[inline(always)]
fn digit(byte: u8) -> Option<u64> {
    let digit = byte.wrapping_sub(b'0');
    (digit < 10).then_some(u64::from(digit))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A text that is one number.
    fn double(text: &[u8]) -> Option<f64> {
        let mut cursor = Cursor::new(text);
        let value = cursor.double()?;
        (cursor.at() == text.len()).then_some(value)
    }

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
        let of = |text: &str| {
            let mut cursor = Cursor::new(text.as_bytes());
            let corner = cursor.corner()?;
            (cursor.at() == text.len()).then_some(corner)
        };
        assert_eq!(of("1"), Some([1, MISSING, MISSING]));
        assert_eq!(of("1/-2"), Some([1, -2, MISSING]));
        assert_eq!(of("1//3"), Some([1, MISSING, 3]));
        assert_eq!(of("-1/+2/3"), Some([-1, 2, 3]));
        assert_eq!(of("7/"), Some([7, MISSING, MISSING]));
        assert_eq!(of("7//"), Some([7, MISSING, MISSING]));
        assert_eq!(of("4000000000"), None, "left to others");
        for text in ["", "/1", "1/2/3/4", "1/x", "1.5", "99999999999999999999"] {
            assert_eq!(of(text), None, "{text}");
        }
    }
}

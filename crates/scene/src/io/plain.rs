// SPDX-License-Identifier: GPL-3.0-or-later
//! Numbers as nearly all text files write them, read from bytes; `None` leaves the others to the standard library.
//! Source: [Cli90] (W. Clinger, How to read floating point numbers accurately): a whole number below 2^53 times or over
//! a power of ten up to 10^22 is rounded once, and so is the nearest double. Tests: `tests`.

/// Powers of ten that doubles hold exactly.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18,
    1e19, 1e20, 1e21, 1e22,
];

/// Digits that a number of 64 bits holds.
const DIGITS: usize = 19;

/// Bytes of a text, read from left to right.
#[derive(Clone, Copy)]
pub struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Cursor<'a> {
    /// At the first byte.
    #[must_use]
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    /// Bytes behind.
    #[must_use]
    pub fn at(&self) -> usize {
        self.at
    }

    /// The next byte; the end of the bytes reads as the end of a line.
    #[inline(always)]
    #[must_use]
    pub fn peek(&self) -> u8 {
        self.bytes.get(self.at).copied().unwrap_or(b'\n')
    }

    /// The byte behind the next one.
    #[inline(always)]
    pub(super) fn second(&self) -> Option<u8> {
        self.bytes.get(self.at + 1).copied()
    }

    /// Steps over so many bytes, at most to the end.
    #[inline(always)]
    pub fn skip(&mut self, count: usize) {
        self.at = (self.at + count).min(self.bytes.len());
    }

    /// Steps over these bytes.
    #[inline(always)]
    pub fn word(&mut self, word: &[u8]) -> Option<()> {
        self.bytes[self.at..].starts_with(word).then(|| self.at += word.len())
    }

    /// Steps over bytes of this kind.
    #[inline(always)]
    pub fn skip_while(&mut self, is_skipped: impl Fn(u8) -> bool) {
        while self.bytes.get(self.at).is_some_and(|&byte| is_skipped(byte)) {
            self.at += 1;
        }
    }

    /// A decimal number: `-12.5`, `3`, `.5e-3`. The caller looks at the byte behind it.
    #[inline]
    pub fn number(&mut self) -> Option<f64> {
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
        let scale = *POWERS.get(usize::try_from(power.unsigned_abs()).ok()?)?;
        let value = if power < 0 { whole as f64 / scale } else { whole as f64 * scale };
        Some(if is_negative { -value } else { value })
    }

    /// The same as the nearest number of single precision, however it is written.
    #[inline]
    pub fn single(&mut self) -> Option<f32> {
        /// The bits that single precision lacks, where a double lies between two of its numbers.
        const TIE: u64 = 1 << 28;
        let before = self.at;
        let is_end = |byte: u8| !matches!(byte, b'0'..=b'9' | b'.' | b'e' | b'E' | b'+' | b'-');
        match self.number() {
            Some(value) if is_end(self.peek()) && value.to_bits() & (2 * TIE - 1) != TIE => {
                Some(value as f32)
            }
            _ => {
                self.at = before;
                self.skip_while(|byte| !is_end(byte));
                std::str::from_utf8(&self.bytes[before..self.at]).ok()?.parse().ok()
            }
        }
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
    pub fn integer(&mut self) -> Option<i64> {
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
        let value = cursor.number()?;
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
    fn singles_are_those_of_the_standard_library() {
        let single = |text: &str| {
            let mut cursor = Cursor::new(text.as_bytes());
            cursor.single().filter(|_| cursor.at() == text.len())
        };
        // Halves between two singles, and decimals whose nearest double is such a half.
        let ties =
            ["16777217", "16777219", "1.00000005960464477539", "1.000000059604644775390625", "33554433e-25"];
        let others =
            ["0.1", "-3", "1e-45", "1e-46", "3.4028236e38", "1e400", "123456789012345678901234567890", "-0"];
        for text in ties.iter().chain(&others) {
            assert_eq!(single(text).map(f32::to_bits), text.parse().ok().map(f32::to_bits), "{text}");
        }
        let mut random = 11_u64;
        for _ in 0..100_000 {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let between = f64::from(f32::from_bits((random >> 33) as u32 & 0x7f7f_ffff));
            let text = format!("{}", f64::from_bits(between.to_bits() | (random & 3) << 27));
            assert_eq!(single(&text).map(f32::to_bits), text.parse().ok().map(f32::to_bits), "{text}");
        }
        assert_eq!(single("nan"), None);
        assert_eq!(single("1-2"), None);
    }
}

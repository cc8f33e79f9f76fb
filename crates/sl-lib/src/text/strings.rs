// SPDX-License-Identifier: GPL-3.0-or-later
//! Functions of strings. Indices and lengths count bytes, as with OSL; where a cut would leave part of a
//! letter, that letter becomes U+FFFD.
//! Source: the OSL 1.14 language reference, "String functions", and OpenImageIO's `Strutil` for unspecified
//! cases.
//! Invariant: no string makes any of them panic. Tests: `tests/strings.rs`.

/// The length in bytes.
#[must_use]
pub fn strlen(s: &str) -> i32 {
    s.len().try_into().unwrap_or(i32::MAX)
}

/// Byte `index`, and 0 outside of the string.
#[must_use]
pub fn getchar(s: &str, index: i32) -> i32 {
    usize::try_from(index).ok().and_then(|i| s.as_bytes().get(i)).map_or(0, |&byte| i32::from(byte as i8))
}

/// Whether `s` begins so: 1 or 0.
#[must_use]
pub fn startswith(s: &str, prefix: &str) -> i32 {
    s.starts_with(prefix).into()
}

/// Whether `s` ends so: 1 or 0.
#[must_use]
pub fn endswith(s: &str, suffix: &str) -> i32 {
    s.ends_with(suffix).into()
}

/// At most `length` bytes from index `start` on, which counts from the end if it is negative.
#[must_use]
pub fn substr(s: &str, start: i32, length: i32) -> String {
    let size = s.len() as i64;
    let start = i64::from(start);
    let first = (if start < 0 { start + size } else { start }).clamp(0, size);
    let last = (first + i64::from(length).max(0)).min(size);
    String::from_utf8_lossy(&s.as_bytes()[first as usize..last as usize]).into_owned()
}

fn is_space(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\n' | b'\r' | 0x0b | 0x0c)
}

/// The whole number that a string begins with, behind white space; 0 if it does with none. Clamped to the
/// range of an `int`.
#[must_use]
pub fn stoi(s: &str) -> i32 {
    let s = s.trim_start_matches(|c: char| c.is_ascii() && is_space(c as u8));
    let (negative, digits) = match s.as_bytes().first() {
        Some(b'-') => (true, &s[1..]),
        Some(b'+') => (false, &s[1..]),
        _ => (false, s),
    };
    let mut value: i64 = 0;
    for digit in digits.bytes().take_while(u8::is_ascii_digit) {
        value = (value * 10 + i64::from(digit - b'0')).min(1 << 40);
    }
    let value = if negative { -value } else { value };
    value.clamp(i32::MIN.into(), i32::MAX.into()) as i32
}

/// How many bytes of a string are digits.
fn digits(s: &[u8]) -> usize {
    s.iter().take_while(|byte| byte.is_ascii_digit()).count()
}

/// The number that a string begins with, behind white space; 0 if it does with none. Known are decimal numbers, `inf`,
/// `infinity` and `nan`.
#[must_use]
pub fn stof(s: &str) -> f32 {
    let s = s.trim_start_matches(|c: char| c.is_ascii() && is_space(c as u8));
    let bytes = s.as_bytes();
    let sign = usize::from(matches!(bytes.first(), Some(b'+' | b'-')));
    let rest = &bytes[sign..];
    let is_at_start =
        |pattern: &[u8]| rest.get(..pattern.len()).is_some_and(|start| start.eq_ignore_ascii_case(pattern));
    let mut end = if is_at_start(b"infinity") {
        8
    } else if is_at_start(b"inf") || is_at_start(b"nan") {
        3
    } else {
        let whole = digits(rest);
        let part = if rest.get(whole) == Some(&b'.') { digits(&rest[whole + 1..]) } else { 0 };
        if whole + part == 0 {
            return 0.0;
        }
        let mantissa = if rest.get(whole) == Some(&b'.') { whole + 1 + part } else { whole };
        let mut end = mantissa;
        if matches!(rest.get(mantissa), Some(b'e' | b'E')) {
            let signed = mantissa + 1 + usize::from(matches!(rest.get(mantissa + 1), Some(b'+' | b'-')));
            let exponent = rest.get(signed..).map_or(0, digits);
            if exponent > 0 {
                end = signed + exponent;
            }
        }
        end
    };
    end += sign;
    s[..end].parse().unwrap_or(0.0)
}

/// The parts of a string between separators, or between white space if the separator is empty; at most `most`, of which the
/// last one is all that is left.
#[must_use]
pub fn split<'a>(s: &'a str, separator: &str, most: usize) -> Vec<&'a str> {
    if s.is_empty() || most == 0 {
        return vec![];
    }
    if !separator.is_empty() {
        return s.splitn(most, separator).collect();
    }
    let mut rest = s.trim_start_matches(is_white);
    let mut parts = Vec::new();
    while !rest.is_empty() {
        if parts.len() + 1 == most {
            parts.push(rest);
            break;
        }
        let end = rest.find(is_white).unwrap_or(rest.len());
        parts.push(&rest[..end]);
        rest = rest[end..].trim_start_matches(is_white);
    }
    parts
}

fn is_white(c: char) -> bool {
    c.is_ascii() && is_space(c as u8)
}

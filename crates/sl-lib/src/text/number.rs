// SPDX-License-Identifier: GPL-3.0-or-later
//! Numbers as text, as C's `printf` writes them: `%f`, `%e` and `%g`.
//! Source: C99, 7.19.6.1. Tests: `tests/strings.rs`, against C's.

/// How a number is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Notation {
    /// `%f`: digits behind the point.
    Fixed,
    /// `%e`: a power of ten, of two digits or more.
    Scientific,
    /// `%g`: the shorter one, without zeros at the end.
    General,
}

/// The digits of a finite number, without its sign; `keep` keeps a redundant point and zeros, as `#` does.
#[must_use]
pub fn digits(value: f64, notation: Notation, precision: usize, keep: bool) -> String {
    let value = value.abs();
    match notation {
        Notation::Fixed => with_point(format!("{value:.precision$}"), keep && precision == 0),
        Notation::Scientific => {
            let (mantissa, exponent) = scientific(value, precision);
            let mantissa = with_point(mantissa, keep && precision == 0);
            format!("{mantissa}{}", power(exponent))
        }
        Notation::General => {
            let precision = precision.max(1);
            let (mantissa, exponent) = scientific(value, precision - 1);
            let is_small = exponent < -4 || exponent >= precision as i32;
            let (text, tail) = if is_small {
                (mantissa, power(exponent))
            } else {
                let decimals = (precision as i32 - 1 - exponent) as usize;
                (format!("{value:.decimals$}"), String::new())
            };
            let text = if keep {
                let dot = !text.contains('.');
                with_point(text, dot)
            } else if text.contains('.') {
                text.trim_end_matches('0').trim_end_matches('.').to_owned()
            } else {
                text
            };
            text + &tail
        }
    }
}

fn with_point(mut text: String, point: bool) -> String {
    if point {
        text.push('.');
    }
    text
}

/// Mantissa, with as many digits behind its point, and power of ten.
fn scientific(value: f64, precision: usize) -> (String, i32) {
    let text = format!("{value:.precision$e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    (mantissa.to_owned(), exponent.parse().unwrap_or(0))
}

fn power(exponent: i32) -> String {
    format!("e{}{:02}", if exponent < 0 { '-' } else { '+' }, exponent.abs())
}

/// `%.{precision}g` of any number, 1 to 40 digits.
#[must_use]
pub fn general(value: f64, precision: usize) -> String {
    let sign = if value.is_sign_negative() { "-" } else { "" };
    if value.is_nan() {
        return format!("{sign}nan");
    }
    if value.is_infinite() {
        return format!("{sign}inf");
    }
    format!("{sign}{}", digits(value, Notation::General, precision.clamp(1, 40), false))
}

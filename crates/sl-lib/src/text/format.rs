// SPDX-License-Identifier: GPL-3.0-or-later
//! `format`, `printf`, `error`, `warning` and `fprintf`: text with conversions.
//! Source: OSL 1.14: each `%` takes one argument; an array or a triple is written element by element with a space between;
//! conversions that do not fit the value are repaired. Numbers are written as by C, strings are
//! left-justified, as in fmtlib, which OSL prints with. Differs: `%u`, `*` and length modifiers, on which OSL
//! prints a complaint of fmtlib, have their meaning in C, or none. Invariants: any text is a format; widths
//! and precisions are at most 512. Tests: `tests/strings.rs`.

use super::number::{Notation, digits};

/// Wider fields and more digits than that are not written.
const LARGEST: usize = 512;

/// The value of a conversion: all elements of one argument, triples and matrices as their floats. Closures
/// come as text.
#[derive(Clone, Copy, Debug)]
pub enum Argument<'a> {
    /// Whole numbers.
    Ints(&'a [i32]),
    /// Floats.
    Floats(&'a [f32]),
    /// Strings.
    Strings(&'a [&'a str]),
}

/// A format that was read, to be filled many times.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Format {
    pieces: Vec<Piece>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Piece {
    Text(String),
    Placeholder(Spec),
}

/// A `%` with all up to its letter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Spec {
    left: bool,
    plus: bool,
    space: bool,
    alternate: bool,
    zeros: bool,
    width: usize,
    precision: Option<usize>,
    letter: u8,
}

/// There are more placeholders than arguments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooFewArguments {
    /// The number of placeholders.
    pub placeholders: usize,
    /// How many arguments.
    pub arguments: usize,
}

impl std::fmt::Display for TooFewArguments {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "Mismatch between format string and arguments: {} values are to be written, but there are {}",
            self.placeholders, self.arguments
        )
    }
}

impl std::error::Error for TooFewArguments {}

impl Format {
    /// Reads a format. Every text is valid: a `%` without a conversion letter is text.
    #[must_use]
    pub fn new(format: &str) -> Self {
        let mut pieces = Vec::new();
        let mut text = String::new();
        let mut rest = format;
        while let Some(at) = rest.find('%') {
            text.push_str(&rest[..at]);
            rest = &rest[at + 1..];
            if let Some(after) = rest.strip_prefix('%') {
                text.push('%');
                rest = after;
            } else if let Some((spec, after)) = Spec::read(rest) {
                if !text.is_empty() {
                    pieces.push(Piece::Text(std::mem::take(&mut text)));
                }
                pieces.push(Piece::Placeholder(spec));
                rest = after;
            } else {
                text.push('%');
            }
        }
        text.push_str(rest);
        if !text.is_empty() {
            pieces.push(Piece::Text(text));
        }
        Self { pieces }
    }

    /// How many arguments it takes.
    #[must_use]
    pub fn placeholders(&self) -> usize {
        self.pieces.iter().filter(|piece| matches!(piece, Piece::Placeholder(_))).count()
    }

    /// The text with its placeholders filled. Arguments without a placeholder are not written.
    ///
    /// # Errors
    /// If there are fewer arguments than placeholders.
    pub fn fill(&self, arguments: &[Argument]) -> Result<String, TooFewArguments> {
        if arguments.len() < self.placeholders() {
            return Err(TooFewArguments { placeholders: self.placeholders(), arguments: arguments.len() });
        }
        let mut arguments = arguments.iter();
        let mut out = String::new();
        for piece in &self.pieces {
            match piece {
                Piece::Text(text) => out.push_str(text),
                Piece::Placeholder(spec) => spec.write(arguments.next(), &mut out),
            }
        }
        Ok(out)
    }
}

impl Spec {
    /// Reads the conversion after a `%`, and the rest; `None` if there is no letter.
    fn read(text: &str) -> Option<(Self, &str)> {
        let end = text.bytes().position(|c| b"cdefgimnopsuvxXEFG".contains(&c))?;
        let mut spec = Self { letter: text.as_bytes()[end], ..Self::default() };
        let mut number: Option<usize> = None;
        for c in text[..end].bytes() {
            match c {
                b'-' => spec.left = true,
                b'+' => spec.plus = true,
                b' ' => spec.space = true,
                b'#' => spec.alternate = true,
                b'0' if number.is_none() && spec.precision.is_none() => spec.zeros = true,
                b'0'..=b'9' => {
                    let value = (number.unwrap_or(0) * 10 + usize::from(c - b'0')).min(LARGEST);
                    number = Some(value);
                    if spec.precision.is_some() { spec.precision = number } else { spec.width = value }
                }
                b'.' => (number, spec.precision) = (None, Some(0)),
                _ => {}
            }
        }
        Some((spec, &text[end + 1..]))
    }

    fn write(self, argument: Option<&Argument>, out: &mut String) {
        let mut first = true;
        let mut put = |field: String| {
            if !std::mem::take(&mut first) {
                out.push(' ');
            }
            out.push_str(&field);
        };
        match argument {
            Some(Argument::Ints(values)) => values.iter().for_each(|&x| put(self.int(x))),
            Some(Argument::Floats(values)) => values.iter().for_each(|&x| put(self.float(x))),
            Some(Argument::Strings(values)) => values.iter().for_each(|x| put(self.string(x))),
            None => {}
        }
    }

    /// Sign, prefix and digits, padded to the requested width.
    fn padded(self, sign: &str, prefix: &str, digits: &str, zeros: bool) -> String {
        let fill = self.width.saturating_sub(sign.len() + prefix.len() + digits.len());
        let fill = if self.left {
            return format!("{sign}{prefix}{digits}{}", " ".repeat(fill));
        } else if zeros {
            return format!("{sign}{prefix}{}{digits}", "0".repeat(fill));
        } else {
            " ".repeat(fill)
        };
        format!("{fill}{sign}{prefix}{digits}")
    }

    fn sign(self, negative: bool) -> &'static str {
        match (negative, self.plus, self.space) {
            (true, ..) => "-",
            (_, true, _) => "+",
            (.., true) => " ",
            _ => "",
        }
    }

    fn int(self, value: i32) -> String {
        let size = value.unsigned_abs();
        let (sign, prefix, digits) = match self.letter {
            b'x' => (self.sign(false), "0x", format!("{:x}", value as u32)),
            b'X' => (self.sign(false), "0X", format!("{:X}", value as u32)),
            b'o' => (self.sign(value < 0), "0", format!("{size:o}")),
            b'u' => (self.sign(false), "", (value as u32).to_string()),
            _ => (self.sign(value < 0), "", size.to_string()),
        };
        let prefix = if self.alternate { prefix } else { "" };
        let least = self.precision.unwrap_or(0);
        let digits = format!("{}{digits}", "0".repeat(least.saturating_sub(digits.len())));
        self.padded(sign, prefix, &digits, self.zeros && self.precision.is_none())
    }

    fn float(self, value: f32) -> String {
        let sign = self.sign(value.is_sign_negative());
        if !value.is_finite() {
            return self.padded(sign, "", if value.is_nan() { "nan" } else { "inf" }, false);
        }
        let notation = match self.letter {
            b'e' | b'E' => Notation::Scientific,
            b'g' | b'G' => Notation::General,
            _ => Notation::Fixed,
        };
        let mut digits = digits(value.into(), notation, self.precision.unwrap_or(6), self.alternate);
        if self.letter.is_ascii_uppercase() {
            digits.make_ascii_uppercase();
        }
        self.padded(sign, "", &digits, self.zeros)
    }

    fn string(self, value: &str) -> String {
        let length = self.precision.map_or(value.len(), |letters| {
            value.char_indices().nth(letters).map_or(value.len(), |(at, _)| at)
        });
        let value = &value[..length];
        let fill = self.width.saturating_sub(value.chars().count());
        format!("{value}{}", " ".repeat(fill))
    }
}

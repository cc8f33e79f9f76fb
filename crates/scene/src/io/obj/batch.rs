// SPDX-License-Identifier: GPL-3.0-or-later
//! Statements of an OBJ file in batches: numbers and corners that are written as nearly all files write them are
//! read, other statements are kept as text. So batches can be made on one thread and used on another, in the order
//! of the file. Memory: one batch. Tests: `tests/obj.rs`.

use std::io::BufRead;

use super::plain;
use crate::io::Error;
use crate::io::lines::LogicalLines;

/// Statements of a batch at most.
const STATEMENTS: usize = 1 << 13;
/// Bytes of text of a batch, but for the last line.
const TEXT: usize = 1 << 20;

/// Indices of a corner's position, texture coordinate and normal as written.
pub(super) type WrittenCorner = [Option<i64>; 3];

/// Some statements.
#[derive(Default)]
pub(super) struct Batch {
    statements: Vec<Statement>,
    numbers: Vec<f64>,
    corners: Vec<WrittenCorner>,
    text: String,
}

struct Statement {
    line: u64,
    kind: Kind,
}

/// The kinds of statements, and how much of the batch's lists belongs to them.
enum Kind {
    Position,
    Texcoord,
    Normal,
    Face { corners: usize },
    Text { bytes: usize },
}

/// A statement of a batch.
pub(super) enum Read<'a> {
    /// `v` with three numbers.
    Position([f64; 3]),
    /// `vt` with two or three numbers, without the third.
    Texcoord([f32; 2]),
    /// `vn` with three numbers.
    Normal([f32; 3]),
    /// `f`.
    Face(&'a [WrittenCorner]),
    /// Any other one.
    Text(&'a str),
}

impl Batch {
    /// Reads the next lines; `false` behind the last one. What was read before an error is kept.
    pub(super) fn fill<R: BufRead>(&mut self, lines: &mut LogicalLines<R>) -> Result<bool, Error> {
        while self.statements.len() < STATEMENTS && self.text.len() < TEXT {
            let Some((line, text)) = lines.next()? else { return Ok(false) };
            let kind = self.add(text);
            self.statements.push(Statement { line, kind });
        }
        Ok(true)
    }

    fn add(&mut self, text: &str) -> Kind {
        let [numbers, corners] = [self.numbers.len(), self.corners.len()];
        if let Some(kind) = self.add_plain(text.as_bytes()) {
            return kind;
        }
        self.numbers.truncate(numbers);
        self.corners.truncate(corners);
        self.text.push_str(text);
        Kind::Text { bytes: text.len() }
    }

    /// A statement of plain numbers.
    fn add_plain(&mut self, text: &[u8]) -> Option<Kind> {
        let is_space = |byte: &u8| matches!(byte, b' ' | b'\t' | b'\x0c');
        let end = text.iter().position(is_space)?;
        let mut tokens = text[end..].split(is_space).filter(|token| !token.is_empty());
        match &text[..end] {
            b"v" => {
                self.add_numbers(&mut tokens, 3)?;
                tokens.next().is_none().then_some(Kind::Position)
            }
            b"vn" => {
                self.add_numbers(&mut tokens, 3)?;
                tokens.next().is_none().then_some(Kind::Normal)
            }
            b"vt" => {
                self.add_numbers(&mut tokens, 2)?;
                let is_third_plain = tokens.next().is_none_or(|third| plain::double(third).is_some());
                (is_third_plain && tokens.next().is_none()).then_some(Kind::Texcoord)
            }
            b"f" => {
                let before = self.corners.len();
                for token in tokens {
                    self.corners.push(plain::corner(token)?);
                }
                Some(Kind::Face { corners: self.corners.len() - before })
            }
            _ => None,
        }
    }

    fn add_numbers<'a>(&mut self, tokens: &mut impl Iterator<Item = &'a [u8]>, count: usize) -> Option<()> {
        for _ in 0..count {
            self.numbers.push(plain::double(tokens.next()?)?);
        }
        Some(())
    }

    /// The statements with their lines, in order.
    pub(super) fn statements(&self) -> impl Iterator<Item = (u64, Read<'_>)> {
        let (mut numbers, mut corners, mut text) = (&self.numbers[..], &self.corners[..], &self.text[..]);
        self.statements.iter().map(move |statement| {
            let mut next = || {
                let (first, rest) = numbers.split_first().unwrap_or((&0.0, &[]));
                numbers = rest;
                *first
            };
            let read = match statement.kind {
                Kind::Position => Read::Position([(); 3].map(|()| next())),
                Kind::Texcoord => Read::Texcoord([(); 2].map(|()| next() as f32)),
                Kind::Normal => Read::Normal([(); 3].map(|()| next() as f32)),
                Kind::Face { corners: count } => {
                    let (face, rest) = corners.split_at(count);
                    corners = rest;
                    Read::Face(face)
                }
                Kind::Text { bytes } => {
                    let (line, rest) = text.split_at(bytes);
                    text = rest;
                    Read::Text(line)
                }
            };
            (statement.line, read)
        })
    }
}

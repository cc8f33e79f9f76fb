// SPDX-License-Identifier: GPL-3.0-or-later
//! The numbers of a PLY body, one after the other, in each of the three encodings.
//! Source: G. Turk, The PLY polygon file format, 1994. A text has one element to a line; numbers are written as C
//! programs do, `nan` and `.5` included. Memory: one line. Tests: `tests/ply.rs`.

use std::io::{BufRead, Read};

use super::header::{Encoding, Property, Scalar};

/// Bytes that a line of a text body may have.
const LONGEST_LINE: u64 = 16 << 20;

/// Why there is no number.
pub(super) enum Fault {
    /// The file ends.
    End,
    /// A word that is no number, or none.
    Token,
    /// A list of a negative length.
    Negative,
    /// A line that is no line.
    TooLong,
    System(std::io::Error),
}

impl From<std::io::Error> for Fault {
    fn from(error: std::io::Error) -> Self {
        match error.kind() {
            std::io::ErrorKind::UnexpectedEof => Self::End,
            _ => Self::System(error),
        }
    }
}

/// Reads numbers.
pub(super) struct Numbers<'a, R> {
    input: &'a mut R,
    encoding: Encoding,
    /// Lines read so far, of a text.
    line: u64,
    /// The line of a text, or bytes that were read ahead.
    text: Vec<u8>,
    /// Start of the next word or number of `text`.
    at: usize,
}

/// Bytes that are read ahead, if no element is longer.
const AHEAD: usize = 1 << 16;

impl<'a, R: BufRead> Numbers<'a, R> {
    /// Of a body that begins after this number of lines.
    pub(super) fn new(input: &'a mut R, encoding: Encoding, lines: u64) -> Self {
        Self { input, encoding, line: lines, text: Vec::new(), at: 0 }
    }

    /// The line of the last element, of a text.
    pub(super) fn line(&self) -> Option<u64> {
        (self.encoding == Encoding::Text).then_some(self.line)
    }

    /// The line itself.
    pub(super) fn text(&self) -> String {
        String::from_utf8_lossy(&self.text).into_owned()
    }

    /// Goes to the next element.
    pub(super) fn begin(&mut self) -> Result<(), Fault> {
        let there = self.encoding != Encoding::Text || self.next_line()?;
        if there { Ok(()) } else { Err(Fault::End) }
    }

    /// Whether anything follows; of a text, anything but blank lines.
    pub(super) fn has_more(&mut self) -> std::io::Result<bool> {
        match self.encoding {
            Encoding::Text => match self.next_line() {
                Ok(more) => Ok(more),
                Err(Fault::System(error)) => Err(error),
                Err(_) => Ok(true),
            },
            _ => Ok(self.at < self.text.len() || !self.input.fill_buf()?.is_empty()),
        }
    }

    /// Reads the next line that is not blank; `false` at the end.
    fn next_line(&mut self) -> Result<bool, Fault> {
        loop {
            self.text.clear();
            self.at = 0;
            self.line += 1;
            if self.input.take(LONGEST_LINE).read_until(b'\n', &mut self.text)? == 0 {
                return Ok(false);
            }
            if self.text.len() as u64 == LONGEST_LINE && self.text.last() != Some(&b'\n') {
                return Err(Fault::TooLong);
            }
            if !self.text.trim_ascii().is_empty() {
                return Ok(true);
            }
        }
    }

    /// The next word of the line.
    fn token(&mut self) -> Result<&str, Fault> {
        let rest = &self.text[self.at..];
        let start = rest.iter().position(|b| !b.is_ascii_whitespace()).ok_or(Fault::Token)?;
        let rest = &rest[start..];
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.at += start + length;
        std::str::from_utf8(&rest[..length]).map_err(|_| Fault::Token)
    }

    /// Whether the line of a text has no more words.
    pub(super) fn is_spent(&self) -> bool {
        self.encoding == Encoding::Text && self.text[self.at..].trim_ascii().is_empty()
    }

    #[inline]
    fn bytes<const N: usize>(&mut self) -> Result<[u8; N], Fault> {
        let mut bytes = [0; N];
        match self.text.get(self.at..self.at + N) {
            Some(ahead) => {
                bytes.copy_from_slice(ahead);
                self.at += N;
            }
            None => {
                let ahead = self.text.len() - self.at;
                bytes[..ahead].copy_from_slice(&self.text[self.at..]);
                self.text.clear();
                self.at = 0;
                self.input.read_exact(&mut bytes[ahead..])?;
            }
        }
        if self.encoding == Encoding::BigEndian {
            bytes.reverse();
        }
        Ok(bytes)
    }

    /// Reads at least this many bytes of an encoding of bytes ahead, where the file has as many.
    pub(super) fn read_ahead(&mut self, size: usize) -> Result<(), Fault> {
        if self.text.len() - self.at < size {
            self.text.drain(..self.at);
            self.at = 0;
            let more = size.max(AHEAD) - self.text.len();
            self.input.take(more as u64).read_to_end(&mut self.text)?;
        }
        Ok(())
    }

    /// The bytes that were read ahead.
    pub(super) fn ahead(&self) -> &[u8] {
        &self.text[self.at..]
    }

    /// Steps over bytes that were read ahead.
    pub(super) fn step(&mut self, bytes: usize) {
        self.at += bytes;
    }

    /// The encoding.
    pub(super) fn encoding(&self) -> Encoding {
        self.encoding
    }

    /// A number as a double, which holds each of them.
    pub(super) fn float(&mut self, of_type: Scalar) -> Result<f64, Fault> {
        if self.encoding == Encoding::Text {
            return Ok(match of_type {
                // As a float, so that it is rounded once.
                Scalar::F32 => f64::from(self.token()?.parse::<f32>().map_err(|_| Fault::Token)?),
                Scalar::F64 => self.token()?.parse().map_err(|_| Fault::Token)?,
                _ => self.integer(of_type)? as f64,
            });
        }
        Ok(match of_type {
            Scalar::F32 => f64::from(f32::from_le_bytes(self.bytes()?)),
            Scalar::F64 => f64::from_le_bytes(self.bytes()?),
            _ => self.integer(of_type)? as f64,
        })
    }

    /// A number of an integer type.
    pub(super) fn integer(&mut self, of_type: Scalar) -> Result<i64, Fault> {
        if self.encoding == Encoding::Text {
            let number: i64 = self.token()?.parse().map_err(|_| Fault::Token)?;
            let range = match of_type {
                Scalar::I8 => i64::from(i8::MIN)..=i64::from(i8::MAX),
                Scalar::U8 => 0..=i64::from(u8::MAX),
                Scalar::I16 => i64::from(i16::MIN)..=i64::from(i16::MAX),
                Scalar::U16 => 0..=i64::from(u16::MAX),
                Scalar::I32 => i64::from(i32::MIN)..=i64::from(i32::MAX),
                _ => 0..=i64::from(u32::MAX),
            };
            return if range.contains(&number) { Ok(number) } else { Err(Fault::Token) };
        }
        Ok(match of_type {
            Scalar::I8 => i64::from(i8::from_le_bytes(self.bytes()?)),
            Scalar::U8 => i64::from(u8::from_le_bytes(self.bytes()?)),
            Scalar::I16 => i64::from(i16::from_le_bytes(self.bytes()?)),
            Scalar::U16 => i64::from(u16::from_le_bytes(self.bytes()?)),
            Scalar::I32 => i64::from(i32::from_le_bytes(self.bytes()?)),
            Scalar::U32 => i64::from(u32::from_le_bytes(self.bytes()?)),
            // No caller reads an integer where the header declares a float.
            Scalar::F32 | Scalar::F64 => return Err(Fault::Token),
        })
    }

    /// Appends `length` numbers of an integer type.
    pub(super) fn integers(
        &mut self,
        of_type: Scalar,
        length: u64,
        into: &mut Vec<i64>,
    ) -> Result<(), Fault> {
        let bytes = usize::try_from(length).unwrap_or(usize::MAX).saturating_mul(4);
        let is_usual =
            self.encoding == Encoding::LittleEndian && matches!(of_type, Scalar::I32 | Scalar::U32);
        if is_usual && bytes <= AHEAD {
            // The usual types at once.
            self.read_ahead(bytes)?;
            if let Some(ahead) = self.ahead().get(..bytes) {
                let numbers = ahead.as_chunks::<4>().0.iter().map(|&bytes| u32::from_le_bytes(bytes));
                let is_signed = of_type == Scalar::I32;
                into.extend(numbers.map(|x| if is_signed { i64::from(x as i32) } else { i64::from(x) }));
                self.at += bytes;
                return Ok(());
            }
        }
        (0..length).try_for_each(|_| {
            into.push(self.integer(of_type)?);
            Ok(())
        })
    }

    /// The length of a list.
    pub(super) fn length(&mut self, of_type: Scalar) -> Result<u64, Fault> {
        let text = self.encoding == Encoding::Text;
        u64::try_from(self.integer(of_type)?).map_err(|_| if text { Fault::Token } else { Fault::Negative })
    }

    /// Steps over a property.
    pub(super) fn skip(&mut self, property: &Property) -> Result<(), Fault> {
        let count = match property.count {
            Some(count) => self.length(count)?,
            None => 1,
        };
        if self.encoding == Encoding::Text {
            return (0..count).try_for_each(|_| self.float(property.item).map(drop));
        }
        let bytes = count.saturating_mul(property.item.size() as u64);
        let ahead = self.text.len() - self.at;
        if bytes <= ahead as u64 {
            self.at += bytes as usize;
            return Ok(());
        }
        self.text.clear();
        self.at = 0;
        let bytes = bytes - ahead as u64;
        let skipped = std::io::copy(&mut self.input.take(bytes), &mut std::io::sink())?;
        if skipped == bytes { Ok(()) } else { Err(Fault::End) }
    }
}

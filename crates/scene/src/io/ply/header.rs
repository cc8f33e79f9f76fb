// SPDX-License-Identifier: GPL-3.0-or-later
//! PLY headers: checked line by line, then read by `ply-rs-bw`.
//! Source: G. Turk, The PLY polygon file format, 1994. Lines end with LF, CRLF or CR; spaces and tabs are alike.
//! Invariant of [`Header`]: names are unique, every element has a property, list lengths are integers.
//! Proof: `tests/ply.rs::headers_of_all_kinds`, `tests/broken_files.rs`.

use std::io::BufRead;
use std::path::Path;

use ply_rs_bw::parser::Parser;
use ply_rs_bw::ply::{DefaultElement, ElementDef, Encoding, PropertyType, ScalarType};

use crate::io::Error;
use crate::io::error::quoted;

/// Bytes that a header may have.
const LONGEST: usize = 1 << 20;

const TYPES: &str =
    "char int8 uchar uint8 short int16 ushort uint16 int int32 uint uint32 float float32 double float64";

/// A header that was checked.
pub(super) struct Header {
    pub(super) encoding: Encoding,
    /// Elements in the order of the body, without those that have no property and so no bytes.
    pub(super) elements: Vec<ElementDef>,
    /// Bytes after the header.
    pub(super) body_bytes: u64,
    /// Lines of the header.
    pub(super) lines: u64,
}

/// Reads the header of a file of `length` bytes and leaves `input` at the first byte of the body.
pub(super) fn read(input: &mut impl BufRead, length: u64, path: &Path) -> Result<Header, Error> {
    let mut lines = HeaderLines { input, path, number: 0, bytes: 0, crlf: false };
    let error = |line, problem: &str, remedy: &str| Err(Error::data(path, Some(line), problem, remedy));
    if lines.next()? != "ply" {
        return error(1, "not a PLY file", "expected `ply` in its first line");
    }
    let mut checker = Checker::default();
    let mut plain = String::from("ply\n");
    loop {
        let line = lines.next()?;
        if let Err((problem, remedy)) = checker.check(&line) {
            return error(lines.number, &problem, &remedy);
        }
        if !line.starts_with("comment") && !line.starts_with("obj_info") && !line.is_empty() {
            plain.push_str(&line);
            plain.push('\n');
        }
        if line == "end_header" {
            break;
        }
    }
    let (body_bytes, number) = (length.saturating_sub(lines.bytes as u64), lines.number);
    if !checker.has_format {
        return error(
            number,
            "no `format` line in the header",
            "expected `format ascii 1.0` or a binary format",
        );
    }
    let parsed = Parser::<DefaultElement>::new().read_ply_header(&mut plain.as_bytes());
    let Ok(parsed) = parsed else {
        return error(
            number,
            "the header cannot be read",
            "expected `format`, `element` and `property` lines",
        );
    };
    let elements = parsed.elements.into_iter().map(|(_, e)| e).filter(|e| !e.properties.is_empty()).collect();
    Ok(Header { encoding: parsed.encoding, elements, body_bytes, lines: number })
}

impl Header {
    /// Refuses counts that the file is too short for, before anyone takes memory for them.
    pub(super) fn check_length(&self, path: &Path) -> Result<(), Error> {
        let mut left = self.body_bytes;
        for element in &self.elements {
            let least = least_bytes(element, self.encoding).saturating_mul(element.count as u64);
            // The last number of a text may end with the file.
            let slack = u64::from(self.encoding == Encoding::Ascii);
            if least > left + slack {
                let problem = format!(
                    "{} `{}` elements of at least {least} bytes are declared, but only {left} bytes follow",
                    element.count, element.name
                );
                return Err(Error::data(path, None, problem, "the file may have been cut off"));
            }
            left = left.saturating_sub(least);
        }
        Ok(())
    }
}

/// The fewest bytes that one element takes.
pub(super) fn least_bytes(element: &ElementDef, encoding: Encoding) -> u64 {
    let properties = element.properties.iter().map(|(_, p)| &p.data_type);
    match encoding {
        // A digit and what separates it from the next.
        Encoding::Ascii => 2 * properties.count() as u64,
        _ => properties
            .map(|data_type| match data_type {
                PropertyType::Scalar(t) | PropertyType::List(t, _) => size(t),
            })
            .sum(),
    }
}

/// Bytes of a scalar in a binary file.
pub(super) fn size(scalar: &ScalarType) -> u64 {
    match scalar {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    }
}

/// Lines of a header: trimmed, with single spaces.
struct HeaderLines<'a, R> {
    input: &'a mut R,
    path: &'a Path,
    number: u64,
    bytes: usize,
    /// Whether CR is followed by LF: after `end_header` a lone LF would be data.
    crlf: bool,
}

impl<R: BufRead> HeaderLines<'_, R> {
    fn next(&mut self) -> Result<String, Error> {
        self.number += 1;
        let mut line = Vec::new();
        loop {
            match self.byte()? {
                Some(b'\n') => break,
                Some(b'\r') => {
                    if self.number == 1 {
                        self.crlf = self.peek()? == Some(b'\n');
                    }
                    if self.crlf && self.peek()? == Some(b'\n') {
                        self.byte()?;
                    }
                    break;
                }
                Some(byte) => line.push(byte),
                None if line.trim_ascii() == b"end_header" => break,
                None => return Err(self.error("the file ends in its header", "expected `end_header`")),
            }
            if self.bytes > LONGEST || (self.number == 1 && line.len() > 16) {
                let problem = if self.number == 1 { "not a PLY file" } else { "a header of more than 1 MiB" };
                return Err(self.error(problem, "expected `ply`, then the header, then `end_header`"));
            }
        }
        let text = String::from_utf8_lossy(&line);
        let text = if self.number == 1 { text.trim_start_matches('\u{feff}') } else { &text };
        Ok(text.split_whitespace().collect::<Vec<_>>().join(" "))
    }

    fn error(&self, problem: &str, remedy: &str) -> Error {
        Error::data(self.path, Some(self.number), problem, remedy)
    }

    fn peek(&mut self) -> Result<Option<u8>, Error> {
        let available = self.input.fill_buf().map_err(|e| Error::system(self.path, &e))?;
        Ok(available.first().copied())
    }

    fn byte(&mut self) -> Result<Option<u8>, Error> {
        let byte = self.peek()?;
        if byte.is_some() {
            self.input.consume(1);
            self.bytes += 1;
        }
        Ok(byte)
    }
}

/// What the lines of a header have said so far.
#[derive(Default)]
struct Checker {
    has_format: bool,
    elements: Vec<String>,
    properties: Vec<String>,
}

impl Checker {
    /// The error is what is wrong and what would be right.
    fn check(&mut self, line: &str) -> Result<(), (String, String)> {
        let words: Vec<&str> = line.split(' ').collect();
        match words[..] {
            ["" | "comment" | "obj_info", ..] | ["end_header"] => Ok(()),
            ["format", "ascii" | "binary_little_endian" | "binary_big_endian", "1.0"] if !self.has_format => {
                self.has_format = true;
                Ok(())
            }
            ["format", ..] => Err((
                format!("bad format line {}", quoted(line)),
                "expected once `format ascii 1.0`, `format binary_little_endian 1.0` or `format binary_big_endian 1.0`".into(),
            )),
            ["element", name, count] => {
                let remedy = || "expected `element NAME COUNT`".to_owned();
                is_name(name).then_some(()).ok_or_else(|| (format!("bad name {}", quoted(name)), remedy()))?;
                if !count.bytes().all(|b| b.is_ascii_digit()) || count.parse::<usize>().is_err() {
                    return Err((format!("bad count {}", quoted(count)), remedy()));
                }
                self.properties.clear();
                once(&mut self.elements, name)
            }
            ["property", "list", length, item, name] => {
                is_type(length)?;
                is_type(item)?;
                if length.starts_with('f') || length.starts_with('d') {
                    return Err((format!("list lengths of type {}", quoted(length)), "expected an integer type".into()));
                }
                self.property(name)
            }
            ["property", of_type, name] => {
                is_type(of_type)?;
                self.property(name)
            }
            _ => Err((
                format!("bad header line {}", quoted(line)),
                "expected `format`, `comment`, `element NAME COUNT`, `property TYPE NAME` or `end_header`".into(),
            )),
        }
    }

    fn property(&mut self, name: &str) -> Result<(), (String, String)> {
        if self.elements.is_empty() {
            return Err((
                "a property before the first element".into(),
                "expected `element NAME COUNT` first".into(),
            ));
        }
        if !is_name(name) {
            return Err((
                format!("bad name {}", quoted(name)),
                "expected letters, digits, `_` and `-`".into(),
            ));
        }
        once(&mut self.properties, name)
    }
}

fn is_type(word: &str) -> Result<(), (String, String)> {
    match TYPES.split(' ').any(|t| t == word) {
        true => Ok(()),
        false => Err((format!("unknown type {}", quoted(word)), format!("valid are {TYPES}"))),
    }
}

/// Names that `ply-rs-bw` takes.
fn is_name(word: &str) -> bool {
    let mut bytes = word.bytes();
    bytes.next().is_some_and(|b| b.is_ascii_alphabetic() || b == b'_')
        && bytes.all(|b| b.is_ascii_alphanumeric() || b == b'_' || b == b'-')
}

fn once(seen: &mut Vec<String>, name: &str) -> Result<(), (String, String)> {
    if seen.iter().any(|s| s == name) {
        return Err((format!("{} is declared twice", quoted(name)), "names must differ".into()));
    }
    seen.push(name.to_owned());
    Ok(())
}

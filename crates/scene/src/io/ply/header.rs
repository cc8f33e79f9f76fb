// SPDX-License-Identifier: GPL-3.0-or-later
//! PLY headers.
//! Source: G. Turk, The PLY polygon file format, 1994. Lines end with LF, CRLF or CR; spaces and tabs are alike.
//! Invariant of [`Header`]: names are unique, every element has a property, list lengths are integers.
//! Tests: `tests/ply.rs::headers_of_all_kinds`, `tests/broken_files.rs`.

use std::collections::HashSet;
use std::io::BufRead;
use std::path::Path;

use crate::io::error::quoted;
use crate::io::{Error, Oddity, Warnings};

/// Bytes that a header may have.
const LONGEST: usize = 1 << 20;

const TYPES: &str =
    "char int8 uchar uint8 short int16 ushort uint16 int int32 uint uint32 float float32 double float64";

/// How the numbers of a body are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Text,
    LittleEndian,
    BigEndian,
}

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn of(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes in a binary file.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    pub(super) fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }
}

/// A property of an element: a number, or a list of numbers behind their count.
#[derive(Clone, Debug)]
pub(super) struct Property {
    pub(super) name: String,
    /// The type of a list's count.
    pub(super) count: Option<Scalar>,
    pub(super) item: Scalar,
}

/// A kind of element and how many there are.
#[derive(Clone, Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

impl Element {
    /// The fewest bytes that one takes.
    pub(super) fn least_bytes(&self, encoding: Encoding) -> u64 {
        match encoding {
            // A digit and a separator for each number of a point; unused properties may be missing.
            Encoding::Text => 2 * self.properties.len().min(3) as u64,
            _ => self.properties.iter().map(|p| p.count.unwrap_or(p.item).size() as u64).sum(),
        }
    }
}

/// A header that was checked.
pub(super) struct Header {
    pub(super) encoding: Encoding,
    /// Elements in the order of the body, without those that have no property and so no bytes.
    pub(super) elements: Vec<Element>,
    /// Bytes after the header.
    pub(super) body_bytes: u64,
    /// Lines of the header.
    pub(super) lines: u64,
}

/// Reads the header of a file of `length` bytes and leaves `input` at the first byte of the body.
pub(super) fn read(
    input: &mut impl BufRead,
    length: u64,
    path: &Path,
    warnings: &mut Warnings,
) -> Result<Header, Error> {
    let mut lines = HeaderLines { input, path, number: 0, bytes: 0, crlf: false };
    let error = |line, problem: &str, remedy: &str| Err(Error::data(path, Some(line), problem, remedy));
    if lines.next()? != "ply" {
        return error(1, "not a PLY file", "expected `ply` in its first line");
    }
    let mut declared = Declared::default();
    loop {
        let line = lines.next()?;
        if line == "end_header" {
            break;
        }
        if declared.is_remark(&line) {
            warnings.note(Oddity::BadHeaderLine, path, Some(lines.number), quoted(&line));
        } else if let Err((problem, remedy)) = declared.line(&line) {
            return error(lines.number, &problem, &remedy);
        }
    }
    let (body_bytes, number) = (length.saturating_sub(lines.bytes as u64), lines.number);
    let Some(encoding) = declared.encoding else {
        let remedy = "expected `format ascii 1.0` or a binary format";
        return error(number, "no `format` line in the header", remedy);
    };
    let elements = declared.elements.into_iter().filter(|e| !e.properties.is_empty()).collect();
    Ok(Header { encoding, elements, body_bytes, lines: number })
}

impl Header {
    /// Rejects counts that exceed the file, before memory is taken for them.
    pub(super) fn check_length(&self, path: &Path) -> Result<(), Error> {
        let mut left = self.body_bytes;
        for element in &self.elements {
            let least = element.least_bytes(self.encoding).saturating_mul(element.count);
            // The last number of a text may end with the file.
            let slack = u64::from(self.encoding == Encoding::Text);
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

/// The fault of a line, and the remedy.
type Mistake = (String, String);

/// The declarations of a header so far.
#[derive(Default)]
struct Declared {
    encoding: Option<Encoding>,
    elements: Vec<Element>,
    element_names: HashSet<String>,
    /// Of the last element.
    property_names: HashSet<String>,
}

impl Declared {
    /// Whether a line without a keyword cannot be about the layout of the body: it precedes the first
    /// element. Old exporters put their name there.
    fn is_remark(&self, line: &str) -> bool {
        let keyword = line.split(' ').next().unwrap_or_default();
        let known = ["", "comment", "obj_info", "format", "element", "property"];
        self.elements.is_empty() && !known.contains(&keyword)
    }

    fn line(&mut self, line: &str) -> Result<(), Mistake> {
        let parts: Vec<&str> = line.split(' ').collect();
        match parts[..] {
            ["" | "comment" | "obj_info", ..] => Ok(()),
            ["format", name, "1.0"] if self.encoding.is_none() && encoding(name).is_some() => {
                self.encoding = encoding(name);
                Ok(())
            }
            ["format", ..] => Err((
                format!("bad format line {}", quoted(line)),
                "expected once `format ascii 1.0`, `format binary_little_endian 1.0` or `format binary_big_endian 1.0`".into(),
            )),
            ["element", name, count] => {
                let digits = count.bytes().all(|b| b.is_ascii_digit());
                let number = count.parse().ok().filter(|_| digits);
                let mistake = || (format!("bad count {}", quoted(count)), "expected `element NAME COUNT`".to_owned());
                let count = number.ok_or_else(mistake)?;
                once(&mut self.element_names, name)?;
                self.property_names.clear();
                self.elements.push(Element { name: name.to_owned(), count, properties: Vec::new() });
                Ok(())
            }
            ["property", "list", count, item, name] => {
                let (of_count, item) = (scalar(count)?, scalar(item)?);
                if !of_count.is_integer() {
                    let problem = format!("list lengths of type {}", quoted(count));
                    return Err((problem, "expected an integer type".into()));
                }
                self.property(name, Some(of_count), item)
            }
            ["property", item, name] => {
                let item = scalar(item)?;
                self.property(name, None, item)
            }
            _ => Err((
                format!("bad header line {}", quoted(line)),
                "expected `format`, `comment`, `element NAME COUNT`, `property TYPE NAME` or `end_header`".into(),
            )),
        }
    }

    fn property(&mut self, name: &str, count: Option<Scalar>, item: Scalar) -> Result<(), Mistake> {
        let Some(element) = self.elements.last_mut() else {
            let problem = "a property before the first element";
            return Err((problem.into(), "expected `element NAME COUNT` first".into()));
        };
        once(&mut self.property_names, name)?;
        element.properties.push(Property { name: name.to_owned(), count, item });
        Ok(())
    }
}

fn encoding(name: &str) -> Option<Encoding> {
    Some(match name {
        "ascii" => Encoding::Text,
        "binary_little_endian" => Encoding::LittleEndian,
        "binary_big_endian" => Encoding::BigEndian,
        _ => return None,
    })
}

fn scalar(token: &str) -> Result<Scalar, Mistake> {
    Scalar::of(token).ok_or_else(|| (format!("unknown type {}", quoted(token)), format!("valid are {TYPES}")))
}

fn once(names: &mut HashSet<String>, name: &str) -> Result<(), Mistake> {
    match names.insert(name.to_owned()) {
        true => Ok(()),
        false => Err((format!("{} is declared twice", quoted(name)), "names must differ".into())),
    }
}

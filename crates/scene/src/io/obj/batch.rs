// SPDX-License-Identifier: GPL-3.0-or-later
//! Statements of a block of an OBJ file: numbers and corners that are written as nearly all files write them are
//! read, other statements are kept as text. So batches are made on any thread and used on one, in the order of the
//! file. Statements of one kind on lines that follow each other are a run. Memory: one block. Tests: `tests/obj.rs`.

use super::plain::{PlainCorner, Words};
use crate::io::Error;
use crate::io::lines::{LONGEST, LogicalLines};
use crate::io::plain::Cursor;

/// Statements of a block.
#[derive(Default)]
pub(super) struct Batch {
    runs: Vec<Run>,
    positions: Vec<[f64; 3]>,
    texcoords: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
    /// Corners of each face.
    faces: Vec<u32>,
    corners: Vec<PlainCorner>,
    text: String,
    /// Physical lines.
    pub(super) lines: u64,
}

/// Statements of one kind, the first of which is on this line of the block.
struct Run {
    line: u64,
    kind: Kind,
    /// Statements, or bytes of a text.
    count: usize,
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Positions,
    Texcoords,
    Normals,
    Faces,
    Text,
}

/// A run of a batch.
pub(super) enum Read<'a> {
    /// `v` with three numbers.
    Positions(&'a [[f64; 3]]),
    /// `vt` with two or three numbers, without the third.
    Texcoords(&'a [[f32; 2]]),
    /// `vn` with three numbers.
    Normals(&'a [[f32; 3]]),
    /// `f`: the number of corners of each, and all corners.
    Faces(&'a [u32], &'a [PlainCorner]),
    /// Any other statement.
    Text(&'a str),
}

#[cfg(test)]
impl std::fmt::Display for Read<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Positions(all) => write!(f, "v {all:?}"),
            Self::Texcoords(all) => write!(f, "vt {all:?}"),
            Self::Normals(all) => write!(f, "vn {all:?}"),
            Self::Faces(counts, corners) => write!(f, "f {counts:?} {corners:?}"),
            Self::Text(text) => f.write_str(text),
        }
    }
}

impl Batch {
    /// Reads the lines of a block. What was read before an error is kept.
    pub(super) fn fill(&mut self, mut lines: LogicalLines<&[u8]>) -> Result<(), Error> {
        self.clear();
        while !lines.rest().is_empty() {
            let plain = self.add_plain(lines.rest());
            // Lines that are too long are refused in the general way.
            if let Some((kind, length)) = plain.filter(|(_, length)| *length <= LONGEST) {
                let line = lines.count() + 1;
                match self.runs.last_mut() {
                    Some(run) if run.kind == kind && run.line + run.count as u64 == line => run.count += 1,
                    _ => self.runs.push(Run { line, kind, count: 1 }),
                }
                lines.skip_line(length);
                continue;
            }
            let Some((line, text)) = lines.next()? else { break };
            self.text.push_str(text);
            self.runs.push(Run { line, kind: Kind::Text, count: text.len() });
        }
        self.lines = lines.count();
        Ok(())
    }

    /// Forgets all statements.
    pub(super) fn clear(&mut self) {
        self.runs.clear();
        self.positions.clear();
        self.texcoords.clear();
        self.normals.clear();
        self.faces.clear();
        self.corners.clear();
        self.text.clear();
    }

    /// A line that is a statement of plain numbers, and its bytes; otherwise nothing is added.
    #[inline(always)]
    fn add_plain(&mut self, bytes: &[u8]) -> Option<(Kind, usize)> {
        let mut cursor = Cursor::new(bytes);
        let kind = match *bytes {
            [b'v', b' ' | b'\t', ..] => {
                cursor.word(b"v")?;
                let position = numbers(&mut cursor)?;
                cursor.end()?;
                self.positions.push(position);
                Kind::Positions
            }
            [b'v', b'n', ..] => {
                cursor.word(b"vn")?;
                let normal: [f64; 3] = numbers(&mut cursor)?;
                cursor.end()?;
                self.normals.push(normal.map(|x| x as f32));
                Kind::Normals
            }
            [b'v', b't', ..] => {
                cursor.word(b"vt")?;
                let texcoord: [f64; 2] = numbers(&mut cursor)?;
                if cursor.end().is_none() {
                    cursor.double()?;
                    cursor.end()?;
                }
                self.texcoords.push(texcoord.map(|x| x as f32));
                Kind::Texcoords
            }
            [b'f', b' ' | b'\t', ..] => {
                cursor.word(b"f")?;
                let before = self.corners.len();
                if self.add_corners(&mut cursor).is_none() {
                    self.corners.truncate(before);
                    return None;
                }
                self.faces.push((self.corners.len() - before) as u32);
                Kind::Faces
            }
            _ => return None,
        };
        Some((kind, cursor.at()))
    }

    #[inline(always)]
    fn add_corners(&mut self, cursor: &mut Cursor<'_>) -> Option<()> {
        while cursor.end().is_none() {
            self.corners.push(cursor.corner()?);
        }
        Some(())
    }

    /// The runs with their first lines, in order.
    pub(super) fn runs(&self) -> impl Iterator<Item = (u64, Read<'_>)> {
        let (mut positions, mut texcoords) = (&self.positions[..], &self.texcoords[..]);
        let (mut normals, mut faces) = (&self.normals[..], &self.faces[..]);
        let (mut corners, mut text) = (&self.corners[..], &self.text[..]);
        self.runs.iter().map(move |run| {
            let read = match run.kind {
                Kind::Positions => Read::Positions(first(&mut positions, run.count)),
                Kind::Texcoords => Read::Texcoords(first(&mut texcoords, run.count)),
                Kind::Normals => Read::Normals(first(&mut normals, run.count)),
                Kind::Faces => {
                    let faces = first(&mut faces, run.count);
                    let count = faces.iter().map(|&count| count as usize).sum();
                    Read::Faces(faces, first(&mut corners, count))
                }
                Kind::Text => {
                    let (line, rest) = text.split_at(run.count);
                    text = rest;
                    Read::Text(line)
                }
            };
            (run.line, read)
        })
    }
}

/// Numbers, each behind blanks.
#[inline(always)]
fn numbers<const N: usize>(cursor: &mut Cursor<'_>) -> Option<[f64; N]> {
    let mut numbers = [0.0; N];
    for number in &mut numbers {
        cursor.blanks()?;
        *number = cursor.double()?;
    }
    Some(numbers)
}

/// Takes the first values of a list.
fn first<'a, T>(list: &mut &'a [T], count: usize) -> &'a [T] {
    let (first, rest) = list.split_at(count);
    *list = rest;
    first
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! OBJ statements, one by one, into the lists of the file and the parts of its materials.
//! Source: Wavefront, Advanced Visualizer manual, appendix B1.
//! Invariant: a corner that reaches a part exists. Memory: the lists, the parts, some batches; the budget is
//! charged after each batch. Tests: `tests/obj.rs`, `tests/broken_files.rs`,
//! `tests/growth.rs`.

use std::io::BufRead;
use std::path::Path;
use std::sync::mpsc::sync_channel;
use std::thread::Builder;

use super::batch::{Batch, Read, WrittenCorner};
use super::mtl::Library;
use super::parts::{Lists, Parts};
use super::vertices::{Corner, NONE};
use crate::io::error::quoted;
use crate::io::lines::LogicalLines;
use crate::io::origin::Origin;
use crate::io::polygon::Cutter;
use crate::io::source::Access;
use crate::io::{Error, Oddity, Warnings};
use gnurt_image::Excess;

/// Bytes from which a file is worth a second thread.
const LONG: u64 = 1 << 19;
/// Batches of statements that wait at most.
const BATCHES: usize = 4;

/// The statements of a file so far.
pub(super) struct Statements<'a> {
    path: &'a Path,
    access: &'a Access,
    pub(super) lists: Lists,
    pub(super) parts: Parts,
    pub(super) library: Library,
    /// Number of the material that faces get now.
    material: usize,
    /// Whether any statement was an OBJ one.
    recognised: bool,
    count: u64,
    /// Bytes charged to the budget.
    held: usize,
    corners: Vec<Corner>,
    cutter: Cutter,
    /// Of the positions.
    pub(super) origin: Origin,
}

impl<'a> Statements<'a> {
    /// Reads all lines of the file at `path`, which has `length` bytes. Those of a long file are read on a thread of their own.
    pub(super) fn read<R: BufRead + Send>(
        mut lines: LogicalLines<R>,
        path: &'a Path,
        length: u64,
        access: &'a Access,
        warnings: &mut Warnings,
    ) -> Result<Self, Error> {
        let mut statements = Self {
            path,
            access,
            lists: Lists::default(),
            parts: Parts::default(),
            library: Library::default(),
            material: 0,
            recognised: false,
            count: 0,
            held: 0,
            corners: Vec::new(),
            cutter: Cutter::for_file(length),
            origin: Origin::default(),
        };
        if length < LONG || !statements.read_beside(&mut lines, warnings)? {
            let mut more = true;
            while more {
                let mut batch = Batch::default();
                let filled = batch.fill(&mut lines);
                statements.add(&batch, warnings)?;
                more = filled?;
            }
        }
        if statements.count > 0 && !statements.recognised {
            let remedy = "expected lines such as `v X Y Z` and `f 1 2 3`";
            return Err(Error::data(path, Some(1), "no OBJ statement in this file", remedy));
        }
        Ok(statements)
    }

    /// Reads lines on another thread; `false`, and nothing is read, if the system has none.
    fn read_beside<R: BufRead + Send>(
        &mut self,
        lines: &mut LogicalLines<R>,
        warnings: &mut Warnings,
    ) -> Result<bool, Error> {
        std::thread::scope(|scope| {
            let (sender, batches) = sync_channel(BATCHES);
            let make = move || {
                let mut more = true;
                while more {
                    let mut batch = Batch::default();
                    let filled = batch.fill(lines);
                    more = matches!(filled, Ok(true));
                    // After an error the receiver is gone.
                    if sender.send((batch, filled)).is_err() {
                        return;
                    }
                }
            };
            if Builder::new().name("gnurt obj".into()).spawn_scoped(scope, make).is_err() {
                return Ok(false);
            }
            for (batch, filled) in batches {
                self.add(&batch, warnings)?;
                filled?;
            }
            Ok(true)
        })
    }

    /// Adds the statements of a batch.
    fn add(&mut self, batch: &Batch, warnings: &mut Warnings) -> Result<(), Error> {
        let path = self.path;
        for (line, statement) in batch.statements() {
            let location = Location { path, line };
            match statement {
                Read::Position(position) => self.place(position, None, &location, warnings)?,
                Read::Texcoord(texcoord) => self.lists.texcoords.push(texcoord),
                Read::Normal(normal) => self.lists.normals.push(normal),
                Read::Face(corners) => self.face(corners, &location, warnings)?,
                Read::Text(text) => self.statement(&location, text, warnings)?,
            }
            self.recognised |= !matches!(statement, Read::Text(_));
            self.count += 1;
        }
        self.hold()
    }

    /// Charges the budget for the memory taken since the last call.
    fn hold(&mut self) -> Result<(), Error> {
        let now = self.lists.memory_bytes() + self.parts.memory_bytes();
        if now > self.held {
            let excess = |e: Excess| Error::data(self.path, None, e.to_string(), Excess::REMEDY);
            self.access.budget.hold(now - self.held).map_err(excess)?;
            self.held = now;
        }
        Ok(())
    }

    fn statement(
        &mut self,
        location: &Location<'_>,
        text: &str,
        warnings: &mut Warnings,
    ) -> Result<(), Error> {
        let (keyword, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
        match keyword {
            "v" => self.position(rest, location, warnings)?,
            "vt" => {
                let texcoord = attribute::<2>(rest, location, warnings);
                self.lists.texcoords.push(texcoord);
            }
            "vn" => {
                let normal = attribute::<3>(rest, location, warnings);
                self.lists.normals.push(normal);
            }
            "f" | "fo" => {
                let corners: Vec<WrittenCorner> =
                    values(rest).map(|token| corner(token, location)).collect::<Result<_, _>>()?;
                self.face(&corners, location, warnings)?;
            }
            "l" | "p" => warnings.note(Oddity::PointsOrLines, location.path, Some(location.line), ""),
            "mtllib" => {
                self.library.read(location.path, location.line, rest.trim(), self.access, warnings)?
            }
            "usemtl" => {
                self.material = self.library.number_of(rest.trim(), location.path, location.line, warnings)
            }
            "o" | "g" | "s" => {}
            "surf" | "bsp" | "bzp" => {
                warnings.note(Oddity::NotShown, location.path, Some(location.line), "free-form surface");
            }
            _ => return Ok(()),
        }
        self.recognised = true;
        Ok(())
    }

    fn position(
        &mut self,
        rest: &str,
        location: &Location<'_>,
        warnings: &mut Warnings,
    ) -> Result<(), Error> {
        const REMEDY: &str = "expected `v X Y Z`, `v X Y Z W` or `v X Y Z R G B`";
        let mut numbers = [1.0_f64; 6];
        let mut count = 0;
        for token in values(rest).take(7) {
            let x = double(token)
                .ok_or_else(|| location.error(format!("bad number {}", quoted(token)), REMEDY))?;
            if let Some(slot) = numbers.get_mut(count) {
                *slot = x;
            }
            count += 1;
        }
        if count < 3 {
            return Err(location.error(format!("a vertex of {count} numbers"), REMEDY));
        }
        let [x, y, z, r, g, b] = numbers;
        let color = (count >= 6).then(|| [r, g, b].map(|channel| channel as f32));
        self.place([x, y, z], color, location, warnings)
    }

    /// Adds a vertex.
    fn place(
        &mut self,
        position: [f64; 3],
        color: Option<[f32; 3]>,
        location: &Location<'_>,
        warnings: &mut Warnings,
    ) -> Result<(), Error> {
        let lists = &mut self.lists;
        if lists.positions.len() >= NONE as usize {
            return Err(location.error("more than 2^32 - 1 vertices".into(), "divide the file"));
        }
        // The first vertex determines whether vertices have colours.
        let colored = if lists.positions.is_empty() { color.is_some() } else { !lists.colors.is_empty() };
        if colored {
            if color.is_none() {
                let detail = "a vertex without colour among coloured ones";
                warnings.note(Oddity::BadAttribute, location.path, Some(location.line), detail);
            }
            lists.colors.push(color.unwrap_or([1.0; 3]));
        }
        lists.positions.push(self.origin.place(position));
        Ok(())
    }

    fn face(
        &mut self,
        written: &[WrittenCorner],
        location: &Location<'_>,
        warnings: &mut Warnings,
    ) -> Result<(), Error> {
        let corners = &mut self.corners;
        corners.clear();
        let (mut texcoords, mut normals) = (true, true);
        let (mut bad_texcoord, mut bad_normal) = (false, false);
        for &[v, t, n] in written {
            let position = resolve_position(v, self.lists.positions.len(), location)?;
            let texcoord = resolve(t, self.lists.texcoords.len());
            let normal = resolve(n, self.lists.normals.len());
            bad_texcoord |= t.is_some() && texcoord.is_none();
            bad_normal |= n.is_some() && normal.is_none();
            texcoords &= texcoord.is_some();
            normals &= normal.is_some();
            corners.push([position, texcoord.unwrap_or(NONE), normal.unwrap_or(NONE)]);
        }
        let mut note = |oddity| warnings.note(oddity, location.path, Some(location.line), "");
        if bad_texcoord {
            note(Oddity::TexcoordOutOfRange);
        }
        if bad_normal {
            note(Oddity::NormalOutOfRange);
        }
        if corners.len() < 3 {
            note(Oddity::ShortFace);
            return Ok(());
        }
        // A face has texture coordinates, or normals, in all of its corners or in none.
        for [_, texcoord, normal] in corners.iter_mut() {
            *texcoord = if texcoords { *texcoord } else { NONE };
            *normal = if normals { *normal } else { NONE };
        }
        self.parts.add_face(self.material, corners, &self.lists, &mut self.cutter);
        Ok(())
    }
}

/// The location of a statement.
struct Location<'a> {
    path: &'a Path,
    line: u64,
}

impl Location<'_> {
    fn error(&self, problem: String, remedy: impl Into<String>) -> Error {
        Error::data(self.path, Some(self.line), problem, remedy)
    }
}

/// The values of a statement up to a comment.
fn values(rest: &str) -> impl Iterator<Item = &str> {
    rest.split_whitespace().take_while(|token| !token.starts_with('#'))
}

/// A number as C programs print it; those of Microsoft's `1.#IND` kind are NaN.
fn double(token: &str) -> Option<f64> {
    match token.parse() {
        Ok(x) => Some(x),
        Err(_) if token.contains(".#") || token.trim_start_matches('-').starts_with("nan(") => Some(f64::NAN),
        Err(_) => None,
    }
}

/// The same in single precision.
fn number(token: &str) -> Option<f32> {
    double(token).map(|x| x as f32)
}

/// `vt` and `vn`: a missing or invalid number becomes 0, which means no value.
fn attribute<const N: usize>(rest: &str, location: &Location<'_>, warnings: &mut Warnings) -> [f32; N] {
    let mut numbers = [0.0; N];
    let mut good = values(rest).next().is_some();
    for (slot, token) in numbers.iter_mut().zip(values(rest)) {
        let x = number(token).filter(|x| x.is_finite());
        good &= x.is_some();
        *slot = x.unwrap_or(0.0);
    }
    if !good {
        warnings.note(Oddity::BadAttribute, location.path, Some(location.line), quoted(rest));
    }
    numbers
}

/// `v`, `v/t`, `v//n` or `v/t/n` as written.
fn corner(token: &str, location: &Location<'_>) -> Result<WrittenCorner, Error> {
    let bad = || {
        location.error(format!("bad corner {}", quoted(token)), "expected `V`, `V/VT`, `V//VN` or `V/VT/VN`")
    };
    let mut indices = [None; 3];
    for (k, part) in token.split('/').enumerate() {
        let slot = indices.get_mut(k).ok_or_else(bad)?;
        if k == 0 || !part.is_empty() {
            *slot = Some(part.parse::<i64>().map_err(|_| bad())?);
        }
    }
    Ok(indices)
}

fn resolve_position(index: Option<i64>, count: usize, location: &Location<'_>) -> Result<u32, Error> {
    resolve(index, count).ok_or_else(|| {
        let problem = format!("vertex index {} out of range", index.unwrap_or(0));
        let remedy = match count {
            0 => "no vertex is defined before this line".to_owned(),
            n => format!("expected 1 to {n} or -{n} to -1"),
        };
        location.error(problem, remedy)
    })
}

/// A position in a list of `count` values, from 0; in the file indices count from 1, or from the list's end if negative.
fn resolve(index: Option<i64>, count: usize) -> Option<u32> {
    let count = i64::try_from(count).ok()?;
    let index = match index? {
        i if i < 0 => i.checked_add(count)?,
        i => i - 1,
    };
    (0..count).contains(&index).then_some(index).and_then(|i| u32::try_from(i).ok()).filter(|&i| i != NONE)
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! OBJ statements, one by one, into the lists of the file and the parts of its materials.
//! Source: Wavefront, Advanced Visualizer manual, appendix B1.
//! Invariant: a corner that reaches a part exists. Memory: the lists, the parts, some batches; the budget is
//! charged after each batch. Tests: `tests/obj.rs`, `tests/broken_files.rs`,
//! `tests/growth.rs`.

use std::io::Read;
use std::path::Path;

use super::batch::{Batch, Read as Run};
use super::blocks;
use super::mtl::Library;
use super::parts::{Corner, Lists, NONE, Parts};
use super::plain::{MISSING, PlainCorner};
use crate::io::error::quoted;
use crate::io::origin::Origin;
use crate::io::polygon::Cutter;
use crate::io::source::Access;
use crate::io::{Error, Oddity, Warnings};
use gnurt_image::Excess;

/// Bytes from which a file is worth a second thread.
const LONG: u64 = 1 << 19;

/// Indices of a corner's position, texture coordinate and normal as written.
type WrittenCorner = [Option<i64>; 3];

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
    /// Lines of the blocks before.
    lines: u64,
    /// Bytes charged to the budget.
    held: usize,
    corners: Vec<Corner>,
    cutter: Cutter,
    /// Of the positions.
    pub(super) origin: Origin,
}

impl<'a> Statements<'a> {
    /// Reads all lines of the file at `path`, which has `length` bytes.
    pub(super) fn read(
        file: impl Read + Send,
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
            lines: 0,
            held: 0,
            corners: Vec::new(),
            cutter: Cutter::for_file(length),
            origin: Origin::default(),
        };
        let threads = if length < LONG { 1 } else { access.threads() };
        blocks::for_each(file, path, threads, |batch, outcome| {
            statements.add(batch, warnings)?;
            outcome
                .map_err(|error| Error { line: error.line.map(|line| line + statements.lines), ..error })?;
            statements.lines += batch.lines;
            Ok(())
        })?;
        if statements.count > 0 && !statements.recognised {
            let remedy = "expected lines such as `v X Y Z` and `f 1 2 3`";
            return Err(Error::data(path, Some(1), "no OBJ statement in this file", remedy));
        }
        Ok(statements)
    }

    /// Adds the statements of a batch.
    fn add(&mut self, batch: &Batch, warnings: &mut Warnings) -> Result<(), Error> {
        let path = self.path;
        for (line, run) in batch.runs() {
            let location = Location { path, line: self.lines + line };
            self.recognised |= !matches!(run, Run::Text(_));
            self.count += 1;
            match run {
                Run::Positions(positions) => self.place_all(positions, &location, warnings)?,
                Run::Texcoords(texcoords) => self.lists.texcoords.extend_from_slice(texcoords),
                Run::Normals(normals) => self.lists.normals.extend_from_slice(normals),
                Run::Faces(faces, corners) => self.faces(faces, corners, &location, warnings)?,
                Run::Text(text) => self.statement(&location, text, warnings)?,
            }
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
                self.face(corners.into_iter(), location, warnings)?;
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

    /// Adds vertices without colours, one to a line.
    fn place_all(
        &mut self,
        positions: &[[f64; 3]],
        location: &Location<'_>,
        warnings: &mut Warnings,
    ) -> Result<(), Error> {
        let count = self.lists.positions.len();
        if self.lists.colors.is_empty() && positions.len() < (NONE as usize).saturating_sub(count) {
            self.origin.place_all(positions, &mut self.lists.positions);
            return Ok(());
        }
        positions.iter().zip(location.line..).try_for_each(|(&position, line)| {
            self.place(position, None, &Location { line, ..*location }, warnings)
        })
    }

    /// Adds faces, one to a line.
    fn faces(
        &mut self,
        faces: &[u32],
        corners: &[PlainCorner],
        location: &Location<'_>,
        warnings: &mut Warnings,
    ) -> Result<(), Error> {
        let lists = &self.lists;
        let counts = [lists.positions.len(), lists.texcoords.len(), lists.normals.len()];
        // Below this, an index that is missing is out of range like others.
        let are_small = counts.iter().all(|&count| count < MISSING.unsigned_abs() as usize);
        let counts = counts.map(|count| count as u32);
        let written = |index: i32| (index != MISSING).then_some(i64::from(index));
        let mut corners = corners;
        for (&count, line) in faces.iter().zip(location.line..) {
            let (face, rest) = corners.split_at(count as usize);
            corners = rest;
            if let &[a, b, c] = face
                && are_small
                && let Some(triangle) = plain_triangle([a, b, c], counts)
            {
                self.parts.add_triangle(self.material, triangle, &self.lists);
                continue;
            }
            let face = face.iter().map(|corner| corner.map(written));
            self.face(face, &Location { line, ..*location }, warnings)?;
        }
        Ok(())
    }

    #[inline]
    fn face(
        &mut self,
        written: impl Iterator<Item = WrittenCorner>,
        location: &Location<'_>,
        warnings: &mut Warnings,
    ) -> Result<(), Error> {
        let corners = &mut self.corners;
        corners.clear();
        let (mut texcoords, mut normals) = (true, true);
        let (mut bad_texcoord, mut bad_normal) = (false, false);
        for [v, t, n] in written {
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
#[derive(Clone, Copy)]
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

/// The corners of a triangle that all exist, and have texture coordinates and normals all or none; `None` leaves others to the
/// general way.
#[inline]
fn plain_triangle(written: [PlainCorner; 3], counts: [u32; 3]) -> Option<[Corner; 3]> {
    let place = |index: i32, count: u32| {
        let place = if index > 0 { index as u32 - 1 } else { count.wrapping_add(index as u32) };
        if place < count { place } else { NONE }
    };
    let triangle = written.map(|[v, t, n]| [place(v, counts[0]), place(t, counts[1]), place(n, counts[2])]);
    let has = |k: usize| triangle.iter().all(|corner| corner[k] != NONE);
    let has_none = |k: usize| written.iter().all(|corner| corner[k] == MISSING);
    (has(0) && (has(1) || has_none(1)) && (has(2) || has_none(2))).then_some(triangle)
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

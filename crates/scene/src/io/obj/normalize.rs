// SPDX-License-Identifier: GPL-3.0-or-later
//! Checks OBJ statements and hands them on in a plain dialect, as a stream.
//! Source: original.
//!
//! The dialect: `v x y z [r g b]` (colours for all or none), `vt u v`, `vn x y z`, `f` with three or more absolute
//! corners of one and the same form `v`, `v/t`, `v//n` or `v/t/n` that exist, and `g K` before a run of faces of material
//! `K` and one form. Runs are cut every [`LONGEST_RUN`] faces, for `tobj` keeps 80 bytes for each face of a run.
//! Memory: one statement. Proof: `tests/obj.rs`, `tests/broken_files.rs`.

use std::io::{BufRead, Read};
use std::path::{Path, PathBuf};

use super::mtl::Library;
use crate::io::error::quoted;
use crate::io::lines::LogicalLines;
use crate::io::{Error, Oddity, Warnings};

/// Faces in a run that `tobj` sees at once.
const LONGEST_RUN: usize = 1 << 14;
/// Runs in a file: each costs `tobj` some 500 bytes, which no file's length would account for.
const MOST_RUNS: usize = 1 << 20;

/// What stands in a run: the material's number and the form of its corners.
#[derive(Clone, Copy, PartialEq, Eq)]
struct RunKey {
    material: usize,
    texcoords: bool,
    normals: bool,
}

/// One corner of a face: positions in the lists of the file, from 1; 0 = none.
#[derive(Clone, Copy)]
struct Corner {
    position: usize,
    texcoord: usize,
    normal: usize,
}

/// The plain dialect as a byte stream. After the stream has ended or failed, ask [`finish`](Self::finish).
pub(super) struct Normalizer<'a, R> {
    lines: LogicalLines<R>,
    path: PathBuf,
    warnings: &'a mut Warnings,
    library: Library,
    failure: Option<Error>,
    out: Vec<u8>,
    given: usize,
    statements: Statements,
}

/// What the statements so far have said.
#[derive(Default)]
struct Statements {
    positions: usize,
    texcoords: usize,
    normals: usize,
    colored: bool,
    material: usize,
    run: Option<RunKey>,
    faces_in_run: usize,
    runs: usize,
    /// Whether any statement was an OBJ one.
    recognised: bool,
    any: bool,
    corners: Vec<Corner>,
}

impl<'a, R: BufRead> Normalizer<'a, R> {
    pub(super) fn new(lines: LogicalLines<R>, path: &Path, warnings: &'a mut Warnings) -> Self {
        Self {
            lines,
            path: path.to_owned(),
            warnings,
            library: Library::default(),
            failure: None,
            out: Vec::new(),
            given: 0,
            statements: Statements::default(),
        }
    }

    /// The materials that the file uses, or the mistake that ended the stream.
    pub(super) fn finish(self) -> Result<Library, Error> {
        match self.failure {
            Some(error) => Err(error),
            None if self.statements.any && !self.statements.recognised => Err(Error::data(
                &self.path,
                Some(1),
                "no OBJ statement in this file",
                "expected lines such as `v X Y Z` and `f 1 2 3`",
            )),
            None => Ok(self.library),
        }
    }

    /// Appends the next statement that matters to `out`; `false` at the end.
    fn advance(&mut self) -> Result<bool, Error> {
        let Some((line, text)) = self.lines.next()? else {
            return Ok(false);
        };
        let (keyword, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
        let place = Place { path: &self.path, line };
        let (said, out, warnings) = (&mut self.statements, &mut self.out, &mut *self.warnings);
        said.any = true;
        said.recognised |= matches!(
            keyword,
            "v" | "vt" | "vn" | "f" | "fo" | "o" | "g" | "l" | "p" | "mtllib" | "usemtl" | "s"
        );
        match keyword {
            "v" => said.position(rest, &place, out, warnings)?,
            "vt" => said.attribute::<2>("vt", rest, &place, out, warnings),
            "vn" => said.attribute::<3>("vn", rest, &place, out, warnings),
            "f" | "fo" => said.face(rest, &place, out, warnings)?,
            "l" | "p" => warnings.note(Oddity::PointsOrLines, place.path, Some(line), ""),
            "mtllib" => self.library.read(place.path, line, rest.trim(), warnings),
            "usemtl" => said.material = self.library.number_of(rest.trim(), place.path, line, warnings),
            _ => {}
        }
        Ok(true)
    }
}

impl<R: BufRead> Read for Normalizer<'_, R> {
    fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
        if self.given == self.out.len() {
            self.out.clear();
            self.given = 0;
            while self.out.len() < into.len() && self.failure.is_none() {
                match self.advance() {
                    Ok(true) => {}
                    Ok(false) => break,
                    Err(error) => self.failure = Some(error),
                }
            }
            if self.failure.is_some() {
                return Err(std::io::ErrorKind::InvalidData.into());
            }
        }
        let n = into.len().min(self.out.len() - self.given);
        into[..n].copy_from_slice(&self.out[self.given..self.given + n]);
        self.given += n;
        Ok(n)
    }
}

/// Where a statement stands.
struct Place<'a> {
    path: &'a Path,
    line: u64,
}

impl Place<'_> {
    fn error(&self, problem: String, remedy: impl Into<String>) -> Error {
        Error::data(self.path, Some(self.line), problem, remedy)
    }
}

/// The values of a statement up to a comment.
fn values(rest: &str) -> impl Iterator<Item = &str> {
    rest.split_whitespace().take_while(|token| !token.starts_with('#'))
}

/// A number as C programs print it; those of Microsoft's `1.#IND` kind are NaN.
fn number(token: &str) -> Option<f32> {
    match token.parse() {
        Ok(x) => Some(x),
        Err(_) if token.contains(".#") || token.trim_start_matches('-').starts_with("nan(") => Some(f32::NAN),
        Err(_) => None,
    }
}

fn write_statement(out: &mut Vec<u8>, keyword: &str, numbers: &[f32]) {
    use std::io::Write;
    out.extend_from_slice(keyword.as_bytes());
    for x in numbers {
        // The shortest text that reads back as the same float; writing to a vector cannot fail.
        let _ = write!(out, " {x}");
    }
    out.push(b'\n');
}

impl Statements {
    fn position(
        &mut self,
        rest: &str,
        place: &Place<'_>,
        out: &mut Vec<u8>,
        warnings: &mut Warnings,
    ) -> Result<(), Error> {
        const REMEDY: &str = "expected `v X Y Z`, `v X Y Z W` or `v X Y Z R G B`";
        let mut numbers = [1.0_f32; 6];
        let mut count = 0;
        for token in values(rest).take(7) {
            let x =
                number(token).ok_or_else(|| place.error(format!("bad number {}", quoted(token)), REMEDY))?;
            if let Some(slot) = numbers.get_mut(count) {
                *slot = x;
            }
            count += 1;
        }
        if count < 3 {
            return Err(place.error(format!("a vertex of {count} numbers"), REMEDY));
        }
        if self.positions == 0 {
            self.colored = count >= 6;
        } else if self.colored != (count >= 6) && self.colored {
            warnings.note(
                Oddity::BadAttribute,
                place.path,
                Some(place.line),
                "a vertex without colour among coloured ones",
            );
        }
        if count < 6 {
            numbers[3..].fill(1.0);
        }
        self.positions += 1;
        write_statement(out, "v", &numbers[..if self.colored { 6 } else { 3 }]);
        Ok(())
    }

    /// `vt` and `vn`: what is missing or no number is 0, which says nothing.
    fn attribute<const N: usize>(
        &mut self,
        keyword: &str,
        rest: &str,
        place: &Place<'_>,
        out: &mut Vec<u8>,
        warnings: &mut Warnings,
    ) {
        let mut numbers = [0.0; N];
        let mut good = values(rest).next().is_some();
        for (slot, token) in numbers.iter_mut().zip(values(rest)) {
            let x = number(token).filter(|x| x.is_finite());
            good &= x.is_some();
            *slot = x.unwrap_or(0.0);
        }
        if !good {
            warnings.note(Oddity::BadAttribute, place.path, Some(place.line), quoted(rest));
        }
        write_statement(out, keyword, &numbers);
        let count = if N == 2 { &mut self.texcoords } else { &mut self.normals };
        *count += 1;
    }

    fn face(
        &mut self,
        rest: &str,
        place: &Place<'_>,
        out: &mut Vec<u8>,
        warnings: &mut Warnings,
    ) -> Result<(), Error> {
        let mut corners = std::mem::take(&mut self.corners);
        corners.clear();
        let (mut texcoords, mut normals) = (true, true);
        let (mut bad_texcoord, mut bad_normal) = (false, false);
        for token in values(rest) {
            let [v, t, n] = self.corner(token, place)?;
            let position = self.resolve_position(v, place)?;
            let texcoord = resolve(t, self.texcoords);
            let normal = resolve(n, self.normals);
            bad_texcoord |= t.is_some() && texcoord.is_none();
            bad_normal |= n.is_some() && normal.is_none();
            texcoords &= texcoord.is_some();
            normals &= normal.is_some();
            corners.push(Corner { position, texcoord: texcoord.unwrap_or(0), normal: normal.unwrap_or(0) });
        }
        let mut note = |oddity| warnings.note(oddity, place.path, Some(place.line), "");
        if bad_texcoord {
            note(Oddity::TexcoordOutOfRange);
        }
        if bad_normal {
            note(Oddity::NormalOutOfRange);
        }
        if corners.len() < 3 {
            note(Oddity::ShortFace);
        } else {
            self.begin_run(RunKey { material: self.material, texcoords, normals }, place, out)?;
            write_face(out, &corners, texcoords, normals);
        }
        self.corners = corners;
        Ok(())
    }

    /// `v`, `v/t`, `v//n` or `v/t/n` as written.
    fn corner(&self, token: &str, place: &Place<'_>) -> Result<[Option<i64>; 3], Error> {
        let bad = || {
            place.error(format!("bad corner {}", quoted(token)), "expected `V`, `V/VT`, `V//VN` or `V/VT/VN`")
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

    fn resolve_position(&self, index: Option<i64>, place: &Place<'_>) -> Result<usize, Error> {
        resolve(index, self.positions).ok_or_else(|| {
            let problem = format!("vertex index {} out of range", index.unwrap_or(0));
            let remedy = match self.positions {
                0 => "no vertex is defined before this line".to_owned(),
                n => format!("expected 1 to {n} or -{n} to -1"),
            };
            place.error(problem, remedy)
        })
    }

    fn begin_run(&mut self, key: RunKey, place: &Place<'_>, out: &mut Vec<u8>) -> Result<(), Error> {
        if self.run != Some(key) || self.faces_in_run == LONGEST_RUN {
            self.run = Some(key);
            self.faces_in_run = 0;
            self.runs += 1;
            if self.runs > MOST_RUNS {
                let problem = format!("more than {MOST_RUNS} changes of material between faces");
                return Err(place.error(problem, "expected faces grouped by material"));
            }
            out.extend_from_slice(format!("g {}\n", key.material).as_bytes());
        }
        self.faces_in_run += 1;
        Ok(())
    }
}

/// A position in a list of `count` values, from 1; negative indices count from its end.
fn resolve(index: Option<i64>, count: usize) -> Option<usize> {
    let count = i64::try_from(count).ok()?;
    let index = match index? {
        i if i < 0 => i.checked_add(count + 1)?,
        i => i,
    };
    (1..=count).contains(&index).then_some(index as usize)
}

fn write_face(out: &mut Vec<u8>, corners: &[Corner], texcoords: bool, normals: bool) {
    use std::io::Write;
    out.push(b'f');
    for c in corners {
        let (v, t, n) = (c.position, c.texcoord, c.normal);
        // Writing to a vector cannot fail.
        let _ = match (texcoords, normals) {
            (false, false) => write!(out, " {v}"),
            (true, false) => write!(out, " {v}/{t}"),
            (false, true) => write!(out, " {v}//{n}"),
            (true, true) => write!(out, " {v}/{t}/{n}"),
        };
    }
    out.push(b'\n');
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Point clouds as files: Houdini's classic geometry as text, `.geo`, of which points and their attributes are read.
//! Source: the subset that OSL's own tests read and write by Partio; original. Primitives and groups are
//! skipped. A file is of the form
//!
//! ```text
//! PGEOMETRY V5
//! NPoints 2 NPrims 0
//! NPointGroups 0 NPrimGroups 0
//! NPointAttrib 2 NVertexAttrib 0 NPrimAttrib 0 NAttrib 0
//! PointAttrib
//! uv 3 vector 0 0 0
//! kind 1 index 2 oak elm
//! 0 0 1 1 (0 0 0 1)
//! 1 0 1 1 (1 0 0 0)
//! beginExtra
//! endExtra
//! ```
//!
//! Tests: `tests/points.rs`.

use std::sync::Arc;

use super::cloud::{Column, PointCloud, Values};

/// Values of a file.
const MOST: usize = 1 << 28;

/// Words and parentheses of the text, with the line of each.
struct FileTokens<'a> {
    rest: &'a str,
    line: usize,
}

impl<'a> FileTokens<'a> {
    fn next(&mut self) -> Result<&'a str, String> {
        let trimmed = self.rest.trim_start();
        self.line += self.rest[..self.rest.len() - trimmed.len()].matches('\n').count();
        if trimmed.is_empty() {
            return Err(self.wrong("the file ends too early"));
        }
        let single = trimmed.starts_with(['(', ')']);
        let end =
            trimmed.find(|c: char| c.is_whitespace() || matches!(c, '(' | ')')).unwrap_or(trimmed.len());
        let (token, rest) = trimmed.split_at(if single { 1 } else { end });
        self.rest = rest;
        Ok(token)
    }

    fn wrong(&self, why: impl std::fmt::Display) -> String {
        format!("line {}: {why}", self.line)
    }

    fn expect(&mut self, token: &str) -> Result<(), String> {
        match self.next()? {
            found if found == token => Ok(()),
            found => Err(self.wrong(format_args!("'{found}' in place of '{token}'"))),
        }
    }

    fn number<T: std::str::FromStr>(&mut self, what: &str) -> Result<T, String> {
        let token = self.next()?;
        token.parse().map_err(|_| self.wrong(format_args!("'{token}' is no {what}")))
    }

    /// A count after its word.
    fn count(&mut self, token: &str) -> Result<usize, String> {
        self.expect(token)?;
        self.number("count")
    }
}

/// The head of a column.
struct Head {
    column: Column,
    /// The texts that numbers in the file refer to, for texts.
    texts: Vec<Arc<str>>,
}

fn head(tokens: &mut FileTokens<'_>) -> Result<Head, String> {
    let name = tokens.next()?.into();
    let width: usize = tokens.number("count")?;
    if width == 0 || width > 64 {
        return Err(tokens.wrong(format_args!("an attribute of {width} values; 1 to 64 are supported")));
    }
    let kind = tokens.next()?;
    let mut texts = Vec::new();
    let values = match kind {
        "float" | "vector" => Values::Float(Vec::new()),
        "int" => Values::Int(Vec::new()),
        "index" => {
            let count: usize = tokens.number("count")?;
            for _ in 0..count {
                texts.push(tokens.next()?.into());
            }
            Values::Text(Vec::new())
        }
        _ => {
            let known = "float, int, vector and index are supported";
            return Err(tokens.wrong(format_args!("an attribute of the kind '{kind}'; {known}")));
        }
    };
    if kind != "index" {
        // Values of points without data.
        for _ in 0..width {
            tokens.next()?;
        }
    }
    Ok(Head { column: Column { name, width, is_vector: kind == "vector" && width == 3, values }, texts })
}

/// A cloud of a file's text.
///
/// # Errors
/// The line, and the fault.
pub fn read_cloud(text: &str) -> Result<PointCloud, String> {
    let mut tokens = FileTokens { rest: text, line: 1 };
    tokens.expect("PGEOMETRY")?;
    tokens.next()?;
    let points = tokens.count("NPoints")?;
    for skipped in ["NPrims", "NPointGroups", "NPrimGroups"] {
        tokens.count(skipped)?;
    }
    let attributes = tokens.count("NPointAttrib")?;
    for skipped in ["NVertexAttrib", "NPrimAttrib", "NAttrib"] {
        tokens.count(skipped)?;
    }
    let mut heads = Vec::new();
    if attributes > 0 {
        tokens.expect("PointAttrib")?;
    }
    for _ in 0..attributes {
        heads.push(head(&mut tokens)?);
    }
    let row: usize = 3 + heads.iter().map(|head| head.column.width).sum::<usize>();
    // A point takes at least eight bytes.
    if points > text.len() / 8 || points.saturating_mul(row) > MOST {
        return Err(tokens.wrong(format_args!("{points} points exceed the length of the file")));
    }
    let mut positions = Vec::with_capacity(points);
    for _ in 0..points {
        let mut position = [0.0_f32; 4];
        for x in &mut position {
            *x = tokens.number("number")?;
        }
        let [x, y, z, w] = position;
        positions.push(if w == 1.0 || w == 0.0 { [x, y, z] } else { [x / w, y / w, z / w] });
        if heads.is_empty() {
            continue;
        }
        tokens.expect("(")?;
        for Head { column, texts } in &mut heads {
            for _ in 0..column.width {
                match &mut column.values {
                    Values::Float(list) => list.push(tokens.number("number")?),
                    Values::Int(list) => list.push(tokens.number("int")?),
                    Values::Text(list) => {
                        let number: i64 = tokens.number("int")?;
                        let text = usize::try_from(number).ok().and_then(|i| texts.get(i));
                        list.push(text.cloned().unwrap_or_else(|| "".into()));
                    }
                }
            }
        }
        tokens.expect(")")?;
    }
    let columns = heads.into_iter().map(|head| head.column).collect();
    PointCloud::new(positions, columns).ok_or_else(|| tokens.wrong("attributes do not fit the points"))
}

/// The text of a cloud's file.
///
/// # Errors
/// A name or a text that such a file cannot hold: it is empty, or has spaces or parentheses.
pub fn write_cloud(cloud: &PointCloud) -> Result<String, String> {
    use std::fmt::Write;
    let token = |text: &str| -> Result<(), String> {
        let fits = !text.is_empty() && !text.contains(|c: char| c.is_whitespace() || matches!(c, '(' | ')'));
        fits.then_some(()).ok_or_else(|| format!("'{text}' is not a valid word of a .geo file"))
    };
    let mut out = String::new();
    let (points, columns) = (cloud.positions().len(), cloud.columns());
    let _ = writeln!(out, "PGEOMETRY V5\nNPoints {points} NPrims 0\nNPointGroups 0 NPrimGroups 0");
    let _ = writeln!(out, "NPointAttrib {} NVertexAttrib 0 NPrimAttrib 0 NAttrib 0", columns.len());
    if !columns.is_empty() {
        out.push_str("PointAttrib\n");
    }
    let mut texts: Vec<Vec<Arc<str>>> = Vec::new();
    for column in columns {
        token(&column.name)?;
        let mut own = Vec::new();
        let _ = write!(out, "{} {} ", column.name, column.width);
        let zeros = " 0".repeat(column.width);
        match &column.values {
            Values::Float(_) => {
                let kind = if column.is_vector { "vector" } else { "float" };
                let _ = writeln!(out, "{kind}{zeros}");
            }
            Values::Int(_) => {
                let _ = writeln!(out, "int{zeros}");
            }
            Values::Text(list) => {
                own = list.iter().filter(|text| !text.is_empty()).cloned().collect();
                own.sort();
                own.dedup();
                let _ = write!(out, "index {}", own.len());
                for text in &own {
                    token(text)?;
                    let _ = write!(out, " {text}");
                }
                out.push('\n');
            }
        }
        texts.push(own);
    }
    for (i, [x, y, z]) in cloud.positions().iter().enumerate() {
        let _ = write!(out, "{x} {y} {z} 1");
        let mut between = " (";
        for (column, texts) in columns.iter().zip(&texts) {
            for k in i * column.width..(i + 1) * column.width {
                out.push_str(std::mem::replace(&mut between, " "));
                let _ = match &column.values {
                    Values::Float(list) => write!(out, "{}", list[k]),
                    Values::Int(list) => write!(out, "{}", list[k]),
                    Values::Text(list) => {
                        let number = texts.binary_search(&list[k]).map_or(-1, |at| at as i64);
                        write!(out, "{number}")
                    }
                };
            }
        }
        out.push_str(if columns.is_empty() { "\n" } else { ")\n" });
    }
    out.push_str("beginExtra\nendExtra\n");
    Ok(out)
}

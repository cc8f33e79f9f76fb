// SPDX-License-Identifier: GPL-3.0-or-later
//! The text of a layer: blocks, values, names that are valid and unlike those beside them. Tests: `tests/save.rs`.

use std::collections::HashSet;
use std::fmt::{Display, Write as _};

/// The tail of an attribute with one value for each vertex.
pub(super) const VERTEX: &str = " (\n            interpolation = \"vertex\"\n        )";

/// A layer under construction.
#[derive(Default)]
pub(super) struct Text {
    text: String,
    depth: usize,
    /// Names of the children of each open block.
    names: Vec<HashSet<String>>,
}

impl Text {
    /// One line.
    pub(super) fn line(&mut self, line: impl Display) {
        // Writing to a string does not fail.
        let _ = writeln!(self.text, "{:1$}{line}", "", 4 * self.depth);
    }

    /// Opens a prim and returns its name. `head` stands before the name, `metadata` in parentheses behind it.
    pub(super) fn open(&mut self, head: &str, name: &str, metadata: &[String]) -> String {
        if self.names.is_empty() {
            self.names.push(HashSet::new());
        }
        let name = unlike(&identifier(name), self.names.last_mut());
        match metadata {
            [] => self.line(format_args!("{head} \"{name}\"")),
            metadata => {
                self.line(format_args!("{head} \"{name}\" ("));
                metadata.iter().for_each(|line| self.line(format_args!("    {line}")));
                self.line(")");
            }
        }
        self.line("{");
        self.depth += 1;
        self.names.push(HashSet::new());
        name
    }

    /// Closes the last open block.
    pub(super) fn close(&mut self) {
        self.depth -= 1;
        self.names.pop();
        self.line("}");
    }

    /// An attribute with an array of vectors.
    pub(super) fn vectors<const N: usize>(
        &mut self,
        head: &str,
        values: impl Iterator<Item = [f32; N]>,
        tail: &str,
    ) {
        let mut array = String::new();
        for value in values {
            let separator = if array.is_empty() { "" } else { ", " };
            let _ = write!(array, "{separator}{}", tuple(value));
        }
        self.line(format_args!("{head} = [{array}]{tail}"));
    }

    /// An attribute with an array of numbers.
    pub(super) fn numbers<T: Display>(&mut self, head: &str, values: impl Iterator<Item = T>, tail: &str) {
        let mut array = String::new();
        for value in values {
            let separator = if array.is_empty() { "" } else { ", " };
            let _ = write!(array, "{separator}{value}");
        }
        self.line(format_args!("{head} = [{array}]{tail}"));
    }

    /// All of it.
    pub(super) fn finish(self) -> String {
        self.text
    }
}

/// `(1, 2, 3)`.
pub(super) fn tuple<const N: usize>(values: [f32; N]) -> String {
    format!("({})", values.map(|x| if x.is_finite() { x.to_string() } else { "0".into() }).join(", "))
}

/// A name with letters, digits and underscores alone, that does not begin with a digit.
fn identifier(name: &str) -> String {
    // The last part of a path says most.
    let last = name.rsplit('/').find(|part| !part.is_empty()).unwrap_or("");
    let mut valid: String =
        last.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).take(200).collect();
    if valid.is_empty() || valid.starts_with(|c: char| c.is_ascii_digit()) {
        valid.insert(0, '_');
    }
    valid
}

/// The name, with a number where it is taken.
fn unlike(name: &str, taken: Option<&mut HashSet<String>>) -> String {
    let Some(taken) = taken else { return name.to_owned() };
    let mut free = name.to_owned();
    let mut number = taken.len();
    while !taken.insert(free.clone()) {
        free = format!("{name}_{number}");
        number += 1;
    }
    free
}

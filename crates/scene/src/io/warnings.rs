// SPDX-License-Identifier: GPL-3.0-or-later
//! Oddities of files that can still be shown: one line per kind and cause, with a count and the first
//! location. See docs/reference/cli.md.
//! Invariant: at most [`MOST_LINES`] lines of a kind, and one for the others, for any file.
//! Tests: `tests::{counts_by_cause_and_keeps_the_first_place, lines_of_a_kind_have_a_limit}`.

use std::fmt;
use std::path::{Path, PathBuf};

use super::error::{Error, printable};

/// Lines of one kind. Further ones are counted in one more line.
const MOST_LINES: usize = 20;
/// Bytes of a detail.
const LONGEST: usize = 1000;

/// Kinds of oddity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Oddity {
    /// No triangle is left to be seen.
    EmptyScene,
    /// Triangles with a NaN or infinite corner.
    NotFiniteTriangle,
    /// Triangles without area.
    ZeroAreaTriangle,
    /// Faces with fewer than three corners.
    ShortFace,
    /// Points and lines, which have no surface.
    PointsOrLines,
    /// Texture coordinate indices out of range.
    TexcoordOutOfRange,
    /// Normal indices out of range.
    NormalOutOfRange,
    /// Texture coordinates, normals or colours that are no numbers.
    BadAttribute,
    /// Numbers outside of the range that their format allows.
    NumberOutOfRange,
    /// Textures that are missing or broken.
    BadTexture,
    /// Material libraries that are missing or unreadable.
    BadMaterialLibrary,
    /// Lines of a material library that cannot be read.
    BadMaterialLine,
    /// Names of materials that no library defines.
    UnknownMaterial,
    /// Features of the format that are not shown.
    NotShown,
    /// Meshes whose faces, points or indices do not fit together.
    BadMesh,
    /// Layers, references and the like that cannot be composed.
    BadComposition,
    /// Pictures named as heights that hold normals.
    NormalsForHeights,
    /// Lines of a header without a meaning.
    BadHeaderLine,
    /// A line of numbers is shorter than the header declares.
    ShortLine,
    /// Cameras that cannot be used.
    BadCamera,
    /// Invalid values in a camera's `extras`.
    CameraExtras,
    /// Nodes whose transform is flat or not finite, or that occur twice in the tree.
    BadNode,
    /// Channels of animations that cannot be played.
    BadAnimation,
    /// Keys of animations that have the time of the key before them.
    RepeatedKey,
    /// Bytes after the end of the data.
    TrailingData,
    /// Things of the format that something near is shown for.
    StandIn,
    /// Parameters that the format does not have.
    UnknownParameter,
}

impl Oddity {
    /// Whether there may be thousands in one mesh, of which only the first is reported. Each cause of the
    /// others is reported.
    fn is_of_geometry(self) -> bool {
        matches!(
            self,
            Self::NotFiniteTriangle
                | Self::ZeroAreaTriangle
                | Self::ShortFace
                | Self::PointsOrLines
                | Self::TexcoordOutOfRange
                | Self::NormalOutOfRange
                | Self::RepeatedKey
                | Self::ShortLine
        )
    }

    /// The oddity and the action taken.
    fn sentence(self) -> &'static str {
        match self {
            Self::EmptyScene => "no triangles: the picture shows only the background",
            Self::NotFiniteTriangle => "triangle with a NaN or infinite corner left out",
            Self::ZeroAreaTriangle => "triangle without area left out",
            Self::ShortFace => "face with fewer than 3 corners left out",
            Self::PointsOrLines => "points or lines left out, they have no surface",
            Self::TexcoordOutOfRange => {
                "face with a texture coordinate index out of range, shown without texture coordinates"
            }
            Self::NormalOutOfRange => "face with a normal index out of range, shown without normals",
            Self::BadAttribute => {
                "texture coordinate, normal, colour or weight that is not a finite number, ignored"
            }
            Self::NumberOutOfRange => "number out of range, the nearest one in it is used",
            Self::BadTexture => "texture cannot be read, ignored",
            Self::BadMaterialLibrary => "material library cannot be read, default materials are used",
            Self::BadMaterialLine => "material line cannot be understood, ignored",
            Self::UnknownMaterial => "unknown material, the default material is used",
            Self::NotShown => "not supported, left out",
            Self::BadMesh => "mesh cannot be shown, left out",
            Self::BadComposition => "composition without a part that cannot be read",
            Self::NormalsForHeights => "bump map holds normals, used as a normal map",
            Self::ShortLine => "line with fewer values than the header declares, read without them",
            Self::BadHeaderLine => "header line cannot be understood, ignored",
            Self::BadCamera => "camera cannot be used, left out",
            Self::CameraExtras => "word of a camera cannot be understood, ignored",
            Self::BadNode => "node cannot be placed, left out",
            Self::BadAnimation => "channel of an animation cannot be played, left out",
            Self::RepeatedKey => "keys of an animation have the same time, the last of them counts",
            Self::TrailingData => "bytes after the end of the data, ignored",
            Self::StandIn => "not supported, something near is shown",
            Self::UnknownParameter => "unknown parameter, ignored",
        }
    }
}

/// One oddity in a scene; `Display` is one line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// The kind of oddity.
    pub oddity: Oddity,
    /// How often.
    pub count: u64,
    /// The file of the first one.
    pub path: PathBuf,
    /// Its line, where known.
    pub line: Option<u64>,
    /// More about the first one; may be empty.
    pub detail: String,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", printable(&self.path.to_string_lossy()))?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        write!(f, ": {}", self.oddity.sentence())?;
        if !self.detail.is_empty() {
            write!(f, " ({})", printable(&self.detail))?;
        }
        if self.count > 1 {
            write!(f, " [{} in all]", self.count)?;
        }
        Ok(())
    }
}

impl Warning {
    /// The warning as an error, the first of `count`.
    pub(super) fn as_error(&self, count: usize) -> Error {
        let detail = if self.detail.is_empty() { String::new() } else { format!(" ({})", self.detail) };
        let others = if count > 1 { format!("; {count} warnings in all") } else { String::new() };
        let remedy = format!("warnings are errors{others}");
        Error::data(&self.path, self.line, format!("{}{detail}", self.oddity.sentence()), remedy)
    }
}

/// All oddities of a scene, by kind and cause.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Warnings {
    list: Vec<Warning>,
}

/// A detail of at most [`LONGEST`] bytes: a name may be as long as its file.
fn shortened(mut detail: String) -> String {
    if detail.len() > LONGEST {
        let end = (0..=LONGEST).rev().find(|&end| detail.is_char_boundary(end)).unwrap_or(0);
        detail.truncate(end);
        detail.push('…');
        detail.shrink_to_fit();
    }
    detail
}

/// The detail of the line that counts all others.
const OTHERS: &str = "and others";

impl Warnings {
    /// Notes one oddity.
    pub fn note(&mut self, oddity: Oddity, path: &Path, line: Option<u64>, detail: impl Into<String>) {
        self.note_many(oddity, 1, path, line, detail);
    }

    /// Notes `count` oddities of one kind and cause, in `detail`; the location is that of the first one.
    pub fn note_many(
        &mut self,
        oddity: Oddity,
        count: u64,
        path: &Path,
        line: Option<u64>,
        detail: impl Into<String>,
    ) {
        if count == 0 {
            return;
        }
        let detail = shortened(detail.into());
        let same = |warning: &Warning, detail: &str| {
            warning.oddity == oddity && (oddity.is_of_geometry() || warning.detail == detail)
        };
        let is_known = self.list.iter().any(|warning| same(warning, &detail));
        let has_room = || self.list.iter().filter(|warning| warning.oddity == oddity).count() < MOST_LINES;
        let detail = if is_known || has_room() { detail } else { OTHERS.to_owned() };
        match self.list.iter_mut().find(|warning| same(warning, &detail)) {
            Some(warning) => warning.count = warning.count.saturating_add(count),
            None => self.list.push(Warning { oddity, count, path: path.to_owned(), line, detail }),
        }
    }

    /// Notes all oddities of another list.
    pub fn append(&mut self, other: Self) {
        for Warning { oddity, count, path, line, detail } in other.list {
            self.note_many(oddity, count, &path, line, detail);
        }
    }

    /// One warning per kind and cause, in the order of their first appearance.
    pub fn iter(&self) -> impl Iterator<Item = &Warning> {
        self.list.iter()
    }

    /// Whether all is well.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// How often a kind was noted.
    #[must_use]
    pub fn count(&self, oddity: Oddity) -> u64 {
        self.list.iter().filter(|w| w.oddity == oddity).map(|w| w.count).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_by_cause_and_keeps_the_first_place() {
        let mut warnings = Warnings::default();
        warnings.note(Oddity::BadTexture, Path::new("a.mtl"), Some(3), "wood.png: no such file");
        warnings.note(Oddity::BadTexture, Path::new("b.mtl"), Some(9), "tile.png: no such file");
        warnings.note(Oddity::BadTexture, Path::new("b.mtl"), Some(12), "wood.png: no such file");
        warnings.note_many(Oddity::ShortFace, 0, Path::new("a.obj"), None, "");
        warnings.note(Oddity::ZeroAreaTriangle, Path::new("a.obj"), None, "in a");
        warnings.note(Oddity::ZeroAreaTriangle, Path::new("a.obj"), None, "in b");
        let lines: Vec<String> = warnings.iter().map(ToString::to_string).collect();
        let expected = [
            "a.mtl:3: texture cannot be read, ignored (wood.png: no such file) [2 in all]",
            "b.mtl:9: texture cannot be read, ignored (tile.png: no such file)",
            "a.obj: triangle without area left out (in a) [2 in all]",
        ];
        assert_eq!(
            lines, expected,
            "one line for each cause, one for triangles; nothing for a count of zero"
        );
        assert_eq!(warnings.count(Oddity::BadTexture), 3, "all of the kind");
    }

    #[test]
    fn lines_of_a_kind_have_a_limit() {
        let mut warnings = Warnings::default();
        for i in 0..500 {
            warnings.note(Oddity::UnknownMaterial, Path::new("a.obj"), Some(i), format!("`m{i}`"));
        }
        assert_eq!(warnings.iter().count(), MOST_LINES + 1, "{warnings:?}");
        let last = warnings.iter().last().map(ToString::to_string).unwrap_or_default();
        assert!(last.contains("(and others) [480 in all]"), "{last}");
        assert_eq!(warnings.count(Oddity::UnknownMaterial), 500, "all are counted");
        warnings.note(Oddity::BadTexture, Path::new("a.mtl"), None, "ö".repeat(1 << 20));
        let long = warnings.iter().last().map_or(0, |warning| warning.detail.len());
        assert!((900..1100).contains(&long), "a name of a megabyte is shortened: {long}");
    }
}

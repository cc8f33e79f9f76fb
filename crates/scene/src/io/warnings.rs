// SPDX-License-Identifier: GPL-3.0-or-later
//! Oddities that a file may have and still be shown: one line per kind, with a count and the first place.
//! Source: original; which ones are recoverable is the contract of the command line.
//! Proof: `tests::counts_by_kind_and_keeps_the_first_place`.

use std::fmt;
use std::path::{Path, PathBuf};

use super::error::printable;

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
    /// Texture coordinate indices that point nowhere.
    TexcoordOutOfRange,
    /// Normal indices that point nowhere.
    NormalOutOfRange,
    /// Texture coordinates, normals or colours that are no numbers.
    BadAttribute,
    /// Textures that are missing or broken.
    BadTexture,
    /// Material libraries that are missing or unreadable.
    BadMaterialLibrary,
    /// Lines of a material library that cannot be read.
    BadMaterialLine,
    /// Names of materials that no library defines.
    UnknownMaterial,
    /// Extensions that the file requires and this program does not know.
    UnknownExtension,
    /// Things of the format that are not shown.
    NotShown,
    /// Cameras that cannot be used.
    BadCamera,
    /// What a camera's `extras` say of it, and cannot mean.
    CameraExtras,
    /// Nodes whose transform flattens space or is no number, or that stand in a tree twice.
    BadNode,
    /// Channels of animations that cannot be played.
    BadAnimation,
    /// Keys of animations that have the time of the key before them.
    RepeatedKey,
    /// Bytes after the end of the data.
    TrailingData,
}

impl Oddity {
    /// What it is and what was done about it.
    fn sentence(self) -> &'static str {
        match self {
            Self::EmptyScene => "no triangles: only the background is seen",
            Self::NotFiniteTriangle => "triangle with a NaN or infinite corner left out",
            Self::ZeroAreaTriangle => "triangle without area left out",
            Self::ShortFace => "face with fewer than 3 corners left out",
            Self::PointsOrLines => "points or lines left out, they have no surface",
            Self::TexcoordOutOfRange => {
                "face with a texture coordinate index out of range, shown without texture coordinates"
            }
            Self::NormalOutOfRange => "face with a normal index out of range, shown without normals",
            Self::BadAttribute => {
                "texture coordinate, normal, colour or weight that is no finite number, ignored"
            }
            Self::BadTexture => "texture cannot be read, the base colour is used",
            Self::BadMaterialLibrary => "material library cannot be read, default materials are used",
            Self::BadMaterialLine => "material line cannot be understood, ignored",
            Self::UnknownMaterial => "unknown material, the default material is used",
            Self::UnknownExtension => "required extension is unknown, shown without it",
            Self::NotShown => "not supported, left out",
            Self::BadCamera => "camera cannot be used, left out",
            Self::CameraExtras => "word of a camera cannot be understood, ignored",
            Self::BadNode => "node cannot be placed, left out",
            Self::BadAnimation => "channel of an animation cannot be played, left out",
            Self::RepeatedKey => "keys of an animation have the same time, the last of them counts",
            Self::TrailingData => "bytes after the end of the data, ignored",
        }
    }
}

/// One kind of oddity in a scene; `Display` is one line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// What kind.
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

/// All oddities of a scene, by kind.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Warnings {
    kinds: Vec<Warning>,
}

impl Warnings {
    /// Notes one oddity.
    pub fn note(&mut self, oddity: Oddity, path: &Path, line: Option<u64>, detail: impl Into<String>) {
        self.note_many(oddity, 1, path, line, detail);
    }

    /// Notes `count` oddities of one kind; the place is that of the first one.
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
        match self.kinds.iter_mut().find(|warning| warning.oddity == oddity) {
            Some(warning) => warning.count += count,
            None => {
                let detail = detail.into();
                self.kinds.push(Warning { oddity, count, path: path.to_owned(), line, detail });
            }
        }
    }

    /// One warning per kind, in the order of their first appearance.
    pub fn iter(&self) -> impl Iterator<Item = &Warning> {
        self.kinds.iter()
    }

    /// Whether all is well.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.kinds.is_empty()
    }

    /// How often a kind was noted.
    #[must_use]
    pub fn count(&self, oddity: Oddity) -> u64 {
        self.kinds.iter().find(|w| w.oddity == oddity).map_or(0, |w| w.count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_by_kind_and_keeps_the_first_place() {
        let mut warnings = Warnings::default();
        warnings.note(Oddity::BadTexture, Path::new("a.mtl"), Some(3), "wood.png: no such file");
        warnings.note(Oddity::BadTexture, Path::new("b.mtl"), Some(9), "tile.png: no such file");
        warnings.note_many(Oddity::ShortFace, 0, Path::new("a.obj"), None, "");
        let lines: Vec<String> = warnings.iter().map(ToString::to_string).collect();
        let line =
            "a.mtl:3: texture cannot be read, the base colour is used (wood.png: no such file) [2 in all]";
        assert_eq!(lines, [line], "one line for both; nothing for a count of zero");
    }
}

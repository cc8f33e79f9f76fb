// SPDX-License-Identifier: GPL-3.0-or-later
//! The table of picture formats.
//! The first bytes of a file select the format when reading, its name's extension when writing.
//! Invariant: names decide only for TGA, whose files have no mark at their beginning. Tests: `tests`.

use std::io::SeekFrom;
use std::path::Path;

use super::format::{PictureFormat, Signature};
use super::source::Source;
use super::{exr, hdr, pfm, png, raster, tiff};
use crate::Error;

impl PictureFormat {
    /// 8 or 16 bits, sRGB, for screens.
    pub const PNG: &'static Self = &png::FORMAT;
    /// Linear, all layers.
    pub const EXR: &'static Self = &exr::FORMAT;
    /// Linear, shared exponent, colour only.
    pub const HDR: &'static Self = &hdr::FORMAT;
    /// Linear 32-bit floats, colour only.
    pub const PFM: &'static Self = &pfm::FORMAT;

    /// All formats.
    pub const ALL: &'static [&'static Self] = &[
        Self::PNG,
        Self::EXR,
        Self::HDR,
        Self::PFM,
        &raster::JPEG,
        &raster::TGA,
        &raster::BMP,
        &raster::WEBP,
        &tiff::FORMAT,
    ];

    /// The formats that can be written.
    pub fn written() -> impl Iterator<Item = &'static Self> {
        Self::ALL.iter().copied().filter(|format| format.is_written())
    }

    /// `.png, .exr`: the extensions of the formats that can be written.
    #[must_use]
    pub fn written_extensions() -> String {
        Self::written().map(|format| format!(".{}", format.extension())).collect::<Vec<_>>().join(", ")
    }

    /// `.png, .exr`: the usual extensions of the formats that can be read.
    #[must_use]
    pub fn read_extensions() -> String {
        Self::ALL.iter().map(|format| format!(".{}", format.extension())).collect::<Vec<_>>().join(", ")
    }

    /// The names of all formats, separated by commas.
    #[must_use]
    pub fn names() -> String {
        Self::ALL.iter().map(|format| format.name).collect::<Vec<_>>().join(", ")
    }

    /// The format to write that a file's name ends in, in upper or lower case.
    ///
    /// # Errors
    /// [`Error::UnknownExtension`] lists the extensions of formats that can be written.
    pub fn from_path(path: &Path) -> Result<&'static Self, Error> {
        let named = Self::written().find(|format| format.is_named(path));
        named.ok_or_else(|| Error::UnknownExtension { path: path.into(), valid: Self::written_extensions() })
    }

    /// Whether the name of a file ends in the extension of a format, in upper or lower case.
    #[must_use]
    pub fn is_named_any(path: &Path) -> bool {
        Self::ALL.iter().any(|format| format.is_named(path))
    }

    fn is_named(&self, path: &Path) -> bool {
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
        self.extensions.iter().any(|known| known.eq_ignore_ascii_case(extension))
    }

    /// The format of a file's contents; leaves the source at its beginning.
    pub(super) fn of(source: &mut dyn Source, length: u64, name: &str) -> Result<&'static Self, Error> {
        let mut head = [0; 12];
        read_at(source, 0, &mut head[..length.min(12) as usize])?;
        if length == 0 {
            return Err(Error::Corrupt { format: "picture", what: "the file is empty".into() });
        }
        let begins = |format: &Self| matches!(format.signature, Signature::Head(is) if is(&head));
        let mut found = Self::ALL.iter().copied().find(|format| begins(format));
        if found.is_none() {
            found = Self::ALL.iter().copied().find(|format| {
                matches!(format.signature, Signature::Foot(foot)
                    if format.is_named(Path::new(name)) || ends_in(source, length, foot))
            });
        }
        source.seek(SeekFrom::Start(0)).map_err(Error::reading)?;
        found.ok_or_else(|| Error::UnknownFormat(Self::names()))
    }
}

fn ends_in(source: &mut dyn Source, length: u64, foot: &[u8]) -> bool {
    let mut found = vec![0; foot.len()];
    length > foot.len() as u64
        && read_at(source, length - foot.len() as u64, &mut found).is_ok()
        && found == foot
}

fn read_at(source: &mut dyn Source, offset: u64, into: &mut [u8]) -> Result<(), Error> {
    source.seek(SeekFrom::Start(offset)).map_err(Error::reading)?;
    source.read_exact(into).map_err(Error::reading)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    #[test]
    fn names_tell_the_output_format() {
        for format in PictureFormat::written() {
            for extension in [format.extension().to_string(), format.extension().to_uppercase()] {
                let path = format!("a.b/c.{extension}");
                assert_eq!(PictureFormat::from_path(Path::new(&path)).ok(), Some(format), "format of {path}");
            }
        }
        for path in ["picture", "picture.", "picture.tga", ".png", "png"] {
            let error = PictureFormat::from_path(Path::new(path)).expect_err("the name says no known format");
            assert!(
                error.to_string().contains(".png, .exr, .hdr, .pfm"),
                "valid endings are listed: {error}"
            );
        }
    }

    #[test]
    fn bytes_tell_the_input_format() {
        let of =
            |bytes: &[u8], name: &str| PictureFormat::of(&mut Cursor::new(bytes), bytes.len() as u64, name);
        assert_eq!(of(b"PF\n1 1\n", "x.png").ok(), Some(PictureFormat::PFM), "bytes win over the name");
        assert_eq!(of(b"\0\0\x02", "x.TGA").ok(), Some(&raster::TGA), "a TGA is told by its name");
        let with_footer = [&[0; 20][..], b"TRUEVISION-XFILE.\0"].concat();
        assert_eq!(of(&with_footer, "x").ok(), Some(&raster::TGA), "a TGA is told by its footer");
        assert!(matches!(of(b"hello", "x.png"), Err(Error::UnknownFormat(_))), "text is no picture");
        assert!(matches!(of(b"", "x.png"), Err(Error::Corrupt { .. })), "an empty file is no picture");
    }
}

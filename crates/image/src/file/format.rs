// SPDX-License-Identifier: GPL-3.0-or-later
//! Which format a file has: by its first bytes when reading, by the ending of its name when writing.
//! The magic numbers are those of the formats. Invariant: names decide only for TGA, which has no
//! magic number at its beginning. Tests: `tests`.

use std::io::SeekFrom;
use std::path::Path;

use super::raster::RasterFormat;
use super::source::Source;
use crate::Error;

/// A format that pictures can be written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum OutputFormat {
    /// 8 bits, sRGB, for screens.
    Png,
    /// Linear, all layers.
    Exr,
    /// Linear 32-bit floats, colour only.
    Pfm,
    /// Linear, shared exponent, colour only.
    Hdr,
}

impl OutputFormat {
    /// All formats.
    pub const ALL: [Self; 4] = [Self::Png, Self::Exr, Self::Pfm, Self::Hdr];

    /// The ending of file names, without the dot.
    #[must_use]
    pub fn extension(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Exr => "exr",
            Self::Pfm => "pfm",
            Self::Hdr => "hdr",
        }
    }

    /// The format that a file's name ends in, in upper or lower case.
    ///
    /// # Errors
    /// [`Error::UnknownExtension`] lists the endings that are known.
    pub fn from_path(path: &Path) -> Result<Self, Error> {
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
        let named = Self::ALL.into_iter().find(|format| format.extension().eq_ignore_ascii_case(extension));
        named.ok_or_else(|| Error::UnknownExtension {
            path: path.into(),
            valid: Self::ALL.map(|format| format!(".{}", format.extension())).join(", "),
        })
    }
}

/// A format that pictures can be read from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum InputFormat {
    Exr,
    Pfm,
    Hdr,
    Tiff,
    Raster(RasterFormat),
}

const KNOWN: &str = "PNG, JPEG, TIFF, TGA, BMP, WebP, HDR, PFM, EXR";
const TGA_FOOTER: &[u8; 18] = b"TRUEVISION-XFILE.\0";

impl InputFormat {
    /// Tells the format and leaves the source at its beginning.
    pub(super) fn of(source: &mut dyn Source, length: u64, name: &str) -> Result<Self, Error> {
        let mut head = [0; 12];
        read_at(source, 0, &mut head[..length.min(12) as usize])?;
        if length == 0 {
            return Err(Error::Corrupt { format: "picture", what: "the file is empty".into() });
        }
        let format = Self::of_head(&head).or_else(|| is_tga(source, length, name).then_some(TGA));
        source.seek(SeekFrom::Start(0)).map_err(Error::reading)?;
        format.ok_or(Error::UnknownFormat(KNOWN))
    }

    fn of_head(head: &[u8; 12]) -> Option<Self> {
        match head {
            [0x89, b'P', b'N', b'G', b'\r', b'\n', 0x1a, b'\n', ..] => Some(Self::Raster(RasterFormat::Png)),
            [0xff, 0xd8, 0xff, ..] => Some(Self::Raster(RasterFormat::Jpeg)),
            [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => Some(Self::Tiff),
            [b'B', b'M', ..] => Some(Self::Raster(RasterFormat::Bmp)),
            [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P'] => {
                Some(Self::Raster(RasterFormat::Webp))
            }
            [0x76, 0x2f, 0x31, 0x01, ..] => Some(Self::Exr),
            [b'#', b'?', b'R', ..] => Some(Self::Hdr),
            [b'P', b'F' | b'f', space, ..] if space.is_ascii_whitespace() => Some(Self::Pfm),
            _ => None,
        }
    }
}

const TGA: InputFormat = InputFormat::Raster(RasterFormat::Tga);

fn is_tga(source: &mut dyn Source, length: u64, name: &str) -> bool {
    let extension = Path::new(name).extension().and_then(|e| e.to_str()).unwrap_or_default();
    let named = ["tga", "icb", "vda", "vst"].iter().any(|known| known.eq_ignore_ascii_case(extension));
    let mut footer = [0; TGA_FOOTER.len()];
    let has_footer = length > footer.len() as u64
        && read_at(source, length - footer.len() as u64, &mut footer).is_ok()
        && footer == *TGA_FOOTER;
    named || has_footer
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
        for format in OutputFormat::ALL {
            for extension in [format.extension().to_string(), format.extension().to_uppercase()] {
                let path = format!("a.b/c.{extension}");
                assert_eq!(OutputFormat::from_path(Path::new(&path)).ok(), Some(format), "format of {path}");
            }
        }
        for path in ["picture", "picture.", "picture.jpg", ".png", "png"] {
            let error = OutputFormat::from_path(Path::new(path)).expect_err("the name says no known format");
            assert!(
                error.to_string().contains(".png, .exr, .pfm, .hdr"),
                "valid endings are listed: {error}"
            );
        }
    }

    #[test]
    fn bytes_tell_the_input_format() {
        let of =
            |bytes: &[u8], name: &str| InputFormat::of(&mut Cursor::new(bytes), bytes.len() as u64, name);
        assert_eq!(of(b"PF\n1 1\n", "x.png").ok(), Some(InputFormat::Pfm), "bytes win over the name");
        assert_eq!(of(b"\0\0\x02", "x.TGA").ok(), Some(TGA), "a TGA is told by its name");
        let with_footer = [&[0; 20][..], TGA_FOOTER].concat();
        assert_eq!(of(&with_footer, "x").ok(), Some(TGA), "a TGA is told by its footer");
        assert!(matches!(of(b"hello", "x.png"), Err(Error::UnknownFormat(_))), "text is no picture");
        assert!(matches!(of(b"", "x.png"), Err(Error::Corrupt { .. })), "an empty file is no picture");
    }
}

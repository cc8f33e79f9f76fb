// SPDX-License-Identifier: GPL-3.0-or-later
//! How large a picture may be, from its declared size and the length of its file, before memory is taken.
//! Invariant: the memory of a picture during reading, its decoder's buffers included, stays below
//! [`Budget::of_picture`] or the caller's limit. Tests: `tests`, `tests/growth.rs`, and the corruption tests
//! of each format.

use crate::{Budget, Error};

/// Most pixels of a picture that is read: 2^28.
pub const MAX_PIXELS: u64 = 1 << 28;

/// Pictures of up to this many pixels are accepted however short their file is: 2^24, 256 MiB as floats.
const BELIEVED_PIXELS: u64 = 1 << 24;

/// Bytes of a pixel of a picture.
pub(super) const PICTURE_BYTES: u64 = 16;

impl Budget {
    /// Checks that this many bytes for each pixel may be taken.
    pub(super) fn check(
        &self,
        format: &'static str,
        [width, height]: [u64; 2],
        pixel_bytes: u64,
    ) -> Result<(), Error> {
        check_size(format, width, height)?;
        self.check_bytes([width, height], width * height * pixel_bytes)
    }

    /// Checks that this many bytes may be taken for a picture of that size.
    pub(super) fn check_bytes(&self, [width, height]: [u64; 2], needed: u64) -> Result<(), Error> {
        match needed <= self.left() {
            true => Ok(()),
            false => Err(Error::TooMuchMemory { width, height, needed, limit: self.limit() }),
        }
    }
}

/// Checks a declared size: at least one pixel, at most [`MAX_PIXELS`].
pub(super) fn check_size(format: &'static str, width: u64, height: u64) -> Result<(), Error> {
    if width == 0 || height == 0 {
        return Err(Error::corrupt(format, format!("the size {width} x {height} holds no pixel")));
    }
    match width.checked_mul(height) {
        Some(pixels) if pixels <= MAX_PIXELS => Ok(()),
        _ => Err(Error::TooLarge { width, height, limit: MAX_PIXELS }),
    }
}

/// Checks a declared size against a file's length, for compressed formats of which a byte can hold this many
/// pixels.
pub(super) fn check_density(
    format: &'static str,
    [width, height]: [u64; 2],
    length: u64,
    pixels_per_byte: u64,
) -> Result<(), Error> {
    check_size(format, width, height)?;
    if width * height > BELIEVED_PIXELS.max(length.saturating_mul(pixels_per_byte)) {
        return Err(too_short(format, [width, height], length));
    }
    Ok(())
}

/// Checks that the bytes a file must at least have are there.
pub(super) fn check_bytes(
    format: &'static str,
    [width, height]: [u64; 2],
    needed: u64,
    length: u64,
) -> Result<(), Error> {
    check_size(format, width, height)?;
    if needed > length { Err(too_short(format, [width, height], length)) } else { Ok(()) }
}

fn too_short(format: &'static str, [width, height]: [u64; 2], length: u64) -> Error {
    Error::corrupt(
        format,
        format!("{length} bytes are too few for {width} x {height} pixels; is it truncated?"),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_limits() {
        assert!(check_size("PNG", 1 << 14, 1 << 14).is_ok(), "2^28 pixels are allowed");
        assert!(
            matches!(check_size("PNG", (1 << 14) + 1, 1 << 14), Err(Error::TooLarge { .. })),
            "more are not"
        );
        assert!(matches!(check_size("PNG", u64::MAX, 2), Err(Error::TooLarge { .. })), "nor an overflow");
        assert!(matches!(check_size("PNG", 0, 2), Err(Error::Corrupt { .. })), "nor an empty picture");
    }

    #[test]
    fn memory_has_a_limit() {
        let side = 1 << 14;
        let budget = Budget::of_picture(2 << 20);
        let error = budget.check("PNG", [side, side], 24).expect_err("6 GiB of 2 MiB").to_string();
        assert!(
            error.contains("6144 MiB") && error.contains("512 MiB"),
            "what it takes and may take: {error}"
        );
        assert!(budget.check("PNG", [side, side / 8], 16).is_ok(), "512 MiB may be taken");
        assert!(
            Budget::of_picture(100 << 20).check("PNG", [side, side], 24).is_ok(),
            "a long file may take more"
        );
    }

    #[test]
    fn short_files_hold_no_large_pictures() {
        let large = [1 << 13, 1 << 13];
        assert!(check_density("PNG", large, 1 << 20, 64).is_ok(), "64 pixels a byte are believed");
        assert!(check_density("PNG", large, (1 << 20) - 1, 64).is_err(), "more are not");
        assert!(
            check_density("PNG", [1 << 12, 1 << 12], 1, 64).is_ok(),
            "pictures of usual size are believed"
        );
        assert!(check_bytes("PFM", [2, 2], 49, 48).is_err(), "missing bytes are noticed");
    }
}

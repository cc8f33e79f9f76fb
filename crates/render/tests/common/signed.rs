// SPDX-License-Identifier: GPL-3.0-or-later
//! The checksum of a checkpoint, for files that are changed on purpose.

/// Puts the right checksum to the end of `file`.
pub(crate) fn sign(file: &mut [u8]) {
    let Some((last, values)) = file.as_chunks_mut::<8>().0.split_last_mut() else { return };
    let sum = values.iter().fold(0, |sum: u64, value| {
        (sum ^ u64::from_le_bytes(*value)).wrapping_mul(0x0000_0100_0000_01b3).rotate_left(23)
    });
    *last = sum.to_le_bytes();
}

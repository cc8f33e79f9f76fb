// SPDX-License-Identifier: GPL-3.0-or-later
//! The checksum of a saved tree, word by word, for files that are changed on purpose.

/// Puts the right checksum to the end of `file`.
pub(crate) fn sign(file: &mut [u8]) {
    let Some(end) = file.len().checked_sub(8) else { return };
    let mut lanes = [0u32; 8];
    let values = file[..end].chunks_exact(4);
    let mut sum = values.len() as u64;
    for (i, value) in values.enumerate() {
        let value = u32::from_le_bytes([value[0], value[1], value[2], value[3]]);
        lanes[i % 8] = (lanes[i % 8] ^ value).rotate_left(13).wrapping_mul(0x9e37_79b1);
    }
    for lane in lanes {
        sum = (sum ^ u64::from(lane)).rotate_left(27).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    }
    file[end..].copy_from_slice(&sum.to_le_bytes());
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! The four pixels around a point, and their bilinear weights. Space: pixels of a picture, row by row.
//! Tests: `tests`, crates/render/tests/motion.rs.

/// The indices of the pixels around a point of a picture of this size, row by row, and their weights. `first` is the upper left pixel,
/// from -1 to the last column or row; `beyond` is the distance of the point from the middle of that pixel, in pixels. Pixels beside the
/// picture count as the nearest ones in it, and without weight.
#[inline(always)]
pub(super) fn around(first: [i32; 2], beyond: [f32; 2], size: [u32; 2]) -> ([usize; 4], [f32; 4]) {
    let side = |k: usize| {
        let (first, last, share) = (first[k], size[k] as i32 - 1, beyond[k]);
        let before = if first < 0 { 0.0 } else { 1.0 - share };
        let after = if first == last { 0.0 } else { share };
        ([first.max(0) as usize, (first + 1).min(last) as usize], [before, after])
    };
    let (columns, across) = side(0);
    let (rows, down) = side(1);
    let [above, below] = rows.map(|row| row * size[0] as usize);
    let at = [above + columns[0], above + columns[1], below + columns[0], below + columns[1]];
    (at, bilinear(across, down))
}

/// Products of the weights of two columns and of two rows.
#[inline(always)]
pub(super) fn bilinear([left, right]: [f32; 2], [above, below]: [f32; 2]) -> [f32; 4] {
    [left * above, right * above, left * below, right * below]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_beside_the_picture_have_no_weight() {
        let size = [4, 3];
        assert_eq!(around([1, 1], [0.25, 0.5], size), ([5, 6, 9, 10], [0.375, 0.125, 0.375, 0.125]));
        assert_eq!(around([-1, 0], [0.25, 0.0], size), ([0, 0, 4, 4], [0.0, 0.25, 0.0, 0.0]), "left of all");
        assert_eq!(around([3, 2], [0.25, 0.5], size), ([11, 11, 11, 11], [0.375, 0.0, 0.0, 0.0]), "the last");
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! The pixels of a picture in motion that are traced: all of them, or one of each cell of `stride` by
//! `stride` pixels, another one in each frame. Space: pixels from the left and the top; the centre of the
//! first one is at 0.5. Tests: `tests`.

/// Pixels of cells of two by two in the order of frames: opposite corners follow each other.
const TURNS: [[u32; 2]; 4] = [[0, 0], [1, 1], [1, 0], [0, 1]];

/// A grid of traced pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lattice {
    /// Columns and rows of the picture.
    pub(super) full: [u32; 2],
    /// 1 or 2.
    pub(super) stride: u32,
    offset: [u32; 2],
}

impl Lattice {
    pub(super) fn new(full: [u32; 2], stride: u32, frame: u32) -> Self {
        let is_whole = stride < 2;
        let offset = if is_whole { [0, 0] } else { TURNS[frame as usize % TURNS.len()] };
        Self { full, stride: if is_whole { 1 } else { 2 }, offset }
    }

    /// Columns and rows of traced pixels.
    pub(super) fn size(&self) -> [u32; 2] {
        self.full.map(|side| (side + self.stride - 1) >> (self.stride - 1))
    }

    /// The pixel of a column and a row of the lattice. The last one may be that at the edge.
    #[inline(always)]
    pub(super) fn pixel(&self, at: [u32; 2]) -> [u32; 2] {
        [0, 1].map(|k| (at[k] * self.stride + self.offset[k]).min(self.full[k] - 1))
    }

    /// Column and row of a point of the picture, 0 at the centres of the first ones.
    #[inline(always)]
    pub(super) fn column_and_row(&self, point: [f32; 2]) -> [f32; 2] {
        [0, 1].map(|k| (point[k] - 0.5 - self.offset[k] as f32) / self.stride as f32)
    }

    /// The columns (`axis` 0) or rows (1) of the lattice beside a column or row of the picture: the first, and
    /// the last one, which is the same where it is traced.
    #[inline(always)]
    pub(super) fn beside(&self, axis: usize, pixel: u32) -> [u32; 2] {
        // Divisions take as long as all the rest.
        let shift = self.stride - 1;
        let last = (self.full[axis] - 1) >> shift;
        let from = pixel + self.stride - self.offset[axis];
        let (below, rest) = (from >> shift, from & shift);
        // One cell was added, so that nothing is negative.
        [below.saturating_sub(1).min(last), (below - u32::from(rest == 0)).min(last)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_pixel_is_traced_once_in_four_frames() {
        for full in [[8, 6], [7, 5], [1, 1], [2, 3]] {
            let mut times = vec![0; (full[0] * full[1]) as usize];
            for frame in 0..4 {
                let lattice = Lattice::new(full, 2, frame);
                let [width, height] = lattice.size();
                let mut traced: Vec<[u32; 2]> = (0..height)
                    .flat_map(|y| (0..width).map(move |x| [x, y]))
                    .map(|at| lattice.pixel(at))
                    .collect();
                traced.sort_unstable();
                traced.dedup();
                traced.iter().for_each(|[x, y]| times[(y * full[0] + x) as usize] += 1);
            }
            assert!(times.iter().all(|&n| n >= 1), "{full:?}: {times:?}");
            let inside = |i: &usize| *i as u32 % full[0] + 1 < full[0] && *i as u32 / full[0] + 1 < full[1];
            assert!((0..times.len()).filter(inside).all(|i| times[i] == 1), "{full:?}: {times:?}");
        }
        let whole = Lattice::new([7, 5], 1, 3);
        assert_eq!((whole.size(), whole.pixel([6, 4])), ([7, 5], [6, 4]), "all pixels");
    }

    #[test]
    fn neighbours_are_those_beside() {
        for (stride, frame) in [(1, 0), (2, 0), (2, 1), (2, 2), (2, 3)] {
            let lattice = Lattice::new([9, 8], stride, frame);
            for axis in 0..2 {
                for pixel in 0..lattice.full[axis] {
                    let beside = lattice.beside(axis, pixel);
                    let at = beside.map(|i| lattice.pixel([i, i])[axis]);
                    let is_near = at.iter().all(|&at| at.abs_diff(pixel) < stride.max(1) + 1);
                    assert!(is_near, "stride {stride}, frame {frame}, axis {axis}, {pixel}: {at:?}");
                    let traced = (0..lattice.size()[axis]).any(|i| lattice.pixel([i, i])[axis] == pixel);
                    assert!(!traced || at.contains(&pixel), "{pixel} is traced: {at:?}");
                    let [column, row] = lattice.column_and_row([pixel as f32 + 0.5; 2]);
                    let expected = (beside[0] + beside[1]) as f32 / 2.0;
                    let is_inside = beside[0] != beside[1] || at[0] == pixel;
                    let found = [column, row][axis];
                    let is_clamped = at[1] + 1 == lattice.full[axis] && lattice.full[axis] % 2 == 1;
                    assert!(!is_inside || is_clamped || found == expected, "{pixel}: {found} {expected}");
                }
            }
        }
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Saving and loading of blocks of triangles. The format is that of [`super`].
//! Tests: `tests/saved.rs` of `gnurt-accel`.

use super::data::{StoredRecord, get_floats, put_floats};
use super::error::LoadError;
use crate::blocks::{TriangleBlock, WIDTH};
use crate::geometry::LARGEST_COORDINATE;

impl StoredRecord for TriangleBlock {
    const LENGTH: usize = 10 * WIDTH;

    #[inline(always)]
    fn put(&self, data: &mut [u32]) {
        let (corners, numbers) = data.split_at_mut(9 * WIDTH);
        put_floats(corners, self.corners.as_flattened().as_flattened());
        numbers.copy_from_slice(&self.numbers);
    }

    #[inline(always)]
    fn get(data: &[u32]) -> Self {
        let mut block = Self { corners: [[[0.0; WIDTH]; 3]; 3], numbers: [0; WIDTH] };
        let (corners, numbers) = data.split_at(9 * WIDTH);
        get_floats(block.corners.as_flattened_mut().as_flattened_mut(), corners);
        block.numbers.copy_from_slice(numbers);
        block
    }
}

impl TriangleBlock {
    /// Whether its triangles can be tested, where there are `count` in all.
    pub fn check(&self, count: u32) -> Result<(), LoadError> {
        check_numbers(&self.numbers, count)?;
        check_corners(self.corners.as_flattened().as_flattened())
    }
}

/// Whether these can be the numbers of a block.
///
/// # Errors
/// They are invalid.
pub fn check_numbers(numbers: &[u32; WIDTH], count: u32) -> Result<(), LoadError> {
    let all = numbers.iter().all(|&number| number < count);
    if all { Ok(()) } else { Err(LoadError::Damaged("a block names a triangle that does not exist")) }
}

/// Whether these can be the corners of a block.
///
/// # Errors
/// They are invalid.
pub fn check_corners(corners: &[f32]) -> Result<(), LoadError> {
    // The greatest as bits, which NaN is as well.
    let greatest = corners.iter().fold(0, |most, x| most.max(x.abs().to_bits()));
    let near = greatest <= LARGEST_COORDINATE.to_bits();
    if near { Ok(()) } else { Err(LoadError::Damaged("a corner is too far away")) }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Primitives that cannot be traced, and the limits of those that can. Tests: `valid_triangles::tests`, `tests/limits.rs` of
//! `gnurt-accel`.

/// Coordinates beyond this are dropped: squares of their differences still fit a float.
pub const LARGEST_COORDINATE: f32 = 1.8e18;

/// Most triangles of one object: the limit of an event's number in the builder. Quads count twice, spheres
/// discs, curves and primitives of user geometries once.
pub const MOST_TRIANGLES: usize = (1 << 30) - 1;

/// Primitives that were left out of a tree, by the first fault found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BadPrimitives {
    /// An index that is not below the number of positions.
    pub bad_index: u64,
    /// A coordinate that is not a number.
    pub nan: u64,
    /// An infinite coordinate.
    pub infinite: u64,
    /// A coordinate beyond [`LARGEST_COORDINATE`].
    pub too_large: u64,
    /// Corners on one line or in one point; spheres, discs and curves without a radius.
    pub zero_area: u64,
    /// More than [`MOST_TRIANGLES`] in one object.
    pub too_many: u64,
}

impl BadPrimitives {
    /// All of them.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.bad_index + self.nan + self.infinite + self.too_large + self.zero_area + self.too_many
    }

    /// Where to count a primitive with these coordinates, if they have a fault.
    pub fn fault(&mut self, coordinates: impl Iterator<Item = f32> + Clone) -> Option<&mut u64> {
        let any = |test: fn(f32) -> bool| coordinates.clone().any(test);
        if any(f32::is_nan) {
            Some(&mut self.nan)
        } else if any(f32::is_infinite) {
            Some(&mut self.infinite)
        } else if any(|x| x.abs() > LARGEST_COORDINATE) {
            Some(&mut self.too_large)
        } else {
            None
        }
    }
}

impl std::ops::AddAssign for BadPrimitives {
    fn add_assign(&mut self, other: Self) {
        self.bad_index += other.bad_index;
        self.nan += other.nan;
        self.infinite += other.infinite;
        self.too_large += other.too_large;
        self.zero_area += other.zero_area;
        self.too_many += other.too_many;
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Saving and loading of spheres and their tree. The format is that of `crate::store`. Tests:
//! `tests/saved.rs`.

use std::io::{self, Read, Write};

use super::{SphereBlock, SphereIndex};
use crate::blocked::Blocked;
use crate::node::WIDTH;
use crate::tree::Tree;
use gnurt_accel_core::store::{LoadError, Reader, StoredRecord, Writer, get_floats, put_floats};
use gnurt_accel_core::{Aabb, INVALID_ID, LARGEST_COORDINATE, Memory};

impl StoredRecord for SphereBlock {
    const LENGTH: usize = 5 * WIDTH;

    #[inline(always)]
    fn put(&self, data: &mut [u32]) {
        let (centers, rest) = data.split_at_mut(3 * WIDTH);
        let (radii, numbers) = rest.split_at_mut(WIDTH);
        put_floats(centers, self.center.as_flattened());
        put_floats(radii, &self.radius);
        numbers.copy_from_slice(&self.numbers);
    }

    #[inline(always)]
    fn get(data: &[u32]) -> Self {
        let mut block =
            Self { center: [[0.0; WIDTH]; 3], radius: [0.0; WIDTH], numbers: [INVALID_ID; WIDTH] };
        let (centers, rest) = data.split_at(3 * WIDTH);
        let (radii, numbers) = rest.split_at(WIDTH);
        get_floats(block.center.as_flattened_mut(), centers);
        get_floats(&mut block.radius, radii);
        block.numbers.copy_from_slice(numbers);
        block
    }
}

impl SphereBlock {
    /// Whether each lane is a sphere, or nothing.
    fn is_sound(&self, count: u32) -> bool {
        (0..WIDTH).all(|lane| {
            let (number, radius) = (self.numbers[lane], self.radius[lane]);
            let near = self.center.iter().all(|row| row[lane].abs() <= LARGEST_COORDINATE);
            let nothing = number == INVALID_ID && radius.is_nan();
            near && (nothing || number < count && radius > 0.0 && radius <= LARGEST_COORDINATE)
        })
    }
}

impl SphereIndex {
    /// Writes the tree.
    ///
    /// # Errors
    /// Those of where it goes.
    pub fn save(&self, writer: &mut Writer<'_, impl Write>) -> io::Result<()> {
        self.0.tree.save(writer)?;
        writer.list(&self.0.blocks)
    }

    /// Whether it is compact.
    pub fn is_compact(&self) -> bool {
        self.0.is_compact()
    }

    /// The lists as they are; [`check`](Self::check) comes after the checksum.
    pub fn load(reader: &mut Reader<'_, impl Read>, memory: Memory, bounds: Aabb) -> Result<Self, LoadError> {
        let tree = Tree::load(reader, memory, bounds)?;
        let blocks: Vec<SphereBlock> = reader.list(1 << 27)?;
        Ok(Self(Blocked::of_parts(tree, blocks)))
    }

    /// Checks all properties that a traversal relies on, for `count` primitives. Then the tree is measured.
    ///
    /// # Errors
    /// The violated property.
    pub fn check(&mut self, count: u32) -> Result<(), LoadError> {
        if !self.0.blocks.iter().all(|block| block.is_sound(count)) {
            return Err(LoadError::Damaged("invalid sphere"));
        }
        self.0.tree.check(self.0.blocks.len())?;
        let numbers = self.0.blocks.iter().flat_map(|block| block.numbers);
        self.0.measure_again(numbers.filter(|&number| number != INVALID_ID).count() as u64);
        Ok(())
    }
}

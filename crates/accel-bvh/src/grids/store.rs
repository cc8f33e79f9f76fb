// SPDX-License-Identifier: GPL-3.0-or-later
//! Vertices and blocks of grids in files. Tests: `tests/grid_meshes.rs` of `gnurt-accel`.

use std::io::{self, Read, Write};
use std::sync::Arc;

use gnurt_accel_core::patches::OwnedVertices;
use gnurt_accel_core::store::{LoadError, Reader, StoredRecord, Writer, get_bytes, put_bytes};

use super::GridBlock;
use crate::blocked::{BlockData, BlockKind};
use crate::index::Whole;
use crate::node::WIDTH;

impl BlockData for Arc<OwnedVertices> {
    fn memory_bytes(&self) -> usize {
        OwnedVertices::memory_bytes(self)
    }

    fn save(&self, writer: &mut Writer<'_, impl Write>) -> io::Result<()> {
        writer.list(self.given().as_flattened())
    }

    fn load(reader: &mut Reader<'_, impl Read>) -> Result<Self, LoadError> {
        let floats: Vec<f32> = reader.list(u32::MAX as usize)?;
        Ok(Self::new(OwnedVertices::new(floats.as_chunks().0)))
    }
}

/// Words of the boxes; of the rest: numbers, vertices, strides, columns and halves.
const BOXES: usize = <Whole as StoredRecord>::LENGTH;

impl StoredRecord for GridBlock {
    const LENGTH: usize = BOXES + 3 * WIDTH + WIDTH / 2 + WIDTH / 4;

    fn put(&self, data: &mut [u32]) {
        let (boxes, rest) = data.split_at_mut(BOXES);
        let (words, rest) = rest.split_at_mut(3 * WIDTH);
        let (columns, halves) = rest.split_at_mut(WIDTH / 2);
        Whole(self.boxes.clone(), [0.0; WIDTH]).put(boxes);
        for (to, row) in words.chunks_mut(WIDTH).zip([&self.numbers, &self.vertices, &self.strides]) {
            to.copy_from_slice(row);
        }
        for (word, &[low, high]) in columns.iter_mut().zip(self.columns.as_chunks().0) {
            *word = u32::from(low) | u32::from(high) << 16;
        }
        put_bytes(halves, &self.halves);
    }

    fn get(data: &[u32]) -> Self {
        let mut block = Self::empty();
        let (boxes, rest) = data.split_at(BOXES);
        let (words, rest) = rest.split_at(3 * WIDTH);
        let (columns, halves) = rest.split_at(WIDTH / 2);
        let Whole(node, _) = Whole::get(boxes);
        block.boxes = node;
        let rows = [&mut block.numbers, &mut block.vertices, &mut block.strides];
        rows.into_iter().zip(words.chunks(WIDTH)).for_each(|(row, from)| row.copy_from_slice(from));
        for (two, &word) in block.columns.as_chunks_mut().0.iter_mut().zip(columns) {
            *two = [word as u16, (word >> 16) as u16];
        }
        get_bytes(&mut block.halves, halves);
        block
    }
}

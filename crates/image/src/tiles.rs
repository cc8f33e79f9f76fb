// SPDX-License-Identifier: GPL-3.0-or-later
//! Textures that are larger than memory: cut into tiles on the disk, of which a fixed number is in memory at a time.
//! Source: \[PKGH97\] (textures by tiles on demand), \[Boe12\] (reading under a version number); original. A
//! texel keeps its value, bit for bit: pictures do not change.
//! * All tiles are in a file, `tile_file.rs`.
//! * Each tile has an entry in its picture's list: the number of its slot in memory, or none. A reader finds
//!   the slot, reads, and checks that the slot's version is still the same: no lock. A reader that misses a
//!   tile reads it from the file into its own memory. Then it waits for the one lock, to store the tile in
//!   the least recently used slot, approximately \[Cor68\].
//! * A tile that cannot be read from the file any more is white; such reads are counted.
//!
//! Tests: `tests`; crates/render/tests/filtering.rs with many readers at once; crates/cli/tests/program/textures.rs for a scene's picture.

use std::fmt;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering, fence};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use crate::Error;
use crate::tile_file::{Cutter, TILE_BYTES, TileFile, WORDS, tile_size};

/// Tiles in memory at least, so that threads do not take them from each other while they are read.
const LEAST_TILES: usize = 64;
/// Tiles whose memory is allocated together, when the first of them is needed: 16 MiB.
const GROUP: usize = 1024;

/// Tiles of textures: a part of them in memory, all of them in a temporary file. Clones share it.
#[derive(Clone)]
pub struct TileCache(Arc<Shared>);

struct Shared {
    file: TileFile,
    /// The number of tiles that may be in memory.
    most: usize,
    /// [`GROUP`] each, the last of fewer.
    slots: Box<[OnceLock<Box<[Slot]>>]>,
    clock: Mutex<Clock>,
    read: AtomicU64,
    failed: AtomicU64,
}

/// A tile in memory.
struct Slot {
    /// Odd while it is written.
    version: AtomicU32,
    /// Whether it was read from since the hand passed.
    was_read: AtomicBool,
    cells: Box<[AtomicU64]>,
}

/// The next slot, and the owners of the slots in use.
struct Clock {
    hand: usize,
    owners: Vec<Option<(Arc<Slots>, usize)>>,
}

/// Where a picture's tiles are.
struct Slots {
    /// In the file, of the first tile.
    offset: u64,
    /// Slot of each tile and 1, row by row; 0 = not in memory.
    slots: Box<[AtomicU32]>,
}

/// A picture in tiles.
#[derive(Clone)]
pub(crate) struct Tiles {
    cache: TileCache,
    tile_slots: Arc<Slots>,
    /// Of a texel: 4, 8 or 16.
    bytes: usize,
    /// Tiles next to each other.
    across: usize,
}

/// The counts of a cache.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TileCounts {
    /// Bytes that the tiles in memory may take.
    pub memory_bytes: u64,
    /// Bytes of all tiles, in the file.
    pub file_bytes: u64,
    /// Tiles that were read from the file.
    pub read: u64,
    /// Reads that failed: their texels are white.
    pub failed: u64,
}

impl TileCache {
    /// A cache whose tiles take about this many bytes of memory; a megabyte at least.
    ///
    /// # Errors
    /// [`Error::File`] if the temporary folder takes no file.
    pub fn new(memory_bytes: u64) -> Result<Self, Error> {
        let count = usize::try_from(memory_bytes / TILE_BYTES as u64).unwrap_or(usize::MAX);
        let count = count.clamp(LEAST_TILES, u32::MAX as usize - 1);
        Ok(Self(Arc::new(Shared {
            file: TileFile::new()?,
            most: count,
            slots: (0..count.div_ceil(GROUP)).map(|_| OnceLock::new()).collect(),
            clock: Mutex::new(Clock { hand: 0, owners: Vec::new() }),
            read: AtomicU64::new(0),
            failed: AtomicU64::new(0),
        })))
    }

    /// Its counts so far.
    #[must_use]
    pub fn counts(&self) -> TileCounts {
        TileCounts {
            memory_bytes: (self.0.most * TILE_BYTES) as u64,
            file_bytes: self.0.file.len(),
            read: self.0.read.load(Ordering::Relaxed),
            failed: self.0.failed.load(Ordering::Relaxed),
        }
    }

    /// Stores a picture whose texels have 4, 8 or 16 bytes: `push_rows` gives all its rows.
    pub(crate) fn store(
        &self,
        size: [usize; 2],
        bytes: usize,
        push_rows: impl FnOnce(&mut Cutter) -> Result<(), Error>,
    ) -> Result<Tiles, Error> {
        let mut cutter = self.0.file.cutter(size, bytes);
        push_rows(&mut cutter)?;
        let Cutter { across, down, offset, .. } = cutter.finish()?;
        let slots = (0..across * down).map(|_| AtomicU32::new(0)).collect();
        Ok(Tiles { cache: self.clone(), tile_slots: Arc::new(Slots { offset, slots }), bytes, across })
    }
}

impl Shared {
    /// Reads words `first` and those behind it of a tile; all ones if they are lost.
    #[inline(always)]
    fn cells(&self, tile_slots: &Arc<Slots>, tile: usize, first: usize, to: &mut [u64]) {
        let tile_slot = &tile_slots.slots[tile];
        let entry = tile_slot.load(Ordering::Acquire);
        if entry != 0 {
            let slot = self.slot(entry as usize - 1);
            let version = slot.version.load(Ordering::Acquire);
            // If the slot is the tile's still, this version is of the tile.
            if version.is_multiple_of(2) && tile_slot.load(Ordering::Acquire) == entry {
                let cells = &slot.cells[first..first + to.len()];
                to.iter_mut().zip(cells).for_each(|(to, cell)| *to = cell.load(Ordering::Relaxed));
                fence(Ordering::Acquire);
                if slot.version.load(Ordering::Relaxed) == version {
                    if !slot.was_read.load(Ordering::Relaxed) {
                        slot.was_read.store(true, Ordering::Relaxed);
                    }
                    return;
                }
            }
        }
        self.fetch(tile_slots, tile, first, to);
    }

    /// The same for a tile that is not in memory: reads it, and finds it a slot.
    #[cold]
    fn fetch(&self, tile_slots: &Arc<Slots>, tile: usize, first: usize, to: &mut [u64]) {
        let mut bytes = vec![0; TILE_BYTES];
        self.read.fetch_add(1, Ordering::Relaxed);
        if self.file.read(tile_slots.offset + (tile * TILE_BYTES) as u64, &mut bytes).is_err() {
            self.failed.fetch_add(1, Ordering::Relaxed);
            return to.fill(u64::MAX);
        }
        let cells = || bytes.as_chunks().0.iter().map(|&bytes| u64::from_le_bytes(bytes));
        to.iter_mut().zip(cells().skip(first)).for_each(|(to, cell)| *to = cell);
        // A thread that died here has left a slot with an odd version, which is never read and written by the
        // next one.
        let mut clock = self.clock.lock().unwrap_or_else(PoisonError::into_inner);
        if tile_slots.slots[tile].load(Ordering::Acquire) == 0 {
            let number = self.victim(&mut clock);
            let slot = self.slot(number);
            if let Some((before, tile)) = clock.owners[number].take() {
                before.slots[tile].store(0, Ordering::Release);
            }
            let version = slot.version.load(Ordering::Relaxed) | 1;
            slot.version.store(version, Ordering::Relaxed);
            fence(Ordering::Release);
            slot.cells.iter().zip(cells()).for_each(|(to, cell)| to.store(cell, Ordering::Relaxed));
            slot.version.store(version.wrapping_add(1), Ordering::Release);
            slot.was_read.store(true, Ordering::Relaxed);
            clock.owners[number] = Some((tile_slots.clone(), tile));
            tile_slots.slots[tile].store(number as u32 + 1, Ordering::Release);
        }
    }

    #[inline]
    fn slot(&self, number: usize) -> &Slot {
        let slot = |_| Slot {
            version: AtomicU32::new(0),
            was_read: AtomicBool::new(false),
            cells: (0..WORDS).map(|_| AtomicU64::new(0)).collect(),
        };
        let first = number - number % GROUP;
        let slots = || (first..self.most.min(first + GROUP)).map(slot).collect();
        &self.slots[number / GROUP].get_or_init(slots)[number % GROUP]
    }

    /// A slot that was never used, or the next one that was not read from since the hand passed it.
    fn victim(&self, clock: &mut Clock) -> usize {
        if clock.owners.len() < self.most {
            clock.owners.push(None);
            return clock.owners.len() - 1;
        }
        for _ in 0..2 * self.most {
            let number = clock.hand;
            clock.hand = (number + 1) % self.most;
            if !self.slot(number).was_read.swap(false, Ordering::Relaxed) {
                return number;
            }
        }
        clock.hand
    }
}

impl Tiles {
    /// The cache that they are in.
    pub(crate) fn cache(&self) -> &TileCache {
        &self.cache
    }

    /// The bytes of a texel, the first in the lowest bits; all ones if they are lost.
    #[inline]
    pub(crate) fn texel(&self, column: usize, row: usize) -> [u64; 2] {
        let [columns, rows] = tile_size(self.bytes);
        let tile = row / rows * self.across + column / columns;
        let at = (row % rows * columns + column % columns) * self.bytes;
        let mut found = [0; 2];
        let count = if self.bytes == 16 { 2 } else { 1 };
        self.cache.0.cells(&self.tile_slots, tile, at / 8, &mut found[..count]);
        if at % 8 == 4 { [found[0] >> 32, 0] } else { found }
    }

    /// The result of [`texel`](Self::texel) for each column of a row, tile by tile.
    pub(crate) fn row(&self, row: usize, width: usize, mut take: impl FnMut(usize, [u64; 2])) {
        let [columns, rows] = tile_size(self.bytes);
        let mut cells = [0; 64];
        let cells = &mut cells[..columns * self.bytes / 8];
        for (tile, first) in (0..width).step_by(columns).enumerate() {
            let tile = row / rows * self.across + tile;
            self.cache.0.cells(&self.tile_slots, tile, row % rows * cells.len(), cells);
            for column in first..width.min(first + columns) {
                let at = (column - first) * self.bytes / 8;
                let raw = match self.bytes {
                    4 => [if column % 2 == 1 { cells[at] >> 32 } else { cells[at] }, 0],
                    8 => [cells[at], 0],
                    _ => [cells[at], cells[at + 1]],
                };
                take(column, raw);
            }
        }
    }

    /// Bytes that they take in addition to their share of the cache.
    pub(crate) fn memory_bytes(&self) -> usize {
        size_of_val(&self.tile_slots.slots[..])
    }
}

/// Tiles are the same if they are the same ones.
impl PartialEq for Tiles {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.tile_slots, &other.tile_slots)
    }
}

impl PartialEq for TileCache {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl Eq for TileCache {}

impl fmt::Debug for TileCache {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("TileCache").field(&self.counts()).finish()
    }
}

impl fmt::Debug for Tiles {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Tiles")
            .field("bytes", &self.bytes)
            .field("tiles", &self.tile_slots.slots.len())
            .finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{TexelData, Texels, Weigh};

    /// A picture whose texels all differ, in one of the forms.
    fn picture(form: usize, width: u32, height: u32) -> Texels {
        let all = 0..width * height;
        let mixed = |i: u32| i.wrapping_mul(0x9e37_79b9) ^ (i << 7);
        let data = match form {
            0 => TexelData::Srgb8(all.map(|i| mixed(i).to_le_bytes()).collect()),
            1 => TexelData::Linear8(all.map(|i| mixed(i).to_le_bytes()).collect()),
            2 => TexelData::Linear16(all.map(|i| [mixed(i) as u16, i as u16, 7, (i >> 3) as u16]).collect()),
            _ => TexelData::Float(all.map(|i| [i as f32, 0.1 * i as f32, -1.0, mixed(i) as f32]).collect()),
        };
        Texels { width, height, data }
    }

    #[test]
    fn texels_are_what_they_were() {
        let cache = TileCache::new(0).expect("a file");
        for form in 0..4 {
            for (width, height) in [(1, 1), (64, 64), (65, 33), (200, 131)] {
                let plain = picture(form, width, height);
                let tiled = cache.keep(plain.clone()).expect("room on the disk");
                for (x, y) in (0..height as usize).flat_map(|y| (0..width as usize).map(move |x| (x, y))) {
                    assert_eq!(
                        tiled.texel(x, y),
                        plain.texel(x, y),
                        "form {form}, {width} x {height} at {x}, {y}"
                    );
                }
                assert_eq!(tiled.clone().resident().data, plain.data, "back in memory");
                let levels = tiled.pyramid(Weigh::Alike);
                for (tiled, plain) in levels.into_iter().zip(plain.pyramid(Weigh::Alike)) {
                    assert!(matches!(tiled.data, TexelData::Tiled(..)), "smaller copies are in tiles, too");
                    assert_eq!(tiled.resident().data, plain.data, "and the same");
                }
            }
        }
        assert_eq!(cache.counts().failed, 0);
    }

    #[test]
    fn memory_is_taken_when_it_is_wanted() {
        let cache = TileCache::new(1 << 44).expect("a file");
        assert_eq!(cache.counts().memory_bytes, 1 << 44, "sixteen tebibytes may be taken");
        let tiled = cache.keep(picture(0, 100, 100)).expect("room on the disk");
        assert_eq!(tiled.texel(99, 99), picture(0, 100, 100).texel(99, 99));
        assert_eq!(cache.0.slots.iter().filter(|slots| slots.get().is_some()).count(), 1, "and are not");
    }

    #[test]
    fn what_is_lost_is_white_and_counted() {
        for form in 0..4 {
            let cache = TileCache::new(0).expect("a file");
            let tiled = cache.keep(picture(form, 100, 100)).expect("room on the disk");
            cache.0.file.lose();
            assert_eq!(tiled.texel(70, 70), [1.0; 4], "form {form}");
            assert_eq!(cache.counts().failed, 1, "counted");
        }
    }
}

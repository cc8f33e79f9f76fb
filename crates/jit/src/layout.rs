// SPDX-License-Identifier: GPL-3.0-or-later
//! The memory layout of a running group: masks, cells, constants and temporaries. A cell that may differ from
//! point to point is a row of words, one for each lane, another one a single word.
//! Tests: `tests/agreement.rs`, `tests/chance.rs`.

use crate::term::QuickMap;

/// Where a cell is, in bytes from the start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CellAddress {
    /// A word for each lane.
    Each(u32),
    /// One word for all.
    One(u32),
}

/// Values that may be without a register at once.
pub(crate) const SPILLS: u32 = 1024;
/// Bytes of a group's memory.
const LARGEST: usize = 256 << 20;

/// The memory of a group.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    /// Points at once: 16, 32 or 1.
    pub(crate) lanes: usize,
    cells: Vec<CellAddress>,
    constants: QuickMap<u32, u32>,
    list: Vec<u32>,
    /// Words of a constant.
    copies: u32,
    lane_bits: u32,
    scratch: u32,
    spills: u32,
    first_constant: u32,
}

impl Layout {
    /// The mask of the lanes that run: bits.
    pub(crate) const EXEC: u32 = 0;
    /// Remaining iterations of loops.
    pub(crate) const FUEL: u32 = 4;
    /// Masks start here.
    const SLOTS: u32 = 64;

    /// The slot of a mask.
    pub(crate) const fn slot(slot: u32) -> u32 {
        Self::SLOTS + 4 * slot
    }

    /// For this many masks, and cells that differ from point to point or not. A constant is there `copies`
    /// times in a row.
    ///
    /// # Errors
    /// That it is too large.
    pub(crate) fn new(lanes: usize, slots: u32, varying: &[bool], copies: u32) -> Result<Self, String> {
        let up = |x: usize| x.next_multiple_of(64);
        let lane_bits = up(Self::slot(slots) as usize);
        let scratch = lane_bits + up(4 * lanes);
        let spills = scratch + 128;
        let mut at = spills + 64 * SPILLS as usize;
        let mut cells = Vec::with_capacity(varying.len());
        for &v in varying {
            if v && lanes > 1 {
                at = up(at);
                cells.push(CellAddress::Each(at as u32));
                at += 4 * lanes;
            } else {
                cells.push(CellAddress::One(at as u32));
                at += 4;
            }
            if at > LARGEST {
                return Err(format!("the group needs more than {} MiB for {lanes} points", LARGEST >> 20));
            }
        }
        Ok(Self {
            lanes,
            cells,
            constants: QuickMap::default(),
            list: Vec::new(),
            copies,
            lane_bits: lane_bits as u32,
            scratch: scratch as u32,
            spills: spills as u32,
            first_constant: up(at) as u32,
        })
    }

    pub(crate) fn address(&self, cell: u32) -> CellAddress {
        self.cells[cell as usize]
    }

    /// The bits of lanes; two rows for work; slots for values without a register.
    pub(crate) const fn areas(&self) -> [u32; 3] {
        [self.lane_bits, self.scratch, self.spills]
    }

    /// Where a constant is.
    pub(crate) fn constant(&mut self, bits: u32) -> u32 {
        let next = self.first_constant + 4 * self.copies * self.list.len() as u32;
        *self.constants.entry(bits).or_insert_with(|| {
            self.list.push(bits);
            next
        })
    }

    /// The memory's length in lines of sixteen words.
    pub(crate) fn lines(&self) -> usize {
        let end = self.first_constant as usize / 4 + self.copies as usize * self.list.len();
        // A row may be loaded from the last word.
        end.div_ceil(16) + 1
    }

    /// Writes the memory as it starts over zeros.
    pub(crate) fn start(&self, memory: &[u32], cell_values: &mut [u32]) {
        for i in 0..self.lanes {
            cell_values[self.lane_bits as usize / 4 + i] = 1 << i;
        }
        for (&address, &cell_value) in self.cells.iter().zip(memory) {
            match address {
                CellAddress::Each(at) => cell_values[at as usize / 4..][..self.lanes].fill(cell_value),
                CellAddress::One(at) => cell_values[at as usize / 4] = cell_value,
            }
        }
        for (k, &bits) in self.list.iter().enumerate() {
            let at = self.first_constant as usize / 4 + k * self.copies as usize;
            cell_values[at..at + self.copies as usize].fill(bits);
        }
    }
}

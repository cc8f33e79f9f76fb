// SPDX-License-Identifier: GPL-3.0-or-later
//! What a back end has to provide: registers, lanes, and instructions in the order that `control` and
//! `region` ask for. Memory is addressed from one fixed register by a distance in bytes.
//! Invariant: the two [`Word`]s are for control alone, and vector registers hold nothing between regions.
//! Tests: `tests/agreement.rs`, `tests/chance.rs`.

use gnurt_simd::Level;
use std::ops::Range;

use crate::op::{Binary, Shift, Unary};

/// How many lanes an instruction has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Width {
    /// A vector of which the first lane counts.
    One,
    /// 128 bits.
    Four,
    /// 256 bits.
    Eight,
    /// 512 bits.
    Sixteen,
}

impl Width {
    /// Lanes that count.
    pub(crate) const fn lanes(self) -> usize {
        match self {
            Self::One => 1,
            Self::Four => 4,
            Self::Eight => 8,
            Self::Sixteen => 16,
        }
    }
}

/// The last source of an instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Source {
    /// A vector register.
    Reg(u8),
    /// All lanes, at this distance in memory.
    Mem(u32),
    /// One number for all lanes.
    Each(u32),
}

/// The sources that instructions take from memory, so that no register is loaded with them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum FromMemory {
    /// None.
    Nothing,
    /// [`Source::Mem`].
    Rows,
    /// That, and [`Source::Each`].
    All,
}

/// How a vector decides between two others by a mask that is a vector, too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Choice {
    /// Into any register; the second source may be in memory.
    Anywhere,
    /// Into the register of the mask; the third source may be in memory.
    IntoMask,
}

/// A target of jumps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Label(u32);

/// Bytes of code, with jumps whose targets may follow.
#[derive(Default)]
pub(crate) struct Text {
    pub(crate) bytes: Vec<u8>,
    /// Offsets of labels; `u32::MAX` where they are not known yet.
    labels: Vec<u32>,
    /// Places of four bytes with distances that are still to be filled in.
    jumps: Vec<(u32, Label)>,
}

impl Text {
    pub(crate) fn label(&mut self) -> Label {
        self.labels.push(u32::MAX);
        Label(self.labels.len() as u32 - 1)
    }

    /// Puts a label here.
    pub(crate) fn bind(&mut self, label: Label) {
        self.labels[label.0 as usize] = self.bytes.len() as u32;
    }

    /// The offset of a label.
    pub(crate) fn address(&self, label: Label) -> u32 {
        self.labels[label.0 as usize]
    }

    /// Four bytes with a distance to be filled in.
    pub(crate) fn jump(&mut self, bytes: [u8; 4], label: Label) {
        self.jumps.push((self.bytes.len() as u32, label));
        self.bytes.extend_from_slice(&bytes);
    }

    /// Gives `set` the four bytes of each jump and the distance from them to their target, and returns the
    /// code.
    ///
    /// # Errors
    /// Those of `set`.
    pub(crate) fn finish(
        &mut self,
        set: impl Fn(&mut [u8; 4], i32) -> Result<(), String>,
    ) -> Result<Vec<u8>, String> {
        for (at, label) in std::mem::take(&mut self.jumps) {
            let distance = self.labels[label.0 as usize].wrapping_sub(at) as i32;
            if let Some(place) = self.bytes[at as usize..].first_chunk_mut() {
                set(place, distance)?;
            }
        }
        Ok(std::mem::take(&mut self.bytes))
    }
}

/// The registers for whole numbers that control uses: masks as bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Word {
    A = 0,
    B = 1,
}

/// The memory areas of regions other than cells.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Areas {
    /// Values that found no register, 64 bytes each.
    pub(crate) spills: u32,
    /// Two rows for divisions of whole numbers.
    pub(crate) scratch: u32,
    /// The bit of each lane, 32 bits each.
    pub(crate) lane_bits: u32,
}

/// Code in the making, of one kind of machine.
pub(crate) trait Isa: Default {
    /// The lanes of its instructions.
    fn wide(level: Level) -> Width;
    /// How often a constant is repeated in memory, so that a register can be loaded from there.
    fn copies(level: Level) -> u32;
    /// Vector registers for values: from 0 to below this, at most 32.
    fn registers(width: Width) -> usize;
    /// Registers for masks alone, below 8 and above 0; none where masks are vectors.
    fn mask_registers(width: Width) -> Range<usize>;
    fn from_memory(width: Width) -> FromMemory;
    /// Whether it has [`Shift::Around`]; else that is made of the two others.
    fn rotates(width: Width) -> bool;
    fn choice(width: Width) -> Choice;
    /// Whether [`write_test`](Self::write_test) and [`write_mask`](Self::write_mask) leave all lanes' bits in
    /// [`Word::A`].
    fn leaves_test(width: Width) -> bool;

    fn text(&mut self) -> &mut Text;
    /// Fills in the distances of all jumps, and returns the code.
    ///
    /// # Errors
    /// That one of them is too large.
    fn finish(&mut self) -> Result<Vec<u8>, String>;

    /// A function of the memory, the context of calls, their target, and the code to call: keeps the
    /// registers that are not its own.
    fn entry(&mut self);
    /// The start of a function without arguments.
    fn start_function(&mut self);
    fn end_function(&mut self);
    /// Calls such a function.
    fn call(&mut self, label: Label);
    /// Calls out of the code, with a number.
    fn call_out(&mut self, number: u32);

    fn jump(&mut self, label: Label);
    fn jump_if_zero(&mut self, word: Word, label: Label);
    fn jump_if_not_zero(&mut self, word: Word, label: Label);
    /// Of a word in memory.
    fn jump_if_zero_at(&mut self, at: u32, label: Label);
    /// Takes from a word in memory, and jumps if the rest is not negative.
    fn spend(&mut self, at: u32, less: u32, label: Label);
    fn load_word(&mut self, word: Word, at: u32);
    fn store_word(&mut self, word: Word, at: u32);
    /// `word &= memory`
    fn and_word(&mut self, word: Word, at: u32);
    /// `word |= memory`
    fn or_word(&mut self, word: Word, at: u32);
    /// `memory |= word`
    fn or_into(&mut self, word: Word, at: u32);
    fn clear(&mut self, at: u32);
    fn and(&mut self, to: Word, from: Word);
    fn xor(&mut self, to: Word, from: Word);
    /// `to &= !from`; what is in `from` is lost.
    fn and_not(&mut self, to: Word, from: Word);

    fn zero(&mut self, width: Width, reg: u8);
    fn load_constant(&mut self, width: Width, reg: u8, at: u32);
    /// One number of memory, in all lanes; with one lane, zeros in the others.
    fn load_each(&mut self, width: Width, reg: u8, at: u32);
    /// All lanes of memory.
    fn load(&mut self, width: Width, reg: u8, at: u32);
    /// All lanes to memory.
    fn store(&mut self, width: Width, reg: u8, at: u32);
    /// The first lane to memory.
    fn store_one(&mut self, width: Width, reg: u8, at: u32);
    /// All bits of a register, of which some lanes may not count.
    fn save(&mut self, width: Width, reg: u8, at: u32);
    /// The inverse.
    fn restore(&mut self, width: Width, reg: u8, at: u32);
    /// The mask of the lanes that run, from `lane` on.
    fn exec(&mut self, width: Width, reg: u8, lane: u32, areas: Areas);
    fn copy(&mut self, width: Width, to: u8, from: u8);
    fn unary(&mut self, width: Width, what: Unary, to: u8, from: Source);
    /// All but divisions of whole numbers.
    fn binary(&mut self, width: Width, what: Binary, to: u8, a: u8, b: Source);
    fn shift(&mut self, width: Width, what: Shift, to: u8, from: u8, by: u8);
    /// [`Choice::Anywhere`].
    fn choose(&mut self, width: Width, to: u8, mask: u8, yes: Source, no: u8);
    /// [`Choice::IntoMask`].
    fn choose_into_mask(&mut self, _: Width, _mask: u8, _yes: u8, _no: Source) {
        unreachable!("this machine chooses into any register")
    }
    /// Divides whole numbers; [`quotient`](Self::quotient) follows, with nothing but a spill between.
    fn divide(&mut self, width: Width, what: Binary, a: u8, b: u8, areas: Areas);
    /// The result of a division.
    fn quotient(&mut self, width: Width, to: u8, areas: Areas);
    /// A mask's bits into those of a word of memory from `lane` on; the word is cleared with the first.
    fn write_test(&mut self, width: Width, reg: u8, lane: u32, at: u32, areas: Areas);

    /// A mask register as ones and zeros in lanes.
    fn spread_mask(&mut self, _reg: u8, _k: u8) {
        no_mask_registers()
    }
    /// The inverse.
    fn gather_mask(&mut self, _k: u8, _reg: u8) {
        no_mask_registers()
    }
    /// The mask of the lanes that run, from `lane` on, to a mask register.
    fn load_exec_mask(&mut self, _k: u8, _lane: u32) {
        no_mask_registers()
    }
    /// A comparison.
    fn compare(&mut self, _: Width, _what: Binary, _k: u8, _a: u8, _b: Source) {
        no_mask_registers()
    }
    /// `And`, `Or` or `Xor` of mask registers.
    fn combine_masks(&mut self, _what: Binary, _to: u8, _a: u8, _b: u8) {
        no_mask_registers()
    }
    fn not_mask(&mut self, _to: u8, _k: u8) {
        no_mask_registers()
    }
    /// `yes` where the mask is set, else `no`.
    fn choose_by_mask(&mut self, _: Width, _to: u8, _k: u8, _yes: Source, _no: u8) {
        no_mask_registers()
    }
    /// A mask register to the bits of a word of memory from `lane` on; the word is cleared with the first.
    fn write_mask(&mut self, _k: u8, _lane: u32, _at: u32) {
        no_mask_registers()
    }
}

fn no_mask_registers() {
    unreachable!("this machine has no registers for masks")
}

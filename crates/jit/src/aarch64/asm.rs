// SPDX-License-Identifier: GPL-3.0-or-later
//! Encodes the instructions that are used: a few on words, and some forty on four lanes.
//! Source: Arm's Architecture Reference Manual for A-profile, part C (A64); original code.
//! All memory is addressed as `x19` plus a distance; one that is too large for an instruction is added into
//! `x16` before.
//! Tests: `tests::*` (words of an assembler), `tests/agreement.rs` (their effects).

use crate::isa::{Label, Text};

/// The register of the memory.
pub(super) const MEMORY: u8 = 19;
/// The register of large distances.
const PLACE: u8 = 16;
/// The register that is zero, or the stack's where there is an address.
pub(super) const ZERO: u8 = 31;
pub(super) const STACK: u8 = 31;

/// An instruction whose registers are not filled in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Code(pub(super) u32);

/// Instructions on words and addresses.
pub(super) mod word {
    use super::Code;

    pub(in super::super) const AND: Code = Code(0x0a00_0000);
    pub(in super::super) const OR: Code = Code(0x2a00_0000);
    pub(in super::super) const XOR: Code = Code(0x4a00_0000);
    pub(in super::super) const AND_NOT: Code = Code(0x0a20_0000);
    /// Sets the flags.
    pub(in super::super) const SUB: Code = Code(0x6b00_0000);
    /// Zero if the divisor is; never a trap.
    pub(in super::super) const DIV: Code = Code(0x1ac0_0c00);
    /// Of 64 bits, as is the next.
    pub(in super::super) const OR_LONG: Code = Code(0xaa00_0000);
    pub(super) const ADD_LONG: Code = Code(0x8b00_0000);
}

/// Instructions on four lanes.
pub(super) mod lanes {
    use super::Code;

    pub(in super::super) const FADD: Code = Code(0x4e20_d400);
    pub(in super::super) const FSUB: Code = Code(0x4ea0_d400);
    pub(in super::super) const FMUL: Code = Code(0x6e20_dc00);
    pub(in super::super) const FDIV: Code = Code(0x6e20_fc00);
    pub(in super::super) const FCMEQ: Code = Code(0x4e20_e400);
    pub(in super::super) const FCMGE: Code = Code(0x6e20_e400);
    pub(in super::super) const FCMGT: Code = Code(0x6ea0_e400);
    pub(in super::super) const FSQRT: Code = Code(0x6ea1_f800);
    pub(in super::super) const FRINTM: Code = Code(0x4e21_9800);
    pub(in super::super) const FRINTP: Code = Code(0x4ea1_8800);
    pub(in super::super) const FRINTZ: Code = Code(0x4ea1_9800);
    /// To the nearest number that fits; zero for NaN.
    pub(in super::super) const FCVTZS: Code = Code(0x4ea1_b800);
    pub(in super::super) const SCVTF: Code = Code(0x4e21_d800);

    pub(in super::super) const AND: Code = Code(0x4e20_1c00);
    pub(in super::super) const ORR: Code = Code(0x4ea0_1c00);
    pub(in super::super) const EOR: Code = Code(0x6e20_1c00);
    pub(in super::super) const BIC: Code = Code(0x4e60_1c00);
    /// The result was the mask.
    pub(in super::super) const BSL: Code = Code(0x6e60_1c00);
    /// Takes the first source where the second, a mask, is set.
    pub(in super::super) const BIT: Code = Code(0x6ea0_1c00);
    /// Where it is not.
    pub(in super::super) const BIF: Code = Code(0x6ee0_1c00);

    pub(in super::super) const ADD: Code = Code(0x4ea0_8400);
    pub(in super::super) const SUB: Code = Code(0x6ea0_8400);
    pub(in super::super) const MUL: Code = Code(0x4ea0_9c00);
    /// Takes the product from the result.
    pub(in super::super) const MLS: Code = Code(0x6ea0_9400);
    pub(in super::super) const NEG: Code = Code(0x6ea0_b800);
    pub(in super::super) const SMIN: Code = Code(0x4ea0_6c00);
    pub(in super::super) const SMAX: Code = Code(0x4ea0_6400);
    pub(in super::super) const CMGT: Code = Code(0x4ea0_3400);
    pub(in super::super) const CMEQ: Code = Code(0x6ea0_8c00);
    /// Whether they have a bit in common.
    pub(in super::super) const CMTST: Code = Code(0x4ea0_8c00);
    /// Of one source, with zero; as is the next.
    pub(in super::super) const IS_ZERO: Code = Code(0x4ea0_9800);
    pub(in super::super) const IS_NEGATIVE: Code = Code(0x4ea0_a800);
    /// Up by positive numbers, down by negative ones.
    pub(in super::super) const USHL: Code = Code(0x6ea0_4400);
    pub(in super::super) const SSHL: Code = Code(0x4ea0_4400);
    /// The first lane into all.
    pub(in super::super) const DUP: Code = Code(0x4e04_0400);
    /// The sum of lanes.
    pub(in super::super) const ADDV: Code = Code(0x4eb1_b800);
    /// The first lane to a word.
    pub(in super::super) const FMOV: Code = Code(0x1e26_0000);
}

/// Between a register and memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Access {
    Load,
    Store,
    /// One lane; loading clears the others.
    LoadOne,
    StoreOne,
    LoadLanes,
    StoreLanes,
}

impl Access {
    /// The instruction, and the logarithm of its bytes.
    const fn code(self) -> (u32, u32) {
        match self {
            Self::Load => (0xb940_0000, 2),
            Self::Store => (0xb900_0000, 2),
            Self::LoadOne => (0xbd40_0000, 2),
            Self::StoreOne => (0xbd00_0000, 2),
            Self::LoadLanes => (0x3dc0_0000, 4),
            Self::StoreLanes => (0x3d80_0000, 4),
        }
    }
}

/// Two registers to the stack, or from there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pair {
    Store,
    Load,
    /// Moves the stack before.
    Push,
    /// Moves the stack after.
    Pop,
    /// Lower halves of vectors, here and below.
    StoreHalves,
    LoadHalves,
}

impl Pair {
    const fn code(self) -> u32 {
        match self {
            Self::Store => 0xa900_0000,
            Self::Load => 0xa940_0000,
            Self::Push => 0xa980_0000,
            Self::Pop => 0xa8c0_0000,
            Self::StoreHalves => 0x6d00_0000,
            Self::LoadHalves => 0x6d40_0000,
        }
    }
}

/// Jumps over one instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Over {
    Zero(u8),
    NotZero(u8),
    Negative,
}

/// Code in the making.
#[derive(Default)]
pub(crate) struct Asm {
    pub(super) text: Text,
}

impl Asm {
    pub(super) fn raw(&mut self, instruction: u32) {
        self.text.bytes.extend_from_slice(&instruction.to_le_bytes());
    }

    /// An instruction with a result and two sources.
    pub(super) fn three(&mut self, Code(code): Code, to: u8, a: u8, b: u8) {
        self.raw(code | u32::from(b) << 16 | u32::from(a) << 5 | u32::from(to));
    }

    /// One with one source.
    pub(super) fn two(&mut self, code: Code, to: u8, from: u8) {
        self.three(code, to, from, 0);
    }

    /// A number into a word.
    pub(super) fn number(&mut self, to: u8, value: u32) {
        self.raw(0x5280_0000 | (value & 0xffff) << 5 | u32::from(to));
        if value >> 16 != 0 {
            self.raw(0x72a0_0000 | value >> 16 << 5 | u32::from(to));
        }
    }

    /// Zeros in all lanes.
    pub(super) fn zeros(&mut self, to: u8) {
        self.raw(0x4f00_0400 | u32::from(to));
    }

    /// Bits of lanes up by less than 32.
    pub(super) fn up(&mut self, to: u8, from: u8, by: u8) {
        self.two(Code(0x4f00_5400 | u32::from(32 + by) << 16), to, from);
    }

    /// Down, zeros following, by 1 to 32.
    pub(super) fn down(&mut self, to: u8, from: u8, by: u8) {
        self.two(Code(0x6f00_0400 | u32::from(64 - by) << 16), to, from);
    }

    /// A lane to a word.
    pub(super) fn take_lane(&mut self, to: u8, from: u8, lane: u8) {
        self.two(Code(0x0e04_3c00 | u32::from(lane) << 19), to, from);
    }

    /// A word to a lane; the others stay.
    pub(super) fn put_lane(&mut self, to: u8, lane: u8, from: u8) {
        self.two(Code(0x4e04_1c00 | u32::from(lane) << 19), to, from);
    }

    /// Between a register and memory at a distance that is a multiple of the access' size.
    pub(super) fn access(&mut self, what: Access, reg: u8, at: u32) {
        let (code, log) = what.code();
        let (mut base, mut near) = (MEMORY, at);
        if at >> log >= 1 << 12 {
            (base, near) = (PLACE, 0);
            if at >> 24 == 0 {
                near = at & 0xfff;
                // x16 = x19 + the twelve bits above those.
                self.raw(0x9140_0000 | at >> 12 << 10 | u32::from(MEMORY) << 5 | u32::from(PLACE));
            } else {
                self.number(PLACE, at);
                self.three(word::ADD_LONG, PLACE, MEMORY, PLACE);
            }
        }
        self.raw(code | near >> log << 10 | u32::from(base) << 5 | u32::from(reg));
    }

    /// Two registers, this many bytes above the stack's end, or by which it moves; a multiple of eight.
    pub(super) fn pair(&mut self, what: Pair, a: u8, b: u8, bytes: i32) {
        let at = (bytes / 8) as u32 & 0x7f;
        self.raw(what.code() | at << 15 | u32::from(b) << 10 | u32::from(STACK) << 5 | u32::from(a));
    }

    /// The stack's end into a register.
    pub(super) fn frame(&mut self, to: u8) {
        self.raw(0x9100_0000 | u32::from(STACK) << 5 | u32::from(to));
    }

    /// Calls the address in a register.
    pub(super) fn call_at(&mut self, reg: u8) {
        self.raw(0xd63f_0000 | u32::from(reg) << 5);
    }

    pub(super) fn end(&mut self) {
        self.raw(0xd65f_03c0);
    }

    /// Jumps over the next instruction.
    pub(super) fn over(&mut self, when: Over) {
        let two = 2 << 5;
        self.raw(match when {
            Over::Zero(reg) => 0x3400_0000 | two | u32::from(reg),
            Over::NotZero(reg) => 0x3500_0000 | two | u32::from(reg),
            Over::Negative => 0x5400_0004 | two,
        });
    }

    /// A jump or a call, which reaches 128 MiB.
    pub(super) fn far(&mut self, code: u32, label: Label) {
        self.text.jump(code.to_le_bytes(), label);
    }

    /// The distance of a jump.
    ///
    /// # Errors
    /// That it is too large.
    pub(super) fn reach(place: &mut [u8; 4], distance: i32) -> Result<(), String> {
        if !(-(1 << 27)..1 << 27).contains(&distance) {
            return Err("the group needs more than 128 MiB of machine code".into());
        }
        let filled = u32::from_le_bytes(*place) | (distance >> 2) as u32 & 0x3ff_ffff;
        *place = filled.to_le_bytes();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Row = (fn(&mut Asm), &'static [u32], &'static str);

    /// Words and texts of an assembler (that of LLVM).
    const ROWS: &[Row] = &[
        (|a| a.three(word::AND, 1, 2, 3), &[0x0a03_0041], "and w1, w2, w3"),
        (|a| a.three(word::OR, 1, 2, 3), &[0x2a03_0041], "orr w1, w2, w3"),
        (|a| a.three(word::XOR, 1, 2, 3), &[0x4a03_0041], "eor w1, w2, w3"),
        (|a| a.three(word::AND_NOT, 1, 2, 3), &[0x0a23_0041], "bic w1, w2, w3"),
        (|a| a.three(word::SUB, 9, 9, 10), &[0x6b0a_0129], "subs w9, w9, w10"),
        (|a| a.three(word::DIV, 9, 9, 10), &[0x1aca_0d29], "sdiv w9, w9, w10"),
        (|a| a.three(word::OR_LONG, MEMORY, ZERO, 0), &[0xaa00_03f3], "mov x19, x0"),
        (|a| a.three(lanes::FADD, 1, 2, 30), &[0x4e3e_d441], "fadd v1.4s, v2.4s, v30.4s"),
        (|a| a.three(lanes::FSUB, 1, 2, 30), &[0x4ebe_d441], "fsub v1.4s, v2.4s, v30.4s"),
        (|a| a.three(lanes::FMUL, 1, 2, 30), &[0x6e3e_dc41], "fmul v1.4s, v2.4s, v30.4s"),
        (|a| a.three(lanes::FDIV, 1, 2, 30), &[0x6e3e_fc41], "fdiv v1.4s, v2.4s, v30.4s"),
        (|a| a.three(lanes::FCMEQ, 1, 2, 30), &[0x4e3e_e441], "fcmeq v1.4s, v2.4s, v30.4s"),
        (|a| a.three(lanes::FCMGE, 1, 2, 30), &[0x6e3e_e441], "fcmge v1.4s, v2.4s, v30.4s"),
        (|a| a.three(lanes::FCMGT, 1, 2, 30), &[0x6ebe_e441], "fcmgt v1.4s, v2.4s, v30.4s"),
        (|a| a.two(lanes::FSQRT, 1, 20), &[0x6ea1_fa81], "fsqrt v1.4s, v20.4s"),
        (|a| a.two(lanes::FRINTM, 1, 20), &[0x4e21_9a81], "frintm v1.4s, v20.4s"),
        (|a| a.two(lanes::FRINTP, 1, 20), &[0x4ea1_8a81], "frintp v1.4s, v20.4s"),
        (|a| a.two(lanes::FRINTZ, 1, 20), &[0x4ea1_9a81], "frintz v1.4s, v20.4s"),
        (|a| a.two(lanes::FCVTZS, 1, 20), &[0x4ea1_ba81], "fcvtzs v1.4s, v20.4s"),
        (|a| a.two(lanes::SCVTF, 1, 20), &[0x4e21_da81], "scvtf v1.4s, v20.4s"),
        (|a| a.three(lanes::AND, 1, 2, 30), &[0x4e3e_1c41], "and v1.16b, v2.16b, v30.16b"),
        (|a| a.three(lanes::ORR, 1, 2, 30), &[0x4ebe_1c41], "orr v1.16b, v2.16b, v30.16b"),
        (|a| a.three(lanes::EOR, 1, 2, 30), &[0x6e3e_1c41], "eor v1.16b, v2.16b, v30.16b"),
        (|a| a.three(lanes::BIC, 1, 2, 30), &[0x4e7e_1c41], "bic v1.16b, v2.16b, v30.16b"),
        (|a| a.three(lanes::BSL, 1, 2, 30), &[0x6e7e_1c41], "bsl v1.16b, v2.16b, v30.16b"),
        (|a| a.three(lanes::BIT, 1, 2, 30), &[0x6ebe_1c41], "bit v1.16b, v2.16b, v30.16b"),
        (|a| a.three(lanes::BIF, 1, 2, 30), &[0x6efe_1c41], "bif v1.16b, v2.16b, v30.16b"),
        (|a| a.three(lanes::ADD, 1, 2, 30), &[0x4ebe_8441], "add v1.4s, v2.4s, v30.4s"),
        (|a| a.three(lanes::SUB, 1, 2, 30), &[0x6ebe_8441], "sub v1.4s, v2.4s, v30.4s"),
        (|a| a.three(lanes::MUL, 1, 2, 30), &[0x4ebe_9c41], "mul v1.4s, v2.4s, v30.4s"),
        (|a| a.three(lanes::MLS, 1, 2, 30), &[0x6ebe_9441], "mls v1.4s, v2.4s, v30.4s"),
        (|a| a.two(lanes::NEG, 1, 20), &[0x6ea0_ba81], "neg v1.4s, v20.4s"),
        (|a| a.three(lanes::SMIN, 1, 2, 30), &[0x4ebe_6c41], "smin v1.4s, v2.4s, v30.4s"),
        (|a| a.three(lanes::SMAX, 1, 2, 30), &[0x4ebe_6441], "smax v1.4s, v2.4s, v30.4s"),
        (|a| a.three(lanes::CMGT, 1, 2, 30), &[0x4ebe_3441], "cmgt v1.4s, v2.4s, v30.4s"),
        (|a| a.three(lanes::CMEQ, 1, 2, 30), &[0x6ebe_8c41], "cmeq v1.4s, v2.4s, v30.4s"),
        (|a| a.three(lanes::CMTST, 1, 2, 30), &[0x4ebe_8c41], "cmtst v1.4s, v2.4s, v30.4s"),
        (|a| a.two(lanes::IS_ZERO, 1, 20), &[0x4ea0_9a81], "cmeq v1.4s, v20.4s, #0"),
        (|a| a.two(lanes::IS_NEGATIVE, 1, 20), &[0x4ea0_aa81], "cmlt v1.4s, v20.4s, #0"),
        (|a| a.three(lanes::USHL, 1, 2, 30), &[0x6ebe_4441], "ushl v1.4s, v2.4s, v30.4s"),
        (|a| a.three(lanes::SSHL, 1, 2, 30), &[0x4ebe_4441], "sshl v1.4s, v2.4s, v30.4s"),
        (|a| a.two(lanes::DUP, 1, 20), &[0x4e04_0681], "dup v1.4s, v20.s[0]"),
        (|a| a.two(lanes::ADDV, 1, 20), &[0x4eb1_ba81], "addv s1, v20.4s"),
        (|a| a.two(lanes::FMOV, 1, 20), &[0x1e26_0281], "fmov w1, s20"),
        (|a| a.zeros(1), &[0x4f00_0401], "movi v1.4s, #0"),
        (|a| a.up(1, 2, 31), &[0x4f3f_5441], "shl v1.4s, v2.4s, #31"),
        (|a| a.up(1, 2, 0), &[0x4f20_5441], "shl v1.4s, v2.4s, #0"),
        (|a| a.down(1, 2, 1), &[0x6f3f_0441], "ushr v1.4s, v2.4s, #1"),
        (|a| a.down(1, 2, 32), &[0x6f20_0441], "ushr v1.4s, v2.4s, #32"),
        (|a| a.take_lane(9, 20, 3), &[0x0e1c_3e89], "mov w9, v20.s[3]"),
        (|a| a.put_lane(20, 2, 9), &[0x4e14_1d34], "mov v20.s[2], w9"),
        (
            |a| a.number(1, 0xabcd_1234),
            &[0x5282_4681, 0x72b5_79a1],
            "mov w1, #0x1234; movk w1, #0xabcd, lsl #16",
        ),
        (|a| a.access(Access::Load, 9, 16380), &[0xb97f_fe69], "ldr w9, [x19, #16380]"),
        (|a| a.access(Access::Store, 1, 4), &[0xb900_0661], "str w1, [x19, #4]"),
        (|a| a.access(Access::LoadOne, 5, 8), &[0xbd40_0a65], "ldr s5, [x19, #8]"),
        (|a| a.access(Access::StoreOne, 5, 8), &[0xbd00_0a65], "str s5, [x19, #8]"),
        (|a| a.access(Access::LoadLanes, 31, 65520), &[0x3dff_fe7f], "ldr q31, [x19, #65520]"),
        (|a| a.access(Access::StoreLanes, 31, 16), &[0x3d80_067f], "str q31, [x19, #16]"),
        (
            |a| a.access(Access::LoadLanes, 3, 0x1_0020),
            &[0x9140_4270, 0x3dc0_0a03],
            "add x16, x19, #0x10000; ldr q3, [x16, #32]",
        ),
        (
            |a| a.access(Access::LoadLanes, 3, 0x0abc_0050),
            &[0x5280_0a10, 0x72a1_5790, 0x8b10_0270, 0x3dc0_0203],
            "mov w16, #0x0050; movk w16, #0x0abc, lsl #16; add x16, x19, x16; ldr q3, [x16]",
        ),
        (|a| a.pair(Pair::Push, 29, 30, -112), &[0xa9b9_7bfd], "stp x29, x30, [sp, #-112]!"),
        (|a| a.pair(Pair::Pop, 29, 30, 112), &[0xa8c7_7bfd], "ldp x29, x30, [sp], #112"),
        (|a| a.pair(Pair::Store, 19, 20, 16), &[0xa901_53f3], "stp x19, x20, [sp, #16]"),
        (|a| a.pair(Pair::Load, 19, 20, 16), &[0xa941_53f3], "ldp x19, x20, [sp, #16]"),
        (|a| a.pair(Pair::StoreHalves, 14, 15, 96), &[0x6d06_3fee], "stp d14, d15, [sp, #96]"),
        (|a| a.pair(Pair::LoadHalves, 14, 15, 96), &[0x6d46_3fee], "ldp d14, d15, [sp, #96]"),
        (|a| a.frame(29), &[0x9100_03fd], "mov x29, sp"),
        (|a| a.call_at(21), &[0xd63f_02a0], "blr x21"),
        (|a| a.end(), &[0xd65f_03c0], "ret"),
        (|a| a.over(Over::Zero(1)), &[0x3400_0041], "cbz w1, .+8"),
        (|a| a.over(Over::NotZero(1)), &[0x3500_0041], "cbnz w1, .+8"),
        (|a| a.over(Over::Negative), &[0x5400_0044], "b.mi .+8"),
    ];

    fn words(make: impl FnOnce(&mut Asm)) -> Result<Vec<u32>, String> {
        let mut asm = Asm::default();
        make(&mut asm);
        let bytes = asm.text.finish(Asm::reach)?;
        Ok(bytes.as_chunks().0.iter().map(|&word| u32::from_le_bytes(word)).collect())
    }

    #[test]
    fn instructions_are_those_of_an_assembler() {
        for &(make, expected, text) in ROWS {
            let found = words(make).expect("it is short");
            assert_eq!(found, expected, "{found:x?} is not {expected:x?}, {text}");
        }
    }

    #[test]
    fn jumps_lead_to_their_labels() {
        let found = words(|a| {
            let (back, on) = (a.text.label(), a.text.label());
            a.text.bind(back);
            a.far(0x1400_0000, on);
            a.end();
            a.far(0x9400_0000, back);
            a.text.bind(on);
        });
        // b .+12; ret; bl .-8
        assert_eq!(found, Ok(vec![0x1400_0003, 0xd65f_03c0, 0x97ff_fffe]));
        let mut place = 0x1400_0000_u32.to_le_bytes();
        assert!(Asm::reach(&mut place, 1 << 27).is_err(), "128 MiB are too far");
        assert_eq!(Asm::reach(&mut place, -(1 << 27)), Ok(()));
        assert_eq!(u32::from_le_bytes(place), 0x1600_0000, "b .-0x8000000");
    }
}

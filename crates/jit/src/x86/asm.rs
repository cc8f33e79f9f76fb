// SPDX-License-Identifier: GPL-3.0-or-later
//! Encodes the instructions that are used: a few on whole registers, and some forty on lanes.
//! Source: Intel's Software Developer's Manual, volume 2, chapters 2 and 3; original code.
//! Lanes are 4 or 8 with the VEX prefix and 16 with EVEX. All memory is addressed as `rbx` plus a distance of 32 bits.
//! Tests: `tests::*` (bytes of an assembler), `tests/agreement.rs` (their effects).

use crate::isa::{Isa as _, Label, Source, Text, Width, Word};

/// An instruction: prefix (0 none, 1 66, 2 F3, 3 F2), map (1 0F, 2 0F38, 3 0F3A) and number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Code(pub(crate) u8, pub(crate) u8, pub(crate) u8);

/// The access to a register and a word of memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Access {
    Load = 0x8b,
    Store = 0x89,
    And = 0x23,
    Or = 0x0b,
    OrInto = 0x09,
}

/// Conditions of jumps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum When {
    Zero = 0x84,
    NotZero = 0x85,
    NotNegative = 0x89,
    /// Without signs.
    AtMost = 0x86,
}

/// Code in the making.
#[derive(Default)]
pub(crate) struct Asm {
    pub(crate) text: Text,
}

impl Asm {
    pub(crate) fn raw(&mut self, bytes: &[u8]) {
        self.text.bytes.extend_from_slice(bytes);
    }

    fn distance(&mut self, x: u32) {
        self.raw(&x.to_le_bytes());
    }

    pub(crate) fn jump_if(&mut self, when: When, label: Label) {
        self.raw(&[0x0f, when as u8]);
        self.text.jump([0; 4], label);
    }

    /// Between a register and a word of memory.
    pub(crate) fn access(&mut self, what: Access, reg: Word, at: u32) {
        self.raw(&[what as u8, 0x83 | (reg as u8) << 3]);
        self.distance(at);
    }

    /// `reg & other`, only for the flags: pass a register twice to test it.
    pub(crate) fn test(&mut self, a: Word, b: Word) {
        self.raw(&[0x85, 0xc0 | (b as u8) << 3 | a as u8]);
    }

    /// `reg = !reg`
    pub(crate) fn not(&mut self, reg: Word) {
        self.raw(&[0xf7, 0xd0 | reg as u8]);
    }

    /// A number into a word of memory.
    pub(crate) fn set_bits(&mut self, at: u32, value: u32) {
        self.raw(&[0xc7, 0x83]);
        self.distance(at);
        self.distance(value);
    }

    /// Whether a word of memory is zero.
    pub(crate) fn compare_word_with_zero(&mut self, at: u32) {
        self.raw(&[0x83, 0xbb]);
        self.distance(at);
        self.raw(&[0]);
    }

    /// A word of memory, less some.
    pub(crate) fn subtract_from_word(&mut self, at: u32, less: u32) {
        self.raw(&[0x81, 0xab]);
        self.distance(at);
        self.raw(&less.to_le_bytes());
    }

    /// An instruction on lanes: `reg` is the result (or its number in the opcode), `v` the first source.
    pub(crate) fn lanes(&mut self, width: Width, code: Code, reg: u8, v: u8, rm: Source) {
        match width {
            Width::Sixteen => self.evex(code, reg, v, rm, 0),
            _ => self.vex(width == Width::Eight, code, reg, v, rm),
        }
    }

    pub(super) fn vex(&mut self, long: bool, Code(prefix, map, number): Code, reg: u8, v: u8, rm: Source) {
        let b = match rm {
            Source::Reg(r) => r >> 3,
            _ => 0,
        };
        let second = (!v & 15) << 3 | u8::from(long) << 2 | prefix;
        if map == 1 && b == 0 {
            self.raw(&[0xc5, u8::from(reg < 8) << 7 | second, number]);
        } else {
            self.raw(&[0xc4, u8::from(reg < 8) << 7 | 0x40 | (b ^ 1) << 5 | map, second, number]);
        }
        self.mod_rm(reg, rm);
    }

    /// With mask `k`; 0 for none.
    pub(super) fn evex(&mut self, Code(prefix, map, number): Code, reg: u8, v: u8, rm: Source, k: u8) {
        let (r, r2) = (reg >> 3 & 1, reg >> 4 & 1);
        let (b, x, each) = match rm {
            Source::Reg(n) => (n >> 3 & 1, n >> 4 & 1, 0),
            Source::Mem(_) => (0, 0, 0),
            Source::Each(_) => (0, 0, 1),
        };
        self.raw(&[
            0x62,
            (r ^ 1) << 7 | (x ^ 1) << 6 | (b ^ 1) << 5 | (r2 ^ 1) << 4 | map,
            (!v & 15) << 3 | 4 | prefix,
            2 << 5 | each << 4 | (v >> 4 & 1 ^ 1) << 3 | k,
            number,
        ]);
        self.mod_rm(reg, rm);
    }

    fn mod_rm(&mut self, reg: u8, rm: Source) {
        let reg = (reg & 7) << 3;
        match rm {
            Source::Reg(n) => self.raw(&[0xc0 | reg | n & 7]),
            // A distance of 32 bits, which is never scaled.
            Source::Mem(at) | Source::Each(at) => {
                self.raw(&[0x83 | reg]);
                self.distance(at);
            }
        }
    }

    /// One number of memory, in all lanes; with one lane, zeros in the others.
    pub(crate) fn broadcast(&mut self, width: Width, reg: u8, at: u32) {
        match width {
            Width::One => self.vex(false, Code(2, 1, 0x10), reg, 0, Source::Mem(at)),
            _ => self.lanes(width, Code(1, 2, 0x18), reg, 0, Source::Mem(at)),
        }
    }

    /// The first lane to memory.
    pub(crate) fn store_first(&mut self, width: Width, reg: u8, at: u32) {
        match width {
            Width::Sixteen => self.evex(Code(2, 1, 0x11), reg, 0, Source::Mem(at), 0),
            _ => self.vex(false, Code(2, 1, 0x11), reg, 0, Source::Mem(at)),
        }
    }

    /// The sign bits of lanes, as bits of `eax`.
    pub(crate) fn signs(&mut self, width: Width, reg: u8) {
        match width {
            Width::Sixteen => {
                self.gather_mask(1, reg);
                self.mask_to_eax(1);
            }
            _ => self.vex(width == Width::Eight, Code(0, 1, 0x50), 0, 0, Source::Reg(reg)),
        }
    }

    /// Sixteen bits of memory to a mask register.
    pub(crate) fn load_mask(&mut self, k: u8, at: u32) {
        self.vex(false, Code(0, 1, 0x90), k, 0, Source::Mem(at));
    }

    /// The bits of `eax` to those of a word of memory from `lane` on, which is cleared with the first; `eax` has all bits
    /// of the word so far.
    pub(crate) fn put_bits(&mut self, lane: u32, at: u32) {
        if lane > 0 {
            // A word that is stored in parts is read late.
            self.raw(&[0xc1, 0xe0, lane as u8]); // shl eax, lane
            self.access(Access::Or, Word::A, at);
        }
        self.access(Access::Store, Word::A, at);
    }

    /// A mask register to `eax`.
    pub(crate) fn mask_to_eax(&mut self, k: u8) {
        self.vex(false, Code(0, 1, 0x93), 0, 0, Source::Reg(k));
    }

    /// One of `kandw`, `korw` and `kxorw` by its number.
    pub(crate) fn masks(&mut self, number: u8, to: u8, a: u8, b: u8) {
        self.vex(true, Code(0, 1, number), to, a, Source::Reg(b));
    }

    /// `yes` where the mask is set, else `no`.
    pub(crate) fn blend(&mut self, to: u8, k: u8, yes: Source, no: u8) {
        self.evex(Code(1, 2, 0x65), to, no, yes, k);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes(make: impl FnOnce(&mut Asm)) -> Vec<u8> {
        let mut asm = Asm::default();
        make(&mut asm);
        asm.finish().expect("it is short")
    }

    #[test]
    fn instructions_are_those_of_an_assembler() {
        let add = Code(0, 1, 0x58);
        let eight = Width::Eight;
        let wide = Width::Sixteen;
        // vaddps ymm1, ymm2, ymm3
        assert_eq!(bytes(|a| a.lanes(eight, add, 1, 2, Source::Reg(3))), [0xc5, 0xec, 0x58, 0xcb]);
        // vaddps ymm9, ymm12, ymm15
        assert_eq!(bytes(|a| a.lanes(eight, add, 9, 12, Source::Reg(15))), [0xc4, 0x41, 0x1c, 0x58, 0xcf]);
        // vaddps zmm17, zmm30, zmm9
        assert_eq!(
            bytes(|a| a.lanes(wide, add, 17, 30, Source::Reg(9))),
            [0x62, 0xc1, 0x0c, 0x40, 0x58, 0xc9]
        );
        // vaddps zmm1, zmm2, dword [rbx+256]{1to16}, with a distance of 32 bits
        assert_eq!(
            bytes(|a| a.lanes(wide, add, 1, 2, Source::Each(256))),
            [0x62, 0xf1, 0x6c, 0x58, 0x58, 0x8b, 0, 1, 0, 0]
        );
        // vmovups [rbx+64], zmm20
        assert_eq!(
            bytes(|a| a.lanes(wide, Code(0, 1, 0x11), 20, 0, Source::Mem(64))),
            [0x62, 0xe1, 0x7c, 0x48, 0x11, 0xa3, 0x40, 0, 0, 0]
        );
        // kandw k1, k2, k3; knotw k4, k5; kmovw k2, [rbx+8]; kmovw eax, k3
        assert_eq!(bytes(|a| a.masks(0x41, 1, 2, 3)), [0xc5, 0xec, 0x41, 0xcb]);
        assert_eq!(bytes(|a| a.not_mask(4, 5)), [0xc5, 0xf8, 0x44, 0xe5]);
        assert_eq!(bytes(|a| a.load_mask(2, 8)), [0xc5, 0xf8, 0x90, 0x93, 8, 0, 0, 0]);
        assert_eq!(bytes(|a| a.mask_to_eax(3)), [0xc5, 0xf8, 0x93, 0xc3]);
        // vblendmps zmm1{k2}, zmm3, zmm4
        assert_eq!(bytes(|a| a.blend(1, 2, Source::Reg(4), 3)), [0x62, 0xf2, 0x65, 0x4a, 0x65, 0xcc]);
        // mov ecx, [rbx+8]
        assert_eq!(bytes(|a| a.access(Access::Load, Word::B, 8)), [0x8b, 0x8b, 8, 0, 0, 0]);
        // jmp over nothing
        let jump = bytes(|a| {
            let label = a.text.label();
            a.jump(label);
            a.text.bind(label);
        });
        assert_eq!(jump, [0xe9, 0, 0, 0, 0]);
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Machine code for x86-64 with AVX2 or AVX-512.
//! `rbx` is the memory, `r12` the argument of calls, `r13` their target; `eax` and `ecx` are the words of
//! control. AVX-512 keeps masks in k2 to k7; k1 is for work.
//! `asm` encodes.
//! Tests: `tests/agreement.rs`, `tests/chance.rs`.

mod asm;

use gnurt_simd::Level;
use std::ops::Range;

use crate::isa::{Areas, Choice, FromMemory, Isa, Label, Source, Text, Width, Word};
use crate::layout::Layout;
use crate::op::{Binary, Shift, Unary};
use asm::{Access, Code, When};

pub(crate) use asm::Asm;

impl Isa for Asm {
    fn wide(level: Level) -> Width {
        if level == Level::Avx512 { Width::Sixteen } else { Width::Eight }
    }

    fn copies(level: Level) -> u32 {
        if level == Level::Avx512 { 4 } else { 8 }
    }

    fn registers(width: Width) -> usize {
        if width == Width::Sixteen { 32 } else { 16 }
    }

    fn mask_registers(width: Width) -> Range<usize> {
        if width == Width::Sixteen { 2..8 } else { 0..0 }
    }

    fn from_memory(width: Width) -> FromMemory {
        match width {
            Width::One => FromMemory::Nothing,
            Width::Sixteen => FromMemory::All,
            _ => FromMemory::Rows,
        }
    }

    fn rotates(width: Width) -> bool {
        width == Width::Sixteen
    }

    fn choice(width: Width) -> Choice {
        if width == Width::Sixteen { Choice::IntoMask } else { Choice::Anywhere }
    }

    fn leaves_test(width: Width) -> bool {
        width == Width::Sixteen
    }

    fn text(&mut self) -> &mut Text {
        &mut self.text
    }

    fn finish(&mut self) -> Result<Vec<u8>, String> {
        self.text.finish(|place, distance| {
            // From the end of the instruction, which is that of the four bytes.
            *place = distance.wrapping_sub(4).to_le_bytes();
            Ok(())
        })
    }

    fn entry(&mut self) {
        self.raw(&[0x53, 0x41, 0x54, 0x41, 0x55]); // push rbx, r12, r13
        self.raw(&[0x48, 0x89, 0xfb, 0x49, 0x89, 0xf4, 0x49, 0x89, 0xd5]); // mov rbx, rdi; r12, rsi; r13, rdx
        self.raw(&[0xff, 0xd1]); // call rcx
        self.raw(&[0xc5, 0xf8, 0x77]); // vzeroupper
        self.raw(&[0x41, 0x5d, 0x41, 0x5c, 0x5b, 0xc3]); // pop r13, r12, rbx; ret
    }

    fn start_function(&mut self) {
        self.raw(&[0x48, 0x83, 0xec, 0x08]); // sub rsp, 8
    }

    fn end_function(&mut self) {
        self.raw(&[0x48, 0x83, 0xc4, 0x08, 0xc3]); // add rsp, 8; ret
    }

    fn call(&mut self, label: Label) {
        self.raw(&[0xe8]);
        self.text.jump([0; 4], label);
    }

    fn call_out(&mut self, number: u32) {
        self.raw(&[0xc5, 0xf8, 0x77, 0x4c, 0x89, 0xe7, 0xbe]); // vzeroupper; mov rdi, r12; mov esi, number
        self.raw(&number.to_le_bytes());
        self.raw(&[0x41, 0xff, 0xd5]); // call r13
    }

    fn jump(&mut self, label: Label) {
        self.raw(&[0xe9]);
        self.text.jump([0; 4], label);
    }

    fn jump_if_zero(&mut self, word: Word, label: Label) {
        self.test(word, word);
        self.jump_if(When::Zero, label);
    }

    fn jump_if_not_zero(&mut self, word: Word, label: Label) {
        self.test(word, word);
        self.jump_if(When::NotZero, label);
    }

    fn jump_if_zero_at(&mut self, at: u32, label: Label) {
        self.compare_word_with_zero(at);
        self.jump_if(When::Zero, label);
    }

    fn spend(&mut self, at: u32, less: u32, label: Label) {
        self.subtract_from_word(at, less);
        self.jump_if(When::NotNegative, label);
    }

    fn load_word(&mut self, word: Word, at: u32) {
        self.access(Access::Load, word, at);
    }

    fn store_word(&mut self, word: Word, at: u32) {
        self.access(Access::Store, word, at);
    }

    fn and_word(&mut self, word: Word, at: u32) {
        self.access(Access::And, word, at);
    }

    fn or_word(&mut self, word: Word, at: u32) {
        self.access(Access::Or, word, at);
    }

    fn or_into(&mut self, word: Word, at: u32) {
        self.access(Access::OrInto, word, at);
    }

    fn clear(&mut self, at: u32) {
        self.set_bits(at, 0);
    }

    fn and(&mut self, to: Word, from: Word) {
        self.raw(&[0x21, 0xc0 | (from as u8) << 3 | to as u8]);
    }

    fn xor(&mut self, to: Word, from: Word) {
        self.raw(&[0x31, 0xc0 | (from as u8) << 3 | to as u8]);
    }

    fn and_not(&mut self, to: Word, from: Word) {
        self.not(from);
        self.and(to, from);
    }

    fn zero(&mut self, width: Width, reg: u8) {
        self.lanes(width, XOR, reg, reg, Source::Reg(reg));
    }

    fn load_constant(&mut self, width: Width, reg: u8, at: u32) {
        match width {
            Width::Sixteen => self.broadcast(width, reg, at),
            _ => self.lanes(width, LOAD, reg, 0, Source::Mem(at)),
        }
    }

    fn load_each(&mut self, width: Width, reg: u8, at: u32) {
        self.broadcast(width, reg, at);
    }

    fn load(&mut self, width: Width, reg: u8, at: u32) {
        match width {
            Width::One => self.broadcast(width, reg, at),
            _ => self.lanes(width, LOAD, reg, 0, Source::Mem(at)),
        }
    }

    fn store(&mut self, width: Width, reg: u8, at: u32) {
        match width {
            Width::One => self.store_first(width, reg, at),
            _ => self.save(width, reg, at),
        }
    }

    fn store_one(&mut self, width: Width, reg: u8, at: u32) {
        self.store_first(width, reg, at);
    }

    fn save(&mut self, width: Width, reg: u8, at: u32) {
        self.lanes(width, Code(0, 1, 0x11), reg, 0, Source::Mem(at));
    }

    fn restore(&mut self, width: Width, reg: u8, at: u32) {
        self.lanes(width, LOAD, reg, 0, Source::Mem(at));
    }

    fn exec(&mut self, width: Width, reg: u8, lane: u32, areas: Areas) {
        if width == Width::Sixteen {
            self.load_exec_mask(1, lane);
            self.spread_mask(reg, 1);
            return;
        }
        let bits = areas.lane_bits + 4 * lane;
        let long = Width::Eight;
        self.broadcast(long, reg, Layout::EXEC);
        self.lanes(long, AND, reg, reg, Source::Mem(bits));
        self.lanes(long, Code(1, 1, 0x76), reg, reg, Source::Mem(bits));
    }

    fn copy(&mut self, width: Width, to: u8, from: u8) {
        self.lanes(width, Code(0, 1, 0x28), to, 0, Source::Reg(from));
    }

    fn unary(&mut self, width: Width, what: Unary, to: u8, from: Source) {
        let (code, round) = match what {
            Unary::Sqrt => (Code(0, 1, 0x51), None),
            Unary::Floor => (Code(1, 3, 0x08), Some(9)),
            Unary::Ceil => (Code(1, 3, 0x08), Some(10)),
            Unary::Trunc => (Code(1, 3, 0x08), Some(11)),
            Unary::ToInt => (Code(2, 1, 0x5b), None),
            Unary::FromInt => (Code(0, 1, 0x5b), None),
        };
        self.lanes(width, code, to, 0, from);
        if let Some(mode) = round {
            self.raw(&[mode]);
        }
    }

    fn binary(&mut self, width: Width, what: Binary, to: u8, a: u8, b: Source) {
        if what.compares() {
            self.compare(width, what, to, a, b);
        } else {
            self.lanes(width, code(what), to, a, b);
        }
    }

    fn shift(&mut self, width: Width, what: Shift, to: u8, from: u8, by: u8) {
        let number = match what {
            Shift::Up => 6,
            Shift::Down => 2,
            Shift::Around => 1,
        };
        self.lanes(width, Code(1, 1, 0x72), number, to, Source::Reg(from));
        self.raw(&[by]);
    }

    fn choose(&mut self, width: Width, to: u8, mask: u8, yes: Source, no: u8) {
        self.lanes(width, Code(1, 3, 0x4a), to, no, yes);
        self.raw(&[mask << 4]);
    }

    fn choose_into_mask(&mut self, width: Width, mask: u8, yes: u8, no: Source) {
        // The mask's bits choose between the other two.
        self.lanes(width, Code(1, 3, 0x25), mask, yes, no);
        self.raw(&[0xca]);
    }

    /// Lane by lane, as the CPU has no division of whole numbers in lanes.
    fn divide(&mut self, width: Width, what: Binary, a: u8, b: u8, areas: Areas) {
        let (x, y) = (areas.scratch, areas.scratch + 64);
        self.save(width, a, x);
        self.save(width, b, y);
        let indexed = |asm: &mut Self, number: u8, reg: u8, at: u32| {
            asm.raw(&[number, 0x84 | reg << 3, 0x8b]);
            asm.raw(&at.to_le_bytes());
        };
        let asm = self;
        let (top, special, done) = (asm.text.label(), asm.text.label(), asm.text.label());
        asm.raw(&[0x31, 0xc9]); // xor ecx, ecx
        asm.text.bind(top);
        indexed(asm, 0x8b, 0, x); // mov eax, [rbx+rcx*4+x]
        indexed(asm, 0x8b, 7, y); // mov edi, [rbx+rcx*4+y]
        asm.raw(&[0x8d, 0x57, 0x01]); // lea edx, [rdi+1]
        asm.raw(&[0x83, 0xfa, 0x01]); // cmp edx, 1
        asm.jump_if(When::AtMost, special);
        asm.raw(&[0x99, 0xf7, 0xff]); // cdq; idiv edi
        match what {
            Binary::IntDiv => {}
            Binary::IntRem => asm.raw(&[0x89, 0xd0]), // mov eax, edx
            _ => {
                asm.raw(&[0x89, 0xd0]);
                asm.raw(&[0x85, 0xc0, 0x79, 0x02]); // test eax, eax; jns over
                asm.raw(&[0x01, 0xf8]); // add eax, edi
            }
        }
        asm.jump(done);
        asm.text.bind(special);
        if what == Binary::IntDiv {
            // By 0 it is 0, by -1 the negative.
            asm.raw(&[0xf7, 0xd8, 0x21, 0xf8]); // neg eax; and eax, edi
        } else {
            asm.raw(&[0x31, 0xc0]); // xor eax, eax
        }
        asm.text.bind(done);
        indexed(asm, 0x89, 0, x); // mov [rbx+rcx*4+x], eax
        asm.raw(&[0xff, 0xc1]); // inc ecx
        asm.raw(&[0x83, 0xf9, width.lanes() as u8]); // cmp ecx, lanes
        asm.jump_if(When::NotZero, top);
    }

    fn quotient(&mut self, width: Width, to: u8, areas: Areas) {
        self.load(width, to, areas.scratch);
    }

    fn write_test(&mut self, width: Width, reg: u8, lane: u32, at: u32, _: Areas) {
        self.signs(width, reg);
        self.put_bits(lane, at);
    }

    fn spread_mask(&mut self, reg: u8, k: u8) {
        self.evex(Code(2, 2, 0x38), reg, 0, Source::Reg(k), 0);
    }

    fn gather_mask(&mut self, k: u8, reg: u8) {
        self.evex(Code(2, 2, 0x39), k, 0, Source::Reg(reg), 0);
    }

    fn load_exec_mask(&mut self, k: u8, lane: u32) {
        self.load_mask(k, Layout::EXEC + lane / 8);
    }

    fn compare(&mut self, width: Width, what: Binary, k: u8, a: u8, b: Source) {
        let (code, order) = comparison(what);
        self.lanes(width, code, k, a, b);
        self.raw(order.as_slice());
    }

    fn combine_masks(&mut self, what: Binary, to: u8, a: u8, b: u8) {
        let number = match what {
            Binary::And => 0x41,
            Binary::Or => 0x45,
            _ => 0x47,
        };
        self.masks(number, to, a, b);
    }

    fn not_mask(&mut self, to: u8, k: u8) {
        self.vex(false, Code(0, 1, 0x44), to, 0, Source::Reg(k));
    }

    fn choose_by_mask(&mut self, _: Width, to: u8, k: u8, yes: Source, no: u8) {
        self.blend(to, k, yes, no);
    }

    fn write_mask(&mut self, k: u8, lane: u32, at: u32) {
        self.mask_to_eax(k);
        self.put_bits(lane, at);
    }
}

/// Lanes from memory.
const LOAD: Code = Code(0, 1, 0x10);
const AND: Code = Code(1, 1, 0xdb);
const OR: Code = Code(1, 1, 0xeb);
const XOR: Code = Code(1, 1, 0xef);

/// A comparison, and the order that follows it for floats.
fn comparison(what: Binary) -> (Code, Option<u8>) {
    match what {
        Binary::IntEqual => (Code(1, 1, 0x76), None),
        Binary::IntGreater => (Code(1, 1, 0x66), None),
        Binary::Equal => (Code(0, 1, 0xc2), Some(0)),
        Binary::Less => (Code(0, 1, 0xc2), Some(1)),
        _ => (Code(0, 1, 0xc2), Some(2)),
    }
}

fn code(what: Binary) -> Code {
    match what {
        Binary::Add => Code(0, 1, 0x58),
        Binary::Sub => Code(0, 1, 0x5c),
        Binary::Mul => Code(0, 1, 0x59),
        Binary::Div => Code(0, 1, 0x5e),
        Binary::Min => Code(0, 1, 0x5d),
        Binary::Max => Code(0, 1, 0x5f),
        Binary::And => AND,
        Binary::Or => OR,
        Binary::Xor => XOR,
        Binary::IntAdd => Code(1, 1, 0xfe),
        Binary::IntSub => Code(1, 1, 0xfa),
        Binary::IntMul => Code(1, 2, 0x40),
        Binary::IntMin => Code(1, 2, 0x39),
        Binary::IntMax => Code(1, 2, 0x3d),
        Binary::Up => Code(1, 2, 0x47),
        Binary::Down => Code(1, 2, 0x45),
        Binary::SignedDown => Code(1, 2, 0x46),
        _ => unreachable!("made elsewhere"),
    }
}

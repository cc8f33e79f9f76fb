// SPDX-License-Identifier: GPL-3.0-or-later
//! Machine code for 64-bit ARM with NEON, which every such CPU has.
//! `x19` is the memory, `x20` the argument of calls, `x21` their target; `w0` and `w1` are the words of control,
//! `w9`, `w10` and `x16` for work. Of the vector registers `v30` and `v31` are for work. Masks are vectors.
//! Nothing is fused, and subnormal numbers count, as in the interpreter. `asm` encodes.
//! Tests: `tests/agreement.rs`, `tests/chance.rs`.

mod asm;

use gnurt_simd::Level;
use std::ops::Range;

use crate::isa::{Areas, Choice, FromMemory, Isa, Label, Source, Text, Width, Word};
use crate::layout::Layout;
use crate::op::{Binary, Shift, Unary};
use asm::{Access, Code, Over, Pair, lanes, word};

pub(crate) use asm::Asm;

/// Words for work.
const WORK: [u8; 2] = [9, 10];
/// Vectors for work.
const SPARE: [u8; 2] = [30, 31];
/// The frame, and where a function returns to.
const FRAME: [u8; 2] = [29, 30];
const CONTEXT: u8 = 20;
const CALLS: u8 = 21;
const JUMP: u32 = 0x1400_0000;
const CALL: u32 = 0x9400_0000;

impl Isa for Asm {
    fn wide(_: Level) -> Width {
        Width::Four
    }

    fn copies(_: Level) -> u32 {
        4
    }

    fn registers(_: Width) -> usize {
        30
    }

    fn mask_registers(_: Width) -> Range<usize> {
        0..0
    }

    fn from_memory(_: Width) -> FromMemory {
        FromMemory::Nothing
    }

    fn rotates(_: Width) -> bool {
        false
    }

    fn choice(_: Width) -> Choice {
        Choice::Anywhere
    }

    fn leaves_test(_: Width) -> bool {
        false
    }

    fn text(&mut self) -> &mut Text {
        &mut self.text
    }

    fn finish(&mut self) -> Result<Vec<u8>, String> {
        self.text.finish(Self::reach)
    }

    fn entry(&mut self) {
        let [frame, back] = FRAME;
        self.pair(Pair::Push, frame, back, -112);
        self.frame(frame);
        self.pair(Pair::Store, asm::MEMORY, CONTEXT, 16);
        // The second is only there for the stack's alignment.
        self.pair(Pair::Store, CALLS, asm::ZERO, 32);
        // Functions keep the lower halves of these.
        for k in 0..4 {
            self.pair(Pair::StoreHalves, 8 + 2 * k, 9 + 2 * k, 48 + 16 * i32::from(k));
        }
        for (to, from) in [(asm::MEMORY, 0), (CONTEXT, 1), (CALLS, 2)] {
            self.three(word::OR_LONG, to, asm::ZERO, from);
        }
        self.call_at(3);
        for k in 0..4 {
            self.pair(Pair::LoadHalves, 8 + 2 * k, 9 + 2 * k, 48 + 16 * i32::from(k));
        }
        self.pair(Pair::Load, CALLS, asm::ZERO, 32);
        self.pair(Pair::Load, asm::MEMORY, CONTEXT, 16);
        self.pair(Pair::Pop, frame, back, 112);
        self.end();
    }

    fn start_function(&mut self) {
        let [frame, back] = FRAME;
        self.pair(Pair::Push, frame, back, -16);
        self.frame(frame);
    }

    fn end_function(&mut self) {
        let [frame, back] = FRAME;
        self.pair(Pair::Pop, frame, back, 16);
        self.end();
    }

    fn call(&mut self, label: Label) {
        self.far(CALL, label);
    }

    fn call_out(&mut self, number: u32) {
        self.three(word::OR_LONG, 0, asm::ZERO, CONTEXT);
        self.number(1, number);
        self.call_at(CALLS);
    }

    fn jump(&mut self, label: Label) {
        self.far(JUMP, label);
    }

    fn jump_if_zero(&mut self, word: Word, label: Label) {
        self.over(Over::NotZero(word as u8));
        self.far(JUMP, label);
    }

    fn jump_if_not_zero(&mut self, word: Word, label: Label) {
        self.over(Over::Zero(word as u8));
        self.far(JUMP, label);
    }

    fn jump_if_zero_at(&mut self, at: u32, label: Label) {
        self.access(Access::Load, WORK[0], at);
        self.over(Over::NotZero(WORK[0]));
        self.far(JUMP, label);
    }

    fn spend(&mut self, at: u32, less: u32, label: Label) {
        let [rest, by] = WORK;
        self.access(Access::Load, rest, at);
        self.number(by, less);
        self.three(word::SUB, rest, rest, by);
        self.access(Access::Store, rest, at);
        self.over(Over::Negative);
        self.far(JUMP, label);
    }

    fn load_word(&mut self, word: Word, at: u32) {
        self.access(Access::Load, word as u8, at);
    }

    fn store_word(&mut self, word: Word, at: u32) {
        self.access(Access::Store, word as u8, at);
    }

    fn and_word(&mut self, word: Word, at: u32) {
        self.access(Access::Load, WORK[0], at);
        self.three(word::AND, word as u8, word as u8, WORK[0]);
    }

    fn or_word(&mut self, word: Word, at: u32) {
        self.access(Access::Load, WORK[0], at);
        self.three(word::OR, word as u8, word as u8, WORK[0]);
    }

    fn or_into(&mut self, word: Word, at: u32) {
        self.access(Access::Load, WORK[0], at);
        self.three(word::OR, WORK[0], WORK[0], word as u8);
        self.access(Access::Store, WORK[0], at);
    }

    fn clear(&mut self, at: u32) {
        self.access(Access::Store, asm::ZERO, at);
    }

    fn and(&mut self, to: Word, from: Word) {
        self.three(word::AND, to as u8, to as u8, from as u8);
    }

    fn xor(&mut self, to: Word, from: Word) {
        self.three(word::XOR, to as u8, to as u8, from as u8);
    }

    fn and_not(&mut self, to: Word, from: Word) {
        self.three(word::AND_NOT, to as u8, to as u8, from as u8);
    }

    fn zero(&mut self, _: Width, reg: u8) {
        self.zeros(reg);
    }

    fn load_constant(&mut self, _: Width, reg: u8, at: u32) {
        self.access(Access::LoadLanes, reg, at);
    }

    fn load_each(&mut self, width: Width, reg: u8, at: u32) {
        self.access(Access::LoadOne, reg, at);
        if width != Width::One {
            self.two(lanes::DUP, reg, reg);
        }
    }

    fn load(&mut self, width: Width, reg: u8, at: u32) {
        let access = if width == Width::One { Access::LoadOne } else { Access::LoadLanes };
        self.access(access, reg, at);
    }

    fn store(&mut self, width: Width, reg: u8, at: u32) {
        let access = if width == Width::One { Access::StoreOne } else { Access::StoreLanes };
        self.access(access, reg, at);
    }

    fn store_one(&mut self, _: Width, reg: u8, at: u32) {
        self.access(Access::StoreOne, reg, at);
    }

    fn save(&mut self, _: Width, reg: u8, at: u32) {
        self.access(Access::StoreLanes, reg, at);
    }

    fn restore(&mut self, _: Width, reg: u8, at: u32) {
        self.access(Access::LoadLanes, reg, at);
    }

    fn exec(&mut self, _: Width, reg: u8, lane: u32, areas: Areas) {
        self.access(Access::LoadLanes, SPARE[0], areas.lane_bits + 4 * lane);
        self.load_each(Width::Four, reg, Layout::EXEC);
        self.three(lanes::CMTST, reg, reg, SPARE[0]);
    }

    fn copy(&mut self, _: Width, to: u8, from: u8) {
        self.three(lanes::ORR, to, from, from);
    }

    fn unary(&mut self, _: Width, what: Unary, to: u8, from: Source) {
        let from = register(from);
        let code = match what {
            Unary::Sqrt => lanes::FSQRT,
            Unary::Floor => lanes::FRINTM,
            Unary::Ceil => lanes::FRINTP,
            Unary::Trunc => lanes::FRINTZ,
            Unary::FromInt => lanes::SCVTF,
            Unary::ToInt => lanes::FCVTZS,
        };
        self.two(code, to, from);
    }

    fn binary(&mut self, width: Width, what: Binary, to: u8, a: u8, b: Source) {
        let b = register(b);
        // The machine's own minimum has another rule for zeros and NaN.
        if let Binary::Min | Binary::Max = what {
            let (high, low) = if what == Binary::Min { (b, a) } else { (a, b) };
            self.three(lanes::FCMGT, SPARE[0], high, low);
            return self.choose(width, to, SPARE[0], Source::Reg(a), b);
        }
        let (code, a, b) = match what {
            Binary::Less => (lanes::FCMGT, b, a),
            Binary::AtMost => (lanes::FCMGE, b, a),
            Binary::Down | Binary::SignedDown => {
                self.two(lanes::NEG, SPARE[0], b);
                let code = if what == Binary::Down { lanes::USHL } else { lanes::SSHL };
                (code, a, SPARE[0])
            }
            _ => (code(what), a, b),
        };
        self.three(code, to, a, b);
    }

    fn shift(&mut self, width: Width, what: Shift, to: u8, from: u8, by: u8) {
        match what {
            Shift::Down if by == 0 => self.copy(width, to, from),
            Shift::Down => self.down(to, from, by),
            _ => self.up(to, from, by),
        }
    }

    fn choose(&mut self, width: Width, to: u8, mask: u8, yes: Source, no: u8) {
        let yes = register(yes);
        if to == no {
            self.three(lanes::BIT, to, yes, mask);
        } else if to == yes {
            self.three(lanes::BIF, to, no, mask);
        } else {
            if to != mask {
                self.copy(width, to, mask);
            }
            self.three(lanes::BSL, to, yes, no);
        }
    }

    fn divide(&mut self, width: Width, what: Binary, a: u8, b: u8, _: Areas) {
        let ([x, y], [rest, quotient]) = (WORK, SPARE);
        for lane in 0..width.lanes() as u8 {
            self.take_lane(x, a, lane);
            self.take_lane(y, b, lane);
            self.three(word::DIV, x, x, y);
            self.put_lane(quotient, lane, x);
        }
        if what == Binary::IntDiv {
            return;
        }
        self.copy(width, rest, a);
        self.three(lanes::MLS, rest, quotient, b);
        self.two(lanes::IS_ZERO, quotient, b);
        self.three(lanes::BIC, quotient, rest, quotient);
        if what == Binary::IntModulo {
            self.two(lanes::IS_NEGATIVE, rest, quotient);
            self.three(lanes::AND, rest, rest, b);
            self.three(lanes::ADD, quotient, quotient, rest);
        }
    }

    fn quotient(&mut self, width: Width, to: u8, _: Areas) {
        self.copy(width, to, SPARE[1]);
    }

    fn write_test(&mut self, _: Width, reg: u8, lane: u32, at: u32, areas: Areas) {
        self.access(Access::LoadLanes, SPARE[0], areas.lane_bits + 4 * lane);
        self.three(lanes::AND, SPARE[0], SPARE[0], reg);
        self.two(lanes::ADDV, SPARE[0], SPARE[0]);
        self.two(lanes::FMOV, WORK[1], SPARE[0]);
        if lane > 0 {
            self.access(Access::Load, WORK[0], at);
            self.three(word::OR, WORK[1], WORK[1], WORK[0]);
        }
        self.access(Access::Store, WORK[1], at);
    }
}

fn register(source: Source) -> u8 {
    match source {
        Source::Reg(reg) => reg,
        Source::Mem(_) | Source::Each(_) => unreachable!("no instruction computes from memory"),
    }
}

fn code(what: Binary) -> Code {
    match what {
        Binary::Add => lanes::FADD,
        Binary::Sub => lanes::FSUB,
        Binary::Mul => lanes::FMUL,
        Binary::Div => lanes::FDIV,
        Binary::And => lanes::AND,
        Binary::Or => lanes::ORR,
        Binary::Xor => lanes::EOR,
        Binary::Equal => lanes::FCMEQ,
        Binary::IntAdd => lanes::ADD,
        Binary::IntSub => lanes::SUB,
        Binary::IntMul => lanes::MUL,
        Binary::IntMin => lanes::SMIN,
        Binary::IntMax => lanes::SMAX,
        Binary::IntGreater => lanes::CMGT,
        Binary::IntEqual => lanes::CMEQ,
        Binary::Up => lanes::USHL,
        _ => unreachable!("made elsewhere"),
    }
}

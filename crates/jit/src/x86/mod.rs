// SPDX-License-Identifier: GPL-3.0-or-later
//! Machine code for x86-64 with AVX2 or AVX-512.
//! Control is on masks in memory, sixteen bits each, with branches that skip code without running lanes;
//! computation is in regions. A layer is a function; `rbx` is the memory, `r12` the argument of calls, `r13`
//! their target. `asm` encodes, `region` allocates registers.
//! Tests: `tests/agreement.rs`, `tests/chance.rs`.

mod asm;
mod region;

use gnurt_simd::Level;

use crate::layout::{CellAddress, Layout, SPILLS};
use crate::op::Region;
use crate::program::{Loop, Node, Program, Test, Tight};
use asm::{Access, Asm, Gpr, Label, When, Width};
use region::Areas;

use Gpr::{Eax, Ecx};

/// The machine code of a group.
pub(crate) struct Code {
    /// The bytes; they may be put anywhere.
    pub(crate) bytes: Vec<u8>,
    /// Where each layer starts. The entry is at 0.
    pub(crate) layers: Vec<u32>,
}

/// How often a constant is repeated in memory, so that a register can be loaded from there.
pub(crate) fn copies(level: Level) -> u32 {
    if level == Level::Avx512 { 4 } else { 8 }
}

/// Makes the code of a program for a level.
///
/// # Errors
/// That too many values are needed at once.
pub(crate) fn code(program: &Program, layout: &mut Layout, level: Level) -> Result<Code, String> {
    let wide = match (layout.lanes, level) {
        (1, _) => Width::One,
        (_, Level::Avx512) => Width::Sixteen,
        _ => Width::Eight,
    };
    let mut asm = Asm::default();
    // entry(memory, context, calls, layer): keeps the registers that are not its own.
    asm.raw(&[0x53, 0x41, 0x54, 0x41, 0x55]); // push rbx, r12, r13
    asm.raw(&[0x48, 0x89, 0xfb, 0x49, 0x89, 0xf4, 0x49, 0x89, 0xd5]); // mov rbx, rdi; r12, rsi; r13, rdx
    asm.raw(&[0xff, 0xd1]); // call rcx
    asm.raw(&[0xc5, 0xf8, 0x77]); // vzeroupper
    asm.raw(&[0x41, 0x5d, 0x41, 0x5c, 0x5b, 0xc3]); // pop r13, r12, rbx; ret
    let layers: Vec<Label> = program.layers.iter().map(|_| asm.label()).collect();
    let mut emitter = Emitter { asm, layout, wide, layers, most: 0 };
    for (number, layer) in program.layers.iter().enumerate() {
        emitter.layer(number, layer);
    }
    if emitter.most > SPILLS {
        return Err(format!("more than {SPILLS} values are needed at once"));
    }
    emitter.asm.finish();
    let layers = emitter.layers.iter().map(|&l| emitter.asm.address(l)).collect();
    Ok(Code { bytes: emitter.asm.bytes, layers })
}

struct Emitter<'a> {
    asm: Asm,
    layout: &'a mut Layout,
    wide: Width,
    layers: Vec<Label>,
    /// Rooms for values without a register.
    most: u32,
}

impl Emitter<'_> {
    fn load(&mut self, reg: Gpr, slot: u32) {
        self.asm.access(Access::Load, reg, Layout::slot(slot));
    }

    fn store(&mut self, reg: Gpr, slot: u32) {
        self.asm.access(Access::Store, reg, Layout::slot(slot));
    }

    fn load_exec(&mut self) {
        self.asm.access(Access::Load, Eax, Layout::EXEC);
    }

    fn store_exec(&mut self) {
        self.asm.access(Access::Store, Eax, Layout::EXEC);
    }

    /// `eax &= !slot`
    fn without(&mut self, slot: u32) {
        self.load(Ecx, slot);
        self.asm.not(Ecx);
        self.asm.and(Eax, Ecx);
    }

    fn layer(&mut self, number: usize, layer: &crate::program::Layer) {
        self.asm.bind(self.layers[number]);
        self.asm.raw(&[0x48, 0x83, 0xec, 0x08]); // sub rsp, 8
        let out = self.asm.label();
        self.load_exec();
        self.store(Eax, layer.entry);
        self.without(layer.done);
        self.asm.test(Eax, Eax);
        self.asm.jump_if(When::Zero, out);
        self.store_exec();
        self.asm.access(Access::OrInto, Eax, Layout::slot(layer.done));
        self.block(&layer.code);
        self.load(Eax, layer.entry);
        self.store_exec();
        self.asm.bind(out);
        self.asm.raw(&[0x48, 0x83, 0xc4, 0x08, 0xc3]); // add rsp, 8; ret
    }

    /// Nodes in order; none of them is done by no lane.
    fn block(&mut self, nodes: &[Node]) {
        let end = self.asm.label();
        for (i, node) in nodes.iter().enumerate() {
            self.node(node);
            if i + 1 < nodes.len() && node.leaves() {
                self.asm.compare_word_with_zero(Layout::EXEC);
                self.asm.jump_if(When::Zero, end);
            }
        }
        self.asm.bind(end);
    }

    fn node(&mut self, node: &Node) {
        match node {
            Node::Region(region) => self.region(region),
            Node::Call(number) => self.call(*number),
            Node::If { test, yes, no, other, done } => self.choice(*test, yes, no, *other, *done),
            Node::Loop(inner) => self.iterations(inner),
            Node::Tight(inner) => self.tight(inner),
            Node::Frame { body, entry, left, gone } => {
                self.asm.set_bits(Layout::slot(*left), 0);
                self.load_exec();
                self.store(Eax, *entry);
                self.block(body);
                self.load(Eax, *entry);
                if let Some(gone) = gone {
                    self.without(*gone);
                }
                self.store_exec();
            }
            Node::Once { flag, entry, body } => {
                let out = self.asm.label();
                self.load_exec();
                self.store(Eax, *entry);
                self.without(*flag);
                self.asm.test(Eax, Eax);
                self.asm.jump_if(When::Zero, out);
                self.store_exec();
                self.asm.access(Access::OrInto, Eax, Layout::slot(*flag));
                self.block(body);
                self.load(Eax, *entry);
                self.store_exec();
                self.asm.bind(out);
            }
            Node::Layer(number) => {
                let label = self.layers[*number as usize];
                self.asm.call(label);
            }
            Node::Leave(note) => {
                if let Some(note) = note {
                    self.load_exec();
                    self.asm.access(Access::OrInto, Eax, Layout::slot(*note));
                }
                self.asm.set_bits(Layout::EXEC, 0);
            }
            Node::LeaveSome { lanes, note } => {
                self.load_exec();
                self.load(Ecx, *lanes);
                self.asm.and(Ecx, Eax);
                if let Some(note) = note {
                    self.asm.access(Access::OrInto, Ecx, Layout::slot(*note));
                }
                self.asm.raw(&[0x31, 0xc8]); // xor eax, ecx
                self.store_exec();
            }
        }
    }

    fn region(&mut self, region: &Region) {
        let [lane_bits, scratch, spills] = self.layout.areas();
        let one = region.tests.is_empty()
            && region
                .stores
                .iter()
                .all(|&(cell, _)| matches!(self.layout.address(cell), CellAddress::One(_)));
        let width = if one { Width::One } else { self.wide };
        let most =
            region::region(&mut self.asm, self.layout, region, width, Areas { spills, scratch, lane_bits });
        self.most = self.most.max(most);
    }

    fn call(&mut self, number: u32) {
        self.asm.raw(&[0xc5, 0xf8, 0x77, 0x4c, 0x89, 0xe7, 0xbe]); // vzeroupper; mov rdi, r12; mov esi, number
        self.asm.raw(&number.to_le_bytes());
        self.asm.raw(&[0x41, 0xff, 0xd5]); // call r13
    }

    fn choice(&mut self, test: Test, yes: &[Node], no: &[Node], other: u32, done: u32) {
        let (otherwise, end) = (self.asm.label(), self.asm.label());
        let lanes = match test {
            Test::Cell(cell) => {
                let (CellAddress::One(at) | CellAddress::Each(at)) = self.layout.address(cell);
                self.asm.compare_word_with_zero(at);
                self.asm.jump_if(When::Zero, otherwise);
                self.block(yes);
                if !no.is_empty() {
                    self.asm.jump(end);
                }
                self.asm.bind(otherwise);
                self.block(no);
                self.asm.bind(end);
                return;
            }
            Test::Lanes(lanes) => lanes,
        };
        // ecx = those of the first block, eax = the others.
        self.load_exec();
        self.load(Ecx, lanes);
        self.asm.and(Ecx, Eax);
        self.asm.raw(&[0x31, 0xc8]); // xor eax, ecx
        self.store(Eax, other);
        self.asm.access(Access::Store, Ecx, Layout::EXEC);
        self.store(Ecx, done);
        self.asm.test(Ecx, Ecx);
        self.asm.jump_if(When::Zero, otherwise);
        self.block(yes);
        if yes.iter().any(Node::leaves) {
            self.load_exec();
            self.store(Eax, done);
        }
        self.asm.bind(otherwise);
        self.load(Eax, other);
        if no.is_empty() {
            self.asm.access(Access::Or, Eax, Layout::slot(done));
            self.store_exec();
            return;
        }
        self.store_exec();
        self.asm.test(Eax, Eax);
        self.asm.jump_if(When::Zero, end);
        self.block(no);
        self.asm.bind(end);
        self.load_exec();
        self.asm.access(Access::Or, Eax, Layout::slot(done));
        self.store_exec();
    }

    /// Keeps the lanes that a region has let go on.
    fn go_on(&mut self, live: u32) {
        if self.wide == Width::Sixteen {
            // The region's test has left its bits in eax.
            self.asm.access(Access::And, Eax, Layout::EXEC);
        } else {
            self.load_exec();
            self.asm.access(Access::And, Eax, Layout::slot(live));
        }
        self.store_exec();
        self.asm.test(Eax, Eax);
    }

    /// Takes the fuel of one iteration. Where none is left all iterating lanes are noted as stopped, and leave the loop.
    fn spend_fuel(&mut self, [turns, say, stopped]: [u32; 3], done: Label) {
        let fueled = self.asm.label();
        self.asm.subtract_from_word(Layout::FUEL, turns);
        self.asm.jump_if(When::NotNegative, fueled);
        // No more iterations are allowed.
        self.asm.set_bits(Layout::FUEL, 0);
        self.call(say);
        self.load_exec();
        self.asm.access(Access::OrInto, Eax, Layout::slot(stopped));
        self.asm.jump(done);
        self.asm.bind(fueled);
    }

    fn tight(&mut self, inner: &Tight) {
        let [top, done] = [self.asm.label(), self.asm.label()];
        self.load_exec();
        self.store(Eax, inner.entry);
        if !inner.body_first {
            self.block(&inner.before);
            self.go_on(inner.live);
            self.asm.jump_if(When::Zero, done);
        }
        self.asm.bind(top);
        self.spend_fuel([inner.turns, inner.say, inner.stopped], done);
        self.block(&inner.iteration);
        self.go_on(inner.live);
        self.asm.jump_if(When::NotZero, top);
        self.asm.bind(done);
        self.load(Eax, inner.entry);
        self.without(inner.stopped);
        self.store_exec();
    }

    fn iterations(&mut self, inner: &Loop) {
        let (top, body, done) = (self.asm.label(), self.asm.label(), self.asm.label());
        self.load_exec();
        self.store(Eax, inner.entry);
        self.store(Eax, inner.live);
        if inner.body_first {
            self.asm.jump(body);
        }
        self.asm.bind(top);
        self.block(&inner.test);
        match inner.condition {
            Test::Cell(cell) => {
                let (CellAddress::One(at) | CellAddress::Each(at)) = self.layout.address(cell);
                self.asm.compare_word_with_zero(at);
            }
            Test::Lanes(lanes) => {
                self.load_exec();
                self.asm.access(Access::And, Eax, Layout::slot(lanes));
                self.store_exec();
                self.store(Eax, inner.live);
                self.asm.test(Eax, Eax);
            }
        }
        self.asm.jump_if(When::Zero, done);
        self.asm.bind(body);
        self.spend_fuel([inner.turns, inner.say, inner.stopped], done);
        self.asm.set_bits(Layout::slot(inner.waiting), 0);
        self.block(&inner.body);
        self.load_exec();
        self.asm.access(Access::Or, Eax, Layout::slot(inner.waiting));
        self.store_exec();
        self.store(Eax, inner.live);
        self.asm.test(Eax, Eax);
        self.asm.jump_if(When::Zero, done);
        self.block(&inner.step);
        self.asm.jump(top);
        self.asm.bind(done);
        self.load(Eax, inner.entry);
        for &gone in &inner.gone {
            self.without(gone);
        }
        self.store_exec();
    }
}

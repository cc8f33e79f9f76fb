// SPDX-License-Identifier: GPL-3.0-or-later
//! The control of a program, for any machine: on masks in memory, a bit for each lane, with branches that skip
//! code without running lanes. A layer is a function.
//! Tests: `tests/agreement.rs`, `tests/chance.rs`.

use gnurt_simd::Level;

use crate::isa::{Areas, Isa, Label, Width, Word};
use crate::layout::{CellAddress, Layout, SPILLS};
use crate::op::Region;
use crate::program::{Loop, Node, Program, Test, Tight};
use crate::region;

use Word::{A, B};

/// The machine code of a group.
pub(crate) struct Code {
    /// The bytes; they may be put anywhere.
    pub(crate) bytes: Vec<u8>,
    /// Where each layer starts. The entry is at 0.
    pub(crate) layers: Vec<u32>,
}

/// Makes the code of a program for a level.
///
/// # Errors
/// That too many values are needed at once, or that the code is too long for the machine's jumps.
pub(crate) fn code<I: Isa>(program: &Program, layout: &mut Layout, level: Level) -> Result<Code, String> {
    let wide = if layout.lanes == 1 { Width::One } else { I::wide(level) };
    let mut asm = I::default();
    asm.entry();
    let layers: Vec<Label> = program.layers.iter().map(|_| asm.text().label()).collect();
    let mut emitter = Emitter { asm, layout, wide, layers, most: 0 };
    for (number, layer) in program.layers.iter().enumerate() {
        emitter.layer(number, layer);
    }
    if emitter.most > SPILLS {
        return Err(format!("more than {SPILLS} values are needed at once"));
    }
    let bytes = emitter.asm.finish()?;
    let text = emitter.asm.text();
    let layers = emitter.layers.iter().map(|&label| text.address(label)).collect();
    Ok(Code { bytes, layers })
}

struct Emitter<'a, I> {
    asm: I,
    layout: &'a mut Layout,
    wide: Width,
    layers: Vec<Label>,
    /// Rooms for values without a register.
    most: u32,
}

impl<I: Isa> Emitter<'_, I> {
    fn load(&mut self, word: Word, slot: u32) {
        self.asm.load_word(word, Layout::slot(slot));
    }

    fn store(&mut self, word: Word, slot: u32) {
        self.asm.store_word(word, Layout::slot(slot));
    }

    fn load_exec(&mut self) {
        self.asm.load_word(A, Layout::EXEC);
    }

    fn store_exec(&mut self) {
        self.asm.store_word(A, Layout::EXEC);
    }

    /// `A &= !slot`
    fn without(&mut self, slot: u32) {
        self.load(B, slot);
        self.asm.and_not(A, B);
    }

    fn layer(&mut self, number: usize, layer: &crate::program::Layer) {
        self.asm.text().bind(self.layers[number]);
        self.asm.start_function();
        let out = self.asm.text().label();
        self.load_exec();
        self.store(A, layer.entry);
        self.without(layer.done);
        self.asm.jump_if_zero(A, out);
        self.store_exec();
        self.asm.or_into(A, Layout::slot(layer.done));
        self.block(&layer.code);
        self.load(A, layer.entry);
        self.store_exec();
        self.asm.text().bind(out);
        self.asm.end_function();
    }

    /// Nodes in order; none of them is done by no lane.
    fn block(&mut self, nodes: &[Node]) {
        let end = self.asm.text().label();
        for (i, node) in nodes.iter().enumerate() {
            self.node(node);
            if i + 1 < nodes.len() && node.leaves() {
                self.asm.jump_if_zero_at(Layout::EXEC, end);
            }
        }
        self.asm.text().bind(end);
    }

    fn node(&mut self, node: &Node) {
        match node {
            Node::Region(region) => self.region(region),
            Node::Call(number) => self.asm.call_out(*number),
            Node::If { test, yes, no, other, done } => self.choice(*test, yes, no, *other, *done),
            Node::Loop(inner) => self.iterations(inner),
            Node::Tight(inner) => self.tight(inner),
            Node::Frame { body, entry, left, gone } => {
                self.asm.clear(Layout::slot(*left));
                self.load_exec();
                self.store(A, *entry);
                self.block(body);
                self.load(A, *entry);
                if let Some(gone) = gone {
                    self.without(*gone);
                }
                self.store_exec();
            }
            Node::Once { flag, entry, body } => {
                let out = self.asm.text().label();
                self.load_exec();
                self.store(A, *entry);
                self.without(*flag);
                self.asm.jump_if_zero(A, out);
                self.store_exec();
                self.asm.or_into(A, Layout::slot(*flag));
                self.block(body);
                self.load(A, *entry);
                self.store_exec();
                self.asm.text().bind(out);
            }
            Node::Layer(number) => {
                let label = self.layers[*number as usize];
                self.asm.call(label);
            }
            Node::Leave(note) => {
                if let Some(note) = note {
                    self.load_exec();
                    self.asm.or_into(A, Layout::slot(*note));
                }
                self.asm.clear(Layout::EXEC);
            }
            Node::LeaveSome { lanes, note } => {
                self.load_exec();
                self.load(B, *lanes);
                self.asm.and(B, A);
                if let Some(note) = note {
                    self.asm.or_into(B, Layout::slot(*note));
                }
                self.asm.xor(A, B);
                self.store_exec();
            }
        }
    }

    fn region(&mut self, region: &Region) {
        self.region_of_loop(region, &region::Carried::default());
    }

    fn areas(&self) -> Areas {
        let [lane_bits, scratch, spills] = self.layout.areas();
        Areas { spills, scratch, lane_bits }
    }

    /// A region that is a loop's iteration.
    fn region_of_loop(&mut self, region: &Region, carried: &region::Carried) {
        let areas = self.areas();
        let one = region.tests.is_empty()
            && region
                .stores
                .iter()
                .all(|&(cell, _)| matches!(self.layout.address(cell), CellAddress::One(_)));
        let width = if one { Width::One } else { self.wide };
        let most = region::region(&mut self.asm, self.layout, region, width, areas, carried);
        self.most = self.most.max(most);
    }

    fn choice(&mut self, test: Test, yes: &[Node], no: &[Node], other: u32, done: u32) {
        let (otherwise, end) = (self.asm.text().label(), self.asm.text().label());
        let lanes = match test {
            Test::Cell(cell) => {
                let (CellAddress::One(at) | CellAddress::Each(at)) = self.layout.address(cell);
                self.asm.jump_if_zero_at(at, otherwise);
                self.block(yes);
                if !no.is_empty() {
                    self.asm.jump(end);
                }
                self.asm.text().bind(otherwise);
                self.block(no);
                self.asm.text().bind(end);
                return;
            }
            Test::Lanes(lanes) => lanes,
        };
        // B = those of the first block, A = the others.
        self.load_exec();
        self.load(B, lanes);
        self.asm.and(B, A);
        self.asm.xor(A, B);
        self.store(A, other);
        self.asm.store_word(B, Layout::EXEC);
        self.store(B, done);
        self.asm.jump_if_zero(B, otherwise);
        self.block(yes);
        if yes.iter().any(Node::leaves) {
            self.load_exec();
            self.store(A, done);
        }
        self.asm.text().bind(otherwise);
        self.load(A, other);
        if no.is_empty() {
            self.asm.or_word(A, Layout::slot(done));
            self.store_exec();
            return;
        }
        self.store_exec();
        self.asm.jump_if_zero(A, end);
        self.block(no);
        self.asm.text().bind(end);
        self.load_exec();
        self.asm.or_word(A, Layout::slot(done));
        self.store_exec();
    }

    /// Keeps the lanes that a region has let go on.
    fn go_on(&mut self, live: u32) {
        if I::leaves_test(self.wide) {
            self.asm.and_word(A, Layout::EXEC);
        } else {
            self.load_exec();
            self.asm.and_word(A, Layout::slot(live));
        }
        self.store_exec();
    }

    /// Takes the fuel of one iteration. Where none is left all iterating lanes are noted as stopped, and leave the loop.
    fn spend_fuel(&mut self, [turns, say, stopped]: [u32; 3], done: Label) {
        let fueled = self.asm.text().label();
        self.asm.spend(Layout::FUEL, turns, fueled);
        // No more iterations are allowed.
        self.asm.clear(Layout::FUEL);
        self.asm.call_out(say);
        self.load_exec();
        self.asm.or_into(A, Layout::slot(stopped));
        self.asm.jump(done);
        self.asm.text().bind(fueled);
    }

    fn tight(&mut self, inner: &Tight) {
        let [top, done] = [self.asm.text().label(), self.asm.text().label()];
        self.load_exec();
        self.store(A, inner.entry);
        if !inner.body_first {
            self.block(&inner.before);
            self.go_on(inner.live);
            self.asm.jump_if_zero(A, done);
        }
        let mut carried = region::Carried::default();
        if let [Node::Region(region)] = &inner.iteration[..] {
            carried = region::carried::<I>(self.layout, region, self.wide, inner.live);
            let areas = self.areas();
            region::load_carried(&mut self.asm, self.layout, &carried, self.wide, areas);
        }
        self.asm.text().bind(top);
        self.spend_fuel([inner.turns, inner.say, inner.stopped], done);
        match &inner.iteration[..] {
            [Node::Region(region)] => self.region_of_loop(region, &carried),
            nodes => self.block(nodes),
        }
        self.go_on(inner.live);
        self.asm.jump_if_not_zero(A, top);
        self.asm.text().bind(done);
        self.load(A, inner.entry);
        self.without(inner.stopped);
        self.store_exec();
    }

    fn iterations(&mut self, inner: &Loop) {
        let (top, body, done) = (self.asm.text().label(), self.asm.text().label(), self.asm.text().label());
        self.load_exec();
        self.store(A, inner.entry);
        self.store(A, inner.live);
        if inner.body_first {
            self.asm.jump(body);
        }
        self.asm.text().bind(top);
        self.block(&inner.test);
        match inner.condition {
            Test::Cell(cell) => {
                let (CellAddress::One(at) | CellAddress::Each(at)) = self.layout.address(cell);
                self.asm.jump_if_zero_at(at, done);
            }
            Test::Lanes(lanes) => {
                self.load_exec();
                self.asm.and_word(A, Layout::slot(lanes));
                self.store_exec();
                self.store(A, inner.live);
                self.asm.jump_if_zero(A, done);
            }
        }
        self.asm.text().bind(body);
        self.spend_fuel([inner.turns, inner.say, inner.stopped], done);
        self.asm.clear(Layout::slot(inner.waiting));
        self.block(&inner.body);
        self.load_exec();
        self.asm.or_word(A, Layout::slot(inner.waiting));
        self.store_exec();
        self.store(A, inner.live);
        self.asm.jump_if_zero(A, done);
        self.block(&inner.step);
        self.asm.jump(top);
        self.asm.text().bind(done);
        self.load(A, inner.entry);
        for &gone in &inner.gone {
            self.without(gone);
        }
        self.store_exec();
    }
}

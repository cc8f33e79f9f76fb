// SPDX-License-Identifier: GPL-3.0-or-later
//! Variables that may differ from point to point, and variables that are always written before they are read.
//! A variable is identified by its first cell. Invariants: a uniform variable is written only where all
//! running lanes agree, from uniform values. A clean variable is read only where every lane that reads it has
//! passed a write in the same run of the block that holds all its uses, so lanes that do not run may be
//! overwritten. Each pass over the text takes time in proportion to its length, for any depth of loops.
//! Tests: `tests/agreement.rs`, `tests/chance.rs`.

use std::collections::HashSet;

use gnurt_sl::exec::{Flow, Instruction, Loop, Plan, Slot, Source, Step};
use gnurt_sl::ir::SymbolKind;

use super::native::{Known, Touch, touches};
use crate::term::QuickMap;

/// A variable of a shader.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Variable {
    /// The block that it is written in first.
    pub(crate) block: u32,
    /// Whether it is clean.
    pub(crate) clean: bool,
    /// How often it is used.
    pub(crate) uses: u32,
}

/// The results.
#[derive(Default)]
pub(crate) struct Analysis {
    /// By cell.
    pub(crate) varying: Vec<bool>,
    /// Local variables.
    pub(crate) variables: QuickMap<u32, Variable>,
}

/// Analyses a group. With one lane nothing varies.
pub(crate) fn analysis(plan: &Plan, known: &Known<'_>, several: bool) -> Analysis {
    let mut analysis = Analysis { varying: vec![false; plan.memory.len()], ..Analysis::default() };
    let mut uses = Uses { analysis: &mut analysis, open: Vec::new(), stack: Vec::new() };
    for layer in &plan.layers {
        for (id, symbol) in layer.shader.symbols.iter().enumerate() {
            if matches!(symbol.kind, SymbolKind::Local | SymbolKind::Temp) {
                let fresh = Variable { block: u32::MAX, clean: false, uses: 0 };
                uses.analysis.variables.insert(layer.slots[id].at, fresh);
            }
        }
        for param in &layer.params {
            uses.block(&param.init, known);
        }
        uses.block(&layer.code, known);
    }
    if several {
        vary(plan, known, &mut analysis);
    }
    analysis
}

struct Uses<'a> {
    analysis: &'a mut Analysis,
    /// By block, whether it is not ended.
    open: Vec<bool>,
    stack: Vec<u32>,
}

impl Uses<'_> {
    fn touch(&mut self, at: u32, touch: Touch) {
        let here = self.stack.last().copied().unwrap_or(0);
        let Some(v) = self.analysis.variables.get_mut(&at) else { return };
        if v.uses == 0 {
            (v.block, v.clean) = (here, touch == Touch::Write);
        } else if !self.open[v.block as usize] {
            v.clean = false;
        }
        v.uses += 1;
    }

    /// Blocks are numbered in this order, here and where code is made.
    fn block(&mut self, list: &[Instruction], known: &Known<'_>) {
        self.block_then(list, known, None);
    }

    fn block_then(&mut self, list: &[Instruction], known: &Known<'_>, condition: Option<&Slot>) {
        self.stack.push(self.open.len() as u32);
        self.open.push(true);
        for instruction in list {
            match instruction {
                Instruction::Do(step) => {
                    let native = known.is_native(step);
                    touches(step, native, |i, touch| self.touch(step.args[i].at, touch));
                }
                Instruction::If { condition, yes, no, .. } => {
                    self.touch(condition.at, Touch::Read);
                    self.block(yes, known);
                    self.block(no, known);
                }
                Instruction::Loop(inner) => {
                    self.block(&inner.init, known);
                    // The condition is read where it is made.
                    self.block_then(&inner.test, known, Some(&inner.condition));
                    self.block(&inner.body, known);
                    self.block(&inner.step, known);
                }
                Instruction::Call(body) => self.block(body, known),
                Instruction::Leave(_) => {}
            }
        }
        if let Some(slot) = condition {
            self.touch(slot.at, Touch::Read);
        }
        if let Some(ended) = self.stack.pop() {
            self.open[ended as usize] = false;
        }
    }
}

/// Marks varying variables, until nothing is added.
fn vary(plan: &Plan, known: &Known<'_>, analysis: &mut Analysis) {
    let mark = |varying: &mut [bool], slot: &Slot| {
        let cells = &mut varying[slot.at as usize..][..slot.cells()];
        let new = cells.iter().any(|v| !v);
        cells.fill(true);
        new
    };
    for slot in plan.globals.values() {
        mark(&mut analysis.varying, slot);
    }
    for layer in &plan.layers {
        for (id, symbol) in layer.shader.symbols.iter().enumerate() {
            if matches!(symbol.kind, SymbolKind::OutputParam | SymbolKind::Global) {
                mark(&mut analysis.varying, &layer.slots[id]);
            }
        }
        for param in layer.params.iter().filter(|p| p.source != Source::Value) {
            mark(&mut analysis.varying, &layer.slots[param.symbol as usize]);
        }
        for copy in &layer.copies {
            mark(&mut analysis.varying, &layer.slots[copy.to_symbol as usize]);
        }
    }
    let mut split_loops = HashSet::new();
    for _ in 0..PASSES {
        let mut walk = Vary { varying: &mut analysis.varying, split_loops: &mut split_loops, changed: false };
        for layer in &plan.layers {
            for param in &layer.params {
                let split = param.source == Source::Geometry;
                walk.block(&param.init, split, known);
            }
            walk.block(&layer.code, false, known);
        }
        if !walk.changed {
            return;
        }
    }
    // Found out one by one, it would take as long as there are variables: then all of them are taken to vary.
    for layer in &plan.layers {
        for (slot, symbol) in layer.slots.iter().zip(&layer.shader.symbols) {
            if symbol.kind != SymbolKind::Const {
                mark(&mut analysis.varying, slot);
            }
        }
    }
}

/// Times that a group is gone through; each takes as long as its text.
const PASSES: usize = 100;

struct Vary<'a> {
    varying: &'a mut Vec<bool>,
    /// Loops, by address, whose lanes may diverge within an iteration: late operations of one iteration
    /// precede early ones of the next.
    split_loops: &'a mut HashSet<*const Loop>,
    changed: bool,
}

/// The effect of a block on its running lanes.
#[derive(Clone, Copy, Default)]
struct Ways {
    /// Lanes may have left it at different times.
    split: bool,
    /// Jumps that lead out of it, by bits.
    jumps: u8,
}

/// `break` and `continue`.
const OF_LOOP: u8 = 1;
const RETURN: u8 = 2;
const EXIT: u8 = 4;

impl Vary<'_> {
    fn varies(&self, slot: &Slot) -> bool {
        slot.size > 0 && self.varying[slot.at as usize]
    }

    fn mark(&mut self, slot: &Slot) {
        let cells = &mut self.varying[slot.at as usize..][..slot.cells()];
        self.changed |= cells.iter().any(|v| !v);
        cells.fill(true);
    }

    /// Goes through a block that lanes come to at different times if `split`.
    fn block(&mut self, list: &[Instruction], mut split: bool, known: &Known<'_>) -> Ways {
        let mut jumps = 0;
        for instruction in list {
            match instruction {
                Instruction::Do(step) => self.step(step, split, known),
                Instruction::If { condition, yes, no, .. } => {
                    let inner = split || self.varies(condition);
                    let [yes, no] = [yes, no].map(|part| self.block(part, inner, known));
                    split |= yes.split || no.split || inner && (yes.jumps | no.jumps) != 0;
                    jumps |= yes.jumps | no.jumps;
                }
                Instruction::Loop(iterations) => {
                    let init = self.block(&iterations.init, split, known);
                    split |= init.split;
                    let key: *const Loop = &**iterations;
                    let mut inner =
                        split || self.varies(&iterations.condition) || self.split_loops.contains(&key);
                    let is_known = inner;
                    let [mut all, mut late] = [init.jumps, 0];
                    for (i, part) in
                        [&iterations.test, &iterations.body, &iterations.step].into_iter().enumerate()
                    {
                        let ways = self.block(part, inner, known);
                        inner |= ways.split;
                        all |= ways.jumps;
                        late |= if i > 0 { ways.jumps } else { 0 };
                    }
                    inner |= self.varies(&iterations.condition);
                    // Once for the whole of it: its early parts then use the result.
                    if inner && !is_known {
                        self.changed |= self.split_loops.insert(key);
                    }
                    split |= inner && late & (RETURN | EXIT) != 0;
                    jumps |= all & !OF_LOOP;
                }
                Instruction::Call(body) => {
                    let ways = self.block(body, split, known);
                    split |= ways.split && ways.jumps & EXIT != 0;
                    jumps |= ways.jumps & EXIT;
                }
                Instruction::Leave(flow) => {
                    jumps |= match flow {
                        Flow::Next => 0,
                        Flow::Break | Flow::Continue => OF_LOOP,
                        Flow::Return => RETURN,
                        Flow::Exit => EXIT,
                    }
                }
            }
        }
        Ways { split, jumps }
    }

    fn step(&mut self, step: &Step, split: bool, known: &Known<'_>) {
        let native = known.is_native(step);
        let mut varies = split || !(native || known.checked(step).is_some());
        touches(step, native, |i, touch| varies |= touch == Touch::Read && self.varies(&step.args[i]));
        if varies {
            touches(step, native, |i, touch| {
                if touch != Touch::Read {
                    self.mark(&step.args[i]);
                }
            });
        }
    }
}

fn any(list: &[Instruction], test: &dyn Fn(Flow) -> bool, in_calls: &dyn Fn(Flow) -> bool) -> bool {
    list.iter().any(|instruction| match instruction {
        Instruction::Do(_) => false,
        Instruction::If { yes, no, .. } => any(yes, test, in_calls) || any(no, test, in_calls),
        Instruction::Loop(iterations) => {
            let outer = |flow| test(flow) && !matches!(flow, Flow::Break | Flow::Continue);
            [&iterations.init, &iterations.test, &iterations.body, &iterations.step]
                .iter()
                .any(|part| any(part, &outer, in_calls))
        }
        Instruction::Call(body) => any(body, in_calls, in_calls),
        Instruction::Leave(flow) => test(*flow),
    })
}

/// Whether a jump out of the block is in it.
pub(crate) fn leaves(list: &[Instruction]) -> bool {
    any(list, &|_| true, &|flow| flow == Flow::Exit)
}

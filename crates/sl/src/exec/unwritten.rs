// SPDX-License-Identifier: GPL-3.0-or-later
//! Tells reads of variables that were never written, for `testshade --debuguninit`.
//! Local variables start at 0; a bit of each of their cells says whether an operation has written it. Operations that read one
//! element look at its cells only, and a report counts as a write, so that it comes once.
//! Source: the rules, the message and the numbers of operations are those of OSL's `debug_uninit`. OSL's compiler compares the condition
//! of each loop with 0, and evaluates all outputs before the first operation and other parameters before their first use: these
//! operations, which plans lack, are counted.
//! Tests: `tests/meaning/unwritten.rs`; OSL's suite, `debug-uninit` (bench/record/osl-suite.md).

use std::collections::{HashMap, HashSet};
use std::ops::Range;
use std::ptr::from_ref;

use super::machine::{Instruction, LayerPlan, Machine, Plan, Step, Unwritten};
use super::slot::Slot;
use crate::ir::{SourcePosition, SymId, SymbolKind};
use crate::opcode::Opcode;
use crate::types::Base;

fn address<T>(of: &T) -> usize {
    from_ref(of).addr()
}

/// Numbers the operations of a layer.
struct Numbers<'a> {
    layer: &'a LayerPlan,
    next: usize,
    known: HashSet<SymId>,
    all: &'a mut HashMap<usize, usize>,
}

impl Numbers<'_> {
    /// A number for the operation at an address, behind the parameters that it is the first to use.
    fn add(&mut self, address: usize, symbols: &[SymId], is_certain: bool) {
        let is_param = |id: &&SymId| self.layer.shader.symbol(**id).kind == SymbolKind::Param;
        let fresh: Vec<SymId> =
            symbols.iter().filter(is_param).filter(|id| !self.known.contains(id)).copied().collect();
        self.next += usize::from(!fresh.is_empty());
        if is_certain {
            self.known.extend(fresh);
        }
        self.all.insert(address, self.next);
        self.next += 1;
    }

    fn block(&mut self, block: &[Instruction], is_certain: bool) {
        for instruction in block {
            match instruction {
                Instruction::Do(step) => self.add(address(step), &step.symbols, is_certain),
                Instruction::If { yes, no, .. } => {
                    self.add(address(instruction), &[], is_certain);
                    self.block(yes, false);
                    self.block(no, false);
                }
                Instruction::Loop(inner) => {
                    self.add(address(instruction), &[], is_certain);
                    self.block(&inner.init, false);
                    self.block(&inner.test, false);
                    // Its comparison with 0.
                    self.next += 1;
                    self.block(&inner.body, false);
                    self.block(&inner.step, false);
                }
                Instruction::Call(body) => {
                    self.add(address(instruction), &[], is_certain);
                    self.block(body, is_certain);
                }
                Instruction::Leave(_) => self.add(address(instruction), &[], is_certain),
            }
        }
    }
}

impl Unwritten {
    pub(super) fn new(plan: &Plan) -> Self {
        let mut numbers = HashMap::new();
        for layer in &plan.layers {
            let mut of_layer = Numbers { layer, next: 0, known: HashSet::new(), all: &mut numbers };
            layer.params.iter().for_each(|param| of_layer.block(&param.init, true));
            let has_outputs = layer.shader.symbols.iter().any(|s| s.kind == SymbolKind::OutputParam);
            of_layer.next += usize::from(has_outputs);
            of_layer.block(&layer.code, true);
        }
        Self { written: vec![false; plan.memory.len()], numbers }
    }

    /// For the next point.
    pub(super) fn clear(&mut self) {
        self.written.fill(false);
    }
}

/// The name of a variable as the text has it: `___3_name` is that of an inner block.
fn plain(name: &str) -> &str {
    let inner = name.strip_prefix("___").and_then(|rest| rest.split_once('_'));
    inner.map_or(name, |(_, name)| name)
}

impl Machine<'_> {
    /// From now on, reports operations that read local variables which were never written.
    pub fn check_reads_of_unwritten(&mut self) {
        self.unwritten = Some(Box::new(Unwritten::new(self.plan)));
    }

    /// Cells of argument `k` that a step touches, in its slot.
    fn touched(&self, step: &Step, k: usize) -> Range<usize> {
        let slot = &step.args[k];
        let index = |k: usize| step.args.get(k).map_or(0, |slot| self.int(slot).max(0) as usize);
        let (size, one) = (slot.size as usize, slot.one.max(1) as usize);
        let range = match (step.code, k) {
            (Opcode::Aref, 1) => one * index(2)..one * (index(2) + 1),
            (Opcode::Aassign, 0) => one * index(1)..one * (index(1) + 1),
            (Opcode::Compref, 1) => index(2)..index(2) + 1,
            (Opcode::Compassign, 0) => index(1)..index(1) + 1,
            (Opcode::Mxcompref, 1) => 4 * index(2) + index(3)..4 * index(2) + index(3) + 1,
            (Opcode::Mxcompassign, 0) => 4 * index(1) + index(2)..4 * index(1) + index(2) + 1,
            (Opcode::PointcloudGet, 2) => 0..index(3),
            (Opcode::Spline | Opcode::SplineInverse, 4) if step.args.len() == 5 => {
                0..one.saturating_mul(index(3))
            }
            // The rest of a longer array stays as it was.
            (Opcode::ArrayCopy, 0) => 0..step.args.get(1).map_or(0, |from| from.size as usize),
            _ => 0..size,
        };
        range.start.min(size)..range.end.min(size)
    }

    /// Reports arguments of a step that were never written, before it runs.
    pub(super) fn check_reads(&mut self, step: &Step) {
        for k in 0..step.args.len().min(64) {
            if step.reads & (1 << k) != 0 && !step.code.is_about_operands() {
                let cells = self.touched(step, k);
                let names = (address(step), step.code.name(), k);
                self.check_read(&step.args[k], step.symbols[k], cells, names, step.at);
            }
        }
    }

    /// The same for the condition of a choice.
    pub(super) fn check_condition(&mut self, choice: &Instruction, condition: &Slot) {
        let slots = &self.plan.layers[self.layer].slots;
        if let Some(symbol) = slots.iter().position(|slot| slot.at == condition.at && slot.size > 0) {
            let names = (address(choice), "if", 0);
            self.check_read(condition, symbol as SymId, 0..1, names, SourcePosition::default());
        }
    }

    fn check_read(
        &mut self,
        slot: &Slot,
        symbol: SymId,
        cells: Range<usize>,
        (address, operation, argument): (usize, &str, usize),
        at: SourcePosition,
    ) {
        let plan = self.plan;
        let layer = &plan.layers[self.layer];
        let symbol = layer.shader.symbol(symbol);
        if !matches!(symbol.kind, SymbolKind::Local | SymbolKind::Temp) || slot.ty.base == Base::Closure {
            return;
        }
        let Some(unwritten) = &mut self.unwritten else { return };
        let cells = slot.at as usize + cells.start..slot.at as usize + cells.end;
        let Some(written) = unwritten.written.get_mut(cells) else { return };
        if written.iter().all(|&written| written) {
            return;
        }
        written.fill(true);
        let number = unwritten.numbers.get(&address).copied().unwrap_or(0);
        let group = if plan.name.is_empty() { "unnamed_group_1" } else { &plan.name };
        let (shader, name) = (&layer.shader.name, plain(&symbol.name));
        let source_position = self.source_position(at);
        self.error(format!(
            "Detected possible use of uninitialized value in {} {name} at {source_position} (group {group}, layer {} {}, \
             shader {shader}, op {number} '{operation}', arg {argument})",
            symbol.ty, self.layer, layer.name
        ));
    }

    /// Notes the results of a step.
    pub(super) fn note_writes(&mut self, step: &Step) {
        for k in 0..step.args.len().min(64) {
            if step.writes & (1 << k) == 0 {
                continue;
            }
            let (cells, from) = (self.touched(step, k), step.args[k].at as usize);
            let cells = from + cells.start..from + cells.end;
            if let Some(written) = self.unwritten.as_mut().and_then(|u| u.written.get_mut(cells)) {
                written.fill(true);
            }
        }
    }
}

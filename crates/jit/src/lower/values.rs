// SPDX-License-Identifier: GPL-3.0-or-later
//! Values of symbols while a region is recorded: the current contents of cells, and the stores at the
//! region's end.
//! Tests: `tests/agreement.rs`, `tests/chance.rs`.

use gnurt_sl::exec::{self, Plan, Slot, Step};
use gnurt_sl_lib::UInts as _;
use gnurt_sl_lib::noise::NoiseKind;

use super::analyse::Analysis;
use super::native::Known;
use crate::op::{Binary, Id, Op, Region};
use crate::program::Test;
use crate::term::{Bits, QuickMap, Term, Which, binary, constant, count, op_of, push, take};

#[derive(Clone, Copy)]
struct Cell {
    value: Id,
    changed: bool,
    /// Whether lanes that do not run keep their values.
    keep: bool,
    /// The first cell of its variable.
    owner: u32,
}

/// The state of the recorded region.
pub(crate) struct Values<'p> {
    pub(crate) plan: &'p Plan,
    pub(crate) analysis: Analysis,
    pub(crate) known: &'p Known<'p>,
    /// The block that is lowered.
    pub(crate) block: u32,
    /// The innermost one that lanes enter by a branch: inner ones are done by masks within a region. None in
    /// loops, whose lanes leave at different times.
    pub(crate) base: u32,
    /// Lanes of the inner blocks, if there are some.
    conditions: Option<Which>,
    /// Lanes that have left the iteration of a loop, for good or up to its end.
    pub(crate) broken: Option<Which>,
    waiting: Option<Which>,
    cells: QuickMap<u32, Cell>,
    /// Uses of variables in this region.
    seen: QuickMap<u32, u32>,
    /// Ints that are 0 or 1, and the masks that they were.
    masks: QuickMap<Id, Id>,
    tests: Vec<(u32, Id)>,
}

/// Regions are ended when they get longer: registers are given out in time that grows with it.
const LONGEST: usize = 6000;

impl<'p> Values<'p> {
    pub(crate) fn new(plan: &'p Plan, analysis: Analysis, known: &'p Known<'p>) -> Self {
        take();
        Self {
            plan,
            analysis,
            known,
            block: 0,
            base: 0,
            conditions: None,
            broken: None,
            waiting: None,
            cells: QuickMap::default(),
            seen: QuickMap::default(),
            masks: QuickMap::default(),
            tests: Vec::new(),
        }
    }

    /// Notes a use of a variable, as the analysis did.
    pub(crate) fn touch(&mut self, at: u32) {
        *self.seen.entry(at).or_default() += 1;
    }

    pub(crate) fn is_long(&self) -> bool {
        count() > LONGEST
    }

    /// The contents of a cell.
    pub(crate) fn bits(&mut self, cell: u32) -> Id {
        if self.known.cells[cell as usize] {
            return constant(self.plan.memory[cell as usize]);
        }
        if let Some(found) = self.cells.get(&cell) {
            return found.value;
        }
        let value = push(Op::Cell(cell));
        self.cells.insert(cell, Cell { value, changed: false, keep: false, owner: cell });
        value
    }

    /// Puts a word into a slot.
    pub(crate) fn set_bits(&mut self, slot: &Slot, i: u32, value: Id) {
        let cell = slot.at + i;
        let variable = self.analysis.variables.get(&slot.at);
        let is_of = |block: u32| variable.is_some_and(|v| v.clean && v.block == block);
        let (own, of_base) = (is_of(self.block), is_of(self.base));
        let value = match self.guard() {
            Some(guard) if !own => push(Op::Choose(guard.0, value, self.bits(cell))),
            _ => value,
        };
        let keep = self.analysis.varying[cell as usize] && !(own || of_base);
        self.cells.insert(cell, Cell { value, changed: true, keep, owner: slot.at });
    }

    /// Lanes that run in inner blocks of a region; none if all do.
    fn guard(&self) -> Option<Which> {
        let left = match (self.broken, self.waiting) {
            (Some(a), Some(b)) => Some(a | b),
            (a, b) => a.or(b),
        };
        match (self.conditions, left) {
            (Some(a), Some(b)) => Some(a & !b),
            (a, b) => a.or(b.map(|b| !b)),
        }
    }

    /// Notes the lanes whose index is out of range.
    pub(crate) fn out_of_range(&mut self, index: &Slot, count: usize, slot: u32) {
        let value = self.bits(index.at);
        let mask = !Bits(value).below(count as u32);
        self.tests.push((slot, mask.0));
    }

    /// The lanes that an int sends on, as a value.
    pub(crate) fn mask(&mut self, condition: &Slot) -> Which {
        self.touch(condition.at);
        let value = self.bits(condition.at);
        exec::Values::truth(self, Bits(value))
    }

    /// Enters an inner block for some of the lanes; returns what leaving it takes.
    pub(crate) fn open(&mut self, mask: Which) -> Option<Which> {
        let outer = self.conditions;
        self.conditions = Some(outer.map_or(mask, |outer| outer & mask));
        outer
    }

    /// Leaves it.
    pub(crate) fn close(&mut self, outer: Option<Which>) {
        self.conditions = outer;
    }

    /// The lanes that run now leave the iteration, for good or up to its end.
    pub(crate) fn leave(&mut self, for_good: bool) {
        let Some(guard) = self.guard() else { return };
        let list = if for_good { &mut self.broken } else { &mut self.waiting };
        *list = Some(list.map_or(guard, |list| list | guard));
    }

    /// The body of an iteration ends.
    pub(crate) fn end_body(&mut self) {
        self.waiting = None;
    }

    /// A region's test ends it: the lanes that an int sends on, and that have not left.
    pub(crate) fn end_iteration(&mut self, condition: &Slot, live: u32) {
        let mut mask = self.mask(condition);
        if let Some(broken) = self.broken.take() {
            mask = mask & !broken;
        }
        self.tests.push((live, mask.0));
    }

    /// Ends the region; none if it does nothing.
    pub(crate) fn end(&mut self) -> Option<Region> {
        let mut stores: Vec<(u32, Id)> = Vec::new();
        let mut changed: Vec<(u32, Cell)> = self.cells.drain().filter(|(_, c)| c.changed).collect();
        changed.sort_unstable_by_key(|(cell, _)| *cell);
        for (cell, state) in changed {
            let nowhere_else = self
                .analysis
                .variables
                .get(&state.owner)
                .is_some_and(|v| v.clean && self.seen.get(&state.owner) == Some(&v.uses));
            if nowhere_else {
                continue;
            }
            let value = if state.keep {
                let old = push(Op::Cell(cell));
                push(Op::Choose(push(Op::Exec), state.value, old))
            } else {
                state.value
            };
            if op_of(value) != Op::Cell(cell) {
                stores.push((cell, value));
            }
        }
        self.seen.clear();
        self.masks.clear();
        let tests = std::mem::take(&mut self.tests);
        let recorded = take();
        (!stores.is_empty() || !tests.is_empty()).then(|| Region::of(&recorded, stores, tests))
    }

    /// Which lanes an int in a slot sends on; `slot` is taken where they differ.
    pub(crate) fn test(&mut self, condition: &Slot, mut slot: impl FnMut() -> u32) -> Test {
        if !self.analysis.varying[condition.at as usize] {
            // The branch reads the cell, so that this use is not one of the region.
            return Test::Cell(condition.at);
        }
        let mask = self.mask(condition);
        let slot = slot();
        self.tests.push((slot, mask.0));
        Test::Lanes(slot)
    }
}

impl exec::Values for Values<'_> {
    type Real = Term;
    type Word = Bits;
    type Mask = Which;
    type Plain = Term;

    fn constant(&mut self, bits: u32) -> Bits {
        Bits(constant(bits))
    }

    fn cell(&mut self, slot: &Slot, i: u32) -> Bits {
        Bits(self.bits(slot.at + i))
    }

    fn set_cell(&mut self, slot: &Slot, i: u32, word: Bits) {
        self.set_bits(slot, i, word.0);
    }

    fn truth(&mut self, word: Bits) -> Which {
        match self.masks.get(&word.0) {
            Some(&mask) => Which(mask),
            None => !Which(binary(Binary::IntEqual, word.0, constant(0))),
        }
    }

    fn int_of(&mut self, mask: Which) -> Bits {
        let bits = Bits(mask.0) & 1;
        self.masks.insert(bits.0, mask.0);
        bits
    }

    fn index(&mut self, step: &Step, operand: usize, _: usize, count: usize) -> Option<usize> {
        self.known.index(&step.args[operand], count)
    }

    fn noise_kind(&mut self, step: &Step) -> NoiseKind {
        self.known.noise(&step.args[1]).unwrap_or(NoiseKind::Null)
    }

    /// The interpreter does it.
    fn gabor(&mut self, _: &Step) {}
}

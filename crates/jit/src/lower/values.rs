// SPDX-License-Identifier: GPL-3.0-or-later
//! Values of symbols while a region is recorded: the current contents of cells, and the stores at the
//! region's end. Conversions are those of `gnurt_sl::exec`'s values.
//! Tests: `tests/agreement.rs`, `tests/chance.rs`.

use gnurt_sl::exec::{Plan, Slot};
use gnurt_sl::types::Base;
use gnurt_sl_lib::{Dual, Number, Real};

use super::analyse::Analysis;
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
    /// By cell, whether it never changes.
    pub(crate) constant: Vec<bool>,
    /// The block that is lowered.
    pub(crate) block: u32,
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
    pub(crate) fn new(plan: &'p Plan, analysis: Analysis, constant: Vec<bool>) -> Self {
        take();
        Self {
            plan,
            analysis,
            constant,
            block: 0,
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
        if self.constant[cell as usize] {
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
        let own = variable.is_some_and(|v| v.clean && v.block == self.block);
        let keep = self.analysis.varying[cell as usize] && !own;
        self.cells.insert(cell, Cell { value, changed: true, keep, owner: slot.at });
    }

    /// Ends the region; none if it does nothing.
    pub(crate) fn end(&mut self) -> Option<Region> {
        let mut stores: Vec<(u32, Id)> = Vec::new();
        let mut changed: Vec<(u32, Cell)> = self.cells.drain().filter(|(_, c)| c.changed).collect();
        changed.sort_unstable_by_key(|(cell, _)| *cell);
        for (cell, state) in changed {
            let nowhere_else = self.analysis.variables.get(&state.owner).is_some_and(|v| {
                v.clean && v.block == self.block && self.seen.get(&state.owner) == Some(&v.uses)
            });
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
        let ops = take();
        (!stores.is_empty() || !tests.is_empty()).then_some(Region { ops, stores, tests })
    }

    /// Which lanes an int in a slot sends on; `slot` is taken where they differ.
    pub(crate) fn test(&mut self, condition: &Slot, mut slot: impl FnMut() -> u32) -> Test {
        if !self.analysis.varying[condition.at as usize] {
            // The branch reads the cell, so that this use is not one of the region.
            return Test::Cell(condition.at);
        }
        self.touch(condition.at);
        let value = self.bits(condition.at);
        let mask = self.truth(value);
        let slot = slot();
        self.tests.push((slot, mask.0));
        Test::Lanes(slot)
    }

    /// Whether words are not 0.
    pub(crate) fn truth(&mut self, bits: Id) -> Which {
        match self.masks.get(&bits) {
            Some(&mask) => Which(mask),
            None => !Which(binary(Binary::IntEqual, bits, constant(0))),
        }
    }

    /// 0 or 1.
    pub(crate) fn int_of(&mut self, mask: Which) -> Bits {
        let bits = Bits(mask.0) & 1;
        self.masks.insert(bits.0, mask.0);
        bits
    }

    /// Number `i` of a slot. Single numbers serve for all components.
    pub(crate) fn float(&mut self, slot: &Slot, i: usize) -> Term {
        let i = if slot.size == 1 { 0 } else { i as u32 };
        let bits = self.bits(slot.at + i);
        if slot.ty.base == Base::Int { Term::from_int(Bits(bits)) } else { Term(bits) }
    }

    /// An int.
    pub(crate) fn int(&mut self, slot: &Slot) -> Bits {
        let bits = self.bits(slot.at);
        if slot.ty.base == Base::Int { Bits(bits) } else { Term(bits).to_int() }
    }

    pub(crate) fn set_int(&mut self, slot: &Slot, value: Bits) {
        if slot.ty.base == Base::Int {
            self.set_bits(slot, 0, value.0);
        } else {
            Dual::put(self, slot, 0, Dual::lift(Term::from_int(value)));
        }
    }

    /// A number and its derivatives.
    pub(crate) fn dual(&mut self, slot: &Slot, i: usize) -> Dual<Term> {
        let value = self.float(slot, i);
        if !slot.derivs {
            return Dual::lift(value);
        }
        let i = if slot.size == 1 { 0 } else { i as u32 };
        let dx = Term(self.bits(slot.at + slot.size + i));
        let dy = Term(self.bits(slot.at + 2 * slot.size + i));
        Dual::new(value, dx, dy)
    }
}

/// Numbers that symbols hold, with derivatives or without.
pub(crate) trait Held: Number<Real = Term, Mask = Which> {
    fn get(values: &mut Values<'_>, slot: &Slot, i: usize) -> Self;
    fn put(values: &mut Values<'_>, slot: &Slot, i: usize, value: Self);
}

impl Held for Term {
    fn get(values: &mut Values<'_>, slot: &Slot, i: usize) -> Self {
        values.float(slot, i)
    }

    /// Only where the slot has no derivatives.
    fn put(values: &mut Values<'_>, slot: &Slot, i: usize, value: Self) {
        let bits = if slot.ty.base == Base::Int { value.to_int().0 } else { value.0 };
        values.set_bits(slot, i as u32, bits);
    }
}

impl Held for Dual<Term> {
    fn get(values: &mut Values<'_>, slot: &Slot, i: usize) -> Self {
        values.dual(slot, i)
    }

    fn put(values: &mut Values<'_>, slot: &Slot, i: usize, value: Self) {
        Term::put(values, slot, i, value.value);
        if slot.derivs && slot.ty.base != Base::Int {
            values.set_bits(slot, slot.size + i as u32, value.dx.0);
            values.set_bits(slot, 2 * slot.size + i as u32, value.dy.0);
        }
    }
}

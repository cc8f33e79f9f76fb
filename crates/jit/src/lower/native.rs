// SPDX-License-Identifier: GPL-3.0-or-later
//! Which operations become code; the others are done by the interpreter, lane by lane.
//! Tests: `tests/agreement.rs`, `tests/chance.rs`.

use gnurt_sl::exec::{Plan, Slot, Step, chooses, is_computed, writes_all};
use gnurt_sl::opcode::Opcode;
use gnurt_sl::types::Type;
use gnurt_sl_lib::noise::NoiseKind;

/// Numbers of a result or operand of an operation in code.
const MOST: u32 = 4096;

/// Symbols that never change, for the analysis and for operations whose meaning depends on them.
pub(crate) struct Known<'p> {
    pub(crate) plan: &'p Plan,
    /// By cell.
    pub(crate) cells: Vec<bool>,
}

impl Known<'_> {
    fn word(&self, slot: &Slot, ty: Type) -> Option<u32> {
        (slot.ty == ty && self.cells[slot.at as usize]).then(|| self.plan.memory[slot.at as usize])
    }

    /// An index that is known and in range.
    pub(crate) fn index(&self, slot: &Slot, count: usize) -> Option<usize> {
        let index = self.word(slot, Type::INT)? as i32;
        usize::try_from(index).ok().filter(|&i| i < count)
    }

    /// The kind of a noise that an operand names.
    pub(crate) fn noise(&self, slot: &Slot) -> Option<NoiseKind> {
        NoiseKind::named(self.plan.strings.text(self.word(slot, Type::STRING)?))
    }

    /// Whether an operation becomes code.
    pub(crate) fn is_native(&self, step: &Step) -> bool {
        let args = &*step.args;
        let is_index = |operand: usize, count: usize| self.index(&args[operand], count).is_some();
        let is_value = args.first().is_none_or(|out| out.ty != Type::CLOSURE);
        is_computed(step.code, args)
            && args.iter().all(|slot| slot.size <= MOST)
            && (is_value || matches!(step.code, Opcode::Assign | Opcode::Aref))
            && match step.code {
                Opcode::Aref => is_index(2, args[1].ty.elements()),
                Opcode::Aassign => is_index(1, args[0].ty.elements()),
                Opcode::Compref => is_index(2, 3),
                Opcode::Compassign => is_index(1, 3),
                Opcode::Mxcompref => is_index(2, 4) && is_index(3, 4),
                Opcode::Mxcompassign => is_index(1, 4) && is_index(2, 4),
                Opcode::Noise | Opcode::Pnoise if args[1].ty == Type::STRING => {
                    self.noise(&args[1]).is_some_and(|kind| kind != NoiseKind::Gabor)
                }
                _ => true,
            }
    }
}

impl Known<'_> {
    /// The index of an operation that becomes code for the lanes where that is in range, and how many parts it
    /// chooses among.
    pub(crate) fn checked<'s>(&self, step: &'s Step) -> Option<(&'s Slot, usize)> {
        let is_open = !self.is_native(step) && is_computed(step.code, &step.args);
        chooses(step).filter(|_| is_open && is_honest(step))
    }
}

/// About as many operations of lanes as an operation takes.
pub(crate) fn weight(step: &Step) -> u32 {
    use Opcode as O;
    let size = step.args.first().map_or(0, |out| out.size);
    let derivs = if step.args.first().is_some_and(|out| out.derivs) { 3 } else { 1 };
    let each = match step.code {
        // Whole numbers are divided lane by lane.
        O::Div | O::Mod | O::Fmod if step.args.iter().all(|slot| slot.ty == Type::INT) => 100,
        O::Div => 6,
        O::Sqrt | O::InverseSqrt | O::Smoothstep | O::Length | O::Normalize | O::Distance => 10,
        O::Mix | O::Clamp | O::Select | O::Dot | O::Cross | O::Abs | O::Fabs | O::Sign => 4,
        code if code.is_noise() => 600,
        O::Transform | O::Matrix | O::Transpose => 10,
        code if code.arity() == 0 || code.is_for_ints() => 2,
        O::Step | O::Floor | O::Ceil | O::Trunc => 2,
        _ => 50,
    };
    each * size.max(1) * derivs
}

/// How an operation uses a symbol.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Touch {
    Read,
    /// All of it.
    Write,
    /// Some of it, or not always.
    Change,
}

/// The arguments that an operation uses, by number, reads first.
pub(crate) fn touches(step: &Step, native: bool, mut visit: impl FnMut(usize, Touch)) {
    let bit = |bits: u64, i: usize| i >= 64 || bits & 1 << i != 0;
    for i in 0..step.args.len() {
        if bit(step.reads, i) {
            visit(i, Touch::Read);
        }
    }
    let all = native && writes_all(step);
    for i in 0..step.args.len().min(64) {
        if bit(step.writes, i) {
            visit(i, if all && !bit(step.reads, i) { Touch::Write } else { Touch::Change });
        }
    }
}

/// Whether the declared writes of an operation are its real ones: files may hold anything.
pub(crate) fn is_honest(step: &Step) -> bool {
    let expected = if step.args.is_empty() { 0 } else { step.code.results() };
    step.writes & expected == expected
}

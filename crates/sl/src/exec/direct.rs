// SPDX-License-Identifier: GPL-3.0-or-later
//! The interpreter's functions of operations on numbers, chosen once, when a group is laid out: what
//! [`compute`](super::compute::compute) asks of an operation's operands is asked then, and not at each point.
//! Invariant: each gives the bits of `compute`. Tests: `tests/meaning.rs`, crates/jit/tests/chance.rs.

use super::compute::{assign, each, equal, ints, is_of_ints, is_of_matrices, noise_of, ordered, others};
use super::machine::{Action, D, Machine, Step};
use super::scalar::{on_cells, on_numbers};
use super::slot::Slot;
use crate::opcode::{Function, Opcode, WithFunction};
use crate::types::{Base, Type};

/// The function of an operation that is computed.
pub(super) fn action(code: Opcode, args: &[Slot]) -> Action {
    let Some((out, rest)) = args.split_first() else { return on_numbers };
    if is_of_matrices(code, args) || rest.len() < code.arity() {
        return on_numbers;
    }
    if is_of_ints(code, args) {
        return |m, step| on_cells(m, step, |v| ints(v, step.code, &step.args[0], &step.args[1..]));
    }
    if let Some(function) = code.with_function(Operands(args)) {
        return function;
    }
    let is_single = |slot: &Slot| slot.size == 1 && is_number(slot);
    match code {
        Opcode::Lt | Opcode::Gt | Opcode::Le | Opcode::Ge => match rest {
            [a, b] if out.ty == Type::INT && a.ty == Type::INT && b.ty == Type::INT => order_ints,
            [a, b] if out.ty == Type::INT && is_single(a) && is_single(b) => order_numbers,
            _ => |m, step| on_cells(m, step, |v| ordered(v, step.code, &step.args[0], &step.args[1..])),
        },
        Opcode::Eq | Opcode::Neq => {
            |m, step| on_cells(m, step, |v| equal(v, step.code, &step.args[0], &step.args[1..]))
        }
        Opcode::Assign | Opcode::Int | Opcode::Float => match rest.first() {
            Some(from) if is_copied(out, from) => copy,
            Some(_) if out.derivs => {
                |m, step| on_cells(m, step, |v| assign::<_, D>(v, &step.args[0], &step.args[1]))
            }
            _ => |m, step| on_cells(m, step, |v| assign::<_, f32>(v, &step.args[0], &step.args[1])),
        },
        code if code.is_noise() && out.derivs => |m, step| on_cells(m, step, |v| noise_of::<_, D>(v, step)),
        code if code.is_noise() => |m, step| on_cells(m, step, |v| noise_of::<_, f32>(v, step)),
        Opcode::Sincos => |m, step| on_cells(m, step, |v| others::<_, D>(v, step)),
        _ if out.derivs => |m, step| on_cells(m, step, |v| others::<_, D>(v, step)),
        _ => |m, step| on_cells(m, step, |v| others::<_, f32>(v, step)),
    }
}

/// Floats, or numbers that become some.
fn is_number(slot: &Slot) -> bool {
    slot.ty.base == Base::Int || slot.ty.base.is_float_based()
}

/// Whether an assignment copies the words of its operand, with changes if it has them.
fn is_copied(out: &Slot, from: &Slot) -> bool {
    let is_plain = |slot: &Slot| slot.ty.base.is_float_based() && slot.ty.base != Base::Matrix;
    let is_alike = is_plain(out) && is_plain(from)
        || out.ty.base == from.ty.base && matches!(out.ty.base, Base::Int | Base::String | Base::Closure);
    is_alike
        && out.size == from.size
        && (from.derivs || !out.derivs)
        && !out.ty.is_array()
        && !from.ty.is_array()
}

fn copy(m: &mut Machine<'_>, step: &Step) {
    let [out, from, ..] = &*step.args else { return };
    let (to, start, count) = (out.at as usize, from.at as usize, out.cells());
    if count == 1 {
        m.memory[to] = m.memory[start];
    } else {
        m.memory.copy_within(start..start + count, to);
    }
}

/// A number of an operand.
#[inline(always)]
fn number(cells: &[u32], slot: &Slot, i: usize) -> f32 {
    let word = cells[slot.at as usize + i];
    if slot.ty.base == Base::Int { word as i32 as f32 } else { f32::from_bits(word) }
}

fn order_ints(m: &mut Machine<'_>, step: &Step) {
    let [out, a, b, ..] = &*step.args else { return };
    let [a, b] = [a, b].map(|slot| m.memory[slot.at as usize] as i32);
    m.memory[out.at as usize] = is_ordered(step.code, a, b).into();
}

fn order_numbers(m: &mut Machine<'_>, step: &Step) {
    let [out, a, b, ..] = &*step.args else { return };
    let [a, b] = [a, b].map(|slot| number(&m.memory, slot, 0));
    m.memory[out.at as usize] = is_ordered(step.code, a, b).into();
}

#[inline(always)]
fn is_ordered<T: PartialOrd>(code: Opcode, a: T, b: T) -> bool {
    match code {
        Opcode::Lt => a < b,
        Opcode::Gt => a > b,
        Opcode::Le => a <= b,
        _ => a >= b,
    }
}

/// The operands of a function of numbers, the result first.
struct Operands<'s>(&'s [Slot]);

impl WithFunction for Operands<'_> {
    type Out = Action;

    fn with<F: Function>(self) -> Action {
        let Some((out, rest)) = self.0.split_first() else { return on_numbers };
        let is_plain = |slot: &Slot| slot.ty.base.is_float_based();
        let has_all = |slot: &Slot| is_number(slot) && (slot.size == 1 || slot.size >= out.size);
        let is_simple = is_plain(out) && rest[..F::COUNT].iter().all(has_all);
        match out.size {
            _ if out.derivs || !is_simple => {
                |m, step| on_cells(m, step, |v| each(v, &step.args[0], &step.args[1..=F::COUNT], F::of::<D>))
            }
            1 => of_one::<F>,
            _ => of_some::<F>,
        }
    }
}

/// A function of single numbers without changes.
fn of_one<F: Function>(m: &mut Machine<'_>, step: &Step) {
    let mut x = [0.0; 3];
    for (x, slot) in x[..F::COUNT].iter_mut().zip(&step.args[1..]) {
        *x = number(&m.memory, slot, 0);
    }
    m.memory[step.args[0].at as usize] = F::of(x).to_bits();
}

/// A function of each component without changes.
fn of_some<F: Function>(m: &mut Machine<'_>, step: &Step) {
    let out = &step.args[0];
    for i in 0..out.size as usize {
        let mut x = [0.0; 3];
        for (x, slot) in x[..F::COUNT].iter_mut().zip(&step.args[1..]) {
            *x = number(&m.memory, slot, if slot.size == 1 { 0 } else { i });
        }
        m.memory[out.at as usize + i] = F::of(x).to_bits();
    }
}

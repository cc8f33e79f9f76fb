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
use gnurt_sl_lib::Number;
use gnurt_sl_lib::math::vectors;

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
    if let Some(function) = is_simple(args).then(|| vector(code, out, rest)).flatten() {
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
            Some(from) if !out.ty.is_array() && !from.ty.is_array() && out.size <= 3 && is_simple(args) => {
                simple::<Same>(out)
            }
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

/// A number with changes or without them, in the cells.
trait Stored: Number<Real = f32, Mask = bool> {
    /// Number `i` of an operand. Single numbers serve for all components.
    fn load(cells: &[u32], slot: &Slot, i: usize) -> Self;
    /// Writes number `i` of floats, which have changes if this has.
    fn store(self, cells: &mut [u32], slot: &Slot, i: usize);
}

impl Stored for f32 {
    #[inline(always)]
    fn load(cells: &[u32], slot: &Slot, i: usize) -> Self {
        number(cells, slot, if slot.size == 1 { 0 } else { i })
    }

    #[inline(always)]
    fn store(self, cells: &mut [u32], slot: &Slot, i: usize) {
        cells[slot.at as usize + i] = self.to_bits();
    }
}

impl Stored for D {
    #[inline(always)]
    fn load(cells: &[u32], slot: &Slot, i: usize) -> Self {
        let i = if slot.size == 1 { 0 } else { i };
        let value = number(cells, slot, i);
        if !slot.derivs {
            return value.into();
        }
        let (at, size) = (slot.at as usize + i, slot.size as usize);
        Self::new(value, f32::from_bits(cells[at + size]), f32::from_bits(cells[at + 2 * size]))
    }

    #[inline(always)]
    fn store(self, cells: &mut [u32], slot: &Slot, i: usize) {
        let (at, size) = (slot.at as usize + i, slot.size as usize);
        cells[at] = self.value.to_bits();
        cells[at + size] = self.dx.to_bits();
        cells[at + 2 * size] = self.dy.to_bits();
    }
}

fn triple<N: Stored>(m: &Machine<'_>, slot: &Slot) -> [N; 3] {
    [N::load(&m.memory, slot, 0), N::load(&m.memory, slot, 1), N::load(&m.memory, slot, 2)]
}

fn set_triple<N: Stored>(m: &mut Machine<'_>, slot: &Slot, [x, y, z]: [N; 3]) {
    x.store(&mut m.memory, slot, 0);
    y.store(&mut m.memory, slot, 1);
    z.store(&mut m.memory, slot, 2);
}

/// The function of an operation on vectors, none if it is another one. Operands [are simple](is_simple).
fn vector(code: Opcode, out: &Slot, rest: &[Slot]) -> Option<Action> {
    let has_three = |slot: &Slot| matches!(slot.size, 1 | 3..);
    Some(match (code, rest) {
        (Opcode::Dot, [a, b]) if out.size == 1 && has_three(a) && has_three(b) => {
            either(out, dot::<f32>, dot::<D>)
        }
        (Opcode::Length, [a]) if out.size == 1 && has_three(a) => either(out, length::<f32>, length::<D>),
        (Opcode::Normalize, [_]) if out.size == 3 => either(out, normalize::<f32>, normalize::<D>),
        (Opcode::Cross, [_, _]) if out.size == 3 => either(out, cross::<f32>, cross::<D>),
        (Opcode::Color | Opcode::Point | Opcode::Vector | Opcode::Normal, [_] | [_, _, _])
            if out.size == 3 =>
        {
            either(out, join::<f32>, join::<D>)
        }
        (Opcode::Compref, [a, index]) if out.size == 1 && has_three(a) && index.ty == Type::INT => {
            either(out, part::<f32>, part::<D>)
        }
        _ => return None,
    })
}

fn either(out: &Slot, plain: Action, with_changes: Action) -> Action {
    if out.derivs { with_changes } else { plain }
}

fn dot<N: Stored>(m: &mut Machine<'_>, step: &Step) {
    let [out, a, b, ..] = &*step.args else { return };
    vectors::dot(triple::<N>(m, a), triple(m, b)).store(&mut m.memory, out, 0);
}

fn length<N: Stored>(m: &mut Machine<'_>, step: &Step) {
    let [out, a, ..] = &*step.args else { return };
    vectors::length(triple::<N>(m, a)).store(&mut m.memory, out, 0);
}

fn normalize<N: Stored>(m: &mut Machine<'_>, step: &Step) {
    let [out, a, ..] = &*step.args else { return };
    let value = vectors::normalize(triple::<N>(m, a));
    set_triple(m, out, value);
}

fn cross<N: Stored>(m: &mut Machine<'_>, step: &Step) {
    let [out, a, b, ..] = &*step.args else { return };
    let value = vectors::cross(triple::<N>(m, a), triple(m, b));
    set_triple(m, out, value);
}

/// Three numbers, or one for all.
fn join<N: Stored>(m: &mut Machine<'_>, step: &Step) {
    let [out, x, rest @ ..] = &*step.args else { return };
    let [y, z] = if let [y, z, ..] = rest { [y, z] } else { [x, x] };
    let value = [x, y, z].map(|slot| N::load(&m.memory, slot, 0));
    set_triple(m, out, value);
}

/// A component.
fn part<N: Stored>(m: &mut Machine<'_>, step: &Step) {
    let [out, a, index, ..] = &*step.args else { return };
    match m.memory[index.at as usize] as usize {
        i @ 0..3 => N::load(&m.memory, a, i).store(&mut m.memory, out, 0),
        // Reports it.
        _ => on_numbers(m, step),
    }
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
        let Some(args) = self.0.get(..=F::COUNT) else { return on_numbers };
        if is_simple(args) {
            return simple::<F>(&args[0]);
        }
        |m, step| on_cells(m, step, |v| each(v, &step.args[0], &step.args[1..=F::COUNT], F::of::<D>))
    }
}

/// An assignment, as a function.
struct Same;

impl Function for Same {
    const COUNT: usize = 1;

    #[inline(always)]
    fn of<N: Number>([a, ..]: [N; 3]) -> N {
        a
    }
}

/// Whether a result has floats, and operands have a number for each or one for all.
fn is_simple(args: &[Slot]) -> bool {
    let Some((out, rest)) = args.split_first() else { return false };
    let has_all = |slot: &Slot| is_number(slot) && (slot.size == 1 || slot.size >= out.size);
    out.ty.base.is_float_based() && rest.iter().all(has_all)
}

/// A function of simple operands.
fn simple<F: Function>(out: &Slot) -> Action {
    match out.size {
        _ if out.derivs => of_some::<F, D>,
        1 => of_one::<F>,
        _ => of_some::<F, f32>,
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

/// A function of each component.
fn of_some<F: Function, N: Stored>(m: &mut Machine<'_>, step: &Step) {
    let out = &step.args[0];
    for i in 0..out.size as usize {
        let mut x = [N::lift(0.0); 3];
        for (x, slot) in x[..F::COUNT].iter_mut().zip(&step.args[1..]) {
            *x = N::load(&m.memory, slot, i);
        }
        F::of(x).store(&mut m.memory, out, i);
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Operations on numbers, for any [`Values`]: the interpreter's cells, or terms that machine code is made of.
//! Nothing traps: a division by zero is zero. Operands may have any types: numbers beyond the end of one are
//! 0, and nothing is written beyond it.
//! Conversions are OSL's. Tests: crates/jit/tests/chance.rs.

use super::machine::{Copy, Step};
use super::slot::Slot;
use crate::opcode::Opcode;
use crate::types::{Base, Type};
use gnurt_sl_lib::math::{self, vectors};
use gnurt_sl_lib::noise::{self, NoiseKind};
use gnurt_sl_lib::{Dual, Mask, Number, Real, UInts, matrix as mx};

/// The contents of symbols.
pub trait Values {
    /// A float.
    type Real: Real<UInts = Self::Word, Mask = Self::Mask>;
    /// A cell.
    type Word: UInts<Mask = Self::Mask>;
    /// The result of a comparison.
    type Mask: Mask;
    /// Numbers of operations whose results have no derivatives.
    type Plain: Number<Real = Self::Real, Mask = Self::Mask>;

    /// A word that is known.
    fn constant(&mut self, bits: u32) -> Self::Word;
    /// Cell `i` of a slot, which has so many.
    fn cell(&mut self, slot: &Slot, i: u32) -> Self::Word;
    /// Writes it.
    fn set_cell(&mut self, slot: &Slot, i: u32, word: Self::Word);
    /// Whether a word is not 0.
    fn truth(&mut self, word: Self::Word) -> Self::Mask;
    /// 0 or 1.
    fn int_of(&mut self, mask: Self::Mask) -> Self::Word;
    /// The index in an operand, moved into range, with a report if it was not; none if it is not known.
    fn index(&mut self, step: &Step, operand: usize, of: usize, count: usize) -> Option<usize>;
    /// The kind of a noise that an operand names.
    fn noise_kind(&mut self, step: &Step) -> NoiseKind;
    /// Gabor noise.
    fn gabor(&mut self, step: &Step);
}

fn is_numeric(slot: &Slot) -> bool {
    slot.ty.base == Base::Int || slot.ty.base.is_float_based()
}

/// The operands of a noise that are coordinates, and periods.
fn coordinates(code: Opcode, args: &[Slot]) -> Option<(&[Slot], bool)> {
    let is_text = |slot: &Slot| slot.ty == Type::STRING;
    let rest = args.get(1 + usize::from(args.get(1).is_some_and(is_text))..)?;
    let numbers = &rest[..rest.iter().position(is_text).unwrap_or(rest.len())];
    let periodic = matches!(code, Opcode::Pnoise | Opcode::Psnoise);
    let count: usize = numbers.iter().map(|slot| slot.size as usize).sum();
    let fits = count > 0 && count <= if periodic { 8 } else { 4 } && !(periodic && count % 2 == 1);
    fits.then_some((numbers, periodic))
}

/// Whether [`compute`] does an operation of these operands, none of which is missing.
#[must_use]
pub fn is_computed(code: Opcode, args: &[Slot]) -> bool {
    let Some((out, rest)) = args.split_first() else { return code.is_nothing() };
    let all_numeric = || rest.iter().all(is_numeric);
    code.is_computed()
        && (out.size > 0 || code.is_nothing())
        && match code {
            Opcode::Color | Opcode::Point | Opcode::Vector | Opcode::Normal | Opcode::Matrix => all_numeric(),
            Opcode::Transform | Opcode::TransformV => rest.len() == 2 && rest[0].ty == Type::MATRIX,
            Opcode::Hash => all_numeric(),
            // The quotient of a matrix takes the inverse, of doubles.
            Opcode::Div => rest.get(1).is_none_or(|by| by.ty != Type::MATRIX),
            code if code.is_noise() => coordinates(code, args).is_some(),
            // Whole numbers only.
            _ if code.arity() == 0 && code.is_for_ints() => args.iter().all(|a| a.ty == Type::INT),
            _ => true,
        }
}

/// Whether an operation that is computed writes all of its results.
#[must_use]
pub fn writes_all(step: &Step) -> bool {
    let (Some(out), from) = (step.args.first(), step.args.get(1)) else { return true };
    let is_array = |slot: &Slot| slot.ty.is_array();
    match step.code {
        Opcode::Aassign | Opcode::Compassign | Opcode::Mxcompassign => false,
        Opcode::Assign | Opcode::Int | Opcode::Float | Opcode::ArrayCopy
            if is_array(out) || from.is_some_and(is_array) || step.code == Opcode::ArrayCopy =>
        {
            // A shorter array leaves the elements behind its end.
            from.is_some_and(|from| from.size >= out.size)
        }
        Opcode::Aref => from.is_some_and(|array| array.one >= out.size),
        Opcode::Sincos => matches!(&*step.args, [_, sine, cosine, ..] if cosine.size == sine.size),
        Opcode::Dx | Opcode::Dy | Opcode::Dz | Opcode::Filterwidth => true,
        Opcode::Assign | Opcode::Int | Opcode::Float => true,
        Opcode::Matrix | Opcode::Transpose => out.size <= 16,
        _ if is_of_matrices(step.code, &step.args) => out.size <= 16,
        code if code.arity() > 0 => true,
        Opcode::Color | Opcode::Point | Opcode::Vector | Opcode::Normal => out.size <= 3,
        Opcode::Cross | Opcode::Normalize | Opcode::Transform | Opcode::TransformV => out.size <= 3,
        code if code.is_noise() => matches!(out.size, 1 | 3),
        _ => out.size == 1,
    }
}

/// Whether an operation of these operands is arithmetic of matrices.
pub(super) fn is_of_matrices(code: Opcode, args: &[Slot]) -> bool {
    matches!(code, Opcode::Add | Opcode::Sub | Opcode::Mul | Opcode::Div | Opcode::Neg)
        && args.iter().any(|a| a.ty == Type::MATRIX)
}

/// Whether an operation of these operands is one of ints.
pub(super) fn is_of_ints(code: Opcode, args: &[Slot]) -> bool {
    code.is_for_ints() && args.iter().all(|a| a.ty == Type::INT)
}

#[inline(always)]
fn bits<V: Values>(v: &mut V, slot: &Slot, i: usize) -> V::Word {
    if i < slot.size as usize { v.cell(slot, i as u32) } else { v.constant(0) }
}

fn set_bits<V: Values>(v: &mut V, slot: &Slot, i: usize, word: V::Word) {
    if i < slot.size as usize {
        v.set_cell(slot, i as u32, word);
    }
}

fn known<V: Values>(v: &mut V, x: f32) -> V::Real {
    V::Real::from_bits(v.constant(x.to_bits()))
}

/// Number `i` of a slot. Single numbers serve for all components.
#[inline(always)]
fn float<V: Values>(v: &mut V, slot: &Slot, i: usize) -> V::Real {
    let word = bits(v, slot, if slot.size == 1 { 0 } else { i });
    if slot.ty.base == Base::Int { V::Real::from_int(word) } else { V::Real::from_bits(word) }
}

#[inline(always)]
fn get<V: Values, N: Number<Real = V::Real>>(v: &mut V, slot: &Slot, i: usize) -> N {
    let value = float(v, slot, i);
    N::from_parts(value, || {
        let i = if slot.size == 1 { 0 } else { i as u32 };
        if slot.derivs && i < slot.size {
            // Written out: `map` becomes a call.
            let dx = v.cell(slot, slot.size + i);
            [V::Real::from_bits(dx), V::Real::from_bits(v.cell(slot, 2 * slot.size + i))]
        } else {
            [value.of(0.0); 2]
        }
    })
}

pub(super) fn put<V: Values, N: Number<Real = V::Real>>(v: &mut V, slot: &Slot, i: usize, x: N) {
    if i >= slot.size as usize {
        return;
    }
    let (value, i) = (x.value(), i as u32);
    if slot.ty.base == Base::Int {
        v.set_cell(slot, i, value.to_int());
        return;
    }
    v.set_cell(slot, i, value.bits());
    if slot.derivs {
        let slopes = x.slopes().unwrap_or([value.of(0.0); 2]);
        v.set_cell(slot, slot.size + i, slopes[0].bits());
        v.set_cell(slot, 2 * slot.size + i, slopes[1].bits());
    }
}

fn int<V: Values>(v: &mut V, slot: &Slot) -> V::Word {
    let word = bits(v, slot, 0);
    if slot.ty.base == Base::Int { word } else { V::Real::from_bits(word).to_int() }
}

fn set_int<V: Values>(v: &mut V, slot: &Slot, word: V::Word) {
    if slot.ty.base == Base::Int {
        set_bits(v, slot, 0, word);
    } else {
        put::<V, Dual<V::Real>>(v, slot, 0, Dual::lift(V::Real::from_int(word)));
    }
}

fn triple<V: Values, N: Number<Real = V::Real>>(v: &mut V, slot: &Slot) -> [N; 3] {
    [0, 1, 2].map(|i| get(v, slot, i))
}

fn set_triple<V: Values, N: Number<Real = V::Real>>(v: &mut V, slot: &Slot, value: [N; 3]) {
    for (i, x) in value.into_iter().enumerate() {
        put(v, slot, i, x);
    }
}

fn matrix<V: Values>(v: &mut V, slot: &Slot) -> [[V::Real; 4]; 4] {
    [0, 1, 2, 3].map(|r| {
        [0, 1, 2, 3].map(|c| match slot.size {
            1 if r != c => known(v, 0.0),
            _ => float(v, slot, r * 4 + c),
        })
    })
}

fn set_matrix<V: Values>(v: &mut V, slot: &Slot, m: [[V::Real; 4]; 4]) {
    for (i, x) in m.into_iter().flatten().enumerate() {
        put::<V, Dual<V::Real>>(v, slot, i, Dual::lift(x));
    }
}

/// Fetches a value along a connection. Derivatives of a part are as far away as those of the whole.
pub fn transfer<V: Values>(v: &mut V, copy: &Copy) {
    let (from, to) = (&copy.from, &copy.to);
    let is_word = |slot: &Slot| matches!(slot.ty.base, Base::Closure | Base::String);
    if is_word(from) || from.ty.base == Base::Int && to.ty.base == Base::Int {
        for i in 0..from.size.min(to.size) {
            let word = v.cell(from, i);
            v.set_cell(to, i, word);
        }
        return;
    }
    for i in 0..to.size {
        if from.size > 1 && i >= from.size {
            break;
        }
        let value: Dual<V::Real> = if copy.from_derivs > 0 {
            let i = if from.size == 1 { 0 } else { i };
            let [x, dx, dy] = [0, 1, 2].map(|k| V::Real::from_bits(v.cell(from, i + k * copy.from_derivs)));
            Dual::new(x, dx, dy)
        } else {
            get(v, from, i as usize)
        };
        if copy.to_derivs > 0 {
            for (k, x) in [value.value, value.dx, value.dy].into_iter().enumerate() {
                v.set_cell(to, i + k as u32 * copy.to_derivs, x.bits());
            }
        } else {
            put(v, to, i as usize, value);
        }
    }
}

/// Does an operation that [is computed](is_computed).
pub fn compute<V: Values>(v: &mut V, step: &Step) {
    let is_written = |i: usize| i < 64 && step.writes & 1 << i != 0;
    if step.args.iter().enumerate().any(|(i, a)| is_written(i) && a.derivs) {
        numbers::<V, Dual<V::Real>>(v, step);
    } else {
        numbers::<V, V::Plain>(v, step);
    }
}

fn numbers<V: Values, N: Number<Real = V::Real, Mask = V::Mask>>(v: &mut V, step: &Step) {
    let (code, args) = (step.code, &*step.args);
    let Some((out, rest)) = args.split_first() else { return };
    if is_of_matrices(code, args) {
        matrices(v, code, out, rest);
        return;
    }
    if is_of_ints(code, args) {
        ints(v, code, out, rest);
        return;
    }
    if code.arity() > 0 {
        each::<V, N>(v, out, &rest[..code.arity()], |x| code.apply(x));
        return;
    }
    others::<V, N>(v, step);
}

/// A function of each component.
#[inline(always)]
pub(super) fn each<V: Values, N: Number<Real = V::Real>>(
    v: &mut V,
    out: &Slot,
    operands: &[Slot],
    f: impl Fn([N; 3]) -> N,
) {
    for i in 0..out.size as usize {
        let first = get::<V, N>(v, &operands[0], i);
        let mut x = [first; 3];
        for (x, slot) in x.iter_mut().zip(operands).skip(1) {
            *x = get(v, slot, i);
        }
        put(v, out, i, f(x));
    }
}

/// Operations that are neither functions of each component nor of matrices or ints.
pub(super) fn others<V: Values, N: Number<Real = V::Real, Mask = V::Mask>>(v: &mut V, step: &Step) {
    let (code, args) = (step.code, &*step.args);
    let Some((out, rest)) = args.split_first() else { return };
    match code {
        Opcode::Eq | Opcode::Neq => equal(v, code, out, rest),
        Opcode::Lt | Opcode::Gt | Opcode::Le | Opcode::Ge => ordered(v, code, out, rest),
        Opcode::IsNan | Opcode::IsInf | Opcode::IsFinite => {
            let x = float(v, &rest[0], 0);
            let mask = match code {
                Opcode::IsNan => !Real::equal(x, x),
                Opcode::IsInf => Real::equal(Real::abs(x), x.of(f32::INFINITY)),
                _ => Real::abs(x).at_most(x.of(f32::MAX)),
            };
            let value = v.int_of(mask);
            set_int(v, out, value);
        }
        Opcode::ArrayCopy => copy(v, out, &rest[0]),
        Opcode::Assign | Opcode::Int | Opcode::Float => assign::<V, N>(v, out, &rest[0]),
        Opcode::Aref
        | Opcode::Aassign
        | Opcode::Compref
        | Opcode::Compassign
        | Opcode::Mxcompref
        | Opcode::Mxcompassign => element::<V, N>(v, step),
        Opcode::ArrayLength | Opcode::IsConnected | Opcode::IsConstant => {
            let value = v.constant(step.answer as u32);
            set_int(v, out, value);
        }
        Opcode::Color | Opcode::Point | Opcode::Vector | Opcode::Normal => {
            let value = [0, 1, 2].map(|i: usize| get::<V, N>(v, &rest[i.min(rest.len() - 1)], 0));
            set_triple(v, out, value);
        }
        Opcode::Matrix => {
            let value = if rest.len() >= 16 {
                [0, 1, 2, 3].map(|r| [0, 1, 2, 3].map(|c| float(v, &rest[r * 4 + c], 0)))
            } else {
                matrix(v, &rest[0])
            };
            set_matrix(v, out, value);
        }
        Opcode::Transpose => {
            let m = matrix(v, &rest[0]);
            set_matrix(v, out, mx::transpose(&m));
        }
        Opcode::Dot | Opcode::Distance => {
            let (a, b) = (triple::<V, N>(v, &rest[0]), triple(v, &rest[1]));
            put(v, out, 0, if code == Opcode::Dot { vectors::dot(a, b) } else { vectors::distance(a, b) });
        }
        Opcode::Cross => {
            let (a, b) = (triple::<V, N>(v, &rest[0]), triple(v, &rest[1]));
            set_triple(v, out, vectors::cross(a, b));
        }
        Opcode::Length => {
            let value = vectors::length(triple::<V, N>(v, &rest[0]));
            put(v, out, 0, value);
        }
        Opcode::Normalize => {
            let value = vectors::normalize(triple::<V, N>(v, &rest[0]));
            set_triple(v, out, value);
        }
        Opcode::Sincos => {
            for i in 0..rest[0].size as usize {
                let (sine, cosine) = math::sincos(get::<V, N>(v, out, i));
                put(v, &rest[0], i, sine);
                put(v, &rest[1], i, cosine);
            }
        }
        Opcode::Dx | Opcode::Dy | Opcode::Dz | Opcode::Filterwidth => {
            for i in 0..out.size as usize {
                let x: Dual<V::Real> = get(v, &rest[0], i);
                let change = match code {
                    Opcode::Dx => x.dx,
                    Opcode::Dy => x.dy,
                    Opcode::Dz => x.value.of(0.0),
                    _ => math::filterwidth(x.dx, x.dy),
                };
                put(v, out, i, N::lift(change));
            }
        }
        Opcode::Area => {
            let value: [Dual<V::Real>; 3] = triple(v, &rest[0]);
            let area = vectors::area(value.map(|d| d.dx), value.map(|d| d.dy));
            put(v, out, 0, N::lift(area));
        }
        Opcode::Transform | Opcode::TransformV => {
            let value = triple::<V, N>(v, &rest[1]);
            let m = matrix(v, &rest[0]);
            let is_point = code == Opcode::Transform;
            let value =
                if is_point { mx::transform_point(&m, value) } else { mx::transform_vector(&m, value) };
            set_triple(v, out, value);
        }
        Opcode::Hash => hash(v, out, rest),
        code if code.is_noise() => {
            noise_of::<V, N>(v, step);
        }
        _ => {}
    }
}

pub(super) fn ints<V: Values>(v: &mut V, code: Opcode, out: &Slot, rest: &[Slot]) {
    let a = bits(v, &rest[0], 0);
    let b = match rest.get(1) {
        Some(b) => bits(v, b, 0),
        None => a,
    };
    let zero = v.constant(0);
    let value = match code {
        Opcode::Add => a + b,
        Opcode::Sub => a - b,
        Opcode::Mul => a.product(b),
        Opcode::Div => a.quotient(b),
        Opcode::Mod | Opcode::Fmod => a.remainder(b),
        Opcode::BitAnd => a & b,
        Opcode::BitOr => a | b,
        Opcode::Xor => a ^ b,
        Opcode::Shl => a.moved_up(b),
        Opcode::Shr => a.moved_down(b),
        Opcode::Min => a.signed_min(b),
        Opcode::Max => a.signed_max(b),
        Opcode::And => {
            let both = v.truth(a) & v.truth(b);
            v.int_of(both)
        }
        Opcode::Or => {
            let either = v.truth(a) | v.truth(b);
            v.int_of(either)
        }
        Opcode::Neg => zero - a,
        Opcode::Compl => a ^ u32::MAX,
        // The smallest whole number stays as it is.
        _ => V::Word::pick(zero.above(a), zero - a, a),
    };
    set_bits(v, out, 0, value);
}

fn all<M: Mask>(list: impl Iterator<Item = M>) -> Option<M> {
    list.reduce(|a, b| a & b)
}

pub(super) fn equal<V: Values>(v: &mut V, code: Opcode, out: &Slot, rest: &[Slot]) {
    let (a, b) = (&rest[0], &rest[1]);
    let same = match (a.ty.base, b.ty.base) {
        (Base::String, _) | (_, Base::String) | (Base::Int, Base::Int) => {
            let (a, b) = (bits(v, a, 0), bits(v, b, 0));
            Some(a.same(b))
        }
        (Base::Closure, _) | (_, Base::Closure) => {
            let (a, b) = (bits(v, a, 0).equal(0), bits(v, b, 0).equal(0));
            Some((a & b) | (!a & !b))
        }
        (Base::Matrix, _) | (_, Base::Matrix) => {
            let (a, b) = (matrix(v, a), matrix(v, b));
            all(a.into_iter().flatten().zip(b.into_iter().flatten()).map(|(x, y)| Real::equal(x, y)))
        }
        _ => compare(v, a, b, Real::equal),
    };
    let Some(same) = same else { return };
    let value = v.int_of(if code == Opcode::Eq { same } else { !same });
    set_int(v, out, value);
}

/// Whether a comparison holds for all components.
fn compare<V: Values>(
    v: &mut V,
    a: &Slot,
    b: &Slot,
    holds: impl Fn(V::Real, V::Real) -> V::Mask,
) -> Option<V::Mask> {
    all((0..a.size.max(b.size) as usize).map(|i| {
        let (x, y) = (float(v, a, i), float(v, b, i));
        holds(x, y)
    }))
}

pub(super) fn ordered<V: Values>(v: &mut V, code: Opcode, out: &Slot, rest: &[Slot]) {
    let (a, b) = (&rest[0], &rest[1]);
    let (a, b) = if matches!(code, Opcode::Gt | Opcode::Ge) { (b, a) } else { (a, b) };
    let is_strict = matches!(code, Opcode::Lt | Opcode::Gt);
    let mask = if a.ty == Type::INT && b.ty == Type::INT {
        let (a, b) = (bits(v, a, 0), bits(v, b, 0));
        Some(if is_strict { b.above(a) } else { !a.above(b) })
    } else {
        compare(v, a, b, |x, y| if is_strict { x.less(y) } else { x.at_most(y) })
    };
    let Some(mask) = mask else { return };
    let value = v.int_of(mask);
    set_int(v, out, value);
}

pub(super) fn assign<V: Values, N: Number<Real = V::Real>>(v: &mut V, out: &Slot, a: &Slot) {
    if out.ty.is_array() || a.ty.is_array() {
        copy(v, out, a);
        return;
    }
    match out.ty.base {
        Base::String | Base::Closure => {
            let word = if a.ty.base == out.ty.base { bits(v, a, 0) } else { v.constant(0) };
            set_bits(v, out, 0, word);
        }
        Base::Int => {
            let word = int(v, a);
            set_bits(v, out, 0, word);
        }
        Base::Matrix => {
            let value = matrix(v, a);
            set_matrix(v, out, value);
        }
        // All parts are read before the first is written: `out` may be `a`.
        _ if out.size == 1 => {
            let value: N = get(v, a, 0);
            put(v, out, 0, value);
        }
        _ => {
            let value = triple::<V, N>(v, a);
            set_triple(v, out, value);
        }
    }
}

/// As many elements as both have.
fn copy<V: Values>(v: &mut V, out: &Slot, a: &Slot) {
    let is_float = out.ty.base.is_float_based() && is_numeric(a);
    for i in 0..out.size.min(a.size) as usize {
        if is_float {
            let value: Dual<V::Real> = get(v, a, i);
            put(v, out, i, value);
        } else {
            let word = bits(v, a, i);
            set_bits(v, out, i, word);
        }
    }
}

fn copy_part<V: Values, N: Number<Real = V::Real>>(
    v: &mut V,
    (out, at): (&Slot, usize),
    (from, start): (&Slot, usize),
    count: usize,
) {
    for i in 0..count {
        if from.ty.base.is_float_based() || out.ty.base.is_float_based() {
            let value: N = get(v, from, start + i);
            put(v, out, at + i, value);
        } else {
            let word = bits(v, from, start + i);
            set_bits(v, out, at + i, word);
        }
    }
}

/// An operation on a part of a value, and its parts: the operands of the index, of the array and of a value
/// that is written, if one is; how many parts there are, and numbers of one.
struct Parts<'s> {
    index: usize,
    array: &'s Slot,
    other: &'s Slot,
    writes: bool,
    count: usize,
    one: usize,
}

impl<'s> Parts<'s> {
    fn of(step: &'s Step) -> Option<Self> {
        let [a, b, c, ..] = &*step.args else { return None };
        let elements = |array: &Slot| (array.ty.elements(), array.one as usize);
        Some(match step.code {
            Opcode::Aref => {
                let (count, one) = elements(b);
                Self { index: 2, array: b, other: a, writes: false, count, one }
            }
            Opcode::Aassign => {
                let (count, one) = elements(a);
                Self { index: 1, array: a, other: c, writes: true, count, one }
            }
            Opcode::Compref => Self { index: 2, array: b, other: a, writes: false, count: 3, one: 1 },
            Opcode::Compassign => Self { index: 1, array: a, other: c, writes: true, count: 3, one: 1 },
            _ => return None,
        })
    }
}

/// The operand with the index of an operation that can choose among all parts of a value, and how many there
/// are.
#[must_use]
pub fn chooses(step: &Step) -> Option<(&Slot, usize)> {
    let parts = Parts::of(step)?;
    let is_whole = parts.count > 0 && parts.count * parts.one <= parts.array.size as usize;
    let alike = |a: &Slot, b: &Slot| a.ty.base == b.ty.base || is_float(a) && is_float(b);
    let is_short = parts.count * parts.one <= CHOSEN && parts.other.size as usize >= parts.one;
    let index = &step.args[parts.index];
    let is_right = index.ty == Type::INT && (alike(parts.array, parts.other) || parts.array.ty.is_triple());
    (is_whole && is_short && is_right && is_numeric(parts.array)).then_some((index, parts.count))
}

fn is_float(slot: &Slot) -> bool {
    slot.ty.base.is_float_based()
}

/// Numbers of a value that an unknown index chooses among.
const CHOSEN: usize = 48;

/// Reads or writes the part of an index that is not known, and in range.
fn choose<V: Values, N: Number<Real = V::Real, Mask = V::Mask>>(v: &mut V, step: &Step) {
    let Some(parts) = Parts::of(step) else { return };
    let index = int(v, &step.args[parts.index]);
    for i in 0..parts.one {
        if parts.writes {
            let value: N = get(v, parts.other, i);
            for k in 0..parts.count {
                let at = k * parts.one + i;
                if parts.array.ty.base == Base::Int {
                    let (old, new) = (bits(v, parts.array, at), int(v, parts.other));
                    set_bits(v, parts.array, at, V::Word::pick(index.equal(k as u32), new, old));
                } else {
                    let old: N = get(v, parts.array, at);
                    put(v, parts.array, at, N::pick(index.equal(k as u32), value, old));
                }
            }
        } else if parts.array.ty.base == Base::Int && parts.other.ty.base == Base::Int {
            let mut word = bits(v, parts.array, i);
            for k in 1..parts.count {
                let other = bits(v, parts.array, k * parts.one + i);
                word = V::Word::pick(index.equal(k as u32), other, word);
            }
            set_bits(v, parts.other, i, word);
        } else {
            let mut value: N = get(v, parts.array, i);
            for k in 1..parts.count {
                let other = get(v, parts.array, k * parts.one + i);
                value = N::pick(index.equal(k as u32), other, value);
            }
            put(v, parts.other, i, value);
        }
    }
}

/// Elements of arrays, components of triples and matrices.
fn element<V: Values, N: Number<Real = V::Real, Mask = V::Mask>>(v: &mut V, step: &Step) {
    let (out, rest) = (&step.args[0], &step.args[1..]);
    match step.code {
        Opcode::Aref => {
            let array = &rest[0];
            let count = array.ty.elements();
            if count == 0 {
                return;
            }
            let Some(index) = v.index(step, 2, 1, count) else { return choose::<V, N>(v, step) };
            let start = if array.size == 1 { 0 } else { index * array.one as usize };
            copy_part::<V, N>(v, (out, 0), (array, start), array.one.min(out.size) as usize);
        }
        Opcode::Aassign => {
            let count = out.ty.elements();
            if count == 0 {
                return;
            }
            let Some(index) = v.index(step, 1, 0, count) else { return choose::<V, N>(v, step) };
            let value = &rest[1];
            if out.ty.base == Base::Closure && value.ty.base != Base::Closure {
                let zero = v.constant(0);
                set_bits(v, out, index, zero);
            } else if out.ty.base == Base::Int {
                let word = int(v, value);
                set_bits(v, out, index, word);
            } else {
                let one = out.one as usize;
                copy_part::<V, N>(v, (out, index * one), (value, 0), one);
            }
        }
        Opcode::Compref => {
            let Some(index) = v.index(step, 2, 1, 3) else { return choose::<V, N>(v, step) };
            let value: N = get(v, &rest[0], index);
            put(v, out, 0, value);
        }
        Opcode::Compassign => {
            let Some(index) = v.index(step, 1, 0, 3) else { return choose::<V, N>(v, step) };
            let value: N = get(v, &rest[1], 0);
            put(v, out, index, value);
        }
        Opcode::Mxcompref => {
            let (row, column) = (v.index(step, 2, 1, 4), v.index(step, 3, 1, 4));
            let at = row.unwrap_or(0) * 4 + column.unwrap_or(0);
            let value = float(v, &rest[0], at);
            put(v, out, 0, N::lift(value));
        }
        _ => {
            let (row, column) = (v.index(step, 1, 0, 4), v.index(step, 2, 0, 4));
            let at = row.unwrap_or(0) * 4 + column.unwrap_or(0);
            let value = float(v, &rest[2], 0);
            put(v, out, at, N::lift(value));
        }
    }
}

fn matrices<V: Values>(v: &mut V, code: Opcode, out: &Slot, rest: &[Slot]) {
    let is_matrix = |slot: &Slot| slot.ty == Type::MATRIX;
    let a = matrix(v, &rest[0]);
    let Some(by) = rest.get(1).filter(|_| code != Opcode::Neg) else {
        set_matrix(v, out, a.map(|row| row.map(|x| -x)));
        return;
    };
    let value = match code {
        Opcode::Mul if is_matrix(&rest[0]) && is_matrix(by) => mx::multiply(&a, &matrix(v, by)),
        Opcode::Mul if is_matrix(&rest[0]) => mx::scale(&a, float(v, by, 0)),
        Opcode::Mul => {
            let factor = float(v, &rest[0], 0);
            mx::scale(&matrix(v, by), factor)
        }
        Opcode::Div => {
            let by = float(v, by, 0);
            let zero = by.of(0.0);
            mx::scale(&a, V::Real::choose(Real::equal(by, zero), zero, by.of(1.0) / by))
        }
        _ => {
            let b = matrix(v, by);
            let sign = if code == Opcode::Sub { -1.0 } else { 1.0 };
            let sum = |r: usize, c: usize| a[r][c] + b[r][c] * sign;
            [0, 1, 2, 3].map(|r| [0, 1, 2, 3].map(|c| sum(r, c)))
        }
    };
    set_matrix(v, out, value);
}

fn hash<V: Values>(v: &mut V, out: &Slot, rest: &[Slot]) {
    let words: Vec<V::Word> = match rest {
        [one] if one.ty.base == Base::Int => vec![bits(v, one, 0)],
        _ => {
            let all = rest.iter().flat_map(|slot| (0..slot.size as usize).map(move |i| (slot, i))).take(4);
            all.map(|(slot, i)| float(v, slot, i).known_bits()).collect()
        }
    };
    let value = match *words {
        [] => v.constant(0),
        [a] => noise::hash_uints([a]),
        [a, b] => noise::hash_uints([a, b]),
        [a, b, c] => noise::hash_uints([a, b, c]),
        [a, b, c, d, ..] => noise::hash_uints([a, b, c, d]),
    };
    set_int(v, out, value);
}

pub(super) fn noise_of<V: Values, N: Number<Real = V::Real>>(v: &mut V, step: &Step) {
    let (code, out) = (step.code, &step.args[0]);
    let kind = match code {
        Opcode::Snoise | Opcode::Psnoise => NoiseKind::Perlin,
        Opcode::Cellnoise => NoiseKind::Cell,
        Opcode::Hashnoise => NoiseKind::Hash,
        _ if step.args[1].ty == Type::STRING => v.noise_kind(step),
        _ => NoiseKind::UPerlin,
    };
    if kind == NoiseKind::Gabor {
        v.gabor(step);
        return;
    }
    let Some((list, count, period)) = noise_numbers::<V, N>(v, step) else { return };
    let three = out.size >= 3;
    let value = kind.plain(&list[..count], period.as_ref().map(|period| &period[..count]), three);
    for (i, x) in value.into_iter().enumerate().take(if three { 3 } else { 1 }) {
        put(v, out, i, x);
    }
}

/// Numbers of a noise: the coordinates come first.
type NoiseNumbers<N> = ([N; 8], usize, Option<[<N as Number>::Real; 4]>);

/// The numbers of a noise, how many of them are coordinates, and its periods.
#[inline(always)]
pub(super) fn noise_numbers<V: Values, N: Number<Real = V::Real>>(
    v: &mut V,
    step: &Step,
) -> Option<NoiseNumbers<N>> {
    let (slots, is_periodic) = coordinates(step.code, &step.args)?;
    let mut list = [N::lift(known(v, 0.0)); 8];
    let mut count = 0;
    for slot in slots {
        for i in 0..slot.size as usize {
            list[count] = get(v, slot, i);
            count += 1;
        }
    }
    if !is_periodic {
        return Some((list, count, None));
    }
    let half = count / 2;
    Some((list, half, Some([0, 1, 2, 3].map(|i: usize| list[half + i.min(half - 1)].value()))))
}

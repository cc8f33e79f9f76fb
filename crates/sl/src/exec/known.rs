// SPDX-License-Identifier: GPL-3.0-or-later
//! Results of operations on known values, by the evaluator of numbers.
//! Tests: `tests/passes.rs`.

use super::compute::{compute, is_computed};
use super::machine::Step;
use super::math::quotient;
use super::scalar::Scalar;
use super::slot::Slot;
use super::strings::Strings;
use crate::hir::Data;
use crate::opcode::Opcode;
use crate::types::{Base, Type};

/// Numbers that an operation may take.
const MOST: usize = 256;

/// Writes a value into words, as many of them as a slot has; ints become floats where those are wanted.
pub(super) fn fill(words: &mut [u32], slot: &Slot, data: &Data, strings: &mut Strings) {
    let words = &mut words[slot.at as usize..][..slot.size as usize];
    match data {
        Data::Int(_) if slot.ty.base == Base::Closure => words.fill(0),
        Data::Int(list) => words.iter_mut().zip(list).for_each(|(word, &v)| {
            *word = if slot.ty.base == Base::Int { v as u32 } else { (v as f32).to_bits() };
        }),
        Data::Float(list) => words.iter_mut().zip(list).for_each(|(word, v)| *word = v.to_bits()),
        Data::Str(list) => words.iter_mut().zip(list).for_each(|(word, v)| *word = strings.number(v)),
    }
}

/// The value in words.
pub(super) fn data(words: &[u32], slot: &Slot, strings: &Strings) -> Data {
    let words = words[slot.at as usize..][..slot.size as usize].iter();
    match slot.ty.base {
        Base::String => Data::Str(words.map(|&w| strings.text(w).clone()).collect()),
        Base::Int | Base::Closure => Data::Int(words.map(|&w| w as i32).collect()),
        _ => Data::Float(words.map(|&w| f32::from_bits(w)).collect()),
    }
}

/// The result of an operation, whose type comes first, of known operands; none if it does more than that.
pub(crate) fn result(code: Opcode, out: Type, operands: &[(Type, &Data)]) -> Option<Data> {
    // An inverse is of doubles, which the evaluator has not.
    if let (Opcode::Div, Type::MATRIX, &[(_, a), (Type::MATRIX, b)]) = (code, out, operands) {
        return quotient(a, b);
    }
    let is_plain = (code.is_pure() || code.is_indexed()) && !code.is_about_operands() && code.results() == 1;
    let is_value = matches!(out.base, Base::Int | Base::String) || out.base.is_float_based();
    let count: usize = operands.iter().map(|(ty, _)| ty.size()).sum();
    if !is_plain || !is_value || out.array < 0 || count + out.size() > MOST {
        return None;
    }
    let (mut cells, mut strings, mut at) = (vec![0; count + out.size()], Strings::default(), 0);
    let types = std::iter::once(out).chain(operands.iter().map(|(ty, _)| *ty));
    let args: Box<[Slot]> = types
        .map(|ty| {
            let slot = Slot::new(at, ty, false);
            at += slot.size as usize;
            slot
        })
        .collect();
    for (slot, (_, value)) in args[1..].iter().zip(operands) {
        fill(&mut cells, slot, value, &mut strings);
    }
    if operands.iter().any(|(ty, _)| ty.array < 0) || !is_computed(code, &args) {
        return None;
    }
    let step = Step::of_numbers(code, args);
    let mut scalar = Scalar { cells: &mut cells, strings: &strings, faults: Vec::new() };
    compute(&mut scalar, &step);
    let is_right = scalar.faults.is_empty();
    is_right.then(|| data(&cells, &step.args[0], &strings))
}

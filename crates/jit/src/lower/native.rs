// SPDX-License-Identifier: GPL-3.0-or-later
//! Which operations become code; the others are done by the interpreter, lane by lane.
//! Tests: `tests/agreement.rs`, `tests/chance.rs`.

use gnurt_sl::exec::{Slot, Step};
use gnurt_sl::types::{Base, Type};
use gnurt_sl_lib::noise::NoiseKind;

use super::functions;

/// Known symbols during the compilation of a group.
pub(crate) trait Known {
    /// An int that is the same always.
    fn constant_int(&self, slot: &Slot) -> Option<i32>;
    /// A text that is the same always.
    fn constant_text(&self, slot: &Slot) -> Option<&str>;
}

fn numeric(slot: &Slot) -> bool {
    slot.size > 0 && (slot.ty.base == Base::Int || slot.ty.base.is_float_based())
}

fn one_number(slot: &Slot) -> bool {
    numeric(slot) && !slot.ty.is_array()
}

/// Numbers for `out`: one for all, or one for each.
fn serves(slot: &Slot, out: &Slot) -> bool {
    numeric(slot) && (slot.size == 1 || slot.size >= out.size)
}

fn triple(slot: &Slot) -> bool {
    numeric(slot) && (slot.size == 1 || slot.size >= 3)
}

fn matrix(slot: &Slot) -> bool {
    numeric(slot) && (slot.size == 1 || slot.size >= 16)
}

/// The kind of a noise and its numbers, if both are known.
pub(crate) fn noise<'s>(step: &'s Step, known: &dyn Known) -> Option<(NoiseKind, &'s [Slot])> {
    let named = step.args.get(1).is_some_and(|a| a.ty == Type::STRING);
    let kind = match &*step.name {
        "snoise" | "psnoise" => NoiseKind::Perlin,
        "cellnoise" => NoiseKind::Cell,
        "hashnoise" => NoiseKind::Hash,
        _ if named => NoiseKind::named(known.constant_text(&step.args[1])?)?,
        _ => NoiseKind::UPerlin,
    };
    let first = 1 + usize::from(named);
    let end = (first..step.args.len()).find(|&i| step.args[i].ty == Type::STRING).unwrap_or(step.args.len());
    let numbers = step.args.get(first..end)?;
    let count: usize = numbers.iter().map(|slot| slot.size as usize).sum();
    let periodic = step.name.starts_with('p');
    let fits = count > 0 && count <= if periodic { 8 } else { 4 } && (!periodic || count.is_multiple_of(2));
    let known = fits && kind != NoiseKind::Gabor && numbers.iter().all(one_number);
    known.then_some((kind, numbers))
}

/// An index that is known and in range.
fn index(known: &dyn Known, slot: &Slot, count: usize) -> Option<usize> {
    let index = known.constant_int(slot)?;
    usize::try_from(index).ok().filter(|&i| i < count)
}

/// The cell of an element or component that an operation names, counted from the start of its array or value.
pub(crate) fn element(step: &Step, known: &dyn Known) -> Option<usize> {
    let args = &step.args;
    match &*step.name {
        "aref" => Some(index(known, args.get(2)?, args[1].ty.elements())? * args[1].one as usize),
        "aassign" => Some(index(known, args.get(1)?, args[0].ty.elements())? * args[0].one as usize),
        "compref" => index(known, args.get(2)?, 3),
        "compassign" => index(known, args.get(1)?, 3),
        "mxcompref" => Some(index(known, args.get(2)?, 4)? * 4 + index(known, args.get(3)?, 4)?),
        "mxcompassign" => Some(index(known, args.get(1)?, 4)? * 4 + index(known, args.get(2)?, 4)?),
        _ => None,
    }
}

/// Whether an operation becomes code.
pub(crate) fn is_native(step: &Step, known: &dyn Known) -> bool {
    let args = &*step.args;
    let name = &*step.name;
    if matches!(name, "useparam" | "nop" | "end" | "bump" | "displace") {
        return true;
    }
    let Some((out, rest)) = args.split_first() else { return false };
    if out.size == 0 {
        return false;
    }
    let out_number = numeric(out);
    let any_matrix = args.iter().any(|a| a.ty == Type::MATRIX);
    let ints = args.len() > 1 && args.iter().all(|a| a.ty == Type::INT);
    if any_matrix && matches!(name, "add" | "sub" | "mul" | "div" | "neg") {
        let of_two = rest.len() == 2 && rest.iter().all(matrix);
        return out.ty == Type::MATRIX
            && match name {
                "neg" => !rest.is_empty() && matrix(&rest[0]),
                "div" => of_two && rest[0].ty == Type::MATRIX && rest[1].ty != Type::MATRIX,
                "mul" => of_two,
                _ => of_two,
            };
    }
    if ints && functions::int_arguments(name).is_some_and(|n| rest.len() >= n) {
        return true;
    }
    if let Some(count) = functions::arguments(name) {
        return out_number && rest.len() >= count && rest[..count].iter().all(|a| serves(a, out));
    }
    let two = |f: fn(&Slot) -> bool| rest.len() == 2 && rest.iter().all(f);
    match name {
        "eq" | "neq" => {
            let [a, b] = rest else { return false };
            let is_integer = |s: &Slot| matches!(s.ty.base, Base::String | Base::Closure | Base::Int);
            let larger = if a.size > b.size { a } else { b };
            one_number(out)
                && (is_integer(a) && is_integer(b) && a.ty.base == b.ty.base && a.size == 1 && b.size == 1
                    || one_number(a) && one_number(b) && serves(a, larger) && serves(b, larger))
        }
        "lt" | "gt" | "le" | "ge" => {
            let [a, b] = rest else { return false };
            let larger = if a.size > b.size { a } else { b };
            one_number(out) && one_number(a) && one_number(b) && serves(a, larger) && serves(b, larger)
        }
        "isnan" | "isinf" | "isfinite" => one_number(out) && rest.first().is_some_and(numeric),
        "assign" | "int" | "float" => {
            let Some(a) = rest.first() else { return false };
            let is_integer = |s: &Slot| matches!(s.ty.base, Base::String | Base::Closure);
            if out.ty.is_array() || a.ty.is_array() {
                return (numeric(out) && numeric(a)) || (is_integer(out) && is_integer(a));
            }
            is_integer(out)
                || out_number
                    && a.size > 0
                    && numeric(a)
                    && (a.size == 1 || a.size >= out.size.min(3))
                    && (out.ty.base != Base::Matrix || matrix(a))
        }
        "arraycopy" => {
            let is_integer = |s: &Slot| matches!(s.ty.base, Base::String | Base::Closure);
            rest.first().is_some_and(|a| (numeric(out) && numeric(a)) || (is_integer(out) && is_integer(a)))
        }
        "aref" => {
            rest.len() >= 2
                && element(step, known).is_some()
                && rest[0].ty.base.components() > 0
                && rest[0].size > 1
                && kind(&rest[0]) == kind(out)
        }
        "aassign" => {
            args.len() == 3
                && element(step, known).is_some()
                && kind(&args[2]) == kind(out)
                && (args[2].size == 1 || args[2].size >= out.one)
        }
        "compref" => rest.len() == 2 && one_number(out) && triple(&rest[0]) && element(step, known).is_some(),
        "compassign" => {
            args.len() == 3
                && out.size >= 3
                && numeric(out)
                && numeric(&args[2])
                && element(step, known).is_some()
        }
        "mxcompref" => {
            args.len() == 4 && one_number(out) && matrix(&rest[0]) && element(step, known).is_some()
        }
        "mxcompassign" => {
            args.len() == 4
                && out.size >= 16
                && numeric(out)
                && numeric(&args[3])
                && element(step, known).is_some()
        }
        "arraylength" | "isconnected" | "isconstant" => one_number(out) && rest.len() == 1,
        "color" | "point" | "vector" | "normal" => {
            out_number && out.size == 3 && !rest.is_empty() && rest.iter().all(one_number)
        }
        "matrix" => {
            out.ty == Type::MATRIX
                && rest.iter().all(one_number)
                && (rest.len() >= 16 || rest.first().is_some_and(matrix))
        }
        "transpose" => out.ty == Type::MATRIX && rest.len() == 1 && matrix(&rest[0]),
        "dot" | "distance" => one_number(out) && two(triple),
        "cross" => out_number && out.size >= 3 && two(triple),
        "length" | "area" => one_number(out) && rest.len() == 1 && triple(&rest[0]),
        "normalize" => out_number && out.size >= 3 && rest.len() == 1 && triple(&rest[0]),
        "sincos" => {
            args.len() == 3
                && numeric(&args[1])
                && numeric(&args[2])
                && args[2].size >= args[1].size
                && serves(&args[0], &args[1])
        }
        "Dx" | "Dy" | "Dz" | "filterwidth" => out_number && rest.len() == 1 && serves(&rest[0], out),
        "transform" | "transformv" => {
            out_number && out.size >= 3 && rest.len() == 2 && rest[0].ty == Type::MATRIX && triple(&rest[1])
        }
        "noise" | "snoise" | "pnoise" | "psnoise" | "cellnoise" | "hashnoise" => {
            out_number && matches!(out.size, 1 | 3) && args.len() > 1 && noise(step, known).is_some()
        }
        "hash" => {
            one_number(out)
                && !rest.is_empty()
                && rest.iter().all(one_number)
                && (1..=4).contains(&rest.iter().map(|a| a.size).sum::<u32>())
        }
        _ => false,
    }
}

/// Floats, whole numbers or something else that is a word.
pub(crate) fn kind(slot: &Slot) -> u8 {
    match slot.ty.base {
        Base::Int => 0,
        Base::String => 1,
        Base::Closure => 2,
        base if base.is_float_based() => 3,
        _ => 4,
    }
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
    let mut parts = matches!(&*step.name, "aassign" | "compassign" | "mxcompassign");
    if let [out, a, ..] = &*step.args
        && (out.ty.is_array() || a.ty.is_array())
        && matches!(&*step.name, "arraycopy" | "assign" | "int" | "float")
    {
        // A shorter array leaves the elements behind its end.
        parts |= a.size < out.size;
    }
    for i in 0..step.args.len() {
        if bit(step.reads, i) {
            visit(i, Touch::Read);
        }
    }
    for i in 0..step.args.len().min(64) {
        if bit(step.writes, i) {
            let whole = native && !parts && !bit(step.reads, i);
            visit(i, if whole { Touch::Write } else { Touch::Change });
        }
    }
}

/// Whether the declared writes of an operation are its real ones: files may hold anything.
pub(crate) fn is_honest(step: &Step) -> bool {
    let expected: u64 = match &*step.name {
        "printf" | "error" | "warning" | "fprintf" | "setmessage" | "useparam" | "nop" | "end" => 0,
        "sincos" => 6,
        _ => return step.args.is_empty() || step.writes & 1 != 0,
    };
    step.writes & expected == expected
}

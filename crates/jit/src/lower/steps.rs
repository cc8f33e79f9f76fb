// SPDX-License-Identifier: GPL-3.0-or-later
//! Operations as records of their computation. Each computes the same as `gnurt_sl::exec`, in its order, for
//! arguments that `native` accepts.
//! Tests: `tests/agreement.rs`, `tests/chance.rs`.

use gnurt_sl::exec::{Slot, Step};
use gnurt_sl::ir::SymbolKind;
use gnurt_sl::types::{Base, Type};
use gnurt_sl_lib::math::{self, vectors};
use gnurt_sl_lib::{Dual, Number, Real, UInts};

use super::functions;
use super::native::{Known, element, noise};
use super::values::{Held, Values};
use crate::op::Binary;
use crate::term::{Bits, Term, Which, binary, constant};

type D = Dual<Term>;

/// Records an operation of a layer.
pub(crate) fn step(v: &mut Values<'_>, layer: usize, step: &Step, known: &dyn Known) {
    let args = &*step.args;
    let Some(out) = args.first() else { return };
    let name = &*step.name;
    let written = |i: usize| i < 64 && step.writes & 1 << i != 0;
    let derivs = args.iter().enumerate().any(|(i, a)| written(i) && a.derivs);
    let ints = args.len() > 1 && args.iter().all(|a| a.ty == Type::INT);
    let any_matrix = args.iter().any(|a| a.ty == Type::MATRIX);
    match name {
        "useparam" | "nop" | "end" | "bump" | "displace" => {}
        "add" | "sub" | "mul" | "div" | "neg" if any_matrix => matrices(v, name, args),
        _ if ints && functions::int_arguments(name).is_some() => on_ints(v, name, args),
        "eq" | "neq" => equal(v, name, args),
        "lt" | "gt" | "le" | "ge" => ordered(v, name, args),
        "isnan" | "isinf" | "isfinite" => finite(v, name, args),
        "arraycopy" => copy(v, out, &args[1]),
        "assign" | "int" | "float" if out.ty.is_array() || args[1].ty.is_array() => copy(v, out, &args[1]),
        "assign" | "int" | "float" if matches!(out.ty.base, Base::String | Base::Closure) => {
            let same = args[1].ty.base == out.ty.base;
            let bits_id = if same { v.bits(args[1].at) } else { constant(0) };
            v.set_bits(out, 0, bits_id);
        }
        "arraylength" => v.set_int(out, Bits(constant(args[1].ty.array as u32))),
        "isconnected" => {
            let connected = v.plan.layers[layer].connected[step.symbols[1] as usize];
            v.set_int(out, Bits(constant(connected.into())));
        }
        "isconstant" => {
            let (plan, id) = (&v.plan.layers[layer], step.symbols[1]);
            let fixed = plan.shader.symbol(id).kind == SymbolKind::Const
                || plan.constant.get(id as usize).is_some_and(|&c| c);
            v.set_int(out, Bits(constant(fixed.into())));
        }
        "aref" | "aassign" | "compref" | "compassign" | "mxcompref" | "mxcompassign" => {
            parts(v, step, element(step, known).unwrap_or(0));
        }
        "Dx" | "Dy" | "Dz" | "filterwidth" => changes(v, name, args),
        "area" => {
            let [a, b] = slopes(v, &args[1]);
            let area = vectors::area(a, b);
            D::put(v, out, 0, D::lift(area));
        }
        "hash" => hash(v, args),
        _ if derivs => numbers::<D>(v, step, known),
        _ => numbers::<Term>(v, step, known),
    }
}

fn triple<N: Held>(v: &mut Values<'_>, slot: &Slot) -> [N; 3] {
    [0, 1, 2].map(|i| N::get(v, slot, i))
}

fn set_triple<N: Held>(v: &mut Values<'_>, slot: &Slot, value: [N; 3]) {
    for (i, x) in value.into_iter().enumerate() {
        N::put(v, slot, i, x);
    }
}

fn matrix(v: &mut Values<'_>, slot: &Slot) -> [[Term; 4]; 4] {
    [0, 1, 2, 3].map(|r| {
        [0, 1, 2, 3].map(|c| match slot.size {
            1 if r != c => Term::constant(0.0),
            _ => v.float(slot, r * 4 + c),
        })
    })
}

fn set_matrix(v: &mut Values<'_>, slot: &Slot, m: [[Term; 4]; 4]) {
    for (i, x) in m.into_iter().flatten().enumerate() {
        D::put(v, slot, i, D::lift(x));
    }
}

/// Functions of numbers that hand on derivatives, if there are some.
fn numbers<N: Held>(v: &mut Values<'_>, step: &Step, known: &dyn Known) {
    let (args, name) = (&*step.args, &*step.name);
    let (out, rest) = (&args[0], &args[1..]);
    if let Some(count) = functions::arguments(name) {
        for i in 0..out.size as usize {
            let first = N::get(v, &rest[0], i);
            let mut x = [first; 3];
            for (x, slot) in x.iter_mut().zip(&rest[..count]).skip(1) {
                *x = N::get(v, slot, i);
            }
            let value = functions::apply(name, x);
            N::put(v, out, i, value);
        }
        return;
    }
    match name {
        "assign" | "int" | "float" => {
            if out.ty.base == Base::Int {
                let value = v.int(&rest[0]);
                v.set_bits(out, 0, value.0);
            } else if out.ty.base == Base::Matrix {
                let value = matrix(v, &rest[0]);
                set_matrix(v, out, value);
            } else {
                let size = (out.size as usize).min(3);
                let values: Vec<N> = (0..size).map(|i| N::get(v, &rest[0], i)).collect();
                for (i, value) in values.into_iter().enumerate() {
                    N::put(v, out, i, value);
                }
            }
        }
        "color" | "point" | "vector" | "normal" => {
            let value = [0, 1, 2].map(|i: usize| N::get(v, &rest[i.min(rest.len() - 1)], 0));
            set_triple(v, out, value);
        }
        "matrix" => {
            let value = if rest.len() >= 16 {
                [0, 1, 2, 3].map(|r| [0, 1, 2, 3].map(|c| v.float(&rest[r * 4 + c], 0)))
            } else {
                matrix(v, &rest[0])
            };
            set_matrix(v, out, value);
        }
        "transpose" => {
            let m = matrix(v, &rest[0]);
            set_matrix(v, out, [0, 1, 2, 3].map(|r| [0, 1, 2, 3].map(|c: usize| m[c][r])));
        }
        "dot" => {
            let value = vectors::dot(triple::<N>(v, &rest[0]), triple(v, &rest[1]));
            N::put(v, out, 0, value);
        }
        "cross" => {
            let value = vectors::cross(triple::<N>(v, &rest[0]), triple(v, &rest[1]));
            set_triple(v, out, value);
        }
        "length" => {
            let value = vectors::length(triple::<N>(v, &rest[0]));
            N::put(v, out, 0, value);
        }
        "distance" => {
            let value = vectors::distance(triple::<N>(v, &rest[0]), triple(v, &rest[1]));
            N::put(v, out, 0, value);
        }
        "normalize" => {
            let value = vectors::normalize(triple::<N>(v, &rest[0]));
            set_triple(v, out, value);
        }
        "sincos" => {
            for i in 0..args[1].size as usize {
                let (sine, cosine) = math::sincos(N::get(v, &args[0], i));
                N::put(v, &args[1], i, sine);
                N::put(v, &args[2], i, cosine);
            }
        }
        "transform" | "transformv" => {
            let value = triple::<N>(v, &rest[1]);
            let m = matrix(v, &rest[0]);
            let column = |k: usize| {
                let part = |i: usize| value[i] * N::lift(m[i][k]);
                part(0) + part(1) + part(2)
            };
            let value = if name == "transformv" {
                [0, 1, 2].map(column)
            } else {
                let [x, y, z, w] = [0, 1, 2, 3].map(|k| {
                    let sum = column(k);
                    sum.with_value(sum.value() + m[3][k])
                });
                [math::div(x, w), math::div(y, w), math::div(z, w)]
            };
            set_triple(v, out, value);
        }
        _ => {
            let Some((kind, slots)) = noise(step, known) else { return };
            let mut x: Vec<N> = Vec::new();
            for slot in slots {
                x.extend((0..slot.size as usize).map(|i| N::get(v, slot, i)));
            }
            let periodic = name.starts_with('p');
            let (point, period) = if periodic { x.split_at(x.len() / 2) } else { (&*x, [].as_slice()) };
            let period: Vec<Term> = period.iter().map(|x| x.value()).collect();
            let value = functions::noise(kind, point, periodic.then_some(&*period), out.size == 3);
            for (i, value) in value.into_iter().enumerate().take(out.size as usize) {
                N::put(v, out, i, value);
            }
        }
    }
}

fn on_ints(v: &mut Values<'_>, name: &str, args: &[Slot]) {
    let a = v.int(&args[1]);
    let b = if functions::int_arguments(name) == Some(2) { v.int(&args[2]) } else { a };
    let of = |what: Binary| Bits(binary(what, a.0, b.0));
    let value = match name {
        "add" => a + b,
        "sub" => a - b,
        "mul" => of(Binary::IntMul),
        "div" => of(Binary::IntDiv),
        "mod" | "fmod" => of(Binary::IntRem),
        "bitand" => a & b,
        "bitor" => a | b,
        "xor" => a ^ b,
        "shl" => Bits(binary(Binary::Up, a.0, functions::five_bits(b).0)),
        "shr" => Bits(binary(Binary::SignedDown, a.0, functions::five_bits(b).0)),
        "min" => of(Binary::IntMin),
        "max" => of(Binary::IntMax),
        "and" => {
            let both = v.truth(a.0) & v.truth(b.0);
            v.int_of(both)
        }
        "or" => {
            let either = v.truth(a.0) | v.truth(b.0);
            v.int_of(either)
        }
        "neg" => UInts::constant(a, 0) - a,
        "compl" => a ^ u32::MAX,
        _ => functions::int_abs(a),
    };
    v.set_int(&args[0], value);
}

fn equal(v: &mut Values<'_>, name: &str, args: &[Slot]) {
    let [out, a, b] = args else { return };
    let same = match (a.ty.base, b.ty.base) {
        (Base::String, _) | (_, Base::String) | (Base::Int, Base::Int) => {
            Which(binary(Binary::IntEqual, v.bits(a.at), v.bits(b.at)))
        }
        (Base::Closure, _) | (_, Base::Closure) => {
            let empty = |x: u32| binary(Binary::IntEqual, x, constant(0));
            let (a, b) = (v.bits(a.at), v.bits(b.at));
            Which(binary(Binary::IntEqual, empty(a), empty(b)))
        }
        (Base::Matrix, _) | (_, Base::Matrix) => {
            let (a, b) = (matrix(v, a), matrix(v, b));
            let pairs = a.into_iter().flatten().zip(b.into_iter().flatten());
            all(pairs.map(|(x, y)| Real::equal(x, y)))
        }
        _ => {
            let count = a.size.max(b.size) as usize;
            let list: Vec<Which> = (0..count).map(|i| Real::equal(v.float(a, i), v.float(b, i))).collect();
            all(list.into_iter())
        }
    };
    let value = v.int_of(if name == "eq" { same } else { !same });
    v.set_int(out, value);
}

fn all(list: impl Iterator<Item = Which>) -> Which {
    list.reduce(|a, b| a & b).unwrap_or(Which(constant(!0)))
}

fn ordered(v: &mut Values<'_>, name: &str, args: &[Slot]) {
    let [out, a, b] = args else { return };
    let value = if a.ty == Type::INT && b.ty == Type::INT {
        let (a, b) = (v.bits(a.at), v.bits(b.at));
        let greater = |a, b| Which(binary(Binary::IntGreater, a, b));
        match name {
            "lt" => greater(b, a),
            "gt" => greater(a, b),
            "le" => !greater(a, b),
            _ => !greater(b, a),
        }
    } else {
        let count = a.size.max(b.size) as usize;
        let list: Vec<Which> = (0..count)
            .map(|i| {
                let (a, b) = (v.float(a, i), v.float(b, i));
                match name {
                    "lt" => a.less(b),
                    "gt" => b.less(a),
                    "le" => a.at_most(b),
                    _ => b.at_most(a),
                }
            })
            .collect();
        all(list.into_iter())
    };
    let value = v.int_of(value);
    v.set_int(out, value);
}

fn finite(v: &mut Values<'_>, name: &str, args: &[Slot]) {
    let x = v.float(&args[1], 0);
    let value = match name {
        "isnan" => !Real::equal(x, x),
        "isinf" => Real::equal(Real::abs(x), x.of(f32::INFINITY)),
        _ => Real::abs(x).at_most(x.of(f32::MAX)),
    };
    let value = v.int_of(value);
    v.set_int(&args[0], value);
}

/// As many elements as both have.
fn copy(v: &mut Values<'_>, out: &Slot, a: &Slot) {
    let floats = |slot: &Slot| slot.ty.base.is_float_based();
    for i in 0..out.size.min(a.size) as usize {
        if floats(out) && (floats(a) || a.ty.base == Base::Int) {
            let value = D::get(v, a, if a.size == 1 { 0 } else { i });
            D::put(v, out, i, value);
        } else {
            let bits_id = v.bits(a.at + i as u32);
            v.set_bits(out, i as u32, bits_id);
        }
    }
}

fn copy_part(v: &mut Values<'_>, out: &Slot, at: usize, from: &Slot, start: usize, count: usize) {
    for i in 0..count {
        if from.ty.base.is_float_based() || out.ty.base.is_float_based() {
            let value = D::get(v, from, start + i);
            D::put(v, out, at + i, value);
        } else {
            let bits_id = v.bits(from.at + (start + i) as u32);
            v.set_bits(out, (at + i) as u32, bits_id);
        }
    }
}

/// Elements of arrays, components of triples and matrices.
fn parts(v: &mut Values<'_>, step: &Step, at: usize) {
    let args = &step.args;
    match &*step.name {
        "aref" => {
            let count = (args[1].one as usize).min(args[0].size as usize);
            copy_part(v, &args[0], 0, &args[1], at, count);
        }
        "aassign" if args[0].ty.base == Base::Int => {
            let value = v.int(&args[2]);
            v.set_bits(&args[0], at as u32, value.0);
        }
        "aassign" => copy_part(v, &args[0], at, &args[2], 0, args[0].one as usize),
        "compref" => {
            let value = D::get(v, &args[1], at);
            D::put(v, &args[0], 0, value);
        }
        "compassign" => {
            let value = D::get(v, &args[2], 0);
            D::put(v, &args[0], at, value);
        }
        "mxcompref" => {
            let value = v.float(&args[1], at);
            D::put(v, &args[0], 0, D::lift(value));
        }
        _ => {
            let value = v.float(&args[3], 0);
            D::put(v, &args[0], at, D::lift(value));
        }
    }
}

fn changes(v: &mut Values<'_>, name: &str, args: &[Slot]) {
    let [out, a] = args else { return };
    for i in 0..out.size as usize {
        let value = v.dual(a, i);
        let change = match name {
            "Dx" => value.dx,
            "Dy" => value.dy,
            "Dz" => Term::constant(0.0),
            _ => math::filterwidth(value.dx, value.dy),
        };
        D::put(v, out, i, D::lift(change));
    }
}

fn slopes(v: &mut Values<'_>, slot: &Slot) -> [[Term; 3]; 2] {
    let value = triple::<D>(v, slot);
    [value.map(|d| d.dx), value.map(|d| d.dy)]
}

fn hash(v: &mut Values<'_>, args: &[Slot]) {
    let rest = &args[1..];
    let value = if rest.len() == 1 && rest[0].ty.base == Base::Int {
        functions::hash(&[Bits(v.bits(rest[0].at))])
    } else {
        let mut cell_values: Vec<Bits> = Vec::new();
        for slot in rest {
            cell_values.extend((0..slot.size as usize).map(|i| v.float(slot, i).known_bits()));
        }
        functions::hash(&cell_values)
    };
    v.set_int(&args[0], value);
}

fn matrices(v: &mut Values<'_>, name: &str, args: &[Slot]) {
    let (out, rest) = (&args[0], &args[1..]);
    let scaled = |m: [[Term; 4]; 4], by: Term| m.map(|row| row.map(|x| x * by));
    if name == "neg" {
        let m = matrix(v, &rest[0]).map(|row| row.map(|x| -x));
        set_matrix(v, out, m);
        return;
    }
    let (a, b) = (&rest[0], &rest[1]);
    let (whole_a, whole_b) = (a.ty == Type::MATRIX, b.ty == Type::MATRIX);
    let value = match name {
        "mul" if whole_a && whole_b => {
            let (a, b) = (matrix(v, a), matrix(v, b));
            a.map(|row| {
                [0, 1, 2, 3]
                    .map(|k: usize| row[0] * b[0][k] + row[1] * b[1][k] + row[2] * b[2][k] + row[3] * b[3][k])
            })
        }
        "mul" if whole_a => scaled(matrix(v, a), v.float(b, 0)),
        "mul" => scaled(matrix(v, b), v.float(a, 0)),
        "div" => {
            let by = v.float(b, 0);
            let zero = by.of(0.0);
            let inverse = Term::choose(Real::equal(by, zero), zero, by.of(1.0) / by);
            scaled(matrix(v, a), inverse)
        }
        _ => {
            let (a, b) = (matrix(v, a), matrix(v, b));
            let sign = if name == "sub" { -1.0 } else { 1.0 };
            let sum = |r: usize, c: usize| a[r][c] + Term::constant(sign) * b[r][c];
            [0, 1, 2, 3].map(|r| [0, 1, 2, 3].map(|c| sum(r, c)))
        }
    };
    set_matrix(v, out, value);
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Operators that are not the same for each component: ints, comparisons, matrices.
//! Nothing traps: a division by zero is zero.

use super::machine::{Action, Machine, Step};
use crate::types::{Base, Type};
use gnurt_sl_lib::{math, matrix as mx};

/// Operations on ints.
pub(super) fn ints(name: &str) -> Option<Action> {
    Some(Action::Whole(match name {
        "add" | "sub" | "mul" | "div" | "mod" | "fmod" | "bitand" | "bitor" | "xor" | "shl" | "shr"
        | "min" | "max" => two,
        "neg" | "compl" | "abs" | "fabs" => one,
        "and" | "or" => two,
        _ => return None,
    }))
}

fn two(m: &mut Machine<'_>, s: &Step) {
    let [out, a, b, ..] = &*s.args else { return };
    let (a, b) = (m.int(a), m.int(b));
    let value = match &*s.name {
        "add" => a.wrapping_add(b),
        "sub" => a.wrapping_sub(b),
        "mul" => a.wrapping_mul(b),
        "div" => math::div_int(a, b),
        "mod" | "fmod" => math::rem_int(a, b),
        "bitand" => a & b,
        "bitor" => a | b,
        "xor" => a ^ b,
        "shl" => a.wrapping_shl(b as u32),
        "shr" => a.wrapping_shr(b as u32),
        "min" => a.min(b),
        "max" => a.max(b),
        "and" => i32::from(a != 0 && b != 0),
        _ => i32::from(a != 0 || b != 0),
    };
    m.set_int(out, value);
}

fn one(m: &mut Machine<'_>, s: &Step) {
    let [out, a, ..] = &*s.args else { return };
    let a = m.int(a);
    let value = match &*s.name {
        "neg" => a.wrapping_neg(),
        "compl" => !a,
        _ => math::abs_int(a),
    };
    m.set_int(out, value);
}

pub(super) fn equal(m: &mut Machine<'_>, s: &Step) {
    let [out, a, b, ..] = &*s.args else { return };
    let same = match (a.ty.base, b.ty.base) {
        (Base::String, _) | (_, Base::String) | (Base::Int, Base::Int) => {
            m.cell_bits(a, 0) == m.cell_bits(b, 0)
        }
        (Base::Closure, _) | (_, Base::Closure) => (m.cell_bits(a, 0) == 0) == (m.cell_bits(b, 0) == 0),
        (Base::Matrix, _) | (_, Base::Matrix) => m.matrix(a) == m.matrix(b),
        _ => (0..a.size.max(b.size) as usize).all(|i| m.float(a, i) == m.float(b, i)),
    };
    m.set_int(out, i32::from(same == (&*s.name == "eq")));
}

pub(super) fn ordered(m: &mut Machine<'_>, s: &Step) {
    let [out, a, b, ..] = &*s.args else { return };
    fn holds<T: PartialOrd>(name: &str, a: T, b: T) -> bool {
        match name {
            "lt" => a < b,
            "gt" => a > b,
            "le" => a <= b,
            _ => a >= b,
        }
    }
    let value = if a.ty == Type::INT && b.ty == Type::INT {
        holds(&s.name, m.int(a), m.int(b))
    } else {
        (0..a.size.max(b.size) as usize).all(|i| holds(&s.name, m.float(a, i), m.float(b, i)))
    };
    m.set_int(out, i32::from(value));
}

pub(super) fn finite(m: &mut Machine<'_>, s: &Step) {
    let [out, a, ..] = &*s.args else { return };
    let x = m.float(a, 0);
    let value = match &*s.name {
        "isnan" => x.is_nan(),
        "isinf" => x.is_infinite(),
        _ => x.is_finite(),
    };
    m.set_int(out, i32::from(value));
}

pub(super) fn matrix(m: &mut Machine<'_>, s: &Step) {
    let [out, a, rest @ ..] = &*s.args else { return };
    let Some(b) = rest.first() else {
        let value = m.matrix(a).map(|row| row.map(|x| -x));
        m.set_matrix(out, &value);
        return;
    };
    let (whole_a, whole_b) = (a.ty == Type::MATRIX, b.ty == Type::MATRIX);
    let value = match &*s.name {
        "mul" if whole_a && whole_b => mx::multiply(&m.matrix(a), &m.matrix(b)),
        "mul" if whole_a => mx::scale(&m.matrix(a), m.float(b, 0)),
        "mul" => mx::scale(&m.matrix(b), m.float(a, 0)),
        "div" if whole_a && whole_b => mx::divide(&m.matrix(a), &m.matrix(b)),
        "div" if whole_a => {
            let by = m.float(b, 0);
            mx::scale(&m.matrix(a), if by == 0.0 { 0.0 } else { 1.0 / by })
        }
        "div" => mx::scale(&mx::inverse(&m.matrix(b)), m.float(a, 0)),
        name => {
            let (a, b) = (m.matrix(a), m.matrix(b));
            let sign = if name == "sub" { -1.0 } else { 1.0 };
            std::array::from_fn(|r| std::array::from_fn(|c| a[r][c] + sign * b[r][c]))
        }
    };
    m.set_matrix(out, &value);
}

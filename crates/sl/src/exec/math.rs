// SPDX-License-Identifier: GPL-3.0-or-later
//! Inverses, normals and splines: arguments to the library and back.

use super::machine::{D, Machine, Step};
use super::slot::Slot;
use crate::hir::Data;
use crate::types::Type;
use gnurt_sl_lib::math::vectors;
use gnurt_sl_lib::spline as curve;
use gnurt_sl_lib::{Dual, matrix as mx};

/// A matrix or a number over a matrix.
pub(super) fn divide(m: &mut Machine<'_>, s: &Step) {
    let [out, a, b, ..] = &*s.args else { return };
    let value = if a.ty == Type::MATRIX {
        mx::divide(&m.matrix(a), &m.matrix(b))
    } else {
        mx::scale(&mx::inverse(&m.matrix(b)), m.float(a, 0))
    };
    m.set_matrix(out, &value);
}

/// The same of known values.
pub(super) fn quotient(a: &Data, b: &Data) -> Option<Data> {
    let matrix = |data: &Data| match data {
        Data::Float(list) if list.len() == 16 => {
            Some([0, 4, 8, 12].map(|i| [0, 1, 2, 3].map(|k| list[i + k])))
        }
        _ => None,
    };
    let by = matrix(b)?;
    let value = match (matrix(a), a) {
        (Some(a), _) => mx::divide(&a, &by),
        (None, Data::Float(list)) => mx::scale(&mx::inverse(&by), *list.first()?),
        (None, Data::Int(list)) => mx::scale(&mx::inverse(&by), *list.first()? as f32),
        _ => return None,
    };
    Some(Data::Float(value.as_flattened().to_vec()))
}

pub(super) fn determinant(m: &mut Machine<'_>, s: &Step) {
    let value = mx::determinant(&m.matrix(&s.args[1]));
    m.set(&s.args[0], 0, value.into());
}

pub(super) fn calculatenormal(m: &mut Machine<'_>, s: &Step) {
    let value = m.triple(&s.args[1]);
    let (dx, dy) = (value.map(|d| d.dx), value.map(|d| d.dy));
    let value = vectors::calculatenormal(dx, dy, m.point.flipped);
    m.set_triple(&s.args[0], Dual::from(value).components());
}

/// The knots of one component.
fn knots(m: &Machine<'_>, slot: &Slot, component: usize, count: usize) -> Vec<D> {
    let one = slot.one as usize;
    (0..count).map(|k| m.dual(slot, k * one + component)).collect()
}

/// Name, position and knots of a spline; the knots' number may precede them.
fn parts<'s>(m: &Machine<'_>, s: &'s Step) -> Option<(curve::Basis, D, &'s Slot, usize)> {
    let basis = curve::Basis::named(&m.text(&s.args[1]));
    let x = m.dual(&s.args[2], 0);
    let list = s.args.last()?;
    let all = list.ty.elements();
    let count = match s.args.len() {
        5 => usize::try_from(m.int(&s.args[3])).unwrap_or(0).min(all),
        _ => all,
    };
    Some((basis, x, list, count))
}

pub(super) fn spline(m: &mut Machine<'_>, s: &Step) {
    let out = s.args[0];
    let Some((basis, x, list, count)) = parts(m, s) else { return };
    let values: Vec<D> = (0..out.size as usize)
        .map(|i| curve::spline(basis, x, &*knots(m, list, i.min(list.one as usize - 1), count)))
        .collect();
    for (i, value) in values.into_iter().enumerate() {
        m.set(&out, i, value);
    }
}

pub(super) fn splineinverse(m: &mut Machine<'_>, s: &Step) {
    let Some((basis, y, list, count)) = parts(m, s) else { return };
    let knots: Vec<f32> = knots(m, list, 0, count).into_iter().map(|k| k.value).collect();
    let value = curve::splineinverse(basis, y, &knots);
    m.set(&s.args[0], 0, value);
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Assignments, which convert as well.
//! Conversions are OSL's.

use super::machine::{Machine, Step};
use super::slot::Slot;
use crate::types::{Base, Type};

pub(super) fn assign(m: &mut Machine<'_>, s: &Step) {
    let [out, a, ..] = &*s.args else { return };
    if out.ty.is_array() || a.ty.is_array() {
        copy(m, out, a);
        return;
    }
    match (out.ty.base, a.ty.base) {
        (Base::String, _) => {
            let number = if a.ty == Type::STRING { m.cell_bits(a, 0) } else { 0 };
            m.set_bits(out, 0, number);
        }
        (Base::Closure, base) => {
            let number = if base == Base::Closure { m.cell_bits(a, 0) } else { 0 };
            m.set_bits(out, 0, number);
        }
        (Base::Int, _) => {
            let value = m.int(a);
            m.set_bits(out, 0, value as u32);
        }
        (Base::Matrix, _) => {
            let value = m.matrix(a);
            m.set_matrix(out, &value);
        }
        _ => {
            // All parts are read before the first is written: `out` may be `a`.
            let mut values = [gnurt_sl_lib::Dual::from(0.0); 3];
            let size = (out.size as usize).min(3);
            for (i, value) in values.iter_mut().enumerate().take(size) {
                *value = m.dual(a, i);
            }
            for (i, value) in values.into_iter().enumerate().take(size) {
                m.set(out, i, value);
            }
        }
    }
}

pub(super) fn array(m: &mut Machine<'_>, s: &Step) {
    let [out, a, ..] = &*s.args else { return };
    copy(m, out, a);
}

/// As many elements as both have.
fn copy(m: &mut Machine<'_>, out: &Slot, a: &Slot) {
    let count = out.size.min(a.size) as usize;
    let floats = |slot: &Slot| slot.ty.base.is_float_based();
    for i in 0..count {
        if floats(out) && (floats(a) || a.ty.base == Base::Int) {
            let value = if a.size == 1 { m.dual(a, 0) } else { m.dual(a, i) };
            m.set(out, i, value);
        } else {
            let cell_bits = m.cell_bits(a, i);
            m.set_bits(out, i, cell_bits);
        }
    }
}

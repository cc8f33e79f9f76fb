// SPDX-License-Identifier: GPL-3.0-or-later
//! Numbers of a batch's points, with their changes, out of cells and back.
//! Tests: crates/jit/tests/batches.rs.

use super::cells::{Batch, Cells, DualRow, LANES, Row};
use super::slot::Slot;
use crate::types::Base;

/// Number `i` of a slot. Single numbers serve for all components.
pub(super) fn dual(batch: &dyn Batch, slot: &Slot, i: u32) -> DualRow {
    let mut out = DualRow::default();
    let i = if slot.size == 1 { 0 } else { i };
    fill(&mut out.value, batch, slot, i);
    if slot.derivs {
        fill(&mut out.dx, batch, slot, slot.size + i);
        fill(&mut out.dy, batch, slot, 2 * slot.size + i);
    }
    out
}

/// The contents at this offset from the first cell of a slot.
fn fill(row: &mut Row, batch: &dyn Batch, slot: &Slot, offset: u32) {
    let number = |cell_bits: u32| {
        if slot.ty.base == Base::Int { cell_bits as i32 as f32 } else { f32::from_bits(cell_bits) }
    };
    match batch.get(slot.at + offset) {
        Cells::One(cell_bits) => *row = [number(cell_bits); LANES],
        Cells::Each(cells_bits) => {
            for (x, &cell_bits) in row.iter_mut().zip(cells_bits) {
                *x = number(cell_bits);
            }
        }
    }
}

/// Writes number `i` of a slot of floats for some points.
pub(super) fn put(batch: &mut dyn Batch, lanes: u32, (slot, i): (&Slot, u32), value: &DualRow) {
    for (k, row) in [&value.value, &value.dx, &value.dy].into_iter().enumerate() {
        if k == 0 || slot.derivs {
            let mut cells_bits = [0; LANES];
            cells_bits.iter_mut().zip(row).for_each(|(cell_bits, x)| *cell_bits = x.to_bits());
            batch.put(slot.at + k as u32 * slot.size + i, lanes, &cells_bits);
        }
    }
}

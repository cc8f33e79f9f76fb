// SPDX-License-Identifier: GPL-3.0-or-later
//! Numbers of a batch's points, with their changes, out of cells and back.
//! Tests: crates/jit/tests/batches.rs.

use super::cells::{Batch, Cells, DualRow, LANES, Row, mapped};
use super::slot::Slot;
use crate::types::Base;

/// Number `i` of a slot. Single numbers serve for all components.
pub(super) fn dual(batch: &dyn Batch, slot: &Slot, i: u32) -> DualRow {
    let mut out = DualRow::default();
    read(&mut out, batch, slot, i);
    out
}

/// The same, into zeros.
fn read(out: &mut DualRow, batch: &dyn Batch, slot: &Slot, i: u32) {
    let i = if slot.size == 1 { 0 } else { i };
    fill(&mut out.value, batch, slot, i);
    if slot.derivs {
        fill(&mut out.dx, batch, slot, slot.size + i);
        fill(&mut out.dy, batch, slot, 2 * slot.size + i);
    }
}

/// Number `i` of the slot and index that `of(i)` names.
pub(super) fn triple<'s>(batch: &dyn Batch, of: impl Fn(usize) -> (&'s Slot, u32)) -> [DualRow; 3] {
    let mut out = <[DualRow; 3]>::default();
    for (i, row) in out.iter_mut().enumerate() {
        let (slot, index) = of(i);
        read(row, batch, slot, index);
    }
    out
}

/// The contents at this offset from the first cell of a slot.
fn fill(row: &mut Row, batch: &dyn Batch, slot: &Slot, offset: u32) {
    let is_int = slot.ty.base == Base::Int;
    let number = |cell_bits: u32| if is_int { cell_bits as i32 as f32 } else { f32::from_bits(cell_bits) };
    match batch.get(slot.at + offset) {
        Cells::One(cell_bits) => *row = [number(cell_bits); LANES],
        Cells::Each(cells_bits) if is_int => *row = mapped(cells_bits, |cell_bits| cell_bits as i32 as f32),
        Cells::Each(cells_bits) => *row = mapped(cells_bits, f32::from_bits),
    }
}

/// Writes number `i` of a slot of floats for some points.
pub(super) fn put(batch: &mut dyn Batch, lanes: u32, (slot, i): (&Slot, u32), value: &DualRow) {
    for (k, row) in [&value.value, &value.dx, &value.dy].into_iter().enumerate() {
        if k == 0 || slot.derivs {
            batch.put(slot.at + k as u32 * slot.size + i, lanes, &mapped(row, f32::to_bits));
        }
    }
}

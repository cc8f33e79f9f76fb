// SPDX-License-Identifier: GPL-3.0-or-later
//! Numbers of a batch's points, with their changes, out of cells and back.
//! Tests: crates/jit/tests/batches.rs.

use super::cells::{Batch, Cells, DualRow, LANES, Row};
use super::slot::Slot;
use crate::types::Base;

/// Number `i` of a slot. Single numbers stand for all components.
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

/// What lies so far behind the first cell of a slot.
fn fill(row: &mut Row, batch: &dyn Batch, slot: &Slot, offset: u32) {
    let number =
        |word: u32| if slot.ty.base == Base::Int { word as i32 as f32 } else { f32::from_bits(word) };
    match batch.get(slot.at + offset) {
        Cells::One(word) => *row = [number(word); LANES],
        Cells::Each(words) => {
            for (x, &word) in row.iter_mut().zip(words) {
                *x = number(word);
            }
        }
    }
}

/// Writes number `i` of a slot of floats for some points.
pub(super) fn put(batch: &mut dyn Batch, lanes: u32, (slot, i): (&Slot, u32), value: &DualRow) {
    for (k, row) in [&value.value, &value.dx, &value.dy].into_iter().enumerate() {
        if k == 0 || slot.derivs {
            let mut words = [0; LANES];
            words.iter_mut().zip(row).for_each(|(word, x)| *word = x.to_bits());
            batch.put(slot.at + k as u32 * slot.size + i, lanes, &words);
        }
    }
}

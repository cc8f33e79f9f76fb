// SPDX-License-Identifier: GPL-3.0-or-later
//! The interpreter as a [`Program`]: the points of a batch, one after the other.
//! Source: original. Proof: `tests/batch.rs`.

use super::batch::{LANES, Points, Program, Results, Row};
use super::host::Host;
use super::machine::{Machine, Memory, Plan};
use super::slot::Kept;
use crate::types::Base;

impl Program for Plan {
    fn run(&self, host: &dyn Host, points: &Points, out: &mut Results) {
        out.closures.clear();
        out.events.clear();
        out.ci = [0; LANES];
        let rows = self.kept.last().map_or(0, |kept| kept.row + kept.ty.size());
        out.rows.clear();
        out.rows.resize(rows, [0.0; LANES]);
        if self.is_left_out() {
            return;
        }
        let memory = self.memories.lock().ok().and_then(|mut list| list.pop());
        let mut machine = Machine::within(self, host, memory.unwrap_or_else(|| Memory::new(self)));
        machine.closures = std::mem::take(&mut out.closures);
        for lane in 0..points.count.min(LANES) {
            machine.run_beside(&points.point(lane));
            out.ci[lane] = machine.ci();
            for kept in &self.kept {
                machine.keep(kept, lane, &mut out.rows);
            }
            if machine.was_stopped()
                && let Some(event) = self.strike()
            {
                machine.events.push(event);
            }
            out.events.extend(machine.events.drain(..).map(|event| (lane, event)));
        }
        out.closures = std::mem::take(&mut machine.closures);
        let memory = machine.into_memory();
        if let Ok(mut list) = self.memories.lock() {
            list.push(memory);
        }
    }

    fn kept(&self) -> &[Kept] {
        &self.kept
    }
}

impl Machine<'_> {
    fn keep(&self, kept: &Kept, lane: usize, rows: &mut [Row]) {
        let Some(slot) = self.plan.slot_of(&kept.name) else { return };
        for k in 0..kept.ty.size() {
            let word = self.memory[slot.at as usize + k];
            rows[kept.row + k][lane] =
                if slot.ty.base == Base::Int { word as i32 as f32 } else { f32::from_bits(word) };
        }
    }
}

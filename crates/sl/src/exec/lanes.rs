// SPDX-License-Identifier: GPL-3.0-or-later
//! The interpreter as a [`Program`]: the points of a batch, one after the other.
//! Tests: `tests/meaning/more.rs`.

use super::batch::{Points, Program, Results};
use super::cells::{LANES, Row};
use super::host::{Host, Point};
use super::machine::{Machine, Plan};
use super::slot::{RetainedOutput, Slot};
use crate::format::general;
use crate::hir::Data;
use crate::ir::{SymbolKind, uses};
use crate::types::{Base, Type};

impl Program for Plan {
    fn run(&self, host: &dyn Host, points: &Points, out: &mut Results) {
        out.closures.clear();
        out.events.clear();
        out.ci = [0; LANES];
        let rows = self.retained.last().map_or(0, |retained| retained.row + retained.ty.size());
        out.rows.clear();
        out.rows.resize(rows, [0.0; LANES]);
        if self.is_left_out() {
            return;
        }
        let mut machine = Machine::within(self, host, self.lend());
        machine.closures = std::mem::take(&mut out.closures);
        for lane in 0..points.count.min(LANES) {
            machine.run_neighbours(&points.point(lane));
            out.ci[lane] = machine.ci();
            for (retained, slot) in self.retained.iter().zip(&self.retained_slots) {
                machine.keep(retained, slot, lane, &mut out.rows);
            }
            if machine.was_stopped()
                && let Some(event) = self.strike()
            {
                machine.events.push(event);
            }
            out.events.extend(machine.events.drain(..).map(|event| (lane, event)));
        }
        out.closures = std::mem::take(&mut machine.closures);
        self.take_back(machine.into_memory());
    }

    fn retained(&self) -> &[RetainedOutput] {
        &self.retained
    }

    fn describe_point(&self, host: &dyn Host, point: &Point) -> Vec<String> {
        let mut machine = Machine::new(self, host);
        machine.run(point);
        let mut lines = Vec::new();
        for (number, layer) in self.layers.iter().enumerate() {
            if !machine.done[number] {
                lines.push(format!("{} is not asked for", layer.name));
                continue;
            }
            // Symbols removed by a pass, and outputs that are not needed, have no value.
            let mut is_used = vec![false; layer.shader.symbols.len()];
            uses(&layer.shader.code, &mut |id, _| is_used[id as usize] = true);
            for (symbol, is_used) in layer.shader.symbols.iter().zip(is_used) {
                let is_made = matches!(symbol.kind, SymbolKind::OutputParam | SymbolKind::Local);
                let is_named = symbol.kind == SymbolKind::Param || is_used && is_made;
                if !is_named || symbol.ty.struct_id().is_some() {
                    continue;
                }
                // `___3_name` is a name of an inner block.
                let plain =
                    symbol.name.trim_start_matches('_').trim_start_matches(|c: char| c.is_ascii_digit());
                let plain =
                    if symbol.name.starts_with("___") { plain.trim_start_matches('_') } else { &symbol.name };
                if symbol.name.starts_with("___") && plain.is_empty() {
                    continue;
                }
                let Some((ty, data)) = machine.output(Some(number), &symbol.name) else { continue };
                lines.push(format!("{}.{plain} = {}", layer.name, machine.text_of(ty, &data)));
            }
        }
        lines.push(format!("Ci = {}", machine.closure_text(machine.ci()).replace("\n\t", " ")));
        lines
    }
}

impl Machine<'_> {
    fn text_of(&self, ty: Type, data: &Data) -> String {
        let mut cells_bits: Vec<String> = match data {
            Data::Int(list) if ty.base == Base::Closure => {
                list.iter().map(|&n| self.closure_text(n as u32).replace("\n\t", " ")).collect()
            }
            Data::Int(list) => list.iter().map(ToString::to_string).collect(),
            Data::Float(list) => list.iter().map(|&x| general(f64::from(x), 6)).collect(),
            Data::Str(list) => list.iter().map(|text| format!("\"{text}\"")).collect(),
        };
        if cells_bits.len() > 32 {
            let left = cells_bits.len() - 32;
            cells_bits.truncate(32);
            cells_bits.push(format!("and {left} more"));
        }
        cells_bits.join(" ")
    }
}

impl Machine<'_> {
    fn keep(&self, retained: &RetainedOutput, slot: &Slot, lane: usize, rows: &mut [Row]) {
        for k in 0..retained.ty.size() {
            let cell_bits = self.memory[slot.at as usize + k];
            rows[retained.row + k][lane] =
                if slot.ty.base == Base::Int { cell_bits as i32 as f32 } else { f32::from_bits(cell_bits) };
        }
    }
}

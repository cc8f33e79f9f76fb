// SPDX-License-Identifier: GPL-3.0-or-later
//! How values are read and written.

use super::host::Given;
use super::known::data;
use super::machine::{D, Event, Machine, Step};
use super::slot::Slot;
use crate::hir::Data;
use crate::ir::SourcePosition;
use crate::types::Base;
use gnurt_sl_lib::Dual;
use std::sync::Arc;

/// Bytes of output that a point may report, the rest of its line counted.
const MOST_OUTPUT: usize = 16 << 20;

impl Machine<'_> {
    /// Word `i` of a slot; 0 beyond its end, for files may give operations symbols of any types.
    #[inline(always)]
    pub(super) fn cell_bits(&self, slot: &Slot, i: usize) -> u32 {
        if i < slot.size as usize { self.memory[slot.at as usize + i] } else { 0 }
    }

    /// Puts it; nothing is written beyond the slot's end.
    pub(super) fn set_bits(&mut self, slot: &Slot, i: usize, cell_bits: u32) {
        if i < slot.size as usize {
            self.memory[slot.at as usize + i] = cell_bits;
        }
    }

    pub(super) fn int(&self, slot: &Slot) -> i32 {
        match slot.ty.base {
            Base::Int => self.cell_bits(slot, 0) as i32,
            _ => f32::from_bits(self.cell_bits(slot, 0)) as i32,
        }
    }

    pub(super) fn set_int(&mut self, slot: &Slot, value: i32) {
        match slot.ty.base {
            Base::Int => self.set_bits(slot, 0, value as u32),
            _ => self.set(slot, 0, (value as f32).into()),
        }
    }

    /// The text in a slot.
    pub(super) fn text(&self, slot: &Slot) -> Arc<str> {
        self.text_at(slot, 0)
    }

    pub(super) fn text_at(&self, slot: &Slot, i: usize) -> Arc<str> {
        if slot.ty.base == Base::String {
            self.strings.text(self.cell_bits(slot, i)).clone()
        } else {
            "".into()
        }
    }

    pub(super) fn set_text(&mut self, slot: &Slot, i: usize, text: &str) {
        let number = self.strings.number(text);
        self.set_bits(slot, i, number);
    }

    /// Number `i` of a slot as a float. Single numbers serve for all components.
    #[inline(always)]
    pub(super) fn float(&self, slot: &Slot, i: usize) -> f32 {
        let i = if slot.size == 1 { 0 } else { i };
        let cell_bits = self.cell_bits(slot, i);
        if slot.ty.base == Base::Int { cell_bits as i32 as f32 } else { f32::from_bits(cell_bits) }
    }

    /// The same with its derivatives.
    #[inline(always)]
    pub(super) fn dual(&self, slot: &Slot, i: usize) -> D {
        let value = self.float(slot, i);
        if !slot.derivs {
            return value.into();
        }
        let i = if slot.size == 1 { 0 } else { i };
        let size = slot.size as usize;
        if i >= size {
            return value.into();
        }
        let part = |k: usize| f32::from_bits(self.memory[slot.at as usize + k * size + i]);
        Dual::new(value, part(1), part(2))
    }

    /// Puts a number and its derivatives.
    #[inline(always)]
    pub(super) fn set(&mut self, slot: &Slot, i: usize, value: D) {
        let (at, size) = (slot.at as usize + i, slot.size as usize);
        if i >= size {
            return;
        }
        if slot.ty.base == Base::Int {
            self.memory[at] = value.value as i32 as u32;
            return;
        }
        self.memory[at] = value.value.to_bits();
        if slot.derivs {
            self.memory[at + size] = value.dx.to_bits();
            self.memory[at + 2 * size] = value.dy.to_bits();
        }
    }

    /// Three numbers with derivatives.
    pub(super) fn triple(&self, slot: &Slot) -> [D; 3] {
        [self.dual(slot, 0), self.dual(slot, 1), self.dual(slot, 2)]
    }

    pub(super) fn set_triple(&mut self, slot: &Slot, value: [D; 3]) {
        for (i, v) in value.into_iter().enumerate() {
            self.set(slot, i, v);
        }
    }

    /// Three numbers.
    pub(super) fn triple_value(&self, slot: &Slot) -> [f32; 3] {
        [self.float(slot, 0), self.float(slot, 1), self.float(slot, 2)]
    }

    pub(super) fn matrix(&self, slot: &Slot) -> [[f32; 4]; 4] {
        std::array::from_fn(|r| {
            std::array::from_fn(|c| match slot.size {
                1 if r != c => 0.0,
                _ => self.float(slot, r * 4 + c),
            })
        })
    }

    pub(super) fn set_matrix(&mut self, slot: &Slot, m: &[[f32; 4]; 4]) {
        for (i, &value) in m.iter().flatten().enumerate() {
            self.set(slot, i, value.into());
        }
    }

    /// The value of a slot by itself.
    pub(super) fn data(&self, slot: &Slot) -> Data {
        data(&self.memory, slot, &self.strings)
    }

    /// Stores a value from outside, as much of it as fits.
    pub(super) fn give(&mut self, slot: &Slot, given: &Given) {
        let size = slot.size as usize;
        match &given.value {
            Data::Int(list) => {
                for (i, &v) in list.iter().take(size).enumerate() {
                    if slot.ty.base == Base::Int {
                        self.set_bits(slot, i, v as u32)
                    } else {
                        self.set(slot, i, (v as f32).into())
                    }
                }
            }
            Data::Float(list) => {
                for (i, &v) in list.iter().take(size).enumerate() {
                    let part = |k: usize| given.derivs[k].get(i).copied().unwrap_or(0.0);
                    self.set(slot, i, Dual::new(v, part(0), part(1)));
                }
            }
            Data::Str(list) => {
                for (i, v) in list.iter().take(size).enumerate() {
                    self.set_text(slot, i, v);
                }
            }
        }
    }

    /// The names of the layer that runs, and of its shader.
    pub(super) fn layer_names(&self) -> (Arc<str>, Arc<str>) {
        let layer = &self.plan.layers[self.layer];
        (layer.name.clone(), layer.shader.name.clone())
    }

    /// `file:line`
    pub(super) fn source_position(&self, at: SourcePosition) -> String {
        let shader = &self.plan.layers[self.layer].shader;
        format!("{}:{}", shader.files.get(usize::from(at.file)).map_or("", |f| f), at.line)
    }

    /// Reports a mistake whose message the host completes by its place.
    pub(super) fn located_error(&mut self, s: &Step, message: String) {
        let (layer, shader) = self.layer_names();
        let position = self.source_position(s.at);
        let place = format!("at {position} in layer \"{layer}\" (shader \"{shader}\")");
        let message = self.host.with_place(message, &place);
        self.error(message);
    }

    pub(super) fn error(&mut self, message: String) {
        self.report(Event::Error(message));
    }

    /// Records output, up to a limit, because a loop may print in each iteration.
    pub(super) fn report(&mut self, event: Event) {
        let (Event::Print(text) | Event::Error(text) | Event::Warning(text) | Event::File(_, text)) = &event;
        let before = self.reports;
        self.reports = before.saturating_add(text.len() + 64);
        if self.reports <= MOST_OUTPUT {
            self.events.push(event);
        } else if before <= MOST_OUTPUT {
            let text = format!("more than {} MiB of output: the rest is left out", MOST_OUTPUT >> 20);
            self.events.push(Event::Warning(text));
        }
    }
}

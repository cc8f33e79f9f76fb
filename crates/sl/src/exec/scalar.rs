// SPDX-License-Identifier: GPL-3.0-or-later
//! The cells of one point as [`Values`].
//! Tests: `tests/meaning.rs`.

use super::compute::{Values, compute, noise_numbers, put, transfer};
use super::machine::{Copy, D, Machine, Step};
use super::slot::Slot;
use super::strings::Strings;
use crate::types::Type;
use gnurt_sl_lib::noise::{GaborOptions, NoiseKind};
use gnurt_sl_lib::{Real, UInt};

/// What an operation has to report.
pub(super) enum Fault {
    /// An index, the operand that it is for, and the elements of that.
    Index(i32, usize, usize),
    /// A kind of noise of no known name.
    Noise,
}

/// The cells, texts by number, and faults of operations so far.
pub(super) struct Scalar<'m> {
    pub(super) cells: &'m mut [u32],
    pub(super) strings: &'m Strings,
    pub(super) faults: Vec<Fault>,
}

impl Scalar<'_> {
    fn text(&self, slot: &Slot) -> &str {
        if slot.ty.base == Type::STRING.base { self.strings.text(self.cells[slot.at as usize]) } else { "" }
    }

    fn float(&self, slot: &Slot, i: usize) -> f32 {
        let word =
            self.cells[slot.at as usize + if slot.size == 1 { 0 } else { i.min(slot.size as usize - 1) }];
        if slot.ty.base == Type::INT.base { word as i32 as f32 } else { f32::from_bits(word) }
    }

    fn options(&self, step: &Step) -> GaborOptions {
        let mut options = GaborOptions::default();
        let first = (2..step.args.len()).find(|&i| step.args[i].ty == Type::STRING);
        for pair in step.args[first.unwrap_or(step.args.len())..].chunks(2) {
            let [name, value] = pair else { break };
            if value.size == 0 {
                continue;
            }
            match self.text(name) {
                "anisotropic" => options.anisotropic = self.float(value, 0) as i32,
                "do_filter" => options.do_filter = self.float(value, 0) as i32 != 0,
                "direction" => options.direction = [0, 1, 2].map(|i| self.float(value, i)),
                "bandwidth" => options.bandwidth = self.float(value, 0),
                "impulses" => options.impulses = self.float(value, 0),
                _ => {}
            }
        }
        options
    }
}

impl Values for Scalar<'_> {
    type Real = f32;
    type Word = UInt;
    type Mask = bool;
    // Functions without changes are in `direct`; known values need no second copy of them.
    type Plain = D;

    #[inline]
    fn constant(&mut self, bits: u32) -> UInt {
        UInt(bits)
    }

    #[inline]
    fn cell(&mut self, slot: &Slot, i: u32) -> UInt {
        UInt(self.cells[(slot.at + i) as usize])
    }

    #[inline]
    fn set_cell(&mut self, slot: &Slot, i: u32, word: UInt) {
        self.cells[(slot.at + i) as usize] = word.0;
    }

    fn truth(&mut self, word: UInt) -> bool {
        word.0 != 0
    }

    fn int_of(&mut self, mask: bool) -> UInt {
        UInt(mask.into())
    }

    fn index(&mut self, step: &Step, operand: usize, of: usize, count: usize) -> Option<usize> {
        let slot = &step.args[operand];
        let word = if slot.size > 0 { self.cells[slot.at as usize] } else { 0 };
        let is_int = slot.ty.base == Type::INT.base;
        let index = if is_int { word } else { f32::from_bits(word).to_int().0 } as i32;
        if index >= 0 && (index as usize) < count {
            return Some(index as usize);
        }
        self.faults.push(Fault::Index(index, of, count));
        Some(if index < 0 { 0 } else { count.saturating_sub(1) })
    }

    fn noise_kind(&mut self, step: &Step) -> NoiseKind {
        let kind = NoiseKind::named(self.text(&step.args[1]));
        kind.unwrap_or_else(|| {
            self.faults.push(Fault::Noise);
            NoiseKind::Null
        })
    }

    fn gabor(&mut self, step: &Step) {
        let options = self.options(step);
        let Some((list, count, period)) = noise_numbers::<Self, D>(self, step) else { return };
        let (point, period) = (&list[..count], period.as_ref().map(|period| &period[..count]));
        let out = &step.args[0];
        let value = if out.size >= 3 {
            NoiseKind::Gabor.noise3(point, period, &options)
        } else {
            [NoiseKind::Gabor.noise(point, period, &options); 3]
        };
        for (i, x) in value.into_iter().enumerate().take(if out.size >= 3 { 3 } else { 1 }) {
            put(self, out, i, x);
        }
    }
}

/// Does an operation on numbers.
pub(super) fn on_numbers(m: &mut Machine<'_>, step: &Step) {
    on_cells(m, step, |v| compute(v, step));
}

/// Does something with the cells, and reports its faults.
#[inline(always)]
pub(super) fn on_cells(m: &mut Machine<'_>, step: &Step, work: impl FnOnce(&mut Scalar<'_>)) {
    let mut scalar = Scalar { cells: &mut m.memory, strings: &m.strings, faults: Vec::new() };
    work(&mut scalar);
    if !scalar.faults.is_empty() {
        let faults = scalar.faults;
        faults.iter().for_each(|fault| m.report_fault(step, fault));
    }
}

/// Fetches a value along a connection.
pub(super) fn connect(m: &mut Machine<'_>, copy: &Copy) {
    let mut scalar = Scalar { cells: &mut m.memory, strings: &m.strings, faults: Vec::new() };
    transfer(&mut scalar, copy);
}

impl Machine<'_> {
    fn report_fault(&mut self, step: &Step, fault: &Fault) {
        let source_position = self.source_position(step.at);
        let text = match *fault {
            Fault::Noise => {
                let name = self.text(&step.args[1]);
                format!("noise type \"{name}\" is unknown, called from ({source_position})")
            }
            Fault::Index(index, of, count) => {
                let (layer, shader) = self.layer_names();
                let symbol = &self.plan.layers[self.layer].shader.symbol(step.symbols[of]).name;
                let symbol = match symbol.strip_prefix("___").and_then(|rest| rest.split_once('_')) {
                    Some((_, plain)) => plain,
                    None => symbol,
                };
                let group = if self.plan.name.is_empty() { "<unnamed group>" } else { &self.plan.name };
                format!(
                    "Index [{index}] out of range {symbol}[0..{}]: {source_position} (group {group}, layer {} {layer}, shader {shader})",
                    count as i64 - 1,
                    self.layer
                )
            }
        };
        self.error(text);
    }
}

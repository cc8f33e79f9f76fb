// SPDX-License-Identifier: GPL-3.0-or-later
//! Elements of arrays and components of triples and matrices. An index that is out of range is moved into it, with a message.
//! The words are OSL's.

use super::machine::{Machine, Step};
use super::slot::Slot;
use crate::types::Base;

impl Machine<'_> {
    /// The index, moved into range.
    fn index(&mut self, s: &Step, which: usize, of: usize, count: usize) -> usize {
        let index = self.int(&s.args[which]);
        if index >= 0 && (index as usize) < count {
            return index as usize;
        }
        let (layer, shader) = self.layer_names();
        let symbol = &self.plan.layers[self.layer].shader.symbol(s.symbols[of]).name;
        let symbol = match symbol.strip_prefix("___").and_then(|rest| rest.split_once('_')) {
            Some((_, plain)) => plain,
            None => symbol,
        };
        let source_position = self.source_position(s.at);
        let group = if self.plan.name.is_empty() { "<unnamed group>" } else { &self.plan.name };
        let message = format!(
            "Index [{index}] out of range {symbol}[0..{}]: {source_position} (group {group}, layer {} {layer}, shader {shader})",
            count as i64 - 1,
            self.layer
        );
        self.error(message);
        if index < 0 { 0 } else { count.saturating_sub(1) }
    }

    fn copy_part(&mut self, out: &Slot, at: usize, from: &Slot, start: usize, count: usize) {
        for i in 0..count {
            if from.ty.base.is_float_based() || out.ty.base.is_float_based() {
                let value = self.dual(from, start + i);
                self.set(out, at + i, value);
            } else {
                let cell_bits = self.cell_bits(from, start + i);
                self.set_bits(out, at + i, cell_bits);
            }
        }
    }
}

pub(super) fn read_element(m: &mut Machine<'_>, s: &Step) {
    let [out, array, ..] = &*s.args else { return };
    let count = array.ty.elements();
    if count == 0 || s.args.len() < 3 {
        return;
    }
    let index = m.index(s, 2, 1, count);
    let one = array.one as usize;
    if array.size == 1 {
        m.copy_part(out, 0, array, 0, 1);
    } else {
        m.copy_part(out, 0, array, index * one, one.min(out.size as usize));
    }
}

pub(super) fn write_element(m: &mut Machine<'_>, s: &Step) {
    let [array, _, value] = &*s.args else { return };
    let count = array.ty.elements();
    if count == 0 {
        return;
    }
    let index = m.index(s, 1, 0, count);
    let one = array.one as usize;
    if array.ty.base == Base::Closure && value.ty.base != Base::Closure {
        m.set_bits(array, index, 0);
    } else if array.ty.base == Base::Int {
        let value = m.int(value);
        m.set_bits(array, index, value as u32);
    } else {
        m.copy_part(array, index * one, value, 0, one);
    }
}

pub(super) fn read_component(m: &mut Machine<'_>, s: &Step) {
    let [out, value, _] = &*s.args else { return };
    let index = m.index(s, 2, 1, 3);
    let value = m.dual(value, index);
    m.set(out, 0, value);
}

pub(super) fn write_component(m: &mut Machine<'_>, s: &Step) {
    let [out, _, value] = &*s.args else { return };
    let index = m.index(s, 1, 0, 3);
    let value = m.dual(value, 0);
    m.set(out, index, value);
}

pub(super) fn read_matrix(m: &mut Machine<'_>, s: &Step) {
    let [out, value, _, _] = &*s.args else { return };
    let (row, column) = (m.index(s, 2, 1, 4), m.index(s, 3, 1, 4));
    let value = m.float(value, row * 4 + column);
    m.set(out, 0, value.into());
}

pub(super) fn write_matrix(m: &mut Machine<'_>, s: &Step) {
    let [out, _, _, value] = &*s.args else { return };
    let (row, column) = (m.index(s, 1, 0, 4), m.index(s, 2, 0, 4));
    let value = m.float(value, 0);
    m.set(out, row * 4 + column, value.into());
}

pub(super) fn length(m: &mut Machine<'_>, s: &Step) {
    let [out, array] = &*s.args else { return };
    m.set_int(out, array.ty.array);
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Messages between the layers of a point.
//! Rules and words are OSL's.

use super::machine::{Machine, Message, Step};
use crate::types::{Base, Type};

/// Messages of one point.
const LIMIT: usize = 10_000;

fn cell_bits(ty: Type) -> String {
    if ty.base == Base::Closure { "closure color".to_owned() } else { ty.to_string() }
}

pub(super) fn set(m: &mut Machine<'_>, s: &Step) {
    let [name, value] = &*s.args else { return };
    let name = m.text(name);
    let source_position = m.source_position(s.at);
    if let Some(old) = m.messages.iter().find(|old| old.name == name) {
        let message = if old.cells_bits.is_some() {
            format!(
                "message \"{name}\" already exists (created here: {}) cannot set again from {source_position}",
                old.source_position
            )
        } else {
            format!(
                "message \"{name}\" was queried before being set (queried here: {}) setting it now ({source_position}) would lead to inconsistent results",
                old.source_position
            )
        };
        m.error(message);
        return;
    }
    let cells_bits = m.memory[value.at as usize..][..value.size as usize].to_vec();
    let layer = m.layer;
    if m.messages.len() < LIMIT {
        m.messages.push(Message { name, ty: value.ty, cells_bits: Some(cells_bits), layer, source_position });
    }
}

pub(super) fn get(m: &mut Machine<'_>, s: &Step) {
    let (source, name, value) = match &*s.args {
        [_, name, value] => ("".into(), m.text(name), value),
        [_, source, name, value] => (m.text(source), m.text(name), value),
        _ => return,
    };
    let out = s.args[0];
    if &*source == "trace" {
        let (hit, given) = m.host.trace_message(&name, value.ty, &m.point);
        if let Some(given) = given {
            m.give(value, &given);
        }
        m.set_int(&out, i32::from(hit));
        return;
    }
    let source_position = m.source_position(s.at);
    let layer = m.layer;
    let Some(found) = m.messages.iter().find(|old| old.name == name).cloned() else {
        if m.messages.len() < LIMIT {
            m.messages.push(Message { name, ty: value.ty, cells_bits: None, layer, source_position });
        }
        m.set_int(&out, 0);
        return;
    };
    m.set_int(&out, 0);
    if found.ty != value.ty {
        let how = if found.cells_bits.is_some() { "created" } else { "queried" };
        m.error(format!(
            "type mismatch for message \"{name}\" ({how} as {} here: {}) cannot fetch as {} from {source_position}",
            cell_bits(found.ty),
            found.source_position,
            cell_bits(value.ty)
        ));
        return;
    }
    let Some(cells_bits) = found.cells_bits else { return };
    if found.layer > layer {
        m.error(format!(
            "message \"{name}\" was set by layer #{} ({}) but is being queried by layer #{layer} ({source_position}) - messages may only be transferred from nodes that appear earlier in the shading network",
            found.layer, found.source_position
        ));
        return;
    }
    let at = value.at as usize;
    m.memory[at..at + cells_bits.len()].copy_from_slice(&cells_bits);
    if value.derivs {
        let size = value.size as usize;
        m.memory[at + size..at + 3 * size].fill(0);
    }
    m.set_int(&out, 1);
}

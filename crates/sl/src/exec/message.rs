// SPDX-License-Identifier: GPL-3.0-or-later
//! Messages between the layers of a point.
//! Rules and words are OSL's.

use super::machine::{Machine, Message, Step};
use crate::types::{Base, Type};

/// Messages of one point.
const LIMIT: usize = 10_000;

fn word(ty: Type) -> String {
    if ty.base == Base::Closure { "closure color".to_owned() } else { ty.to_string() }
}

pub(super) fn set(m: &mut Machine<'_>, s: &Step) {
    let [name, value] = &*s.args else { return };
    let name = m.text(name);
    let place = m.place(s.at);
    if let Some(old) = m.messages.iter().find(|old| old.name == name) {
        let message = if old.words.is_some() {
            format!(
                "message \"{name}\" already exists (created here: {}) cannot set again from {place}",
                old.place
            )
        } else {
            format!(
                "message \"{name}\" was queried before being set (queried here: {}) setting it now ({place}) would lead to inconsistent results",
                old.place
            )
        };
        m.error(message);
        return;
    }
    let words = m.memory[value.at as usize..][..value.size as usize].to_vec();
    let layer = m.layer;
    if m.messages.len() < LIMIT {
        m.messages.push(Message { name, ty: value.ty, words: Some(words), layer, place });
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
    let place = m.place(s.at);
    let layer = m.layer;
    let Some(found) = m.messages.iter().find(|old| old.name == name).cloned() else {
        if m.messages.len() < LIMIT {
            m.messages.push(Message { name, ty: value.ty, words: None, layer, place });
        }
        m.set_int(&out, 0);
        return;
    };
    m.set_int(&out, 0);
    if found.ty != value.ty {
        let how = if found.words.is_some() { "created" } else { "queried" };
        m.error(format!(
            "type mismatch for message \"{name}\" ({how} as {} here: {}) cannot fetch as {} from {place}",
            word(found.ty),
            found.place,
            word(value.ty)
        ));
        return;
    }
    let Some(words) = found.words else { return };
    if found.layer > layer {
        m.error(format!(
            "message \"{name}\" was set by layer #{} ({}) but is being queried by layer #{layer} ({place}) - messages may only be transferred from nodes that appear earlier in the shading network",
            found.layer, found.place
        ));
        return;
    }
    let at = value.at as usize;
    m.memory[at..at + words.len()].copy_from_slice(&words);
    if value.derivs {
        let size = value.size as usize;
        m.memory[at + size..at + 3 * size].fill(0);
    }
    m.set_int(&out, 1);
}

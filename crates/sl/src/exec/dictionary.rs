// SPDX-License-Identifier: GPL-3.0-or-later
//! Dictionaries in XML for shaders: `dict_find`, `dict_next`, `dict_value`.
//! Source: the OSL specification, "Dictionary lookups"; original. The library reads and searches; the host has the files.
//! Tests: `tests/meaning/more.rs`.

use super::host::Given;
use super::machine::{Machine, Step};
use crate::hir::Data;
use crate::types::{Base, Type};
use gnurt_sl_lib::dictionary::numbers;

/// `dict_find (dictionary or node, query)`
pub(super) fn find(m: &mut Machine<'_>, s: &Step) {
    let [out, source_position, query] = &*s.args else { return };
    let query = m.text(query);
    let found = if source_position.ty == Type::STRING {
        let (name, host) = (m.text(source_position), m.host);
        m.dictionaries.find(&name, &query, |file| host.dictionary(file))
    } else {
        let node = m.int(source_position);
        m.dictionaries.find_from(node, &query)
    };
    let node = found.unwrap_or_else(|why| {
        m.error(why.to_string());
        why.result()
    });
    m.set_int(out, node);
}

/// `dict_next (node)`
pub(super) fn next(m: &mut Machine<'_>, s: &Step) {
    let [out, node] = &*s.args else { return };
    let next = m.dictionaries.next(m.int(node));
    m.set_int(out, next);
}

/// `dict_value (node, attribute, value)`
pub(super) fn value(m: &mut Machine<'_>, s: &Step) {
    let [out, node, attribute, value] = &*s.args else { return };
    let (node, attribute) = (m.int(node), m.text(attribute));
    let Some(text) = m.dictionaries.value(node, &attribute) else {
        m.set_int(out, 0);
        return;
    };
    let data = match value.ty.base {
        Base::String => Data::Str(vec![text.into()]),
        Base::Int => {
            let mut list = vec![0; value.ty.size()];
            numbers(text, &mut list, gnurt_sl_lib::text::stoi);
            Data::Int(list)
        }
        _ => {
            let mut list = vec![0.0; value.ty.size()];
            numbers(text, &mut list, gnurt_sl_lib::text::stof);
            Data::Float(list)
        }
    };
    m.give(value, &Given::from(data));
    m.set_int(out, 1);
}

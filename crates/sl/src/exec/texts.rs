// SPDX-License-Identifier: GPL-3.0-or-later
//! Texts: arguments to the library and back.

use super::machine::{Machine, Step};
use crate::opcode::Opcode;
use gnurt_sl_lib::regex::Regex;
use gnurt_sl_lib::text as lib;

/// Longer texts are cut.
const LONGEST: usize = 1 << 20;

pub(super) fn concat(m: &mut Machine<'_>, s: &Step) {
    let mut out = String::new();
    for slot in &s.args[1..] {
        out.push_str(&m.text(slot));
    }
    let mut end = out.len().min(LONGEST);
    while !out.is_char_boundary(end) {
        end -= 1;
    }
    m.set_text(&s.args[0], 0, &out[..end]);
}

pub(super) fn strlen(m: &mut Machine<'_>, s: &Step) {
    let value = lib::strlen(&m.text(&s.args[1]));
    m.set_int(&s.args[0], value);
}

pub(super) fn getchar(m: &mut Machine<'_>, s: &Step) {
    let value = lib::getchar(&m.text(&s.args[1]), m.int(&s.args[2]));
    m.set_int(&s.args[0], value);
}

pub(super) fn startswith(m: &mut Machine<'_>, s: &Step) {
    let value = lib::startswith(&m.text(&s.args[1]), &m.text(&s.args[2]));
    m.set_int(&s.args[0], value);
}

pub(super) fn endswith(m: &mut Machine<'_>, s: &Step) {
    let value = lib::endswith(&m.text(&s.args[1]), &m.text(&s.args[2]));
    m.set_int(&s.args[0], value);
}

pub(super) fn substr(m: &mut Machine<'_>, s: &Step) {
    let length = s.args.get(3).map_or(i32::MAX, |a| m.int(a));
    let value = lib::substr(&m.text(&s.args[1]), m.int(&s.args[2]), length);
    m.set_text(&s.args[0], 0, &value);
}

pub(super) fn stoi(m: &mut Machine<'_>, s: &Step) {
    let value = lib::stoi(&m.text(&s.args[1]));
    m.set_int(&s.args[0], value);
}

pub(super) fn stof(m: &mut Machine<'_>, s: &Step) {
    let value = lib::stof(&m.text(&s.args[1]));
    m.set(&s.args[0], 0, value.into());
}

pub(super) fn split(m: &mut Machine<'_>, s: &Step) {
    let [count, text, results, rest @ ..] = &*s.args else { return };
    let text = m.text(text);
    let separator = rest.first().map_or("".into(), |a| m.text(a));
    let capacity = results.ty.elements();
    let most = rest.get(1).map_or(capacity, |a| usize::try_from(m.int(a)).unwrap_or(0).min(capacity));
    let parts = lib::split(&text, &separator, most);
    for i in 0..capacity {
        m.set_text(results, i, parts.get(i).copied().unwrap_or(""));
    }
    m.set_int(count, parts.len() as i32);
}

/// Patterns that a machine keeps.
const PATTERNS: usize = 1000;

pub(super) fn regex(m: &mut Machine<'_>, s: &Step) {
    let [out, subject, rest @ ..] = &*s.args else { return };
    let (results, pattern) = match rest {
        [results, pattern] => (Some(results), pattern),
        [pattern] => (None, pattern),
        _ => return,
    };
    let (subject, pattern) = (m.text(subject), m.text(pattern));
    if m.regexes.len() > PATTERNS {
        m.regexes.clear();
    }
    if !m.regexes.contains_key(&pattern) {
        let read = Regex::new(&pattern);
        if let Err(wrong) = &read {
            m.error(wrong.to_string());
        }
        m.regexes.insert(pattern.clone(), read.ok());
    }
    let mut match_positions = vec![0_i32; results.map_or(0, |r| r.ty.elements())];
    let whole = s.code == Opcode::RegexMatch;
    let found = match m.regexes.get(&pattern) {
        Some(Some(regex)) => regex.search(&subject, whole, &mut match_positions),
        _ => Ok(0),
    };
    let found = match found {
        Ok(found) => found,
        Err(wrong) => {
            let source_position = m.source_position(s.at);
            m.error(format!("{wrong} at {source_position}"));
            0
        }
    };
    m.set_int(out, found);
    for (i, &source_position) in match_positions.iter().enumerate() {
        if let Some(results) = results {
            m.set_bits(results, i, source_position as u32);
        }
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Groups as text: `param float Kd 0.5 ; shader matte layer1 ; connect layer1.out layer2.in ;`.
//! The text is OSL's.

use super::layers::{Group, Hint};
use super::value::Value;
use crate::format::{escape, general};
use crate::hir::Data;
use crate::ir::Shader;
use crate::parse::unescape;
use crate::types::{Base, Type};
use std::sync::Arc;

/// Finds a shader by its name.
pub type Find<'a> = dyn FnMut(&str) -> Option<Arc<Shader>> + 'a;

/// Reads a group.
///
/// # Errors
/// What is wrong, one message each.
pub fn read_group(
    name: &str,
    text: &str,
    find: &mut Find<'_>,
    said: &mut Vec<String>,
) -> Result<Group, Vec<String>> {
    let mut group = Group { name: name.to_owned(), ..Group::default() };
    let mut pending: Vec<(String, Value, Hint)> = Vec::new();
    for (words, source) in statements(text) {
        let bad = |what: &str| {
            format!(
                "ShaderGroupBegin: error parsing group description: {what}\n        group: {name}\n        problem might be here: {source}\n"
            )
        };
        if let Err(mut messages) = statement(&words, &mut group, &mut pending, find, said) {
            let last = messages.pop().unwrap_or_default();
            messages.push(bad(&last));
            return Err(messages);
        }
    }
    Ok(group)
}

fn statement(
    words: &[Word],
    group: &mut Group,
    pending: &mut Vec<(String, Value, Hint)>,
    find: &mut Find<'_>,
    said: &mut Vec<String>,
) -> Result<(), Vec<String>> {
    let word = |i: usize| words.get(i).map_or("", |w: &Word| &w.text);
    let wrong = |what: &str| Err(vec![what.to_owned()]);
    match word(0) {
        "" => {}
        "param" => match parameter(&words[1..]) {
            Some(found) => pending.push(found),
            None => return wrong("a parameter is: param TYPE NAME VALUES"),
        },
        "shader" => {
            let Some(shader) = find(word(1)) else {
                let missing = format!("Could not find shader \"{}\"\n        group: {}", word(1), group.name);
                return Err(vec![missing, String::new()]);
            };
            group.add(shader, Some(word(2)), pending, said);
            pending.clear();
        }
        "connect" => {
            let split = |w: &str| w.split_once('.').map(|(a, b)| (a.to_owned(), b.to_owned()));
            match (split(word(1)), split(word(2))) {
                (Some((a, b)), Some((c, d))) => {
                    group.connect(&a, &b, &c, &d).map_err(|message| vec![message, String::new()])?;
                }
                _ => return wrong("a connection is: connect LAYER.OUTPUT LAYER.INPUT"),
            }
        }
        _ => return wrong("a statement starts with param, shader or connect"),
    }
    Ok(())
}

#[derive(Clone, Debug)]
struct Word {
    text: String,
    quoted: bool,
}

/// Words up to `;` or, outside double brackets, `,`; and the text they are.
fn statements(text: &str) -> Vec<(Vec<Word>, String)> {
    let mut list = Vec::new();
    let mut words: Vec<Word> = Vec::new();
    let (mut rest, mut start, mut hints) = (text, text.trim_start(), false);
    loop {
        rest = rest.trim_start();
        if words.is_empty() {
            start = rest;
        }
        let Some(first) = rest.chars().next() else { break };
        match first {
            '#' => rest = rest.find('\n').map_or("", |p| &rest[p..]),
            ';' | ',' if first == ';' || !hints => {
                rest = &rest[1..];
                list.push((std::mem::take(&mut words), start[..start.len() - rest.len()].to_owned()));
                hints = false;
            }
            '"' => {
                let mut escaped = false;
                let end = rest.char_indices().skip(1).find(|&(_, c)| {
                    let done = c == '"' && !escaped;
                    escaped = c == '\\' && !escaped;
                    done
                });
                let end = end.map_or(rest.len(), |(i, _)| i + 1);
                words.push(Word { text: unescape(&rest[..end]), quoted: true });
                rest = &rest[end..];
            }
            _ => {
                hints |= rest.starts_with("[[");
                hints &= !rest.starts_with("]]");
                let stop = |c: char| c.is_whitespace() || c == ';' || c == ',';
                let end = rest.find(stop).unwrap_or(rest.len()).max(first.len_utf8());
                let word = &rest[..end];
                hints &= !word.ends_with("]]");
                words.push(Word { text: word.to_owned(), quoted: false });
                rest = &rest[end..];
            }
        }
    }
    if !words.is_empty() {
        list.push((words, start.to_owned()));
    }
    list
}

fn parameter(words: &[Word]) -> Option<(String, Value, Hint)> {
    let (name, array) = match words.first()?.text.split_once('[') {
        Some((name, rest)) => (name, Some(rest.strip_suffix(']')?)),
        None => (words[0].text.as_str(), None),
    };
    let base = Base::from_word(name).filter(|b| *b != Base::Void)?;
    let param = words.get(1)?.text.clone();
    let mut hint = Hint::default();
    let mut values = Vec::new();
    for word in &words[2..] {
        match word.text.strip_prefix("[[").filter(|_| !word.quoted) {
            _ if !word.quoted && word.text.starts_with("[[") => {}
            _ if !word.quoted && (word.text == "int" || word.text == "]]" || word.text == ",") => {}
            _ if !word.quoted && word.text.contains('=') => {
                let text = word.text.trim_end_matches([']', ',']);
                match text.split_once('=') {
                    Some(("lockgeom", v)) => hint.interpolated = v == "0",
                    Some(("interpolated", v)) => hint.interpolated = v != "0",
                    Some(("interactive", v)) => hint.interactive = v != "0",
                    _ => {}
                }
            }
            _ => values.push(word),
        }
    }
    let one = base.components().max(1);
    let data = match base {
        Base::String => Data::Str(values.iter().map(|w| w.text.as_str().into()).collect()),
        Base::Int => Data::Int(values.iter().map(|w| w.text.parse().ok()).collect::<Option<_>>()?),
        _ => Data::Float(values.iter().map(|w| w.text.parse().ok()).collect::<Option<_>>()?),
    };
    let count = values.len() / one;
    let array = match array {
        None => 0,
        Some("") => i32::try_from(count).ok()?,
        Some(text) => text.parse().ok().filter(|&n: &i32| n > 0)?,
    };
    let ty = Type::of(base).array_of(array);
    let mut data = data;
    let wanted = ty.size();
    if wanted > 1 << 24 {
        return None;
    }
    match &mut data {
        // One number stands for all components.
        Data::Float(list) if list.len() == 1 && one == 3 => *list = vec![list[0]; wanted],
        Data::Float(list) => list.resize(wanted, 0.0),
        Data::Int(list) => list.resize(wanted, 0),
        Data::Str(list) => list.resize(wanted, "".into()),
    }
    Some((param, Value { ty, data }, hint))
}

/// The text of a group, which [`read_group`] reads.
#[must_use]
pub fn write_group(group: &Group) -> String {
    let mut out = String::new();
    for (number, layer) in group.layers.iter().enumerate() {
        let mut given: Vec<_> = layer.values.iter().collect();
        given.sort_by_key(|(id, _)| **id);
        for (id, data) in given {
            let symbol = layer.shader.symbol(*id);
            let words: Vec<String> = match data {
                Data::Int(list) => list.iter().map(ToString::to_string).collect(),
                Data::Float(list) => list.iter().map(|&f| general(f64::from(f), 9)).collect(),
                Data::Str(list) => list.iter().map(|s| format!("\"{}\"", escape(s))).collect(),
            };
            let hint = layer.hints.get(id).copied().unwrap_or_default();
            let mut hints = Vec::new();
            if hint.interpolated {
                hints.push("int interpolated=1");
            }
            if hint.interactive {
                hints.push("int interactive=1");
            }
            let hints = if hints.is_empty() { String::new() } else { format!(" [[ {} ]]", hints.join(", ")) };
            out.push_str(&format!("param {} {} {}{hints} ;\n", symbol.ty, symbol.name, words.join(" ")));
        }
        out.push_str(&format!("shader {} {} ;\n", layer.shader.name, layer.name));
        for c in group.connections.iter().filter(|c| c.to_layer == number) {
            let name = |layer: usize, part: &super::layers::Part| {
                let layer = &group.layers[layer];
                let mut text = format!("{}.{}", layer.name, layer.shader.symbol(part.symbol).name);
                for index in [part.element, part.component].into_iter().flatten() {
                    text.push_str(&format!("[{index}]"));
                }
                text
            };
            out.push_str(&format!("connect {} {} ;\n", name(c.from_layer, &c.from), name(c.to_layer, &c.to)));
        }
    }
    out
}

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
/// The faults, one message each.
pub fn read_group(
    name: &str,
    text: &str,
    find: &mut Find<'_>,
    problems: &mut Vec<String>,
) -> Result<Group, Vec<String>> {
    let mut group = Group { name: name.to_owned(), ..Group::default() };
    let mut pending: Vec<(String, Value, Hint)> = Vec::new();
    for (tokens, source) in statements(text) {
        let bad = |what: &str| {
            format!(
                "ShaderGroupBegin: error parsing group description: {what}\n        group: {name}\n        problem might be here: {source}\n"
            )
        };
        if let Err(mut messages) = statement(&tokens, &mut group, &mut pending, find, problems) {
            let last = messages.pop().unwrap_or_default();
            messages.push(bad(&last));
            return Err(messages);
        }
    }
    Ok(group)
}

fn statement(
    tokens: &[GroupToken],
    group: &mut Group,
    pending: &mut Vec<(String, Value, Hint)>,
    find: &mut Find<'_>,
    problems: &mut Vec<String>,
) -> Result<(), Vec<String>> {
    let token = |i: usize| tokens.get(i).map_or("", |w: &GroupToken| &w.text);
    let wrong = |what: &str| Err(vec![what.to_owned()]);
    match token(0) {
        "" => {}
        "param" => match parameter(&tokens[1..]) {
            Some(found) => pending.push(found),
            None => return wrong("a parameter is: param TYPE NAME VALUES"),
        },
        "shader" => {
            let Some(shader) = find(token(1)) else {
                let missing =
                    format!("Could not find shader \"{}\"\n        group: {}", token(1), group.name);
                return Err(vec![missing, String::new()]);
            };
            group.add(shader, Some(token(2)), pending, problems);
            pending.clear();
        }
        "connect" => {
            let split = |w: &str| w.split_once('.').map(|(a, b)| (a.to_owned(), b.to_owned()));
            match (split(token(1)), split(token(2))) {
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
struct GroupToken {
    text: String,
    quoted: bool,
}

/// Words up to `;` or, outside double brackets, `,`; and the text they are.
fn statements(text: &str) -> Vec<(Vec<GroupToken>, String)> {
    let mut list = Vec::new();
    let mut tokens: Vec<GroupToken> = Vec::new();
    let (mut rest, mut start, mut hints) = (text, text.trim_start(), false);
    loop {
        rest = rest.trim_start();
        if tokens.is_empty() {
            start = rest;
        }
        let Some(first) = rest.chars().next() else { break };
        match first {
            '#' => rest = rest.find('\n').map_or("", |p| &rest[p..]),
            ';' | ',' if first == ';' || !hints => {
                rest = &rest[1..];
                list.push((std::mem::take(&mut tokens), start[..start.len() - rest.len()].to_owned()));
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
                tokens.push(GroupToken { text: unescape(&rest[..end]), quoted: true });
                rest = &rest[end..];
            }
            _ => {
                hints |= rest.starts_with("[[");
                hints &= !rest.starts_with("]]");
                let stop = |c: char| c.is_whitespace() || c == ';' || c == ',';
                let end = rest.find(stop).unwrap_or(rest.len()).max(first.len_utf8());
                let token = &rest[..end];
                hints &= !token.ends_with("]]");
                tokens.push(GroupToken { text: token.to_owned(), quoted: false });
                rest = &rest[end..];
            }
        }
    }
    if !tokens.is_empty() {
        list.push((tokens, start.to_owned()));
    }
    list
}

fn parameter(tokens: &[GroupToken]) -> Option<(String, Value, Hint)> {
    let (name, array) = match tokens.first()?.text.split_once('[') {
        Some((name, rest)) => (name, Some(rest.strip_suffix(']')?)),
        None => (tokens[0].text.as_str(), None),
    };
    let base = Base::from_keyword(name).filter(|b| *b != Base::Void)?;
    let param = tokens.get(1)?.text.clone();
    let mut hint = Hint::default();
    let mut values = Vec::new();
    for token in &tokens[2..] {
        match token.text.strip_prefix("[[").filter(|_| !token.quoted) {
            _ if !token.quoted && token.text.starts_with("[[") => {}
            _ if !token.quoted && (token.text == "int" || token.text == "]]" || token.text == ",") => {}
            _ if !token.quoted && token.text.contains('=') => {
                let text = token.text.trim_end_matches([']', ',']);
                match text.split_once('=') {
                    Some(("lockgeom", v)) => hint.interpolated = v == "0",
                    Some(("interpolated", v)) => hint.interpolated = v != "0",
                    Some(("interactive", v)) => hint.interactive = v != "0",
                    _ => {}
                }
            }
            _ => values.push(token),
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
    let expected = ty.size();
    if expected > 1 << 24 {
        return None;
    }
    match &mut data {
        // One number serves for all components.
        Data::Float(list) if list.len() == 1 && one == 3 => *list = vec![list[0]; expected],
        Data::Float(list) => list.resize(expected, 0.0),
        Data::Int(list) => list.resize(expected, 0),
        Data::Str(list) => list.resize(expected, "".into()),
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
            let tokens: Vec<String> = match data {
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
            out.push_str(&format!("param {} {} {}{hints} ;\n", symbol.ty, symbol.name, tokens.join(" ")));
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

// SPDX-License-Identifier: GPL-3.0-or-later
//! Messages about parameters, connections and outputs of groups: the place, the fault, the allowed names.
//! Tests: `tests/messages.rs`.

use gnurt_sl::group::{Group, Value};
use gnurt_sl::hir::Data;
use gnurt_sl::ir::{Shader, SymbolKind};
use gnurt_sl::types::{Base, Type};

/// Names that a message lists.
const MOST_LISTED: usize = 12;

/// Why a shader's parameter cannot have a value, if so.
pub(crate) fn of_value(shader: &Shader, layer: &str, name: &str, value: &Value) -> Option<String> {
    let place = format!("layer '{layer}' (shader '{}')", shader.name);
    let Some(id) = shader.find(name).filter(|&id| shader.symbol(id).kind.is_param()) else {
        let known = choices(name, "parameters", &names(shader, |_| true));
        return Some(format!("{place}: unknown parameter '{name}'; {known}"));
    };
    let ty = shader.symbol(id).ty;
    if ty.is_struct() {
        return Some(format!(
            "{place}: parameter '{name}' is a struct: give values to its members, as '{name}.member'"
        ));
    }
    if ty.base == Base::Closure {
        return Some(format!("{place}: parameter '{name}' is a closure: connect it, it takes no value"));
    }
    let ty = ty.display(&shader.structs);
    value
        .fit(shader.symbol(id).ty)
        .is_none()
        .then(|| format!("{place}: parameter '{name}' is of type {ty}; the value is {}", described(value)))
}

/// A value's kind in words.
pub(crate) fn described(value: &Value) -> String {
    let count = match &value.data {
        Data::Float(list) => list.len(),
        Data::Int(list) => list.len(),
        Data::Str(list) => list.len(),
    };
    match (value.ty, value.ty.base) {
        (Type::FLOAT, _) => "a float".to_owned(),
        (Type::INT, _) => "an int".to_owned(),
        (Type::STRING, _) => "a text".to_owned(),
        (Type::MATRIX, _) => "a matrix".to_owned(),
        (ty, _) if ty.is_triple() => "three floats".to_owned(),
        (_, Base::Int) => format!("an array of {count} ints"),
        (_, Base::String) => format!("an array of {count} texts"),
        _ => format!("an array of {count} floats"),
    }
}

/// Why two layers cannot be connected; `core` is the compiler's own message.
pub(crate) fn of_connection(group: &Group, from: [&str; 2], to: [&str; 2], core: &str) -> String {
    let place = format!("connection '{}.{}' to '{}.{}'", from[0], from[1], to[0], to[1]);
    let layers: Vec<String> = group.layers.iter().map(|layer| layer.name.to_string()).collect();
    for [layer, _] in [from, to] {
        if group.find(layer).is_none() {
            let known = choices(layer, "layers so far", &layers);
            return format!(
                "{place}: unknown layer '{layer}'; {known}; layers are added before they are connected"
            );
        }
    }
    let found = |layer: &str| group.find(layer).map(|number| (number, &group.layers[number].shader));
    let (Some((a, source)), Some((b, target))) = (found(from[0]), found(to[0])) else { return place };
    if b <= a {
        return format!("{place}: layer '{}' must follow layer '{}'", to[0], from[0]);
    }
    for (shader, [layer, name], outputs) in [(source, from, true), (target, to, false)] {
        let whole = name.split('[').next().unwrap_or_default();
        let is_known = |name: &str| shader.find(name).is_some_and(|id| shader.symbol(id).kind.is_param());
        if is_known(whole) || whole.rsplit_once('.').is_some_and(|(start, _)| is_known(start)) {
            continue;
        }
        let (what, kind) =
            if outputs { ("outputs", SymbolKind::OutputParam) } else { ("inputs", SymbolKind::Param) };
        let known = choices(name, what, &names(shader, |found| found == kind));
        return format!("{place}: layer '{layer}' (shader '{}') has no '{name}'; {known}", shader.name);
    }
    let why = core.lines().next().unwrap_or_default();
    format!("{place}: {}", why.trim_start_matches("ConnectShaders: "))
}

/// Why an output cannot be kept.
pub(crate) fn of_output(group: &Group, output: &str) -> String {
    let of_layer = |layer: &gnurt_sl::group::Layer| {
        let shader = &layer.shader;
        let is_kept = |symbol: &gnurt_sl::ir::Symbol| {
            symbol.kind == SymbolKind::OutputParam
                && !symbol.ty.is_struct()
                && !matches!(symbol.ty.base, Base::String | Base::Closure)
        };
        let outputs = shader.params().filter(|(_, symbol)| is_kept(symbol));
        outputs.map(|(_, symbol)| format!("{}.{}", layer.name, symbol.name)).collect::<Vec<_>>()
    };
    let known: Vec<String> = group.layers.iter().flat_map(of_layer).collect();
    format!("there is no output '{output}' of floats or ints; {}", choices(output, "outputs", &known))
}

/// The names of a shader's parameters of some kind.
fn names(shader: &Shader, of: impl Fn(SymbolKind) -> bool) -> Vec<String> {
    let all = shader.params().filter(|(_, symbol)| !symbol.ty.is_struct() && of(symbol.kind));
    all.map(|(_, symbol)| symbol.name.to_string()).collect()
}

/// The most similar name, if one is, and all of them.
fn choices(wrong: &str, what: &str, names: &[String]) -> String {
    if names.is_empty() {
        return format!("{what}: none");
    }
    let nearest = names.iter().map(|name| (distance(wrong, name), name)).min();
    let guess = nearest.filter(|(steps, _)| *steps <= 1 + wrong.len() / 4);
    let guess = guess.map_or(String::new(), |(_, name)| format!("did you mean '{name}'? "));
    let more = if names.len() > MOST_LISTED { ", ..." } else { "" };
    let listed = names.iter().take(MOST_LISTED).map(String::as_str).collect::<Vec<_>>().join(", ");
    format!("{guess}{what}: {listed}{more}")
}

/// Insertions, deletions and exchanges of letters between two names; many for long ones, which are not compared.
fn distance(a: &str, b: &str) -> usize {
    if a.len().max(b.len()) > 60 {
        return usize::MAX;
    }
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut corner = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let here = (corner + usize::from(x != *y)).min(row[j] + 1).min(row[j + 1] + 1);
            corner = std::mem::replace(&mut row[j + 1], here);
        }
    }
    row[b.len()]
}

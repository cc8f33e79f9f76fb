// SPDX-License-Identifier: GPL-3.0-or-later
//! Makes connections.
//! The rules and words are OSL's.

use super::layers::{Connection, Group, Layer, Part};
use crate::ir::SymId;
use crate::types::{Base, Type};

impl Group {
    /// Connects an output of a layer to an input of a later one; structs by their members.
    ///
    /// # Errors
    /// The fault.
    pub fn connect(&mut self, from_layer: &str, from: &str, to_layer: &str, to: &str) -> Result<(), String> {
        let group = self.name.clone();
        let wrong = |what: String| Err(format!("ConnectShaders: {what}\n        group: {group}"));
        for (side, layer, param) in [("source", from_layer, from), ("destination", to_layer, to)] {
            if layer.is_empty() || param.is_empty() {
                return wrong(format!("badly formed {side} layer/parameter"));
            }
            if self.find(layer).is_none() {
                return wrong(format!("{side} layer \"{layer}\" not found"));
            }
        }
        let (Some(a), Some(b)) = (self.find(from_layer), self.find(to_layer)) else { return Ok(()) };
        if b <= a {
            return wrong(format!(
                "destination layer must follow source layer (tried to connect {from_layer}.{from} -> {to_layer}.{to})"
            ));
        }
        let (source, target) = (part(&self.layers[a], from), part(&self.layers[b], to));
        let (Some(source), Some(target)) = (source, target) else {
            let (layer, param) = if source.is_none() { (from_layer, from) } else { (to_layer, to) };
            return wrong(format!(
                "\"{param}\" is not a parameter or global of layer \"{layer}\" (shader \"{}\")",
                {
                    let l = if source.is_none() { a } else { b };
                    &self.layers[l].shader.name
                }
            ));
        };
        if self.layers[b].shader.symbol(target.symbol).flag("allowconnect") == Some(0) {
            return wrong(format!(
                "cannot connect to {to_layer}.{to} because it has metadata allowconnect=0"
            ));
        }
        let (sty, tty) = (source.ty, target.ty);
        let tokens =
            (sty.display(&self.layers[a].shader.structs), tty.display(&self.layers[b].shader.structs));
        if sty.struct_id().is_some() && tty.struct_id().is_some() {
            let sources = self.layers[a].shader.leaves(source.symbol);
            let targets = self.layers[b].shader.leaves(target.symbol);
            let types = |layer: usize, list: &[SymId]| -> Vec<Type> {
                list.iter().map(|&id| self.layers[layer].shader.symbol(id).ty).collect()
            };
            let (from_types, to_types) = (types(a, &sources), types(b, &targets));
            let fits = from_types.len() == to_types.len()
                && from_types.iter().zip(&to_types).all(|(a, b)| alike(*a, *b));
            if !fits || sty.array != tty.array {
                return wrong(format!(
                    "cannot connect a {} ({from}) to a {} ({to}), invalid connection",
                    tokens.0, tokens.1
                ));
            }
            for (s, t) in sources.into_iter().zip(targets) {
                let whole = |layer: &Layer, symbol| Part {
                    symbol,
                    element: None,
                    component: None,
                    ty: layer.shader.symbol(symbol).ty,
                };
                let (from, to) = (whole(&self.layers[a], s), whole(&self.layers[b], t));
                self.join(Connection { from_layer: a, from, to_layer: b, to });
            }
            return Ok(());
        }
        if !fits(sty, tty) {
            return wrong(format!(
                "cannot connect a {} ({from}) to a {} ({to}), invalid connection",
                tokens.0, tokens.1
            ));
        }
        if tty.array < 0 && sty.array > 0 {
            self.layers[b].resize(target.symbol, tty.array_of(sty.array));
        }
        let to = Part { ty: self.layers[b].shader.symbol(target.symbol).ty, ..target };
        let to = if target.element.is_some() || target.component.is_some() { target } else { to };
        self.join(Connection { from_layer: a, from: source, to_layer: b, to });
        Ok(())
    }

    /// Later connections to the same parameter win.
    fn join(&mut self, made: Connection) {
        self.connections.retain(|c| !(c.to_layer == made.to_layer && c.to == made.to));
        self.connections.push(made);
    }
}

/// Whether a value may go along a connection.
fn fits(from: Type, to: Type) -> bool {
    let triple = |t: Type| t.base.is_triple();
    if from.is_array() || to.is_array() {
        let same = from.base == to.base || (triple(from) && triple(to));
        return same && (from.array == to.array || to.array < 0 && from.array > 0);
    }
    match (from.base, to.base) {
        (a, b) if a == b => true,
        (Base::Closure, _) | (_, Base::Closure) | (Base::String, _) | (_, Base::String) => false,
        (Base::Struct(_), _) | (_, Base::Struct(_)) => false,
        (Base::Int | Base::Float, b) => b == Base::Float || b == Base::Int || b.is_triple(),
        (a, b) => a.is_triple() && (b.is_triple() || b == Base::Float),
    }
}

/// Whether members of structs that are connected are of one type; points, vectors, normals and colours are alike.
fn alike(a: Type, b: Type) -> bool {
    a.array == b.array && (a.base == b.base || a.base.is_triple() && b.base.is_triple())
}

/// `name`, `name[1]`, `name[1][2]`, `name.r`, `struct.member`
fn part(layer: &Layer, text: &str) -> Option<Part> {
    let shader = &layer.shader;
    let known = |name: &str| {
        shader.find(name).filter(|&id| {
            let kind = shader.symbol(id).kind;
            kind.is_param() || kind == crate::ir::SymbolKind::Global
        })
    };
    if let Some(symbol) = known(text) {
        return Some(Part { symbol, element: None, component: None, ty: shader.symbol(symbol).ty });
    }
    let (name, rest) = match text.find(['[', '.']) {
        Some(_) => {
            let cut = text.find('[').or_else(|| text.rfind('.'))?;
            text.split_at(cut)
        }
        None => return None,
    };
    let symbol = known(name)?;
    let mut ty = shader.symbol(symbol).ty;
    let (mut element, mut component) = (None, None);
    let mut rest = rest;
    while !rest.is_empty() {
        let index: u32 = if let Some(letter) = rest.strip_prefix('.') {
            rest = "";
            match letter {
                "x" | "r" => 0,
                "y" | "g" => 1,
                "z" | "b" => 2,
                _ => return None,
            }
        } else {
            let (inner, after) = rest.strip_prefix('[')?.split_once(']')?;
            rest = after;
            inner.trim().parse().ok()?
        };
        if ty.is_array() {
            if index as usize >= ty.elements() {
                return None;
            }
            element = Some(index);
            ty = ty.element();
        } else if ty.is_triple() && index < 3 {
            component = Some(index);
            ty = Type::FLOAT;
        } else {
            return None;
        }
    }
    Some(Part { symbol, element, component, ty })
}

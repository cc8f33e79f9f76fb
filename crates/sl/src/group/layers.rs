// SPDX-License-Identifier: GPL-3.0-or-later
//! A group and its layers.

use super::value::Value;
use crate::hir::Data;
use crate::ir::{Shader, SymId};
use crate::types::{Base, Type};
use std::collections::HashMap;
use std::sync::Arc;

/// Whether a parameter's value may differ from the one in its text.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Hint {
    /// May be given by the geometry.
    pub interpolated: bool,
    /// May be changed without a new plan.
    pub interactive: bool,
}

/// A shader with values for its parameters.
#[derive(Clone, Debug)]
pub struct Layer {
    /// Its name in the group.
    pub name: Arc<str>,
    /// The shader; arrays without a length have got one.
    pub shader: Arc<Shader>,
    /// Values given to parameters.
    pub values: HashMap<SymId, Data>,
    /// Hints given with them.
    pub hints: HashMap<SymId, Hint>,
}

/// A parameter, an element of it, or a component of either.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// The parameter.
    pub symbol: SymId,
    /// The element.
    pub element: Option<u32>,
    /// The component.
    pub component: Option<u32>,
    /// The type of the part.
    pub ty: Type,
}

/// An output that feeds an input of a later layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Connection {
    /// The layer it comes from.
    pub from_layer: usize,
    /// The source.
    pub from: Part,
    /// The layer it goes to.
    pub to_layer: usize,
    /// Where it goes.
    pub to: Part,
}

/// A group.
#[derive(Clone, Debug, Default)]
pub struct Group {
    /// Its name.
    pub name: String,
    /// Layers; the last is the group's result.
    pub layers: Vec<Layer>,
    /// Connections.
    pub connections: Vec<Connection>,
}

impl Group {
    /// Adds a layer with values for its parameters. A fault of a value is reported, and the value is dropped.
    pub fn add(
        &mut self,
        shader: Arc<Shader>,
        name: Option<&str>,
        values: &[(String, Value, Hint)],
        messages: &mut Vec<String>,
    ) {
        let name: Arc<str> = match name {
            Some(name) if !name.is_empty() => name.into(),
            _ => format!("{}_{}", shader.name, self.layers.len()).into(),
        };
        let mut layer = Layer { name, shader, values: HashMap::new(), hints: HashMap::new() };
        for (param, value, hint) in values {
            layer.set(param, value, *hint, messages);
        }
        self.layers.push(layer);
    }

    /// The layer of a name.
    #[must_use]
    pub fn find(&self, name: &str) -> Option<usize> {
        self.layers.iter().rposition(|l| &*l.name == name)
    }
}

impl Layer {
    /// Gives a parameter its value.
    pub fn set(&mut self, param: &str, value: &Value, hint: Hint, messages: &mut Vec<String>) {
        let Some(id) = self.shader.find(param).filter(|&id| self.shader.symbol(id).kind.is_param()) else {
            messages.push(format!("attempt to set nonexistent parameter: {param}"));
            return;
        };
        let ty = self.shader.symbol(id).ty;
        if ty.struct_id().is_some() || ty.base == Base::Closure {
            messages.push(format!("Parameter \"{param}\" isStruct or closure: it takes no value"));
            return;
        }
        match value.fit(ty) {
            Some((ty, data)) => {
                if ty != self.shader.symbol(id).ty {
                    self.resize(id, ty);
                }
                self.values.insert(id, data);
                if hint != Hint::default() {
                    self.hints.insert(id, hint);
                }
            }
            None => messages.push(format!(
                "attempt to set parameter from incompatible type: {param} (expected '{}', received '{}')",
                ty.display(&self.shader.structs),
                value.ty
            )),
        }
    }

    /// Gives an array without a length one.
    pub(super) fn resize(&mut self, id: SymId, ty: Type) {
        let shader = Arc::make_mut(&mut self.shader);
        shader.symbols[id as usize].ty = ty;
    }

    /// Whether a parameter may come from the geometry.
    #[must_use]
    pub fn interpolated(&self, id: SymId) -> bool {
        let symbol = self.shader.symbol(id);
        let given = self.hints.get(&id).is_some_and(|h| h.interpolated);
        let lockgeom = symbol.flag("lockgeom") == Some(0);
        let interpolated = symbol.flag("interpolated") == Some(1);
        symbol.kind.is_param() && (given || lockgeom || interpolated)
    }

    /// Whether a parameter may change.
    #[must_use]
    pub fn interactive(&self, id: SymId) -> bool {
        self.hints.get(&id).is_some_and(|h| h.interactive)
            || self.shader.symbol(id).flag("interactive") == Some(1)
    }
}

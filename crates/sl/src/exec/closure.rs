// SPDX-License-Identifier: GPL-3.0-or-later
//! Closures: trees of sums, weights and components.
//! Source: original; what is printed is OSL's.

use super::components::{Closure, Component, NODES, parts};
use super::machine::{Machine, Step};
use crate::format::general;
use crate::hir::Data;
use crate::types::{Base, Type};

/// Makes a component; none, and a message, if the program does not know it. What is written may be among what is read, as in
/// `Ci = layer (coat, Ci)`.
pub(super) fn closure(m: &mut Machine<'_>, s: &Step) {
    let [out, name, rest @ ..] = &*s.args else { return };
    let name = m.text(name);
    let host = m.host;
    let Some(decl) = host.closure(&name) else {
        m.set_word(out, 0, 0);
        let (layer, shader) = m.layer_names();
        let place = m.place(s.at);
        m.error(format!(
            "Closure '{name}' is not supported by the current renderer, called from {place} in shader \"{shader}\", layer {} \"{layer}\", group \"{}\"",
            m.layer, m.plan.name
        ));
        return;
    };
    let plain = decl.params.iter().filter(|p| p.key.is_none()).count();
    let mut params = Vec::with_capacity(decl.params.len());
    for (i, param) in decl.params.iter().enumerate() {
        let slot = match &param.key {
            None => rest.get(i),
            Some(key) => rest.get(plain..).and_then(|pairs| {
                pairs.chunks(2).rfind(|pair| pair.len() == 2 && m.text(&pair[0]) == *key).map(|pair| &pair[1])
            }),
        };
        let value = match slot.filter(|slot| slot.ty.base.components() > 0) {
            Some(slot) => m.data(slot),
            None => zero(param.ty),
        };
        params.push((param.key.clone(), param.ty, fit(param.ty, value)));
    }
    let number = m.add_closure(Closure::Component(Component { name: decl.name.clone(), params }));
    m.set_word(out, 0, number);
}

fn zero(ty: Type) -> Data {
    match ty.base {
        Base::String => Data::Str(vec!["".into(); ty.elements()]),
        Base::Int | Base::Closure => Data::Int(vec![0; ty.elements()]),
        _ => Data::Float(vec![0.0; ty.size()]),
    }
}

/// Ints where floats are wanted, and as many values as there should be.
fn fit(ty: Type, data: Data) -> Data {
    match data {
        Data::Int(list) if ty.base.is_float_based() => {
            fit(ty, Data::Float(list.iter().map(|&v| v as f32).collect()))
        }
        Data::Float(mut list) => {
            list.resize(ty.size(), 0.0);
            Data::Float(list)
        }
        other => other,
    }
}

impl Machine<'_> {
    /// Adds a node; its number, 0 if there are too many.
    pub(super) fn add_closure(&mut self, node: Closure) -> u32 {
        if self.closures.len() >= NODES {
            return 0;
        }
        self.closures.push(node);
        self.closures.len() as u32
    }

    /// The components of a closure with their weights, in order.
    #[must_use]
    pub fn components(&self, number: u32) -> Vec<([f32; 3], &Component)> {
        parts(&self.closures, number)
    }

    /// As `printf` shows it.
    #[must_use]
    pub fn closure_text(&self, number: u32) -> String {
        let mut out = String::new();
        for (i, (w, component)) in self.components(number).into_iter().enumerate() {
            if i > 0 {
                out.push_str("\n\t+ ");
            }
            out.push_str(&format!("{} * {} (", triple(&w), component.name));
            for (k, (key, ty, value)) in component.params.iter().enumerate() {
                if k > 0 {
                    out.push_str(", ");
                }
                if let Some(key) = key {
                    out.push_str(&format!("\"{key}\", "));
                }
                let words = self.closure_param(*ty, value);
                if ty.elements() > 1 {
                    out.push_str(&format!("[{}]", words.join(", ")));
                } else {
                    out.push_str(&words.join(", "));
                }
            }
            out.push(')');
        }
        out
    }

    fn closure_param(&self, ty: Type, value: &Data) -> Vec<String> {
        match value {
            Data::Int(list) if ty.base == Base::Closure => {
                list.iter().map(|&n| self.closure_text(n as u32)).collect()
            }
            Data::Int(list) => list.iter().map(ToString::to_string).collect(),
            Data::Str(list) => list.iter().map(|s| format!("\"{s}\"")).collect(),
            Data::Float(list) if ty.base.is_triple() => list.chunks(3).map(triple).collect(),
            Data::Float(list) => list.iter().map(|&f| general(f64::from(f), 6)).collect(),
        }
    }
}

fn triple(v: &[f32]) -> String {
    let words: Vec<String> = v.iter().map(|&f| general(f64::from(f), 6)).collect();
    format!("({})", words.join(", "))
}

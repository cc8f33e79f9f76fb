// SPDX-License-Identifier: GPL-3.0-or-later
//! Changes of values from outside from pixel to pixel, and other questions about all operations of a group.
//! Tests: `tests/scripts/attributes.rs`.

use gnurt_shading::AttributeRequest;
use gnurt_sl::exec::{Plan, Source};
use gnurt_sl::group::Group;
use gnurt_sl::hir::Data;
use gnurt_sl::ir::{Op, Shader, ops};
use gnurt_sl::opcode::Opcode;

use crate::attributes;

/// Names of the values from outside whose changes from pixel to pixel a group reads, and whether there are any, computed names
/// included.
pub(crate) fn read_changes(plan: &Plan) -> (Vec<String>, bool) {
    let (mut names, mut any) = (Vec::new(), false);
    for layer in &plan.layers {
        let shader = &layer.shader;
        for param in layer.params.iter().filter(|param| param.source == Source::Geometry) {
            let symbol = shader.symbol(param.symbol);
            if symbol.derivs {
                any = true;
                names.push(symbol.name.to_string());
            }
        }
        each_op(shader, &mut |op| {
            let is_read = op.args.last().is_some_and(|&id| shader.symbol(id).derivs);
            if op.code != Opcode::GetAttribute || !is_read {
                return;
            }
            any = true;
            let mut texts = op.args.iter().filter_map(|&id| match &shader.symbol(id).value {
                Some(Data::Str(list)) => list.first(),
                _ => None,
            });
            names.extend(texts.next_back().map(ToString::to_string));
        });
    }
    (names, any)
}

/// Requests for the gradients of requested values.
pub(crate) fn gradients(requests: &[AttributeRequest], names: &[String]) -> Vec<AttributeRequest> {
    let mut found: Vec<AttributeRequest> = Vec::new();
    let components = |name: &str| requests.iter().find(|r| r.name == name).map(|r| 3 * r.components);
    for name in names {
        // Colours of vertices have two names.
        let of_vertices = (name == "color").then_some(("Cd", Some(9)));
        for (name, components) in [Some((&name[..], components(name))), of_vertices].into_iter().flatten() {
            let name = format!("{}{name}", AttributeRequest::GRADIENT);
            if let Some(components) = components.filter(|_| found.iter().all(|known| known.name != name)) {
                found.push(AttributeRequest { name, components, default: vec![0.0; components as usize] });
            }
        }
    }
    found
}

/// Whether a group queries how often the path of a ray was scattered.
pub(crate) fn reads_bounces(group: &Group) -> bool {
    let mut found = false;
    for layer in &group.layers {
        each_op(&layer.shader, &mut |op| {
            let is_name = |&id: &u32| match &layer.shader.symbol(id).value {
                Some(Data::Str(list)) => list.iter().any(|name| attributes::is_of_bounces(name)),
                _ => false,
            };
            found |= op.code == Opcode::GetAttribute && op.args.iter().any(is_name);
        });
    }
    found
}

/// Calls `with` for each operation of a shader.
pub(crate) fn each_op(shader: &Shader, with: &mut dyn FnMut(&Op)) {
    let mut with = |op: &Op| with(op);
    for symbol in &shader.symbols {
        ops(&symbol.init, &mut with);
    }
    ops(&shader.code, &mut with);
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Optimises between layers: constants and copies go through connections, equal layers become one, and
//! connections and outputs without readers go.
//! Invariant: the last layer, globals and requested outputs have the same values. A layer that is needed for
//! none of them does not run, and prints nothing. Tests: `tests/layers.rs`, crates/jit/tests/chance.rs.

use super::fold::{fold, is_plain, remove_unused};
use crate::exec::known_result;
use crate::group::{Connection, Group, Layer, Part};
use crate::hir::Data;
use crate::ir::{Node, Op, Shader, SymId, SymbolKind, Use, ops, uses};
use crate::opcode::Opcode;
use crate::types::Type;
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// Values of parameters that nothing changes while the group runs.
pub fn fixed(group: &Group, number: usize) -> HashMap<SymId, Data> {
    let layer = &group.layers[number];
    let into = group.connections.iter().filter(|c| c.to_layer == number);
    let connected: HashSet<SymId> = into.map(|c| c.to.symbol).collect();
    let mut out = HashMap::new();
    for (id, symbol) in layer.shader.params() {
        let plain = symbol.kind == SymbolKind::Param
            && !connected.contains(&id)
            && !layer.interpolated(id)
            && !layer.interactive(id);
        let value = match layer.values.get(&id) {
            Some(data) => Some(data),
            None if symbol.init.is_empty() => symbol.value.as_ref(),
            None => None,
        };
        if let (true, Some(data)) = (plain, value) {
            out.insert(id, data.clone());
        }
    }
    out
}

/// The group with less to do. `is_wanted` says which outputs, of a layer by number, are requested; others are
/// computed for connections only, if `drops_outputs`.
pub fn optimise(original: &Group, is_wanted: &dyn Fn(usize, SymId) -> bool, drops_outputs: bool) -> Group {
    let mut group = original.clone();
    let mut equal: HashMap<String, usize> = HashMap::new();
    for number in 0..group.layers.len() {
        let known = fixed(&group, number);
        fold(Arc::make_mut(&mut group.layers[number].shader), &known);
        let last = number + 1 == group.layers.len();
        if last || !is_silent(&group.layers[number].shader) {
            continue;
        }
        let wanted = group.layers[number].shader.params().any(|(id, _)| is_wanted(number, id));
        let key = key(original, &group, number);
        let first = *equal.entry(key).or_insert(number);
        if first != number && !wanted {
            group
                .connections
                .iter_mut()
                .filter(|c| c.from_layer == number)
                .for_each(|c| c.from_layer = first);
            continue;
        }
        forward(&mut group, number, &known);
    }
    for number in (0..group.layers.len()).rev() {
        prune(&mut group, number, is_wanted, drops_outputs);
    }
    group
}

/// A text that is the same for layers that do the same.
fn key(original: &Group, group: &Group, number: usize) -> String {
    let layer = &group.layers[number];
    let mut values: Vec<_> = layer.values.iter().collect();
    values.sort_by_key(|(id, _)| **id);
    let mut hints: Vec<_> = layer.hints.iter().collect();
    hints.sort_by_key(|(id, _)| **id);
    let mut connections: Vec<(SymId, String)> = group
        .connections
        .iter()
        .filter(|c| c.to_layer == number)
        .map(|c| (c.to.symbol, format!("{:?} {} {:?}", c.to, c.from_layer, c.from)))
        .collect();
    connections.sort();
    format!("{:p} {values:?} {hints:?} {connections:?}", Arc::as_ptr(&original.layers[number].shader))
}

/// Whether running a layer once, twice or never makes no difference but by its outputs.
fn is_silent(shader: &Shader) -> bool {
    let mut silent = true;
    let mut visit = |op: &Op| {
        let is_known = |&id: &SymId| shader.symbol(id).kind == SymbolKind::Const;
        let indices = match op.code {
            Opcode::Aref | Opcode::Compref | Opcode::Mxcompref => op.args.get(2..),
            Opcode::Aassign | Opcode::Compassign => op.args.get(1..2),
            Opcode::Mxcompassign => op.args.get(1..3),
            _ => None,
        };
        let asks = matches!(
            op.code,
            Opcode::Closure
                | Opcode::Texture
                | Opcode::Environment
                | Opcode::Texture3d
                | Opcode::GetTextureInfo
                | Opcode::GetAttribute
                | Opcode::RayType
                | Opcode::Backfacing
                | Opcode::SurfaceArea
                | Opcode::CalculateNormal
                | Opcode::Transform
                | Opcode::TransformV
                | Opcode::TransformN
                | Opcode::TransformC
                | Opcode::Point
                | Opcode::Vector
                | Opcode::Normal
                | Opcode::Color
                | Opcode::Matrix
                | Opcode::Spline
                | Opcode::Concat
                | Opcode::Strlen
                | Opcode::Break
                | Opcode::Continue
                | Opcode::Return
                | Opcode::Exit
        );
        silent &= asks
            || is_plain(shader, op)
            || op.code.is_nothing()
            || op.code.is_noise()
            || op.code.is_about_operands()
            || indices.is_some_and(|list| list.iter().all(is_known));
    };
    all_blocks(shader).for_each(|block| ops(block, &mut visit));
    for block in all_blocks(shader) {
        uses(block, &mut |id, usage| {
            silent &= usage == Use::Read || shader.symbol(id).kind != SymbolKind::Global;
        });
    }
    silent
}

fn all_blocks(shader: &Shader) -> impl Iterator<Item = &crate::ir::Block> {
    shader.symbols.iter().map(|symbol| &symbol.init).chain([&shader.code])
}

/// The constant source of an output.
enum Source {
    Value(Data),
    /// A parameter's value.
    Param(SymId),
}

fn source(layer: &Layer, id: SymId, known: &HashMap<SymId, Data>) -> Option<Source> {
    let shader = &layer.shader;
    let symbol = shader.symbol(id);
    let mut writes = 0;
    for block in all_blocks(shader) {
        uses(block, &mut |used, usage| writes += u32::from(used == id && usage == Use::Write));
    }
    if symbol.kind != SymbolKind::OutputParam || layer.interpolated(id) || layer.interactive(id) {
        return None;
    }
    if writes == 0 && symbol.init.is_empty() {
        return layer.values.get(&id).or(symbol.value.as_ref()).cloned().map(Source::Value);
    }
    for node in shader.code.iter().filter(|_| writes == 1) {
        if let Node::Op(op) = node
            && matches!(op.code, Opcode::Assign | Opcode::ArrayCopy)
            && op.args.first() == Some(&id)
        {
            let from = *op.args.get(1)?;
            let (of, ty) = (shader.symbol(from), symbol.ty);
            let value = if of.kind == SymbolKind::Const { of.value.as_ref() } else { known.get(&from) };
            return match value {
                Some(value) => converted(of.ty, ty, value).map(Source::Value),
                None => (of.kind == SymbolKind::Param && of.ty == ty).then_some(Source::Param(from)),
            };
        }
        let mut leaves = false;
        ops(std::slice::from_ref(node), &mut |op| leaves |= matches!(op.code, Opcode::Return | Opcode::Exit));
        if leaves {
            return None;
        }
    }
    None
}

fn converted(from: Type, to: Type, value: &Data) -> Option<Data> {
    if from == to {
        return (value.count() == to.size()).then(|| value.clone());
    }
    let is_plain = !from.is_array() && !to.is_array() && value.count() == from.size();
    if is_plain { known_result(Opcode::Assign, to, &[(from, value)]) } else { None }
}

fn is_whole(part: &Part) -> bool {
    part.element.is_none() && part.component.is_none()
}

/// Connects readers of constant outputs and copies to their sources.
fn forward(group: &mut Group, number: usize, known: &HashMap<SymId, Data>) {
    let sources: Vec<(usize, Connection)> =
        group.connections.iter().copied().enumerate().filter(|(_, c)| c.from_layer == number).collect();
    let mut gone = Vec::new();
    for (index, c) in sources {
        let feeds = |layer: usize, symbol: SymId| {
            let mut list =
                group.connections.iter().filter(move |c| c.to_layer == layer && c.to.symbol == symbol);
            list.next().filter(|only| is_whole(&only.to) && list.next().is_none())
        };
        if !is_whole(&c.from) || feeds(c.to_layer, c.to.symbol).is_none() {
            continue;
        }
        match source(&group.layers[number], c.from.symbol, known) {
            Some(Source::Value(value)) => {
                let to = &group.layers[c.to_layer];
                let symbol = to.shader.symbol(c.to.symbol);
                let is_free = symbol.kind == SymbolKind::Param
                    && !to.interpolated(c.to.symbol)
                    && !to.interactive(c.to.symbol);
                if let (true, Some(value)) = (is_free, converted(c.from.ty, c.to.ty, &value)) {
                    group.layers[c.to_layer].values.insert(c.to.symbol, value);
                    gone.push(index);
                }
            }
            Some(Source::Param(param)) => {
                if let Some(&before) = feeds(number, param).filter(|before| before.from.ty == c.from.ty) {
                    (group.connections[index].from_layer, group.connections[index].from) =
                        (before.from_layer, before.from);
                }
            }
            None => {}
        }
    }
    let mut index = 0;
    group.connections.retain(|_| {
        index += 1;
        !gone.contains(&(index - 1))
    });
}

/// Drops outputs that no connection leads from, and connections to parameters that are not read.
fn prune(group: &mut Group, number: usize, is_wanted: &dyn Fn(usize, SymId) -> bool, drops_outputs: bool) {
    let needed: HashSet<SymId> =
        group.connections.iter().filter(|c| c.from_layer == number).map(|c| c.from.symbol).collect();
    let layer = &mut group.layers[number];
    let shader = Arc::make_mut(&mut layer.shader);
    if drops_outputs {
        let unused: Vec<bool> = (0..shader.symbols.len() as SymId)
            .map(|id| {
                let is_output = shader.symbol(id).kind == SymbolKind::OutputParam;
                is_output && !needed.contains(&id) && !is_wanted(number, id)
            })
            .collect();
        remove_unused(shader, &unused);
    }
    let mut reads = vec![false; shader.symbols.len()];
    for block in all_blocks(shader) {
        uses(block, &mut |id, usage| reads[id as usize] |= usage == Use::Read);
    }
    group
        .connections
        .retain(|c| c.to_layer != number || reads[c.to.symbol as usize] || needed.contains(&c.to.symbol));
}

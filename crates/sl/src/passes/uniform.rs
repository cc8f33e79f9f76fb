// SPDX-License-Identifier: GPL-3.0-or-later
//! Finds the symbols that may differ from point to point, by data and by control: what is written under a condition that
//! differs differs too.
//! Source: original; a forward data-flow over whole symbols. What is left is the same at all points, so that a back end with
//! lanes may keep one value and take real branches.

use crate::ir::{Block, Node, Op, Shader, SymId, SymbolKind};

/// Operations that ask the renderer about the point.
fn asks(name: &str) -> bool {
    matches!(
        name,
        "getattribute"
            | "getmessage"
            | "raytype"
            | "trace"
            | "lightcount"
            | "illuminate"
            | "gettextureinfo"
            | "backfacing"
            | "surfacearea"
            | "random"
            | "texture"
            | "texture3d"
            | "environment"
            | "pointcloud_search"
            | "pointcloud_get"
            | "closure"
            | "dict_find"
            | "dict_next"
            | "dict_value"
    )
}

/// By symbol, whether it varies. `given` says which parameters vary: those of the geometry, and connected ones whose source does.
#[must_use]
pub fn varying(shader: &Shader, given: &dyn Fn(SymId) -> bool) -> Vec<bool> {
    let mut state: Vec<bool> = shader
        .symbols
        .iter()
        .enumerate()
        .map(|(id, s)| s.kind == SymbolKind::Global || (s.kind.is_param() && given(id as SymId)))
        .collect();
    loop {
        let mut changed = false;
        for symbol in &shader.symbols {
            block(&symbol.init, false, &mut state, &mut changed);
        }
        block(&shader.code, false, &mut state, &mut changed);
        if !changed {
            return state;
        }
    }
}

fn mark(state: &mut [bool], id: SymId, changed: &mut bool) {
    *changed |= !std::mem::replace(&mut state[id as usize], true);
}

/// Returns whether lanes may have left the block at different times.
fn block(nodes: &Block, mut split: bool, state: &mut [bool], changed: &mut bool) -> bool {
    for node in nodes {
        match node {
            Node::Op(op) => split |= operation(op, split, state, changed),
            Node::If { condition, yes, no, .. } => {
                let inner = split || state[*condition as usize];
                let left = block(yes, inner, state, changed);
                let right = block(no, inner, state, changed);
                // Only what leaves an outer block keeps lanes apart after the choice.
                split |= (left || right) && leaves(yes, no);
            }
            Node::Loop { init, test, condition, body, step, .. } => {
                block(init, split, state, changed);
                let mut inner = split || state[*condition as usize];
                inner |= block(test, inner, state, changed);
                inner |= block(body, inner, state, changed);
                inner |= state[*condition as usize];
                for part in [test, body, step] {
                    block(part, inner, state, changed);
                }
                split |= inner && leaves(body, step);
            }
            Node::Call { body, .. } => {
                block(body, split, state, changed);
            }
        }
    }
    split
}

/// Whether a jump out of the blocks is in them.
fn leaves(a: &Block, b: &Block) -> bool {
    a.iter().chain(b).any(|node| match node {
        Node::Op(op) => matches!(&*op.name, "break" | "continue" | "return" | "exit"),
        Node::If { yes, no, .. } => leaves(yes, no),
        Node::Loop { body, step, .. } => leaves(body, step),
        Node::Call { body, .. } => leaves(body, &Vec::new()),
    })
}

fn operation(op: &Op, split: bool, state: &mut [bool], changed: &mut bool) -> bool {
    if matches!(&*op.name, "break" | "continue" | "return" | "exit") {
        return split;
    }
    let varies = split
        || asks(&op.name)
        || op.args.iter().enumerate().any(|(i, &a)| op.is_read(i) && state[a as usize]);
    if varies {
        for (i, &arg) in op.args.iter().enumerate() {
            if op.is_written(i) {
                mark(state, arg, changed);
            }
        }
    }
    false
}

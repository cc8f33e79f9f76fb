// SPDX-License-Identifier: GPL-3.0-or-later
//! What closures are made of.
//! Source: original.

use crate::hir::Data;
use crate::types::Type;
use std::sync::Arc;

/// One parameter of a closure.
#[derive(Clone, Debug)]
pub struct ClosureParam {
    /// Its type.
    pub ty: Type,
    /// Its name, if it is given by name after the others.
    pub key: Option<Arc<str>>,
}

/// What a closure takes.
#[derive(Clone, Debug)]
pub struct ClosureDecl {
    /// Its name.
    pub name: Arc<str>,
    /// What it takes.
    pub params: Vec<ClosureParam>,
}

/// A named part.
#[derive(Clone, Debug)]
pub struct Component {
    /// Its name.
    pub name: Arc<str>,
    /// Its parameters' values and keys.
    pub params: Vec<(Option<Arc<str>>, Type, Data)>,
}

/// A node of the tree; others are named by their numbers, which are lower than its own.
#[derive(Clone, Debug)]
pub enum Closure {
    /// A part of weight 1.
    Component(Component),
    /// A part times a weight.
    Mul([f32; 3], u32),
    /// Two parts.
    Add(u32, u32),
}

/// Nodes that a batch may have.
pub(super) const NODES: usize = 1 << 20;

/// The components of a closure with their weights, in order: of node `number`, counted from 1.
#[must_use]
pub fn parts(nodes: &[Closure], number: u32) -> Vec<([f32; 3], &Component)> {
    let mut out = Vec::new();
    let mut open = vec![(number, [1.0_f32; 3])];
    while let Some((number, w)) = open.pop() {
        if out.len() > NODES {
            break;
        }
        match (number as usize).checked_sub(1).and_then(|i| nodes.get(i)) {
            Some(Closure::Component(component)) => out.push((w, component)),
            Some(Closure::Mul(weight, inner)) => {
                open.push((*inner, [weight[0] * w[0], weight[1] * w[1], weight[2] * w[2]]));
            }
            Some(Closure::Add(a, b)) => {
                open.push((*b, w));
                open.push((*a, w));
            }
            None => {}
        }
    }
    out
}

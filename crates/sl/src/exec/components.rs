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

// SPDX-License-Identifier: GPL-3.0-or-later
//! Walks over blocks.

use super::shader::{Block, Node, Op, SymId};

/// How a symbol is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Use {
    /// Its value is taken.
    Read,
    /// It gets a value.
    Write,
}

/// Calls `visit` for every operation, inner ones too, in the order of the text.
pub fn ops<'b>(block: &'b [Node], visit: &mut dyn FnMut(&'b Op)) {
    for node in block {
        match node {
            Node::Op(op) => visit(op),
            Node::If { yes, no, .. } => {
                ops(yes, visit);
                ops(no, visit);
            }
            Node::Loop { init, test, body, step, .. } => {
                for part in [init, test, body, step] {
                    ops(part, visit);
                }
            }
            Node::Call { body, .. } => ops(body, visit),
        }
    }
}

/// The same with operations that may be changed.
pub fn ops_mut(block: &mut Block, visit: &mut dyn FnMut(&mut Op)) {
    for node in block {
        match node {
            Node::Op(op) => visit(op),
            Node::If { yes, no, .. } => {
                ops_mut(yes, visit);
                ops_mut(no, visit);
            }
            Node::Loop { init, test, body, step, .. } => {
                for part in [init, test, body, step] {
                    ops_mut(part, visit);
                }
            }
            Node::Call { body, .. } => ops_mut(body, visit),
        }
    }
}

/// Calls `visit` for every use of a symbol.
pub fn uses(block: &[Node], visit: &mut dyn FnMut(SymId, Use)) {
    for node in block {
        match node {
            Node::Op(op) => {
                for (i, &arg) in op.args.iter().enumerate() {
                    if op.is_read(i) {
                        visit(arg, Use::Read);
                    }
                    if op.is_written(i) {
                        visit(arg, Use::Write);
                    }
                }
            }
            Node::If { condition, yes, no, .. } => {
                visit(*condition, Use::Read);
                uses(yes, visit);
                uses(no, visit);
            }
            Node::Loop { init, test, condition, body, step, .. } => {
                visit(*condition, Use::Read);
                for part in [init, test, body, step] {
                    uses(part, visit);
                }
            }
            Node::Call { name, body, .. } => {
                visit(*name, Use::Read);
                uses(body, visit);
            }
        }
    }
}

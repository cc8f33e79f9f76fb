// SPDX-License-Identifier: GPL-3.0-or-later
//! Choices: `&&`, `||` and `?:` evaluate only the needed operands.

use super::lowerer::{Lowerer, Value};
use crate::hir::Expr;
use crate::ir::Node;
use crate::source::Loc;
use crate::types::Type;

impl Lowerer<'_> {
    pub(super) fn logic(&mut self, and: bool, a: &Expr, b: &Expr, loc: Loc) -> Value {
        let left = self.expr(a, None);
        let out = self.truth(&left, true, loc);
        let right = self.block(|l| {
            let value = l.expr(b, None);
            let truth = l.truth(&value, true, loc);
            l.emit("assign", &[out, truth], loc);
        });
        let (yes, no) = if and { (right, Vec::new()) } else { (Vec::new(), right) };
        let at = self.at(loc);
        self.push(Node::If { condition: out, yes, no, at });
        Value { ty: Type::INT, leaves: [out].into() }
    }

    pub(super) fn ternary(&mut self, parts: &[Expr; 3], ty: Type, loc: Loc) -> Value {
        let out = self.temp(ty);
        let condition = self.condition(&parts[0]);
        let branch = |l: &mut Self, e: &Expr| {
            l.block(|l| {
                let value = l.expr(e, Some(&out));
                let value = l.convert(value, ty, loc);
                l.copy(&out, &value, loc);
            })
        };
        let yes = branch(self, &parts[1]);
        let no = branch(self, &parts[2]);
        let at = self.at(loc);
        self.push(Node::If { condition, yes, no, at });
        out
    }
}

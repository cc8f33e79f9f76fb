// SPDX-License-Identifier: GPL-3.0-or-later
//! Statements.

use super::lowerer::Lowerer;
use crate::hir::{Expr, Stmt, StmtKind};
use crate::ir::Node;
use crate::source::Loc;
use crate::types::Type;

impl Lowerer<'_> {
    /// Statements in order; `last` if nothing of the function comes after them.
    pub(super) fn statements(&mut self, list: &[Stmt], last: bool) {
        for (i, s) in list.iter().enumerate() {
            self.statement(s, last && i + 1 == list.len());
        }
    }

    fn jump(&mut self, keyword: &str, loc: Loc) {
        self.emit_with(keyword, Vec::new(), [0; 3], loc);
    }

    fn statement(&mut self, s: &Stmt, last: bool) {
        if !self.full() {
            self.deeper(s.loc, |l| l.statement_here(s, last));
        }
    }

    fn statement_here(&mut self, s: &Stmt, last: bool) {
        match &s.kind {
            StmtKind::Block(list) => self.statements(list, last),
            StmtKind::If(condition, yes, no) => {
                let condition = self.condition(condition);
                let yes = self.block(|l| l.statements(yes, false));
                let no = self.block(|l| l.statements(no, false));
                let at = self.at(s.loc);
                self.push(Node::If { condition, yes, no, at });
            }
            StmtKind::Loop { keyword, init, condition, step, body } => {
                let init = self.block(|l| l.statements(init, false));
                let mut symbol = 0;
                let test = self.block(|l| symbol = l.condition(condition));
                let body = self.block(|l| l.statements(body, false));
                let step = self.block(|l| {
                    if let Some(step) = step {
                        l.expr(step, None);
                    }
                });
                let at = self.at(s.loc);
                self.push(Node::Loop { keyword, init, test, condition: symbol, body, step, at });
            }
            StmtKind::Break => self.jump("break", s.loc),
            StmtKind::Continue => self.jump("continue", s.loc),
            StmtKind::Return(value) => self.returned(value.as_ref(), last, s.loc),
            StmtKind::Declare(list) => {
                for &id in list {
                    let program = self.program;
                    let value = self.var(id);
                    if let Some(init) = &program.vars[id as usize].init {
                        self.set(&value, init, program.vars[id as usize].loc);
                    }
                }
            }
            StmtKind::Expr(e) => drop(self.expr(e, None)),
        }
    }

    fn returned(&mut self, value: Option<&Expr>, last: bool, loc: Loc) {
        let Some(inline) = self.inlines.last() else {
            self.jump("exit", loc);
            return;
        };
        let result = inline.result.clone();
        if let (Some(to), Some(value)) = (result, value) {
            if matches!(value.kind, crate::hir::ExprKind::StructList(_)) {
                self.set(&to, value, loc);
            } else {
                let value = self.expr(value, Some(&to));
                let value = if to.ty == Type::CLOSURE { value } else { self.convert(value, to.ty, loc) };
                self.copy(&to, &value, loc);
            }
        }
        if !last {
            self.jump("return", loc);
        }
    }
}

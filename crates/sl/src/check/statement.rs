// SPDX-License-Identifier: GPL-3.0-or-later
//! Statements.
//! The rules and words are OSL's.

use super::checker::Checker;
use crate::ast;
use crate::hir::{Expr, ExprKind, Stmt, StmtKind, VarKind};
use crate::source::Loc;
use crate::types::Type;

impl Checker<'_> {
    pub(super) fn statements(&mut self, list: &[ast::Stmt]) -> Vec<Stmt> {
        list.iter().filter_map(|s| self.statement(s)).collect()
    }

    fn one(&mut self, s: &ast::Stmt) -> Vec<Stmt> {
        self.statement(s).into_iter().collect()
    }

    fn condition(&mut self, e: &ast::Expr, keyword: Option<&str>) -> Expr {
        let condition = self.expr(e, Type::UNKNOWN);
        let ty = condition.ty;
        let shown = keyword.unwrap_or("if");
        for (bad, what) in [
            (keyword.is_some() && ty == Type::CLOSURE, "a closure"),
            (ty.is_struct(), "a struct"),
            (ty.is_array(), "an array"),
            (ty == Type::VOID, "nothing"),
        ] {
            if bad {
                self.error(e.loc, format!("Cannot use {what} as an '{shown}' condition"));
            }
        }
        condition
    }

    fn in_loop<T>(&mut self, inner: impl FnOnce(&mut Self) -> T) -> T {
        if let Some(frame) = self.frames.last_mut() {
            frame.loops += 1;
        }
        let out = inner(self);
        if let Some(frame) = self.frames.last_mut() {
            frame.loops -= 1;
        }
        out
    }

    fn statement(&mut self, s: &ast::Stmt) -> Option<Stmt> {
        let kind = match &s.kind {
            ast::StmtKind::Empty => return None,
            ast::StmtKind::Block(list) => {
                self.scopes.push();
                let list = self.statements(list);
                self.scopes.pop();
                StmtKind::Block(list)
            }
            ast::StmtKind::If(condition, yes, no) => {
                let condition = self.condition(condition, None);
                let yes = self.one(yes);
                let no = no.as_ref().map_or(Vec::new(), |s| self.one(s));
                StmtKind::If(condition, yes, no)
            }
            ast::StmtKind::While(condition, body) => {
                let (condition, body) =
                    self.in_loop(|c| (c.condition(condition, Some("while")), c.one(body)));
                StmtKind::Loop { keyword: "while", init: Vec::new(), condition, step: None, body }
            }
            ast::StmtKind::DoWhile(body, condition) => {
                let (body, condition) =
                    self.in_loop(|c| (c.one(body), c.condition(condition, Some("dowhile"))));
                StmtKind::Loop { keyword: "dowhile", init: Vec::new(), condition, step: None, body }
            }
            ast::StmtKind::For(init, condition, step, body) => {
                self.for_loop(init, condition.as_ref(), step.as_ref(), body, s.loc)
            }
            ast::StmtKind::Break | ast::StmtKind::Continue => {
                let (kind, keyword) = match s.kind {
                    ast::StmtKind::Break => (StmtKind::Break, "break"),
                    _ => (StmtKind::Continue, "continue"),
                };
                if self.frames.last().is_none_or(|f| f.loops == 0) {
                    self.error(s.loc, format!("Cannot '{keyword}' here -- not inside a loop."));
                    return None;
                }
                kind
            }
            ast::StmtKind::Return(value) => self.returned(value.as_ref(), s.loc),
            ast::StmtKind::Declare(ty, list) => {
                let ty = self.type_of(ty);
                let ids = list.iter().map(|d| self.variable_declaration(d, ty, VarKind::Local)).collect();
                StmtKind::Declare(ids)
            }
            ast::StmtKind::Function(function) => {
                self.function(function);
                return None;
            }
            ast::StmtKind::Expr(e) => StmtKind::Expr(self.expr(e, Type::UNKNOWN)),
        };
        Some(Stmt { kind, loc: s.loc })
    }

    fn for_loop(
        &mut self,
        init: &ast::Stmt,
        condition: Option<&ast::Expr>,
        step: Option<&ast::Expr>,
        body: &ast::Stmt,
        loc: Loc,
    ) -> StmtKind {
        self.scopes.push();
        let init = self.one(init);
        let (condition, step, body) = self.in_loop(|c| {
            let condition = match condition {
                Some(e) => c.condition(e, Some("for")),
                None => Expr { kind: ExprKind::Int(1), ty: Type::INT, loc },
            };
            let step = step.map(|e| c.expr(e, Type::UNKNOWN));
            (condition, step, c.one(body))
        });
        self.scopes.pop();
        StmtKind::Loop { keyword: "for", init, condition, step, body }
    }

    fn returned(&mut self, value: Option<&ast::Expr>, loc: Loc) -> StmtKind {
        let Some((ty, name)) = self.frames.last().and_then(|f| f.returns.clone()) else {
            if let Some(value) = value {
                self.expr(value, Type::UNKNOWN);
                self.error(loc, "Cannot return a value from a shader body".to_owned());
            }
            return StmtKind::Return(None);
        };
        if let Some(frame) = self.frames.last_mut() {
            frame.returned += 1;
        }
        let value = value.map(|e| self.expr(e, ty));
        match &value {
            Some(e) if !ty.assignable_from(e.ty, &self.program.structs) => {
                let message =
                    format!("Cannot return a '{}' from '{} {name}()'", self.show(e.ty), self.show(ty));
                self.error(loc, message);
            }
            None if ty != Type::VOID => {
                self.error(loc, format!("You must return a '{}' from function '{name}'", self.show(ty)));
            }
            _ => {}
        }
        StmtKind::Return(value)
    }
}

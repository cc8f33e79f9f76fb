// SPDX-License-Identifier: GPL-3.0-or-later
//! Values in braces, whose type is that of their target. The rules and words are OSL's.

use super::assignment::is_empty_closure;
use super::checker::Checker;
use crate::ast;
use crate::hir::{Expr, ExprKind};
use crate::source::Loc;
use crate::types::{Base, Type};

impl Checker<'_> {
    /// Braces as a value of type `to`. `report`: report faults; `all`: every member and element must be
    /// given.
    pub(super) fn braces(&mut self, e: &ast::Expr, to: Type, report: bool, all: bool) -> Option<Expr> {
        let ast::ExprKind::Braces(list) = &e.kind else { return None };
        if !self.may_try(e.loc) {
            return None;
        }
        if list.is_empty() && report && !self.formals_of_shader {
            let message = "Empty compound initializers '{ }' only allowed for shader parameters.".to_owned();
            self.early_error(e.loc, message);
        }
        if to.is_array() {
            return self.array(list, to, e.loc, report, all);
        }
        if let Base::Struct(id) = to.base {
            if list.is_empty() && all {
                return None;
            }
            let members = self.members(id, list, e.loc, report, all)?;
            return Some(Expr { kind: ExprKind::StructList(members), ty: to, loc: e.loc });
        }
        if list.is_empty() {
            if all && report {
                let message =
                    format!("Empty initializer list not allowed to represent '{}' here", self.show(to));
                self.error(e.loc, message);
            }
            return if all {
                None
            } else {
                Some(Expr { kind: ExprKind::ArrayList(Vec::new()), ty: to, loc: e.loc })
            };
        }
        self.construct(to, list, e.loc, report)
    }

    fn array(&mut self, list: &[ast::Expr], to: Type, loc: Loc, report: bool, all: bool) -> Option<Expr> {
        let element = to.element();
        let mut values = Vec::with_capacity(list.len());
        let mut good = true;
        for item in list {
            match self.part(item, element, None, report, all) {
                Some(value) => values.push(value),
                None if !report => return None,
                None => good = false,
            }
        }
        let expected = to.elements();
        let fits = to.array < 0 || if all { list.len() == expected } else { list.len() <= expected };
        if !fits && good {
            if report {
                let keyword = if list.len() < expected { "few" } else { "many" };
                let message = format!("Too {keyword} initializers for a '{}'", self.show(to));
                self.error_help(loc, message, format!("expected {expected}, found {}", list.len()));
            }
            return None;
        }
        let ty = if to.array < 0 && all { to.array_of(list.len() as i32) } else { to };
        good.then_some(Expr { kind: ExprKind::ArrayList(values), ty, loc })
    }

    /// One value for each member of a struct, as far as they go.
    pub(super) fn members(
        &mut self,
        id: u16,
        list: &[ast::Expr],
        loc: Loc,
        report: bool,
        all: bool,
    ) -> Option<Vec<Expr>> {
        let spec = self.program.structs.get(id)?.clone();
        let mut values = Vec::with_capacity(list.len());
        let mut good = true;
        for (item, field) in list.iter().zip(&spec.fields) {
            let field_path = format!(" {}.{}", spec.name, field.name);
            match self.part(item, field.ty, Some(&field_path), report, all) {
                Some(value) => values.push(value),
                None if !report => return None,
                None => good = false,
            }
        }
        let fits = if all { list.len() == spec.fields.len() } else { list.len() <= spec.fields.len() };
        if !fits && good {
            if report {
                let keyword = if list.len() < spec.fields.len() { "few" } else { "many" };
                let message = format!("Too {keyword} initializers for struct '{}'", spec.name);
                self.error_help(
                    loc,
                    message,
                    format!("expected {}, found {}", spec.fields.len(), list.len()),
                );
            }
            return None;
        }
        good.then_some(values)
    }

    fn part(
        &mut self,
        item: &ast::Expr,
        to: Type,
        field_path: Option<&str>,
        report: bool,
        all: bool,
    ) -> Option<Expr> {
        if matches!(item.kind, ast::ExprKind::Braces(_)) {
            return self.braces(item, to, report, all);
        }
        let value = self.expr(item, to);
        if value.ty == to
            || to.assignable_from(value.ty, &self.program.structs)
            || is_empty_closure(to, &value)
        {
            return Some(value);
        }
        if report {
            let field_path = field_path.unwrap_or("");
            let message =
                format!("Can't assign '{}' to '{}{field_path}'", self.show(value.ty), self.show(to));
            self.error(item.loc, message);
        }
        None
    }
}

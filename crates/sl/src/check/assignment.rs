// SPDX-License-Identifier: GPL-3.0-or-later
//! Assignments and whether their target may be written.
//! The rules and words are OSL's.

use super::checker::{Checker, wrong};
use crate::ast::{self, Binary};
use crate::hir::{Expr, ExprKind, VarId, VarKind};
use crate::source::Loc;
use crate::types::Type;

/// Whether a written number 0 means the empty closure here.
pub(super) fn is_empty_closure(to: Type, e: &Expr) -> bool {
    let zero = match e.kind {
        ExprKind::Int(value) => value == 0,
        ExprKind::Float(value) => value == 0.0,
        _ => false,
    };
    zero && to == Type::CLOSURE
}

impl Checker<'_> {
    /// The name as written of a variable.
    pub(super) fn plain_name(&self, id: VarId) -> &str {
        let name = &*self.program.vars[id as usize].name;
        match name.strip_prefix("___").and_then(|rest| rest.split_once('_')) {
            Some((_, plain)) => plain,
            None => name,
        }
    }

    /// The read-only variable that `target` is a part of.
    pub(super) fn read_only(&self, target: &Expr) -> Option<VarId> {
        target.root().filter(|id| self.readonly.contains(id))
    }

    fn writable(&mut self, target: &Expr, loc: Loc) {
        if let Some(id) = self.read_only(target) {
            let message = format!("cannot write to non-output parameter \"{}\"", self.plain_name(id));
            self.early_warning(loc, message);
        } else if let Some(id) =
            target.root().filter(|&id| self.program.vars[id as usize].kind == VarKind::Param)
        {
            let name = self.plain_name(id).to_owned();
            let message = format!("cannot write to non-output parameter \"{name}\"");
            self.error_help(
                loc,
                message,
                format!("declare it 'output', or copy it to a variable of its own: {name}_ = {name};"),
            );
        }
    }

    pub(super) fn increment(&mut self, up: bool, before: bool, target: &ast::Expr, loc: Loc) -> Expr {
        let target = self.expr(target, Type::UNKNOWN);
        self.writable(&target, loc);
        let ty = target.ty;
        if !(ty.is_unknown() || ty.is_scalar() || ty.is_triple()) {
            let sign = if up { "++" } else { "--" };
            self.error(loc, format!("Can't do '{sign}' to a {}.", self.show(ty)));
            return wrong(loc);
        }
        let target = Box::new(target);
        let kind = if before { ExprKind::Before(up, target) } else { ExprKind::After(up, target) };
        Expr { kind, ty, loc }
    }

    pub(super) fn assign(
        &mut self,
        op: Option<Binary>,
        target: &ast::Expr,
        value: &ast::Expr,
        loc: Loc,
    ) -> Expr {
        let target = self.expr(target, Type::UNKNOWN);
        self.writable(&target, loc);
        let value = self.expr(value, target.ty);
        let value = match op {
            Some(op) => {
                let old = Expr { kind: ExprKind::Old, ty: target.ty, loc };
                self.binary(op, old, value, loc)
            }
            None => value,
        };
        let name = match target.kind {
            ExprKind::Var(id) => self.plain_name(id).to_owned(),
            _ => String::new(),
        };
        let ty = target.ty;
        let fine = self.fits(ty, &name, &value, loc);
        if !fine {
            return Expr { kind: ExprKind::Error, ty, loc };
        }
        Expr { kind: ExprKind::Assign(Box::new(target), Box::new(value)), ty, loc }
    }

    /// Whether a value may be assigned to a variable of type `to`; reports it if not.
    pub(super) fn fits(&mut self, to: Type, name: &str, value: &Expr, loc: Loc) -> bool {
        let from = value.ty;
        let structs = &self.program.structs;
        let fine = if to.is_array() || from.is_array() {
            to.is_array()
                && from.is_array()
                && (to.array >= from.array || to.array < 0)
                && to.element().equivalent(from.element(), structs)
                && (to.struct_id() == from.struct_id())
        } else if to.is_struct() || from.is_struct() {
            to.base == from.base
        } else {
            is_empty_closure(to, value) || to.assignable_from(from, structs)
        };
        if fine {
            return true;
        }
        if to == Type::INT && from == Type::FLOAT {
            self.warning(loc, format!("Assignment may lose precision: int {name} = float"));
            return true;
        }
        let (to, from) = (self.show(to), self.show(from));
        self.error_help(
            loc,
            format!("Cannot assign {to} {name} = {from}"),
            format!("a value of type '{to}' is expected"),
        );
        false
    }
}

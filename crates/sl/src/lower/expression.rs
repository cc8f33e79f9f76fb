// SPDX-License-Identifier: GPL-3.0-or-later
//! Expressions.

use super::lowerer::{Lowerer, Value};
use crate::ast::{Binary, Unary};
use crate::hir::{Data, Expr, ExprKind};
use crate::source::Loc;
use crate::types::{Base, Type};

impl Lowerer<'_> {
    /// Symbols to leave a result in: the expected ones if they fit.
    pub(super) fn result(&mut self, ty: Type, expected: Option<&Value>) -> Value {
        match expected {
            Some(value)
                if ty.struct_id().is_none()
                    && value.ty.equivalent(ty, &self.program.structs)
                    && !ty.is_array() =>
            {
                Value { ty, ..value.clone() }
            }
            _ => self.temp(ty),
        }
    }

    /// Works out an expression. Its value is left in `expected` if that is as easy.
    pub(super) fn expr(&mut self, e: &Expr, expected: Option<&Value>) -> Value {
        match self.deeper(e.loc, |l| l.expr_here(e, expected)) {
            Some(value) => value,
            None => self.temp(e.ty),
        }
    }

    fn expr_here(&mut self, e: &Expr, expected: Option<&Value>) -> Value {
        let loc = e.loc;
        match &e.kind {
            ExprKind::Int(value) => self.constant(Type::INT, Data::Int(vec![*value])),
            ExprKind::Float(value) => self.constant(Type::FLOAT, Data::Float(vec![*value])),
            ExprKind::Str(value) => self.constant(Type::STRING, Data::Str(vec![value.clone()])),
            ExprKind::Var(id) => self.var(*id),
            ExprKind::Field(..) | ExprKind::Index(..) => {
                let target = self.target(e);
                self.load(&target, loc)
            }
            ExprKind::Old => match self.old.last() {
                Some(value) => value.clone(),
                None => self.temp(e.ty),
            },
            ExprKind::Unary(op, a) => self.unary(*op, a, e.ty, expected, loc),
            ExprKind::Binary(op @ (Binary::And | Binary::Or), a, b) => {
                self.logic(*op == Binary::And, a, b, loc)
            }
            ExprKind::Binary(op, a, b) => self.binary(*op, [a, b], e.ty, expected, loc),
            ExprKind::Ternary(parts) => self.ternary(parts, e.ty, loc),
            ExprKind::Assign(target, value) => self.assign(target, value, loc),
            ExprKind::Before(up, a) => self.increment(*up, true, a, loc),
            ExprKind::After(up, a) => self.increment(*up, false, a, loc),
            ExprKind::Comma(list) => {
                let mut last = None;
                for item in list {
                    last = Some(self.expr(item, None));
                }
                last.unwrap_or_else(|| self.temp(e.ty))
            }
            ExprKind::Cast(a) => {
                // A cast to the existing type, as in `(color) noise (P)`, does not prevent this.
                let value = self.expr(a, expected.filter(|_| a.ty == e.ty));
                self.convert(value, e.ty, loc)
            }
            ExprKind::Construct(parts) => self.construct(parts, e.ty, expected, loc),
            ExprKind::StructList(list) | ExprKind::ArrayList(list) => {
                let out = self.temp(e.ty);
                self.fill(&out, list, loc);
                out
            }
            ExprKind::Call(func, args) => self.call(*func, args, e.ty, loc),
            ExprKind::Builtin(call) => self.builtin(call, e.ty, expected, loc),
            ExprKind::Error => {
                self.error(loc, "cannot be compiled");
                self.temp(Type::INT)
            }
        }
    }

    fn unary(&mut self, op: Unary, a: &Expr, ty: Type, expected: Option<&Value>, loc: Loc) -> Value {
        let value = self.expr(a, None);
        if op == Unary::Not {
            // Not is a comparison with zero, for every type.
            let zero = match value.ty.base {
                Base::String => self.text(""),
                Base::Int | Base::Closure => self.int(0),
                _ => self.float(0.0),
            };
            let out = self.result(Type::INT, expected);
            self.emit("eq", &[out.symbol(), value.symbol(), zero], loc);
            return out;
        }
        let out = self.result(ty, expected);
        if ty == Type::CLOSURE {
            let minus = self.float(-1.0);
            self.emit("mul", &[out.symbol(), value.symbol(), minus], loc);
        } else {
            self.emit(op.keyword(), &[out.symbol(), value.symbol()], loc);
        }
        out
    }

    fn binary(
        &mut self,
        op: Binary,
        [a, b]: [&Expr; 2],
        ty: Type,
        expected: Option<&Value>,
        loc: Loc,
    ) -> Value {
        let mut left = self.expr(a, None);
        // The right side must not change an operand that was read before.
        left = self.settle(left, b, loc);
        let mut right = self.expr(b, None);
        if ty == Type::CLOSURE {
            if op == Binary::Mul && right.ty != Type::FLOAT {
                right = self.convert(right, Type::COLOR, loc);
            }
        } else if matches!(op, Binary::Mul | Binary::Div | Binary::Add | Binary::Sub) {
            if left.ty.base.is_float_based() && right.ty == Type::INT {
                right = self.convert(right, Type::FLOAT, loc);
            } else if right.ty.base.is_float_based() && left.ty == Type::INT {
                left = self.convert(left, Type::FLOAT, loc);
            }
        }
        let out = self.result(ty, expected);
        self.emit(op.keyword(), &[out.symbol(), left.symbol(), right.symbol()], loc);
        out
    }

    /// A copy of `value` if it is a variable and `next` may change variables.
    fn settle(&mut self, value: Value, next: &Expr, loc: Loc) -> Value {
        use crate::ir::SymbolKind::{Const, Param, Temp};
        let fixed = value.leaves.iter().all(|&s| matches!(self.kind(s), Const | Param | Temp));
        if fixed || !changes(next) {
            return value;
        }
        let out = self.temp(value.ty);
        self.copy(&out, &value, loc);
        out
    }

    fn assign(&mut self, target: &Expr, value: &Expr, loc: Loc) -> Value {
        let compound = uses_old(value);
        let target_value = if compound || matches!(target.kind, ExprKind::Var(_) | ExprKind::Field(..)) {
            Some(self.target(target))
        } else {
            None
        };
        if compound {
            let old = match &target_value {
                Some(target_value) => self.load(target_value, loc),
                None => self.temp(target.ty),
            };
            self.old.push(old);
        }
        let expected = target_value.as_ref().and_then(Self::whole);
        let given = self.expr(value, expected.as_ref());
        if compound {
            self.old.pop();
        }
        let target_value = match target_value {
            Some(target_value) => target_value,
            None => self.target(target),
        };
        if target.ty == Type::CLOSURE && given.ty != Type::CLOSURE {
            // The number 0 means the empty closure.
            self.store(&target_value, &given, loc);
            return given;
        }
        let given = self.convert(given, target.ty, loc);
        self.store(&target_value, &given, loc);
        expected.unwrap_or(given)
    }

    fn increment(&mut self, up: bool, before: bool, target: &Expr, loc: Loc) -> Value {
        let target_value = self.target(target);
        let old = self.load(&target_value, loc);
        let one = if target.ty == Type::INT { self.int(1) } else { self.float(1.0) };
        let old_value = if before {
            None
        } else {
            let old_value = self.temp(target.ty);
            self.copy(&old_value, &old, loc);
            Some(old_value)
        };
        let new = Self::whole(&target_value).unwrap_or_else(|| self.temp(target.ty));
        self.emit(if up { "add" } else { "sub" }, &[new.symbol(), old.symbol(), one], loc);
        self.store(&target_value, &new, loc);
        old_value.unwrap_or(new)
    }
}

fn uses_old(e: &Expr) -> bool {
    match &e.kind {
        ExprKind::Old => true,
        ExprKind::Binary(_, a, b) => uses_old(a) || uses_old(b),
        ExprKind::Call(_, args) => args.iter().any(uses_old),
        _ => false,
    }
}

/// Whether working it out may change a variable.
fn changes(e: &Expr) -> bool {
    match &e.kind {
        ExprKind::Assign(..) | ExprKind::Before(..) | ExprKind::After(..) | ExprKind::Call(..) => true,
        ExprKind::Builtin(call) => call.writes != 0 || call.args.iter().any(changes),
        ExprKind::Unary(_, a) | ExprKind::Cast(a) | ExprKind::Field(a, _) => changes(a),
        ExprKind::Binary(_, a, b) => changes(a) || changes(b),
        ExprKind::Ternary(parts) => parts.iter().any(changes),
        ExprKind::Index(a, list) => changes(a) || list.iter().any(changes),
        ExprKind::Comma(list)
        | ExprKind::Construct(list)
        | ExprKind::StructList(list)
        | ExprKind::ArrayList(list) => list.iter().any(changes),
        ExprKind::Int(_)
        | ExprKind::Float(_)
        | ExprKind::Str(_)
        | ExprKind::Var(_)
        | ExprKind::Old
        | ExprKind::Error => false,
    }
}

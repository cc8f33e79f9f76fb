// SPDX-License-Identifier: GPL-3.0-or-later
//! Operators, and functions that give them a meaning for structs.
//! The rules and words are OSL's.

use super::call::Arg;
use super::checker::{Checker, wrong};
use super::expression::higher;
use super::signature::Formal;
use crate::ast::{self, Binary, Unary};
use crate::hir::{Expr, ExprKind};
use crate::source::Loc;
use crate::types::Type;

impl Checker<'_> {
    /// The result of the function that overloads an operator, if there is one for these types.
    fn overloaded(&mut self, keyword: &str, args: &[Expr], loc: Loc) -> Option<Expr> {
        let name = format!("__operator__{keyword}__");
        let structs = &self.program.structs;
        let fits = |formal: &Formal, arg: &Expr| match formal {
            Formal::Is(ty) => {
                ty.assignable_from(arg.ty, structs)
                    || (ty.array < 0 && arg.ty.is_array() && ty.element() == arg.ty.element())
            }
            _ => false,
        };
        let found = self.overloads(&name).into_iter().find(|&n| {
            let formals = &self.signatures[n as usize].formals;
            formals.len() == args.len() && formals.iter().zip(args).all(|(f, a)| fits(f, a))
        })?;
        let returns = self.signatures[found as usize].returns;
        let args = args.iter().cloned().map(Arg::Checked).collect();
        Some(self.resolve(&name.into(), args, returns, loc))
    }

    pub(super) fn unary(&mut self, op: Unary, operand: &ast::Expr, expected: Type, loc: Loc) -> Expr {
        let operand = self.expr(operand, expected);
        if let Some(made) = self.overloaded(op.keyword(), std::slice::from_ref(&operand), loc) {
            return made;
        }
        let ty = operand.ty;
        let usable = !(ty.struct_id().is_some() || ty.is_array());
        let result = match op {
            Unary::Neg if usable && (ty == Type::CLOSURE || ty.is_numeric()) => ty,
            Unary::Not if usable => Type::INT,
            Unary::Compl if ty == Type::INT => ty,
            Unary::Compl if usable => {
                self.error(loc, "Operator '~' can only be done to an int".to_owned());
                return wrong(loc);
            }
            _ => {
                self.error(loc, format!("Can't do '{}' to a {}.", op.sign(), self.show(ty)));
                return wrong(loc);
            }
        };
        Expr { kind: ExprKind::Unary(op, Box::new(operand)), ty: result, loc }
    }

    /// An operator between checked values.
    pub(super) fn binary(&mut self, op: Binary, a: Expr, b: Expr, loc: Loc) -> Expr {
        if !matches!(op, Binary::And | Binary::Or)
            && let Some(made) = self.overloaded(op.keyword(), &[a.clone(), b.clone()], loc)
        {
            return made;
        }
        let Some(ty) = self.binary_type(op, a.ty, b.ty) else {
            let message = format!("Not allowed: '{} {} {}'", self.show(a.ty), op.sign(), self.show(b.ty));
            self.error(loc, message);
            return wrong(loc);
        };
        // Closures are left of their weights.
        let swap = ty == Type::CLOSURE && op == Binary::Mul && b.ty == Type::CLOSURE;
        let (a, b) = if swap { (b, a) } else { (a, b) };
        Expr { kind: ExprKind::Binary(op, Box::new(a), Box::new(b)), ty, loc }
    }

    fn binary_type(&self, op: Binary, l: Type, r: Type) -> Option<Type> {
        if [l, r].iter().any(|t| t.struct_id().is_some() || t.is_array()) {
            return None;
        }
        let either = |test: &dyn Fn(Type) -> bool| test(l) || test(r);
        if either(&|t| t == Type::CLOSURE) {
            let both = l == r;
            let weight = if l == Type::CLOSURE { r } else { l };
            return match op {
                Binary::Add if both => Some(l),
                Binary::Mul if !both && (weight == Type::COLOR || weight.is_scalar()) => Some(Type::CLOSURE),
                Binary::And | Binary::Or => Some(Type::INT),
                _ => None,
            };
        }
        let same = l.equivalent(r, &self.program.structs);
        let mixed = (l.is_numeric() && r.is_scalar()) || (l.is_scalar() && r.is_numeric());
        match op {
            Binary::Mul | Binary::Div | Binary::Add | Binary::Sub => {
                let sum = matches!(op, Binary::Add | Binary::Sub);
                if either(&|t| t == Type::STRING || t.is_unknown() || t == Type::VOID)
                    || (sum && either(&|t| t == Type::MATRIX))
                {
                    return None;
                }
                if same {
                    return Some(match (op, l, r) {
                        (Binary::Sub, Type::POINT, Type::POINT) => Type::VECTOR,
                        (Binary::Add | Binary::Sub, a, b) if a == Type::POINT || b == Type::POINT => {
                            Type::POINT
                        }
                        _ => l,
                    });
                }
                mixed.then(|| higher(l, r))
            }
            Binary::Eq | Binary::Neq => {
                ((same && !l.is_unknown() && l != Type::VOID) || mixed).then_some(Type::INT)
            }
            Binary::Gt | Binary::Lt | Binary::Ge | Binary::Le => {
                (l.is_scalar() && r.is_scalar()).then_some(Type::INT)
            }
            Binary::Mod | Binary::BitAnd | Binary::BitOr | Binary::Xor | Binary::Shl | Binary::Shr => {
                (l == Type::INT && r == Type::INT).then_some(Type::INT)
            }
            Binary::And | Binary::Or => (l != Type::VOID && r != Type::VOID).then_some(Type::INT),
        }
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Calls of functions and of structs' constructors.
//! The rules and words are OSL's.

use super::checker::{Checker, wrong};
use super::scope::Named;
use super::signature::Formal;
use crate::ast;
use crate::hir::{Builtin, Expr, ExprKind};
use crate::source::Loc;
use crate::types::Type;
use std::sync::Arc;

/// An argument before the function is known.
pub(super) enum Arg<'e> {
    /// With its type.
    Checked(Expr),
    /// In braces, whose type the function gives.
    Braces(&'e ast::Expr),
}

impl Arg<'_> {
    pub(super) fn ty(&self) -> Type {
        match self {
            Self::Checked(e) => e.ty,
            Self::Braces(_) => Type::UNKNOWN,
        }
    }
}

impl Checker<'_> {
    pub(super) fn call(&mut self, name: &Arc<str>, args: &[ast::Expr], expected: Type, loc: Loc) -> Expr {
        match self.scopes.find(name) {
            Some(Named::Struct(id)) => {
                let id = *id;
                return self.construct_struct(id, args, loc);
            }
            Some(Named::Funcs(_)) => {}
            Some(_) => self.early_error(loc, format!("'{name}' is not a function")),
            None => {
                let help = self.nearest(name, true);
                self.early_error_help(loc, format!("function '{name}' was not declared in this scope"), help);
            }
        }
        let args = args
            .iter()
            .map(|arg| match arg.kind {
                ast::ExprKind::Braces(_) => Arg::Braces(arg),
                _ => Arg::Checked(self.expr(arg, expected)),
            })
            .collect();
        self.resolve(name, args, expected, loc)
    }

    fn construct_struct(&mut self, id: u16, args: &[ast::Expr], loc: Loc) -> Expr {
        let ty = Type::of(crate::types::Base::Struct(id));
        let (name, expected_type) =
            self.program.structs.get(id).map_or((String::new(), 0), |s| (s.name.clone(), s.fields.len()));
        if expected_type != args.len() {
            let counts = format!("(expected {expected_type}, got {})", args.len());
            self.error(loc, format!("Constructor for '{name}' has the wrong number of arguments {counts}"));
        }
        match self.members(id, args, loc, true, false) {
            Some(members) => Expr { kind: ExprKind::StructList(members), ty, loc },
            None => Expr { kind: ExprKind::Error, ty, loc },
        }
    }

    /// Chooses the function and makes the call.
    pub(super) fn resolve(&mut self, name: &Arc<str>, args: Vec<Arg<'_>>, expected: Type, loc: Loc) -> Expr {
        let Some(chosen) = self.choose(name, &args, expected, loc) else { return wrong(loc) };
        let signature = self.signatures[chosen as usize].clone();
        let mut values = Vec::with_capacity(args.len());
        for (i, arg) in args.into_iter().enumerate() {
            values.push(match arg {
                Arg::Checked(e) => e,
                Arg::Braces(e) => {
                    let formal = match signature.formals.get(i) {
                        Some(Formal::Is(ty)) => *ty,
                        _ => Type::UNKNOWN,
                    };
                    self.braces(e, formal, true, true).unwrap_or_else(|| wrong(e.loc))
                }
            });
        }
        let ty = signature.returns;
        let Some(user) = signature.user else {
            return self.builtin(&signature, values, loc);
        };
        self.check_outputs(name, &signature.formals, signature.outputs, user, &values, loc);
        if self.signatures[chosen as usize].returned == 0 && ty != Type::VOID && signature.defined {
            self.error(loc, format!("non-void function \"{name}\" had no 'return' statement."));
        }
        if !signature.defined && self.mute == 0 {
            self.bodiless.push((user, loc));
        }
        Expr { kind: ExprKind::Call(user, values), ty, loc }
    }

    fn check_outputs(
        &mut self,
        name: &str,
        formals: &[Formal],
        outputs: u64,
        user: u32,
        values: &[Expr],
        loc: Loc,
    ) {
        for (i, value) in values.iter().enumerate().filter(|(i, _)| *i < 64 && outputs & (1 << i) != 0) {
            let formal = self.program.funcs[user as usize].formals.get(i).map_or(0, |f| f.0);
            if let Some(id) = self.read_only(value) {
                let message = format!(
                    "cannot write to non-output parameter \"{}\", as passed to function {name}() as arg {} (output parameter \"{}\")",
                    self.plain_name(id),
                    i + 1,
                    self.plain_name(formal)
                );
                self.warning(loc, message);
            }
            let Some(Formal::Is(expected_type)) = formals.get(i) else { continue };
            if !value.ty.equivalent(*expected_type, &self.program.structs) && value.ty != *expected_type {
                let (given, expected_type) = (self.show(value.ty), self.show(*expected_type));
                let message = format!(
                    "Cannot pass '{given}' as argument {} to {name}\n\tbecause it is an output parameter that must be a {expected_type}",
                    i + 1
                );
                self.error(value.loc, message);
            }
        }
    }

    fn builtin(&mut self, signature: &super::signature::Signature, args: Vec<Expr>, loc: Loc) -> Expr {
        let formals = (0..args.len())
            .map(|i| match signature.formals.get(i) {
                Some(Formal::Is(ty)) => *ty,
                _ => Type::UNKNOWN,
            })
            .collect();
        if signature.printf {
            self.check_printf(&signature.name, &args, loc);
        }
        let effects = super::special::effects(signature, &args);
        for (i, arg) in args.iter().enumerate().filter(|(i, _)| effects.writes & (1_u64 << (i & 63)) != 0) {
            if arg.root().is_none() && !matches!(arg.kind, ExprKind::Error) {
                let message =
                    format!("Argument {} of {} is written to and must be a variable", i + 1, signature.name);
                self.error(arg.loc, message);
            }
        }
        let call = Builtin {
            name: effects.name,
            args,
            formals,
            writes: effects.writes,
            reads: effects.reads,
            derivs: effects.derivs,
        };
        Expr { kind: ExprKind::Builtin(Box::new(call)), ty: signature.returns, loc }
    }
}

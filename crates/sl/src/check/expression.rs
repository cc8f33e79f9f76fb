// SPDX-License-Identifier: GPL-3.0-or-later
//! Expressions: variables, members, indices, choices, conversions and constructors.
//! The rules and words are OSL's.

use super::checker::{Checker, wrong};
use super::scope::Named;
use super::signature::type_of;
use crate::ast;
use crate::hir::{Expr, ExprKind};
use crate::source::Loc;
use crate::types::{Base, Type};

/// Of two compatible types, the one that holds more.
pub(super) fn higher(a: Type, b: Type) -> Type {
    let (x, y) = (a.base.components(), b.base.components());
    if x != y {
        return if x > y { a } else { b };
    }
    if b.base.is_float_based() { b } else { a }
}

impl Checker<'_> {
    /// Checks an expression where a value of type `expected` is required; unknown if any is allowed.
    pub(super) fn expr(&mut self, e: &ast::Expr, expected: Type) -> Expr {
        let loc = e.loc;
        let make = |kind, ty| Expr { kind, ty, loc };
        match &e.kind {
            ast::ExprKind::Int(value) => make(ExprKind::Int(*value), Type::INT),
            ast::ExprKind::Float(value) => make(ExprKind::Float(*value), Type::FLOAT),
            ast::ExprKind::Str(value) => make(ExprKind::Str(value.clone()), Type::STRING),
            ast::ExprKind::Name(name) => self.variable(name, loc),
            ast::ExprKind::Index(base, list) => self.index(base, list, loc),
            ast::ExprKind::Field(base, name) => self.field(base, name, loc),
            ast::ExprKind::Unary(op, a) => self.unary(*op, a, expected, loc),
            ast::ExprKind::Binary(op, a, b) => {
                let a = self.expr(a, expected);
                let b = self.expr(b, expected);
                self.binary(*op, a, b, loc)
            }
            ast::ExprKind::Ternary(parts) => self.ternary(parts, expected, loc),
            ast::ExprKind::Assign(op, target, value) => self.assign(*op, target, value, loc),
            ast::ExprKind::Before(up, target) => self.increment(*up, true, target, loc),
            ast::ExprKind::After(up, target) => self.increment(*up, false, target, loc),
            ast::ExprKind::Comma(list, parenthesised) => {
                if *parenthesised {
                    let message =
                        "Comma operator inside parenthesis is probably an error -- it is not a vector/color.";
                    self.early_warning(loc, message.to_owned());
                }
                let list: Vec<Expr> = list.iter().map(|e| self.expr(e, expected)).collect();
                let ty = list.last().map_or(Type::UNKNOWN, |e| e.ty);
                make(ExprKind::Comma(list), ty)
            }
            ast::ExprKind::Call(name, args) => self.call(name, args, expected, loc),
            ast::ExprKind::Construct(base, args) => match self.construct(Type::of(*base), args, loc, true) {
                Some(made) => made,
                None => wrong(loc),
            },
            ast::ExprKind::Cast(base, value) => self.cast(Type::of(*base), value, loc),
            ast::ExprKind::Braces(_) => self.braces(e, expected, true, false).unwrap_or_else(|| wrong(loc)),
        }
    }

    fn variable(&mut self, name: &str, loc: Loc) -> Expr {
        let id = match self.scopes.find(name) {
            Some(Named::Var(id)) => *id,
            found => {
                let (message, help) = match found {
                    None => (format!("'{name}' was not declared in this scope"), self.nearest(name, false)),
                    Some(Named::Funcs(_)) => (
                        format!("function '{name}' can't be used as a variable"),
                        Some(format!("call it: {name}(...)")),
                    ),
                    Some(_) => (format!("type name '{name}' can't be used as a variable"), None),
                };
                self.early_error_help(loc, message, help);
                return wrong(loc);
            }
        };
        Expr { kind: ExprKind::Var(id), ty: self.program.vars[id as usize].ty, loc }
    }

    fn index(&mut self, base: &ast::Expr, list: &[ast::Expr], loc: Loc) -> Expr {
        let base = self.expr(base, Type::UNKNOWN);
        let indices: Vec<Expr> = list.iter().map(|e| self.expr(e, Type::UNKNOWN)).collect();
        let ty = base.ty;
        let element = ty.element();
        let found = match (indices.len(), ty.is_array()) {
            (1, true) => Some(element),
            (1, false) if ty.is_triple() => Some(Type::FLOAT),
            (2, true) if element.is_triple() => Some(Type::FLOAT),
            (2, false) if ty == Type::MATRIX => Some(Type::FLOAT),
            (3, true) if element == Type::MATRIX => Some(Type::FLOAT),
            _ => None,
        };
        let Some(found) = found else {
            let help = match ty {
                t if t == Type::MATRIX => Some("a matrix takes two indices: m[row][column]".to_owned()),
                t if t.is_unknown() => None,
                t => Some(format!("'{}' cannot be indexed this way", self.show(t))),
            };
            self.early_error_help(loc, "indexing into non-array or non-component type".to_owned(), help);
            return wrong(loc);
        };
        for index in &indices {
            if index.ty != Type::INT && !index.ty.is_unknown() {
                let kind = if ty.is_array() { "array" } else { "component" };
                let message = format!("{kind} index must be an integer, not a {}", self.show(index.ty));
                self.error_help(index.loc, message, "convert it: (int) ...".to_owned());
            }
        }
        Expr { kind: ExprKind::Index(Box::new(base), indices), ty: found, loc }
    }

    fn field(&mut self, base: &ast::Expr, name: &str, loc: Loc) -> Expr {
        let base = self.expr(base, Type::UNKNOWN);
        let letters = match base.ty.base {
            Base::Color if !base.ty.is_array() => "rgb",
            b if b.is_spatial() && !base.ty.is_array() => "xyz",
            _ => "",
        };
        if let Some(component) = letters.find(name).filter(|_| name.len() == 1) {
            let index = Expr { kind: ExprKind::Int(component as i32), ty: Type::INT, loc };
            let kind = match base.kind {
                // A component of an array's element: one step, so that it can be assigned to.
                ExprKind::Index(array, mut list) if list.len() == 1 => {
                    list.push(index);
                    ExprKind::Index(array, list)
                }
                kind => ExprKind::Index(Box::new(Expr { kind, ..base }), vec![index]),
            };
            return Expr { kind, ty: Type::FLOAT, loc };
        }
        let Some(id) = base.ty.struct_id() else {
            let message = format!("type '{}' does not have a member '{name}'", self.show(base.ty));
            let help = (!letters.is_empty()).then(|| {
                let letters_text: Vec<String> = letters.chars().map(|c| format!(".{c}")).collect();
                format!("its members are {}", letters_text.join(", "))
            });
            self.early_error_help(loc, message, help);
            return wrong(loc);
        };
        let found = self.program.structs.get(id).map(|s| (s.name.clone(), s.fields.clone()));
        let (owner, fields) = found.unwrap_or_default();
        let Some(number) = fields.iter().position(|f| f.name == name) else {
            let names: Vec<&str> = fields.iter().map(|f| &*f.name).collect();
            let help = format!("its members are {}", names.join(", "));
            self.early_error_help(
                loc,
                format!("struct type '{owner}' does not have a member '{name}'"),
                Some(help),
            );
            return wrong(loc);
        };
        let mut ty = fields[number].ty;
        if base.ty.is_array() {
            ty = ty.array_of(base.ty.array.max(1) * ty.array.max(1));
        }
        Expr { kind: ExprKind::Field(Box::new(base), number as u32), ty, loc }
    }

    fn ternary(&mut self, parts: &[ast::Expr; 3], expected: Type, loc: Loc) -> Expr {
        let c = self.expr(&parts[0], Type::INT);
        let t = self.expr(&parts[1], expected);
        let f = self.expr(&parts[2], expected);
        for (bad, keyword) in [
            (c.ty == Type::CLOSURE, "a closure"),
            (c.ty.is_struct(), "a struct"),
            (c.ty.is_array(), "an array"),
        ] {
            if bad {
                self.error(loc, format!("Cannot use {keyword} as a condition"));
            }
        }
        let structs = &self.program.structs;
        let fit = t.ty.assignable_from(f.ty, structs) || f.ty.assignable_from(t.ty, structs);
        if t.ty.is_array() || f.ty.is_array() || !fit {
            let message =
                format!("Not allowed: '{} ? {} : {}'", self.show(c.ty), self.show(t.ty), self.show(f.ty));
            self.error_help(loc, message, "both choices must be of one type, and no arrays".to_owned());
            return wrong(loc);
        }
        let ty = if t.ty.struct_id().is_some() || t.ty == Type::CLOSURE { t.ty } else { higher(t.ty, f.ty) };
        Expr { kind: ExprKind::Ternary(Box::new([c, t, f])), ty, loc }
    }

    fn cast(&mut self, to: Type, value: &ast::Expr, loc: Loc) -> Expr {
        let value = self.expr(value, to);
        let from = value.ty;
        let fine = to.assignable_from(from, &self.program.structs)
            || (to == Type::INT && from == Type::FLOAT)
            || (to.is_triple() && from.is_triple());
        if !fine {
            self.error(loc, format!("Cannot cast '{}' to '{}'", self.show(from), self.show(to)));
        }
        Expr { kind: ExprKind::Cast(Box::new(value)), ty: to, loc }
    }

    /// `color(...)` and the like, also written as braces. None, with a message if `report`, if it cannot be made.
    pub(super) fn construct(&mut self, to: Type, args: &[ast::Expr], loc: Loc, report: bool) -> Option<Expr> {
        let (patterns, expected): (&[&str], Type) = match to {
            t if t == Type::FLOAT => (&["f", "i"], Type::FLOAT),
            t if t == Type::INT => (&["f", "i"], Type::UNKNOWN),
            t if t == Type::MATRIX => {
                (&["f", "sf", "ss", "ffffffffffffffff", "sffffffffffffffff", "m"], Type::UNKNOWN)
            }
            t if t.is_triple() => {
                (&["f", "fff", "sfff", "c", "p", "v", "n"], if args.len() == 1 { to } else { Type::FLOAT })
            }
            _ => {
                if report {
                    self.error(loc, format!("Cannot construct type '{}'", self.show(to)));
                }
                return None;
            }
        };
        let parts: Vec<Expr> = args.iter().map(|e| self.expr(e, expected)).collect();
        let fits = |pattern: &&&str| {
            let mut rest = **pattern;
            let all = parts.iter().all(|part| {
                !rest.is_empty() && type_of(&mut rest).assignable_from(part.ty, &self.program.structs)
            });
            all && rest.is_empty()
        };
        if patterns.iter().any(|pattern| fits(&pattern)) {
            return Some(Expr { kind: ExprKind::Construct(parts), ty: to, loc });
        }
        if report {
            let letters_text: Vec<String> = parts.iter().map(|p| self.show(p.ty)).collect();
            let message = format!("Cannot construct {} ({})", self.show(to), letters_text.join(", "));
            let help = match to {
                t if t == Type::MATRIX => "give one float, 16 floats, or the names of two spaces".to_owned(),
                t if t.is_triple() => {
                    "give one float, three floats, or a space's name and three floats".to_owned()
                }
                _ => "give one number".to_owned(),
            };
            self.error_help(loc, message, help);
        }
        None
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! `illuminance (P [, axis, angle] [, "category", name] [, "shadow", 0]) statement`: a loop over the lights. It is read as
//! ```text
//! for (int n = lightcount(), k = 0; k < n; ++k) {
//!     vector L; color Cl; float lightdist, lightpdf;
//!     if (illuminate(k, P [, axis, angle], L, Cl, lightdist, lightpdf [, names and values])) statement
//! }
//! ```
//! `illuminance` is a word that OSL reserves.

use super::reader::{Parse, Parser};
use crate::ast::{Binary, Declarator, Expr, ExprKind, Stmt, StmtKind, TypeName, TypeRef};
use crate::source::Loc;
use crate::types::Base;

/// The variables that an iteration of the loop sets.
const SET: [(&str, Base); 4] =
    [("L", Base::Vector), ("Cl", Base::Color), ("lightdist", Base::Float), ("lightpdf", Base::Float)];

fn expr(kind: ExprKind, depth: u16, loc: Loc) -> Expr {
    Expr { kind, loc, depth }
}

fn name(text: &str, loc: Loc) -> Expr {
    expr(ExprKind::Name(text.into()), 1, loc)
}

fn declare(base: Base, text: &str, init: Expr, loc: Loc) -> Stmt {
    let ty = TypeRef { keyword: TypeName::Simple(base), loc };
    let declarator = Declarator { name: text.into(), loc, array: None, init: Some(init) };
    Stmt { kind: StmtKind::Declare(ty, vec![declarator]), loc }
}

impl Parser {
    /// The rest after the keyword.
    pub(super) fn illuminance(&mut self) -> Parse<StmtKind> {
        let loc = self.loc();
        self.expect("(")?;
        let mut given = vec![self.expression()?];
        while self.take(",") {
            given.push(self.expression()?);
        }
        self.expect(")")?;
        let body = self.boxed()?;
        // Names and values follow the position, or the position and its cone.
        let is_text = |e: Option<&Expr>| matches!(e.map(|e| &e.kind), Some(ExprKind::Str(_)) | None);
        let location_count = if is_text(given.get(1)) { 1 } else { 3.min(given.len()) };
        let options = given.split_off(location_count);
        let depth = given.iter().chain(&options).map(|e| e.depth).max().unwrap_or(0) + 1;
        let (count, number) = ("__lights", "__light");
        let mut args = vec![name(number, loc)];
        args.extend(given);
        args.extend(SET.iter().map(|(keyword, _)| name(keyword, loc)));
        args.extend(options);
        let found = expr(ExprKind::Call("illuminate".into(), args), depth, loc);
        let zero = || expr(ExprKind::Int(0), 1, loc);
        let mut iteration: Vec<Stmt> =
            SET.iter().map(|(keyword, base)| declare(*base, keyword, zero(), loc)).collect();
        iteration.push(Stmt { kind: StmtKind::If(found, body, None), loc });
        let less = ExprKind::Binary(Binary::Lt, Box::new(name(number, loc)), Box::new(name(count, loc)));
        let step = ExprKind::Before(true, Box::new(name(number, loc)));
        let all = StmtKind::For(
            Box::new(declare(Base::Int, number, zero(), loc)),
            Some(expr(less, 2, loc)),
            Some(expr(step, 2, loc)),
            Box::new(Stmt { kind: StmtKind::Block(iteration), loc }),
        );
        let lights = expr(ExprKind::Call("lightcount".into(), Vec::new()), 1, loc);
        Ok(StmtKind::Block(vec![declare(Base::Int, count, lights, loc), Stmt { kind: all, loc }]))
    }
}

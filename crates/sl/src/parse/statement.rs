// SPDX-License-Identifier: GPL-3.0-or-later
//! Statements.
//! The grammar is OSL's.

use super::reader::{Parse, Parser};
use crate::ast::{Expr, Stmt, StmtKind};
use crate::token::Tok;
use crate::types::Base;

impl Parser {
    /// Statements up to a closing brace, which is taken.
    pub(super) fn statements(&mut self) -> Parse<Vec<Stmt>> {
        let mut list = Vec::new();
        while !self.is("}") {
            if self.peek().tok == Tok::End {
                return Err(self.syntax("'}'"));
            }
            list.push(self.statement()?);
        }
        self.expect("}")?;
        Ok(list)
    }

    fn condition(&mut self) -> Parse<Expr> {
        self.expect("(")?;
        let condition = self.comma()?;
        self.expect(")")?;
        Ok(condition)
    }

    pub(super) fn boxed(&mut self) -> Parse<Box<Stmt>> {
        Ok(Box::new(self.statement()?))
    }

    fn statement(&mut self) -> Parse<Stmt> {
        self.enter()?;
        let loc = self.loc();
        let kind = self.statement_kind()?;
        self.depth -= 1;
        Ok(Stmt { kind, loc })
    }

    fn statement_kind(&mut self) -> Parse<StmtKind> {
        if self.take("{") {
            return Ok(StmtKind::Block(self.statements()?));
        }
        if self.take(";") {
            return Ok(StmtKind::Empty);
        }
        if self.take_keyword("if") {
            let condition = self.condition()?;
            let yes = self.boxed()?;
            let no = if self.take_keyword("else") { Some(self.boxed()?) } else { None };
            return Ok(StmtKind::If(condition, yes, no));
        }
        if self.take_keyword("while") {
            let condition = self.condition()?;
            return Ok(StmtKind::While(condition, self.boxed()?));
        }
        if self.take_keyword("do") {
            let body = self.boxed()?;
            if !self.take_keyword("while") {
                return Err(self.syntax("'while'"));
            }
            let condition = self.condition()?;
            self.expect(";")?;
            return Ok(StmtKind::DoWhile(body, condition));
        }
        if self.take_keyword("for") {
            return self.for_loop();
        }
        if self.take_keyword("break") {
            self.expect(";")?;
            return Ok(StmtKind::Break);
        }
        if self.take_keyword("continue") {
            self.expect(";")?;
            return Ok(StmtKind::Continue);
        }
        if self.take_keyword("return") {
            let value = if self.is(";") { None } else { Some(self.expression_or_braces()?) };
            self.expect(";")?;
            return Ok(StmtKind::Return(value));
        }
        if !self.strict && self.take_keyword("illuminance") {
            return self.illuminance();
        }
        if self.starts_declaration() {
            let ty = self.type_ref()?;
            if self.is_name(0) && self.peek_at(1).is("(") {
                return Ok(StmtKind::Function(self.function(ty)?));
            }
            let list = self.declarators()?;
            return Ok(StmtKind::Declare(ty, list));
        }
        let value = self.comma()?;
        self.expect(";")?;
        Ok(StmtKind::Expr(value))
    }

    fn for_loop(&mut self) -> Parse<StmtKind> {
        self.expect("(")?;
        let loc = self.loc();
        let kind = if self.starts_declaration() {
            let ty = self.type_ref()?;
            StmtKind::Declare(ty, self.declarators()?)
        } else if self.take(";") {
            StmtKind::Empty
        } else {
            let value = self.expression()?;
            self.expect(";")?;
            StmtKind::Expr(value)
        };
        let condition = if self.is(";") { None } else { Some(self.comma()?) };
        self.expect(";")?;
        let step = if self.is(")") { None } else { Some(self.comma()?) };
        self.expect(")")?;
        let body = self.boxed()?;
        Ok(StmtKind::For(Box::new(Stmt { kind, loc }), condition, step, body))
    }

    /// Whether a type and a name come next.
    fn starts_declaration(&self) -> bool {
        let simple = self.peek().ident().is_some_and(|n| Base::from_keyword(n).is_some());
        if simple {
            return !self.peek_at(1).is("(");
        }
        self.is_keyword("closure") || (self.is_name(0) && self.is_name(1))
    }
}

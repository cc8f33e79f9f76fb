// SPDX-License-Identifier: GPL-3.0-or-later
//! Expressions.
//! The grammar is OSL's.

use super::fold::fold;
use super::reader::{Parse, Parser};
use super::unescape::unescape;
use crate::ast::{Binary, Expr, ExprKind, Unary};
use crate::source::Loc;
use crate::token::Tok;
use crate::types::Base;

const ASSIGN: [&str; 11] = ["=", "*=", "/=", "+=", "-=", "&=", "|=", "^=", "<<=", ">>=", ""];

impl Parser {
    /// `a, b, c`
    pub(super) fn comma(&mut self) -> Parse<Expr> {
        let first = self.expression()?;
        if !self.is(",") {
            return Ok(first);
        }
        let loc = first.loc;
        let mut list = vec![first];
        while self.take(",") {
            list.push(self.expression()?);
        }
        self.node(ExprKind::Comma(list, false), loc)
    }

    /// An expression without commas.
    pub(super) fn expression(&mut self) -> Parse<Expr> {
        self.enter()?;
        let condition = self.binary(1)?;
        let loc = self.loc();
        let out = if self.take("?") {
            let yes = self.expression()?;
            self.expect(":")?;
            let no = self.expression()?;
            self.node(ExprKind::Ternary(Box::new([condition, yes, no])), loc)?
        } else {
            condition
        };
        self.depth -= 1;
        Ok(out)
    }

    fn binary(&mut self, lowest: u8) -> Parse<Expr> {
        let mut left = self.unary()?;
        loop {
            let Tok::Sign(sign) = self.peek().tok else { return Ok(left) };
            let Some((op, level)) = Binary::from_sign(sign).filter(|found| found.1 >= lowest) else {
                return Ok(left);
            };
            let loc = self.next().loc;
            let right = self.binary(level + 1)?;
            left = match fold(op, &left.kind, &right.kind) {
                Some(kind) => self.node(kind, loc)?,
                None => self.node(ExprKind::Binary(op, Box::new(left), Box::new(right)), loc)?,
            };
        }
    }

    fn unary(&mut self) -> Parse<Expr> {
        self.enter()?;
        let out = self.unary_inner()?;
        self.depth -= 1;
        Ok(out)
    }

    fn unary_inner(&mut self) -> Parse<Expr> {
        let loc = self.loc();
        if self.take("+") {
            return self.unary();
        }
        if self.take("-") {
            let operand = self.unary()?;
            let kind = match operand.kind {
                ExprKind::Int(value) => ExprKind::Int(value.wrapping_neg()),
                ExprKind::Float(value) => ExprKind::Float(-value),
                _ => ExprKind::Unary(Unary::Neg, Box::new(operand)),
            };
            return self.node(kind, loc);
        }
        for (sign, op) in [("!", Unary::Not), ("~", Unary::Compl)] {
            if self.take(sign) {
                let operand = self.unary()?;
                return self.node(ExprKind::Unary(op, Box::new(operand)), loc);
            }
        }
        for (sign, up) in [("++", true), ("--", false)] {
            if self.take(sign) {
                let target = self.lvalue()?;
                return self.node(ExprKind::Before(up, Box::new(target)), loc);
            }
        }
        self.primary()
    }

    fn simple_type(&self, ahead: usize) -> Option<Base> {
        self.peek_at(ahead).ident().and_then(|name| Base::from_keyword(name))
    }

    fn primary(&mut self) -> Parse<Expr> {
        let loc = self.loc();
        match self.peek().tok.clone() {
            Tok::Int(text) => {
                self.next();
                let value = self.integer(&text, loc);
                self.node(ExprKind::Int(value), loc)
            }
            Tok::Float(text) => {
                self.next();
                self.node(ExprKind::Float(text.parse().unwrap_or(0.0)), loc)
            }
            Tok::Str(_) => {
                let mut text = String::new();
                while let Tok::Str(part) = &self.peek().tok {
                    text.push_str(&unescape(part));
                    self.next();
                }
                self.node(ExprKind::Str(text.into()), loc)
            }
            Tok::Sign("(") => self.parenthesis(loc),
            Tok::Ident(_) => {
                if let Some(base) = self.simple_type(0) {
                    self.next();
                    self.expect("(")?;
                    let mut list = vec![self.expression()?];
                    while self.take(",") {
                        list.push(self.expression()?);
                    }
                    self.expect(")")?;
                    return self.node(ExprKind::Construct(base, list), loc);
                }
                if self.is_name(0) && self.peek_at(1).is("(") {
                    return self.call(loc);
                }
                self.variable(loc)
            }
            _ => Err(self.syntax("an expression")),
        }
    }

    fn parenthesis(&mut self, loc: Loc) -> Parse<Expr> {
        self.next();
        if let Some(base) = self.simple_type(0).filter(|_| self.peek_at(1).is(")")) {
            self.next();
            self.next();
            let value = self.unary()?;
            return self.node(ExprKind::Cast(base, Box::new(value)), loc);
        }
        let mut inner = self.comma()?;
        self.expect(")")?;
        if let ExprKind::Comma(_, parenthesised) = &mut inner.kind {
            *parenthesised = true;
            inner.loc = loc;
        }
        Ok(inner)
    }

    fn call(&mut self, loc: Loc) -> Parse<Expr> {
        let (name, _) = self.name()?;
        self.expect("(")?;
        let mut list = Vec::new();
        if !self.is(")") {
            loop {
                list.push(self.expression_or_braces()?);
                if !self.take(",") {
                    break;
                }
            }
        }
        self.expect(")")?;
        self.node(ExprKind::Call(name, list), loc)
    }

    /// An initial value or an argument.
    pub(super) fn expression_or_braces(&mut self) -> Parse<Expr> {
        if !self.is("{") {
            return self.expression();
        }
        self.enter()?;
        let loc = self.next().loc;
        let mut list = Vec::new();
        if !self.is("}") {
            loop {
                list.push(self.expression_or_braces()?);
                if !self.take(",") {
                    break;
                }
            }
        }
        self.expect("}")?;
        self.depth -= 1;
        self.node(ExprKind::Braces(list), loc)
    }

    fn lvalue(&mut self) -> Parse<Expr> {
        let (name, loc) = self.name()?;
        let mut value = self.node(ExprKind::Name(name), loc)?;
        loop {
            let at = self.loc();
            if self.is("[") {
                let mut list = Vec::new();
                while list.len() < 3 && self.take("[") {
                    list.push(self.expression()?);
                    self.expect("]")?;
                }
                value = self.node(ExprKind::Index(Box::new(value), list), at)?;
            } else if self.take(".") {
                let (field, _) = self.name()?;
                value = self.node(ExprKind::Field(Box::new(value), field), at)?;
            } else {
                return Ok(value);
            }
        }
    }

    fn variable(&mut self, start: Loc) -> Parse<Expr> {
        let target = self.lvalue()?;
        let loc = self.loc();
        for (sign, up) in [("++", true), ("--", false)] {
            if self.take(sign) {
                return self.node(ExprKind::After(up, Box::new(target)), start);
            }
        }
        let Tok::Sign(sign) = self.peek().tok else { return Ok(target) };
        if !ASSIGN.contains(&sign) {
            return Ok(target);
        }
        self.next();
        let op = Binary::from_sign(sign.trim_end_matches('=')).map(|found| found.0);
        let value = self.expression()?;
        self.node(ExprKind::Assign(op, Box::new(target), Box::new(value)), loc)
    }

    fn integer(&mut self, text: &str, loc: Loc) -> i32 {
        let (value, limit) = match text.strip_prefix("0x").or_else(|| text.strip_prefix("0X")) {
            Some(hex) => (i64::from_str_radix(hex, 16).unwrap_or(i64::MAX), i64::from(u32::MAX) + 1),
            // One more than the largest, because a minus may precede it.
            None => (text.parse().unwrap_or(i64::MAX), i64::from(i32::MAX) + 1),
        };
        if value > limit {
            let range = format!("{} and {}", i32::MIN, i32::MAX);
            self.error(loc, format!("integer overflow, value must be between {range}."));
        }
        value as i32
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Integer expressions of `#if`.
//! Source: C99, section 6.10.1; original code.

use crate::token::{Tok, Token};

/// Parentheses and signs may nest this deep.
const DEPTH: usize = 100;

/// The value of an expression whose macros are expanded and whose `defined` is replaced. Names that are left are 0.
///
/// # Errors
/// The fault.
pub(super) fn evaluate(tokens: &[Token]) -> Result<i64, String> {
    let mut reader = Reader { tokens, at: 0 };
    let value = reader.ternary(0)?;
    match reader.tokens.get(reader.at) {
        None => Ok(value),
        Some(token) => Err(format!("unexpected '{}' in #if expression", token.spelling())),
    }
}

struct Reader<'a> {
    tokens: &'a [Token],
    at: usize,
}

const LEVELS: [&[&str]; 10] = [
    &["||"],
    &["&&"],
    &["|"],
    &["^"],
    &["&"],
    &["==", "!="],
    &["<=", ">=", "<", ">"],
    &["<<", ">>"],
    &["+", "-"],
    &["*", "/", "%"],
];

impl Reader<'_> {
    fn take(&mut self, sign: &str) -> bool {
        let found = self.tokens.get(self.at).is_some_and(|t| t.is(sign));
        self.at += usize::from(found);
        found
    }

    fn ternary(&mut self, depth: usize) -> Result<i64, String> {
        let condition = self.binary(0, depth)?;
        if !self.take("?") {
            return Ok(condition);
        }
        if depth > DEPTH {
            return Err("#if expression is nested too deeply".into());
        }
        let yes = self.ternary(depth + 1)?;
        if !self.take(":") {
            return Err("missing ':' in #if expression".into());
        }
        let no = self.ternary(depth + 1)?;
        Ok(if condition != 0 { yes } else { no })
    }

    fn binary(&mut self, level: usize, depth: usize) -> Result<i64, String> {
        let Some(signs) = LEVELS.get(level) else { return self.unary(depth) };
        let mut left = self.binary(level + 1, depth)?;
        while let Some(sign) = signs.iter().find(|s| self.tokens.get(self.at).is_some_and(|t| t.is(s))) {
            self.at += 1;
            let right = self.binary(level + 1, depth)?;
            left = apply(sign, left, right)?;
        }
        Ok(left)
    }

    fn unary(&mut self, depth: usize) -> Result<i64, String> {
        if depth > DEPTH {
            return Err("#if expression is nested too deeply".into());
        }
        let Some(token) = self.tokens.get(self.at) else {
            return Err("#if expression ends too early".into());
        };
        self.at += 1;
        match &token.tok {
            Tok::Int(text) => number(text),
            Tok::Ident(_) => Ok(0),
            Tok::Sign("!") => Ok(i64::from(self.unary(depth + 1)? == 0)),
            Tok::Sign("-") => Ok(self.unary(depth + 1)?.wrapping_neg()),
            Tok::Sign("+") => self.unary(depth + 1),
            Tok::Sign("~") => Ok(!self.unary(depth + 1)?),
            Tok::Sign("(") => {
                let value = self.ternary(depth + 1)?;
                if self.take(")") { Ok(value) } else { Err("missing ')' in #if expression".into()) }
            }
            _ => Err(format!("unexpected '{}' in #if expression", token.spelling())),
        }
    }
}

fn number(text: &str) -> Result<i64, String> {
    let value = match text.strip_prefix("0x").or_else(|| text.strip_prefix("0X")) {
        Some(hex) => i64::from_str_radix(hex, 16),
        None => text.parse(),
    };
    value.map_err(|_| format!("'{text}' is too large in #if expression"))
}

fn apply(sign: &str, a: i64, b: i64) -> Result<i64, String> {
    let truth = |t: bool| i64::from(t);
    Ok(match sign {
        "||" => truth(a != 0 || b != 0),
        "&&" => truth(a != 0 && b != 0),
        "|" => a | b,
        "^" => a ^ b,
        "&" => a & b,
        "==" => truth(a == b),
        "!=" => truth(a != b),
        "<=" => truth(a <= b),
        ">=" => truth(a >= b),
        "<" => truth(a < b),
        ">" => truth(a > b),
        "<<" => a.wrapping_shl(b as u32),
        ">>" => a.wrapping_shr(b as u32),
        "+" => a.wrapping_add(b),
        "-" => a.wrapping_sub(b),
        "*" => a.wrapping_mul(b),
        _ if b == 0 => return Err("division by zero in #if expression".into()),
        "/" => a.wrapping_div(b),
        _ => a.wrapping_rem(b),
    })
}

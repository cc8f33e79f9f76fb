// SPDX-License-Identifier: GPL-3.0-or-later
//! Whether format strings and their arguments go together.
//! The rules and words are OSL's.

use super::checker::Checker;
use crate::hir::{Expr, ExprKind};
use crate::source::Loc;
use crate::types::Base;

impl Checker<'_> {
    pub(super) fn check_printf(&mut self, name: &str, args: &[Expr], loc: Loc) {
        let at = usize::from(name == "fprintf");
        let Some(ExprKind::Str(format)) = args.get(at).map(|e| &e.kind) else {
            self.warning(loc, format!("{name}() uses a format string that is not a constant."));
            return;
        };
        let format = format.clone();
        let mut values = args.iter().enumerate().skip(at + 1);
        let mut rest = format.as_bytes();
        while let Some(p) = rest.iter().position(|&b| b == b'%') {
            rest = &rest[p + 1..];
            if rest.first() == Some(&b'%') {
                rest = &rest[1..];
                continue;
            }
            let end = rest.iter().position(|b| b"cdefgimnopsuvxX".contains(b)).unwrap_or(rest.len());
            let letter = rest.get(end).copied().unwrap_or(0);
            rest = rest.get(end + 1..).unwrap_or(&[]);
            let mismatch = format!("{name} has mismatched format string and arguments");
            let Some((i, value)) = values.next() else {
                self.error(loc, format!("{mismatch} (not enough args)"));
                return;
            };
            if let Base::Struct(id) = value.ty.base {
                let known = self.program.structs.get(id).map_or(String::new(), |s| s.name.clone());
                self.error_help(
                    loc,
                    format!("struct '{known}' is not a valid argument"),
                    "print its members".to_owned(),
                );
                return;
            }
            let (letters, expected): (&[u8], &str) = match value.ty.base {
                Base::String | Base::Closure => (b"s", "%s"),
                Base::Int => (b"dioxX", "%d, %i, %o, %x, or %X"),
                base if base.is_float_based() => (b"fgcemnpv", "%f, %g, or %e"),
                _ => continue,
            };
            if !letters.contains(&letter) {
                self.error(loc, format!("{mismatch} (arg {} needs {expected})", i + 1));
                return;
            }
        }
        if values.next().is_some() {
            self.error(loc, format!("{name} has mismatched format string and arguments (too many args)"));
        }
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Evaluates operators between two literals, so that `1.0/3.0` is a number wherever one is required. The
//! folded operators are those of OSL.

use crate::ast::{Binary, ExprKind};

/// The value of `a op b` if both are written numbers of one kind.
pub(super) fn fold(op: Binary, a: &ExprKind, b: &ExprKind) -> Option<ExprKind> {
    match (a, b) {
        (ExprKind::Int(a), ExprKind::Int(b)) => ints(op, *a, *b).map(ExprKind::Int),
        (ExprKind::Float(a), ExprKind::Float(b)) => floats(op, *a, *b),
        _ => None,
    }
}

fn ints(op: Binary, a: i32, b: i32) -> Option<i32> {
    Some(match op {
        Binary::Mul => a.wrapping_mul(b),
        Binary::Div => {
            if b == 0 {
                0
            } else {
                a.wrapping_div(b)
            }
        }
        Binary::Mod => {
            if b == 0 {
                0
            } else {
                a.wrapping_rem(b)
            }
        }
        Binary::Add => a.wrapping_add(b),
        Binary::Sub => a.wrapping_sub(b),
        Binary::Eq => i32::from(a == b),
        Binary::Neq => i32::from(a != b),
        Binary::Gt => i32::from(a > b),
        Binary::Lt => i32::from(a < b),
        Binary::Ge => i32::from(a >= b),
        Binary::Le => i32::from(a <= b),
        Binary::BitAnd => a & b,
        Binary::BitOr => a | b,
        Binary::Xor => a ^ b,
        Binary::Shl => a.wrapping_shl(b as u32),
        Binary::Shr => a.wrapping_shr(b as u32),
        Binary::And | Binary::Or => return None,
    })
}

fn floats(op: Binary, a: f32, b: f32) -> Option<ExprKind> {
    let truth = |t: bool| Some(ExprKind::Int(i32::from(t)));
    match op {
        Binary::Mul => Some(ExprKind::Float(a * b)),
        Binary::Div => Some(ExprKind::Float(if b == 0.0 { 0.0 } else { a / b })),
        Binary::Add => Some(ExprKind::Float(a + b)),
        Binary::Sub => Some(ExprKind::Float(a - b)),
        Binary::Eq => truth(a == b),
        Binary::Neq => truth(a != b),
        Binary::Gt => truth(a > b),
        Binary::Lt => truth(a < b),
        Binary::Ge => truth(a >= b),
        Binary::Le => truth(a <= b),
        _ => None,
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Values of parameters and metadata that are known from the text.
//! The rules for constants are OSL's.

use crate::hir::{Data, Expr, ExprKind};
use crate::types::{Base, Type};
use std::sync::Arc;

/// The value, zeros where it is not known, and whether all of it is.
pub(crate) fn literal(ty: Type, init: Option<&Expr>) -> (Data, bool) {
    let mut ints = Vec::new();
    let mut floats = Vec::new();
    let mut texts: Vec<Arc<str>> = Vec::new();
    let mut complete = true;
    let items: Vec<Option<&Expr>> = match init.map(|e| &e.kind) {
        Some(ExprKind::ArrayList(list)) if !list.is_empty() => list.iter().map(Some).collect(),
        Some(ExprKind::ArrayList(_)) => Vec::new(),
        _ => vec![init],
    };
    for item in items {
        match ty.base {
            Base::Int => match item.map(|e| &e.kind) {
                Some(ExprKind::Int(value)) => ints.push(*value),
                _ => {
                    ints.push(0);
                    complete = false;
                }
            },
            Base::String => match item.map(|e| &e.kind) {
                Some(ExprKind::Str(value)) => texts.push(value.clone()),
                _ => {
                    texts.push("".into());
                    complete = false;
                }
            },
            base if base.is_float_based() => {
                let (values, known) = numbers(ty.element(), item);
                floats.extend(values);
                complete &= known;
            }
            Base::Closure => {
                ints.push(0);
                complete &= matches!(item.map(|e| &e.kind), Some(ExprKind::Int(_) | ExprKind::Float(_)));
            }
            _ => complete = false,
        }
    }
    match ty.base {
        Base::String => (Data::Str(texts), complete),
        base if base.is_float_based() => (Data::Float(floats), complete),
        _ => (Data::Int(ints), complete),
    }
}

fn number(e: &Expr) -> Option<f32> {
    match e.kind {
        ExprKind::Int(value) => Some(value as f32),
        ExprKind::Float(value) => Some(value),
        _ => None,
    }
}

fn numbers(ty: Type, item: Option<&Expr>) -> (Vec<f32>, bool) {
    let count = ty.base.components();
    let spread = |value: f32| -> Vec<f32> {
        (0..count).map(|i| if ty == Type::MATRIX && i % 5 != 0 { 0.0 } else { value }).collect()
    };
    let Some(item) = item else { return (vec![0.0; count], false) };
    if let Some(value) = number(item) {
        return (spread(value), true);
    }
    let ExprKind::Construct(parts) = &item.kind else { return (vec![0.0; count], false) };
    if item.ty != ty {
        return (vec![0.0; count], false);
    }
    let named = parts.first().is_some_and(|e| e.ty == Type::STRING);
    let parts = &parts[usize::from(named)..];
    if let [only] = parts {
        return number(only).map_or((vec![0.0; count], false), |value| (spread(value), !named));
    }
    let known = parts.iter().all(|e| number(e).is_some()) && parts.len() == count;
    let mut values: Vec<f32> = parts.iter().map(|e| number(e).unwrap_or(0.0)).collect();
    values.resize(count, 0.0);
    (values, known && !named)
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Which arguments functions of the library write, and of which they take derivatives.
//! Source: the OSL specification, chapter 7; original.

use super::signature::Signature;
use crate::hir::{Expr, ExprKind};
use crate::types::Type;
use std::sync::Arc;

/// The effects of a call on its arguments.
pub(super) struct Effects {
    pub(super) name: Arc<str>,
    pub(super) writes: u64,
    pub(super) reads: u64,
    pub(super) derivs: u64,
}

const fn bit(i: usize) -> u64 {
    if i < 64 { 1 << i } else { 0 }
}

/// The effects of this call.
pub(super) fn effects(signature: &Signature, args: &[Expr]) -> Effects {
    let plain = &*signature.name;
    let name = match (plain, signature.returns) {
        ("transform", t) if t == Type::VECTOR => "transformv".into(),
        ("transform", t) if t == Type::NORMAL => "transformn".into(),
        _ => signature.name.clone(),
    };
    let last = args.len().saturating_sub(1);
    let text = |i: usize| args.get(i).is_none_or(|e| e.ty == Type::STRING);
    let written = match plain {
        "sincos" => bit(1) | bit(2),
        "getattribute" | "getmessage" | "gettextureinfo" | "getmatrix" | "dict_value" => bit(last),
        "illuminate" => {
            let first = if args.get(3).is_some_and(|e| e.ty == Type::FLOAT) { 4 } else { 2 };
            bit(first) | bit(first + 1) | bit(first + 2) | bit(first + 3)
        }
        "pointcloud_get" => bit(4),
        "pointcloud_search" => options(args, 4, |_| true),
        "regex_match" | "regex_search" if args.len() == 3 => bit(1),
        "split" => bit(1),
        _ if signature.texture => options(args, 1, |name| matches!(name, "alpha" | "errormessage")),
        _ => 0,
    };
    let derivs = match plain {
        "area" | "filterwidth" | "calculatenormal" | "Dx" | "Dy" | "Dz" => bit(0),
        "texture" if text(3) => bit(1) | bit(2),
        "texture3d" | "environment" if text(2) => bit(1),
        "trace" => bit(0) | bit(1),
        "noise" | "pnoise" => gabor(args),
        _ => 0,
    };
    Effects { name, writes: written | signature.outputs, reads: !written, derivs }
}

/// The values after names that `chosen` accepts; a name that is not written out may be any.
fn options(args: &[Expr], first: usize, chosen: impl Fn(&str) -> bool) -> u64 {
    let start = (first..args.len()).find(|&i| args[i].ty == Type::STRING).unwrap_or(args.len());
    (start..args.len().saturating_sub(1))
        .step_by(2)
        .filter(|&i| match &args[i].kind {
            ExprKind::Str(name) => chosen(name),
            _ => true,
        })
        .fold(0, |bits, i| bits | bit(i + 1))
}

/// Only Gabor noise filters, so only it needs derivatives of the position.
fn gabor(args: &[Expr]) -> u64 {
    let named = match args.first().map(|e| (&e.kind, e.ty)) {
        Some((ExprKind::Str(name), _)) => &**name == "gabor",
        Some((_, ty)) => ty == Type::STRING,
        None => false,
    };
    if !named {
        return 0;
    }
    let location_count = args[1..].iter().take_while(|e| e.ty != Type::STRING).count();
    (1..=location_count).fold(0, |bits, i| bits | bit(i))
}

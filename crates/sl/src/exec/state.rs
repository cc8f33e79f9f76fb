// SPDX-License-Identifier: GPL-3.0-or-later
//! Queries of shaders about the renderer and themselves.

use super::host::Given;
use super::machine::{Machine, Step};
use crate::hir::Data;
use crate::ir::SymbolKind;
use crate::types::Type;

pub(super) fn get_attribute(m: &mut Machine<'_>, s: &Step) {
    let (out, rest) = (s.args[0], &s.args[1..]);
    let Some((value, names)) = rest.split_last() else { return };
    let texts: Vec<_> = names.iter().filter(|a| a.ty == Type::STRING).map(|a| m.text(a)).collect();
    let index = names.iter().find(|a| a.ty == Type::INT).map(|a| m.int(a));
    let (object, name) = match &*texts {
        [name] => ("", &**name),
        [object, name, ..] => (&**object, &**name),
        [] => return,
    };
    let given = own(m, s, object, name, value.ty)
        .or_else(|| m.host.attribute(object, name, index, value.ty, &m.point));
    if let Some(given) = &given {
        m.give(value, given);
    }
    m.set_int(&out, i32::from(given.is_some()));
}

/// The shader's own names, if the text requests them by name.
fn own(m: &Machine<'_>, s: &Step, object: &str, name: &str, ty: Type) -> Option<Given> {
    let layer = &m.plan.layers[m.layer];
    let known = s.symbols.get(1).is_some_and(|&id| layer.shader.symbol(id).kind == SymbolKind::Const);
    if !known || !object.is_empty() || ty != Type::STRING {
        return None;
    }
    let text = match name {
        "shader:shadername" => &*layer.shader.name,
        "shader:layername" => &*layer.name,
        "shader:groupname" => &*m.plan.name,
        _ => return None,
    };
    Some(Data::Str(vec![text.into()]).into())
}

pub(super) fn raytype(m: &mut Machine<'_>, s: &Step) {
    let bit = m.host.ray_kind(&m.text(&s.args[1]));
    let value = m.point.ray_kinds & bit != 0;
    m.set_int(&s.args[0], i32::from(value));
}

pub(super) fn backfacing(m: &mut Machine<'_>, s: &Step) {
    let value = m.point.backfacing;
    m.set_int(&s.args[0], i32::from(value));
}

pub(super) fn surface_area(m: &mut Machine<'_>, s: &Step) {
    let value = m.point.surface_area;
    m.set(&s.args[0], 0, value.into());
}

/// Displacement is not done while a point is shaded.
pub(super) fn nothing(_: &mut Machine<'_>, _: &Step) {}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Assignable expressions: a variable, a member, an element, a component.

use super::lowerer::{Lowerer, Value};
use crate::hir::{Expr, ExprKind};
use crate::ir::SymId;
use crate::source::Loc;
use crate::types::Type;
use std::sync::Arc;

/// An assignable position, its indices computed.
#[derive(Clone, Debug)]
pub(super) struct Target {
    /// The symbols that hold it or, with `element`, arrays of it.
    leaves: Arc<[SymId]>,
    element: Option<SymId>,
    components: Vec<SymId>,
    ty: Type,
}

impl Lowerer<'_> {
    /// The target that an expression names.
    pub(super) fn target(&mut self, e: &Expr) -> Target {
        match &e.kind {
            ExprKind::Var(id) => {
                let value = self.var(*id);
                Target { leaves: value.leaves, element: None, components: Vec::new(), ty: e.ty }
            }
            ExprKind::Field(base, number) => {
                let inner = self.target(base);
                let fields =
                    base.ty.struct_id().and_then(|id| self.program.structs.get(id)).map(|s| s.fields.clone());
                let fields = fields.unwrap_or_default();
                let before: usize = fields.iter().take(*number as usize).map(|f| self.count(f.ty)).sum();
                let count = fields.get(*number as usize).map_or(0, |f| self.count(f.ty));
                let leaves = inner.leaves.get(before..before + count).unwrap_or(&[]).into();
                Target { leaves, ty: e.ty, ..inner }
            }
            ExprKind::Index(base, list) => {
                let mut inner = self.target(base);
                let mut indices: Vec<SymId> = list
                    .iter()
                    .map(|i| {
                        let value = self.expr(i, None);
                        self.convert(value, Type::INT, i.loc).symbol()
                    })
                    .collect();
                if base.ty.is_array() && inner.element.is_none() {
                    inner.element = Some(indices.remove(0));
                }
                inner.components.extend(indices);
                Target { ty: e.ty, ..inner }
            }
            _ => {
                let value = self.expr(e, None);
                Target { leaves: value.leaves, element: None, components: Vec::new(), ty: e.ty }
            }
        }
    }

    /// Whether the target is whole symbols.
    pub(super) fn whole(target: &Target) -> Option<Value> {
        let whole = target.element.is_none() && target.components.is_empty();
        whole.then(|| Value { ty: target.ty, leaves: target.leaves.clone() })
    }

    /// The element that contains a target, or the whole.
    fn element(&mut self, target: &Target, loc: Loc) -> Value {
        let Some(index) = target.element else {
            return Value { ty: target.ty, leaves: target.leaves.clone() };
        };
        let mut leaves = Vec::new();
        for &array in target.leaves.iter() {
            let ty = self.shader.symbol(array).ty.element();
            let out = self.temp(ty).symbol();
            self.emit("aref", &[out, array, index], loc);
            leaves.push(out);
        }
        Value { ty: target.ty, leaves: leaves.into() }
    }

    /// The value that is there.
    pub(super) fn load(&mut self, target: &Target, loc: Loc) -> Value {
        let value = self.element(target, loc);
        if target.components.is_empty() {
            return value;
        }
        let out = self.temp(Type::FLOAT);
        let mut args = vec![out.symbol(), value.symbol()];
        args.extend(&target.components);
        let name = if target.components.len() == 2 { "mxcompref" } else { "compref" };
        self.emit(name, &args, loc);
        out
    }

    /// Puts a value there. It has the place's type.
    pub(super) fn store(&mut self, target: &Target, value: &Value, loc: Loc) {
        if target.components.is_empty() {
            let Some(index) = target.element else {
                let to = Value { ty: target.ty, leaves: target.leaves.clone() };
                self.copy(&to, value, loc);
                return;
            };
            let pairs: Vec<(SymId, SymId)> =
                target.leaves.iter().copied().zip(value.leaves.iter().copied()).collect();
            for (array, leaf) in pairs {
                self.emit_with("aassign", vec![array, index, leaf], [!1, 1, 0], loc);
            }
            return;
        }
        let whole = self.element(target, loc);
        let mut args = vec![whole.symbol()];
        args.extend(&target.components);
        args.push(value.symbol());
        let name = if target.components.len() == 2 { "mxcompassign" } else { "compassign" };
        self.emit_with(name, args, [!1, 1, 0], loc);
        if let Some(index) = target.element {
            self.emit_with("aassign", vec![target.leaves[0], index, whole.symbol()], [!1, 1, 0], loc);
        }
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Parameters and their defaults: a value if the text states it, operations if it must be computed. The rules
//! for stated values are OSL's.

use super::lowerer::{Lowerer, Value};
use crate::check::literal;
use crate::hir::{Data, Expr, ExprKind, VarId};
use crate::ir::SymId;
use crate::types::{Base, Type};

impl Lowerer<'_> {
    pub(super) fn parameter(&mut self, id: VarId) {
        let program = self.program;
        let var = &program.vars[id as usize];
        let first = self.shader.symbols.len();
        let value = self.var(id);
        self.shader.symbols[first].meta.clone_from(&var.meta);
        let Some(init) = &var.init else { return };
        let mut done = 0;
        self.defaults(&value, var.ty, init, &mut done);
        // Members that the text leaves out are zero.
        for &leaf in value.leaves.iter().skip(done) {
            self.zero(leaf);
        }
    }

    fn zero(&mut self, leaf: SymId) {
        let ty = self.shader.symbol(leaf).ty;
        let size = ty.size();
        let data = match ty.base {
            Base::String => Data::Str(vec!["".into(); size]),
            base if base.is_float_based() => Data::Float(vec![0.0; size]),
            _ => Data::Int(vec![0; size]),
        };
        self.shader.symbols[leaf as usize].value = Some(data);
    }

    fn defaults(&mut self, value: &Value, ty: Type, init: &Expr, done: &mut usize) {
        if let (Base::Struct(id), false) = (ty.base, ty.is_array()) {
            let fields = self.program.structs.get(id).map(|s| s.fields.clone()).unwrap_or_default();
            if let ExprKind::StructList(list) = &init.kind {
                for (i, field) in fields.iter().enumerate() {
                    match list.get(i) {
                        Some(item) => self.defaults(value, field.ty, item, done),
                        None => {
                            for _ in 0..self.count(field.ty) {
                                self.zero(value.leaves[*done]);
                                *done += 1;
                            }
                        }
                    }
                }
                return;
            }
            // A whole struct: computed again for each member, because members may be given separately.
            for part in 0..self.count(ty) {
                let leaf = value.leaves[*done];
                self.zero(leaf);
                let block = self.block(|l| {
                    let whole = l.expr(init, None);
                    if let Some(&from) = whole.leaves.get(part) {
                        let array = l.shader.symbol(leaf).ty.is_array();
                        l.emit(if array { "arraycopy" } else { "assign" }, &[leaf, from], init.loc);
                    }
                });
                self.shader.symbols[leaf as usize].init = block;
                *done += 1;
            }
            return;
        }
        let leaf = value.leaves[*done];
        *done += 1;
        let (mut data, complete) = literal(ty, Some(init));
        if ty.array > 0 {
            match &mut data {
                Data::Int(list) => list.resize(ty.size(), 0),
                Data::Float(list) => list.resize(ty.size(), 0.0),
                Data::Str(list) => list.resize(ty.size(), "".into()),
            }
        }
        self.shader.symbols[leaf as usize].value = Some(data);
        if !complete {
            let to = Value { ty, leaves: [leaf].into() };
            let block = self.block(|l| l.set(&to, init, init.loc));
            self.shader.symbols[leaf as usize].init = block;
        }
    }
}

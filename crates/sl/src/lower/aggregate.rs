// SPDX-License-Identifier: GPL-3.0-or-later
//! Values of several parts: constructors, structs and arrays in braces.

use super::lowerer::{Lowerer, Value};
use crate::check::literal;
use crate::hir::{Data, Expr, ExprKind};
use crate::source::Loc;
use crate::types::{Base, Type};

impl Lowerer<'_> {
    pub(super) fn construct(
        &mut self,
        parts: &[Expr],
        ty: Type,
        expected: Option<&Value>,
        loc: Loc,
    ) -> Value {
        if ty.is_triple() {
            let whole = Expr { kind: ExprKind::Construct(parts.to_vec()), ty, loc };
            if let (data, true) = literal(ty, Some(&whole)) {
                return self.constant(ty, data);
            }
        }
        let mut values = Vec::with_capacity(parts.len() + 1);
        for part in parts {
            let value = self.expr(part, None);
            let float = value.ty == Type::INT && ty != Type::INT;
            let value = if float { self.convert(value, Type::FLOAT, loc) } else { value };
            values.push(value.symbol());
        }
        let out = self.result(ty, expected);
        values.insert(0, out.symbol());
        let name = if parts.len() == 1 { "assign" } else { ty.base.keyword() };
        self.emit(name, &values, loc);
        out
    }

    /// Gives the members or elements of `out` their values.
    pub(super) fn fill(&mut self, out: &Value, list: &[Expr], loc: Loc) {
        if out.ty.is_array() {
            self.fill_array(out, list, loc);
            return;
        }
        let Base::Struct(id) = out.ty.base else { return };
        let fields = self.program.structs.get(id).map(|s| s.fields.clone()).unwrap_or_default();
        let mut first = 0;
        for (field, item) in fields.iter().zip(list) {
            let count = self.count(field.ty);
            let leaves = out.leaves.get(first..first + count).unwrap_or(&[]).into();
            self.set(&Value { ty: field.ty, leaves }, item, loc);
            first += count;
        }
    }

    /// Gives a variable or member its value.
    pub(super) fn set(&mut self, to: &Value, item: &Expr, loc: Loc) {
        match &item.kind {
            ExprKind::StructList(list) | ExprKind::ArrayList(list) => self.fill(to, list, loc),
            _ => {
                let value = self.expr(item, Some(to));
                let value = if to.ty == Type::CLOSURE { value } else { self.convert(value, to.ty, loc) };
                self.copy(to, &value, loc);
            }
        }
    }

    fn fill_array(&mut self, out: &Value, list: &[Expr], loc: Loc) {
        let element = out.ty.element();
        if element.struct_id().is_none() && element != Type::CLOSURE && !list.is_empty() {
            let whole = Expr { kind: ExprKind::ArrayList(list.to_vec()), ty: out.ty, loc };
            let plain = list
                .iter()
                .all(|e| matches!(e.kind, ExprKind::Int(_) | ExprKind::Float(_) | ExprKind::Str(_)));
            if let (mut data, true) = literal(out.ty, Some(&whole)) {
                let size = out.ty.size();
                if plain && element.base.components() == 1 {
                    match &mut data {
                        Data::Int(values) => values.resize(size, 0),
                        Data::Float(values) => values.resize(size, 0.0),
                        Data::Str(values) => values.resize(size, "".into()),
                    }
                    let constant = self.constant(out.ty, data);
                    self.emit("assign", &[out.symbol(), constant.symbol()], loc);
                    return;
                }
            }
        }
        for (i, item) in list.iter().enumerate() {
            let index = self.int(i as i32);
            let value = match &item.kind {
                ExprKind::StructList(_) => {
                    let value = self.temp(element);
                    self.set(&value, item, loc);
                    value
                }
                _ => {
                    let value = self.expr(item, None);
                    if element == Type::CLOSURE { value } else { self.convert(value, element, loc) }
                }
            };
            let pairs: Vec<_> = out.leaves.iter().copied().zip(value.leaves.iter().copied()).collect();
            for (array, leaf) in pairs {
                self.emit("aassign", &[array, index, leaf], loc);
            }
        }
    }
}

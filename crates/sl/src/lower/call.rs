// SPDX-License-Identifier: GPL-3.0-or-later
//! Calls: functions of the text are inlined, those of the library become an operation. Outputs are passed by
//! reference, as in OSL.

use super::lowerer::{Inline, Lowerer, Value};
use super::position::Target;
use crate::hir::{Builtin, Expr, ExprKind, FuncId};
use crate::ir::{Node, SymId, SymbolKind};
use crate::source::Loc;
use crate::types::Type;
use std::collections::HashSet;

impl Lowerer<'_> {
    pub(super) fn call(&mut self, func: FuncId, args: &[Expr], ty: Type, loc: Loc) -> Value {
        let program = self.program;
        let function = &program.funcs[func as usize];
        if self.inlines.iter().any(|i| i.func == func) {
            self.error(
                loc,
                format!("function '{}' calls itself: functions cannot be recursive", function.name),
            );
            return self.temp(ty);
        }
        if self.full() {
            return self.temp(ty);
        }
        let mut bindings = Vec::new();
        let mut stores: Vec<(Target, Value)> = Vec::new();
        let mut written: HashSet<SymId> = HashSet::new();
        for (arg, (formal, output)) in args.iter().zip(&function.formals) {
            let expected = program.vars[*formal as usize].ty;
            let value = if *output {
                let value = self.written(arg, &mut stores, loc);
                written.extend(value.leaves.iter());
                value
            } else {
                let value = self.expr(arg, None);
                if expected == Type::CLOSURE || expected.array < 0 {
                    value
                } else {
                    self.convert(value, expected, loc)
                }
            };
            bindings.push((*formal, *output, value));
        }
        for id in self.effects.of(program, func).iter() {
            if let Some(value) = self.values.get(id) {
                written.extend(value.leaves.iter());
            }
        }
        for (formal, output, value) in bindings {
            let value = if output { value } else { self.by_value(value, &written, loc) };
            self.values.insert(formal, value);
        }
        let result = (ty != Type::VOID).then(|| self.temp(ty));
        self.inlines.push(Inline { func, result: result.clone(), from: loc });
        let body = function.body.as_deref().unwrap_or_default();
        let body = self.block(|l| {
            l.statements(body, true);
        });
        self.inlines.pop();
        let name = self.text(&function.name);
        let at = self.at(loc);
        self.push(Node::Call { name, body, at });
        for (target, value) in stores {
            self.store(&target, &value, loc);
        }
        result.unwrap_or_else(|| Value { ty, leaves: [].into() })
    }

    /// A writable symbol for a value: constants stay unchanged.
    fn writable(&mut self, value: Value, loc: Loc) -> Value {
        if value.leaves.iter().all(|&s| self.shader.symbols[s as usize].kind != SymbolKind::Const) {
            return value;
        }
        let out = self.temp(value.ty);
        self.copy(&out, &value, loc);
        out
    }

    /// An argument that the call may change; one without a symbol of its own is stored afterwards.
    fn written(&mut self, arg: &Expr, stores: &mut Vec<(Target, Value)>, loc: Loc) -> Value {
        let target = self.target(arg);
        if let Some(whole) = Self::whole(&target) {
            return self.writable(whole, loc);
        }
        let value = self.load(&target, loc);
        stores.push((target, value.clone()));
        value
    }

    /// A value that the function's body cannot change from outside.
    fn by_value(&mut self, value: Value, written: &HashSet<SymId>, loc: Loc) -> Value {
        if value.leaves.iter().all(|s| !written.contains(s)) {
            return value;
        }
        let out = self.temp(value.ty);
        self.copy(&out, &value, loc);
        out
    }

    pub(super) fn builtin(&mut self, call: &Builtin, ty: Type, expected: Option<&Value>, loc: Loc) -> Value {
        let mut args = Vec::with_capacity(call.args.len() + 2);
        let mut stores: Vec<(Target, Value)> = Vec::new();
        for (i, arg) in call.args.iter().enumerate() {
            let formal = call.formals[i];
            let writes = i < 64 && call.writes & (1 << i) != 0;
            let value = if writes && !matches!(arg.kind, ExprKind::Error) {
                self.written(arg, &mut stores, loc)
            } else {
                let value = self.expr(arg, None);
                if formal.is_unknown() || formal == Type::CLOSURE {
                    value
                } else {
                    self.convert(value, formal, loc)
                }
            };
            if let [only] = &*value.leaves {
                args.push(*only);
            } else if let (true, Some(first)) = (&*call.name == "isconnected", value.leaves.first()) {
                // Members are connected together.
                args.push(*first);
            } else {
                self.error(loc, format!("{} cannot take a struct", call.name));
            }
        }
        let closure = ty == Type::CLOSURE;
        let shift = usize::from(ty != Type::VOID) + usize::from(closure);
        let bits = [call.reads << shift, call.writes << shift, call.derivs << shift];
        let out = (ty != Type::VOID).then(|| self.result(ty, expected));
        if closure {
            let name = self.text(&call.name);
            args.insert(0, name);
        }
        if let Some(out) = &out {
            args.insert(0, out.symbol());
        }
        let reads = bits[0] | u64::from(closure) << 1;
        let writes = bits[1] | u64::from(out.is_some());
        let name = if closure { "closure" } else { &*call.name };
        self.emit_with(name, args, [reads, writes, bits[2]], loc);
        for (target, value) in stores {
            self.store(&target, &value, loc);
        }
        out.unwrap_or_else(|| Value { ty, leaves: [].into() })
    }
}

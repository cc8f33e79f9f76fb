// SPDX-License-Identifier: GPL-3.0-or-later
//! Which variables a function writes, in itself or through others: only what it may change is copied when it is passed by value.
//! Source: original.

use crate::hir::{Expr, ExprKind, FuncId, Program, Stmt, StmtKind, VarId};
use std::collections::{HashMap, HashSet};
use std::rc::Rc;

/// Written variables by function.
#[derive(Default)]
pub(super) struct Effects {
    known: HashMap<FuncId, Rc<HashSet<VarId>>>,
}

fn root(e: &Expr) -> Option<VarId> {
    match &e.kind {
        ExprKind::Var(id) => Some(*id),
        ExprKind::Field(base, _) | ExprKind::Index(base, _) => root(base),
        _ => None,
    }
}

impl Effects {
    /// What a function writes.
    pub(super) fn of(&mut self, program: &Program, func: FuncId) -> Rc<HashSet<VarId>> {
        if let Some(found) = self.known.get(&func) {
            return found.clone();
        }
        // A function that calls itself is refused elsewhere.
        self.known.insert(func, Rc::default());
        let mut out = HashSet::new();
        let body = program.funcs[func as usize].body.as_deref().unwrap_or_default();
        self.statements(program, body, &mut out);
        let out = Rc::new(out);
        self.known.insert(func, out.clone());
        out
    }

    fn statements(&mut self, program: &Program, list: &[Stmt], out: &mut HashSet<VarId>) {
        for s in list {
            match &s.kind {
                StmtKind::Block(list) => self.statements(program, list, out),
                StmtKind::If(condition, yes, no) => {
                    self.expr(program, condition, out);
                    self.statements(program, yes, out);
                    self.statements(program, no, out);
                }
                StmtKind::Loop { init, condition, step, body, .. } => {
                    self.statements(program, init, out);
                    self.expr(program, condition, out);
                    if let Some(step) = step {
                        self.expr(program, step, out);
                    }
                    self.statements(program, body, out);
                }
                StmtKind::Break | StmtKind::Continue | StmtKind::Return(None) => {}
                StmtKind::Return(Some(e)) | StmtKind::Expr(e) => self.expr(program, e, out),
                StmtKind::Declare(list) => {
                    out.extend(list);
                    for &id in list {
                        if let Some(init) = &program.vars[id as usize].init {
                            self.expr(program, init, out);
                        }
                    }
                }
            }
        }
    }

    fn expr(&mut self, program: &Program, e: &Expr, out: &mut HashSet<VarId>) {
        match &e.kind {
            ExprKind::Assign(target, value) => {
                out.extend(root(target));
                self.expr(program, target, out);
                self.expr(program, value, out);
            }
            ExprKind::Before(_, target) | ExprKind::After(_, target) => {
                out.extend(root(target));
                self.expr(program, target, out);
            }
            ExprKind::Call(func, args) => {
                for (arg, formal) in args.iter().zip(&program.funcs[*func as usize].formals) {
                    if formal.1 {
                        out.extend(root(arg));
                    }
                    self.expr(program, arg, out);
                }
                out.extend(self.of(program, *func).iter());
            }
            ExprKind::Builtin(call) => {
                for (i, arg) in call.args.iter().enumerate() {
                    if i < 64 && call.writes & (1 << i) != 0 {
                        out.extend(root(arg));
                    }
                    self.expr(program, arg, out);
                }
            }
            ExprKind::Field(a, _) | ExprKind::Unary(_, a) | ExprKind::Cast(a) => self.expr(program, a, out),
            ExprKind::Binary(_, a, b) => {
                self.expr(program, a, out);
                self.expr(program, b, out);
            }
            ExprKind::Index(a, list) => {
                self.expr(program, a, out);
                list.iter().for_each(|e| self.expr(program, e, out));
            }
            ExprKind::Ternary(parts) => parts.iter().for_each(|e| self.expr(program, e, out)),
            ExprKind::Comma(list)
            | ExprKind::Construct(list)
            | ExprKind::StructList(list)
            | ExprKind::ArrayList(list) => {
                list.iter().for_each(|e| self.expr(program, e, out));
            }
            ExprKind::Int(_)
            | ExprKind::Float(_)
            | ExprKind::Str(_)
            | ExprKind::Var(_)
            | ExprKind::Old
            | ExprKind::Error => {}
        }
    }
}

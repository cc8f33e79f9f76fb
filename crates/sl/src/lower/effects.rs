// SPDX-License-Identifier: GPL-3.0-or-later
//! The variables that a function writes, directly or through calls: only arguments that it may change are
//! copied when passed by value.

use crate::hir::{Expr, ExprKind, FuncId, Program, Stmt, StmtKind, VarId};
use std::collections::{HashMap, HashSet};
use std::rc::Rc;

/// Written variables by function.
#[derive(Default)]
pub(super) struct Effects {
    /// In itself.
    own: HashMap<FuncId, Own>,
    /// In itself or through others.
    known: HashMap<FuncId, Rc<HashSet<VarId>>>,
}

/// The effects of a function itself.
#[derive(Default)]
struct Own {
    written: HashSet<VarId>,
    called: Vec<FuncId>,
}

impl Effects {
    /// The variables that a function writes. Called functions are visited by a list, because chains of calls
    /// may be long.
    pub(super) fn of(&mut self, program: &Program, func: FuncId) -> Rc<HashSet<VarId>> {
        if let Some(found) = self.known.get(&func) {
            return found.clone();
        }
        let mut out = HashSet::new();
        let (mut visited, mut open) = (HashSet::from([func]), vec![func]);
        while let Some(next) = open.pop() {
            if let Some(all) = self.known.get(&next) {
                out.extend(all.iter());
                continue;
            }
            let own = self.own.entry(next).or_insert_with(|| {
                let mut own = Own::default();
                own.statements(program, program.funcs[next as usize].body.as_deref().unwrap_or_default());
                own
            });
            out.extend(own.written.iter());
            open.extend(own.called.iter().filter(|&&called| visited.insert(called)));
        }
        let out = Rc::new(out);
        self.known.insert(func, out.clone());
        out
    }
}

impl Own {
    fn statements(&mut self, program: &Program, list: &[Stmt]) {
        for s in list {
            match &s.kind {
                StmtKind::Block(list) => self.statements(program, list),
                StmtKind::If(condition, yes, no) => {
                    self.expr(program, condition);
                    self.statements(program, yes);
                    self.statements(program, no);
                }
                StmtKind::Loop { init, condition, step, body, .. } => {
                    self.statements(program, init);
                    self.expr(program, condition);
                    if let Some(step) = step {
                        self.expr(program, step);
                    }
                    self.statements(program, body);
                }
                StmtKind::Break | StmtKind::Continue | StmtKind::Return(None) => {}
                StmtKind::Return(Some(e)) | StmtKind::Expr(e) => self.expr(program, e),
                StmtKind::Declare(list) => {
                    self.written.extend(list);
                    for &id in list {
                        if let Some(init) = &program.vars[id as usize].init {
                            self.expr(program, init);
                        }
                    }
                }
            }
        }
    }

    fn expr(&mut self, program: &Program, e: &Expr) {
        match &e.kind {
            ExprKind::Assign(target, value) => {
                self.written.extend(target.root());
                self.expr(program, target);
                self.expr(program, value);
            }
            ExprKind::Before(_, target) | ExprKind::After(_, target) => {
                self.written.extend(target.root());
                self.expr(program, target);
            }
            ExprKind::Call(func, args) => {
                for (arg, formal) in args.iter().zip(&program.funcs[*func as usize].formals) {
                    if formal.1 {
                        self.written.extend(arg.root());
                    }
                    self.expr(program, arg);
                }
                self.called.push(*func);
            }
            ExprKind::Builtin(call) => {
                for (i, arg) in call.args.iter().enumerate() {
                    if i < 64 && call.writes & (1 << i) != 0 {
                        self.written.extend(arg.root());
                    }
                    self.expr(program, arg);
                }
            }
            ExprKind::Field(a, _) | ExprKind::Unary(_, a) | ExprKind::Cast(a) => self.expr(program, a),
            ExprKind::Binary(_, a, b) => {
                self.expr(program, a);
                self.expr(program, b);
            }
            ExprKind::Index(a, list) => {
                self.expr(program, a);
                list.iter().for_each(|e| self.expr(program, e));
            }
            ExprKind::Ternary(parts) => parts.iter().for_each(|e| self.expr(program, e)),
            ExprKind::Comma(list)
            | ExprKind::Construct(list)
            | ExprKind::StructList(list)
            | ExprKind::ArrayList(list) => {
                list.iter().for_each(|e| self.expr(program, e));
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

// SPDX-License-Identifier: GPL-3.0-or-later
//! Finds the symbols that need derivatives: those whose derivatives are taken, and all that they are made of.
//! A backward data-flow over whole symbols, as OSL's.

use crate::ir::{Shader, SymId, ops};
use crate::types::Base;

/// Sets [`derivs`](crate::ir::Symbol::derivs) where it is needed. Existing marks stay.
pub fn mark_derivatives(shader: &mut Shader) {
    let mut makes: Vec<Vec<SymId>> = vec![Vec::new(); shader.symbols.len()];
    let mut pending: Vec<SymId> = Vec::new();
    let mut visit = |op: &crate::ir::Op| {
        for (i, &arg) in op.args.iter().enumerate() {
            if i < 64 && op.derivs & (1 << i) != 0 {
                pending.push(arg);
            }
            if op.is_written(i) {
                let read = op.args.iter().enumerate().filter(|(k, _)| op.is_read(*k)).map(|(_, &a)| a);
                makes[arg as usize].extend(read);
            }
        }
    };
    for symbol in &shader.symbols {
        ops(&symbol.init, &mut visit);
    }
    ops(&shader.code, &mut visit);
    pending.extend(shader.symbols.iter().enumerate().filter(|(_, s)| s.derivs).map(|(i, _)| i as SymId));
    let mut visited = vec![false; shader.symbols.len()];
    while let Some(id) = pending.pop() {
        if std::mem::replace(&mut visited[id as usize], true) {
            continue;
        }
        let symbol = &mut shader.symbols[id as usize];
        symbol.derivs = matches!(symbol.ty.base, Base::Float) || symbol.ty.base.is_triple();
        pending.extend(std::mem::take(&mut makes[id as usize]));
    }
}

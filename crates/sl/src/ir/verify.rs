// SPDX-License-Identifier: GPL-3.0-or-later
//! Validity of the intermediate form: output of passes and contents of files are checked before they run.

use super::shader::{Block, Node, Op, Shader, SymId, SymbolKind};
use crate::hir::Data;
use crate::opcode::Opcode;
use crate::types::{Base, Type};

/// Blocks may nest this deep.
const DEPTH: usize = 1000;
/// Values in one symbol.
const SIZE: usize = 1 << 24;

/// Checks a shader.
///
/// # Errors
/// The first fault.
pub fn verify(shader: &Shader) -> Result<(), String> {
    for symbol in &shader.symbols {
        let name = &symbol.name;
        if let Base::Struct(id) = symbol.ty.base {
            shader.structs.get(id).ok_or_else(|| format!("symbol {name}: no struct {id}"))?;
        }
        if symbol.ty.size() > SIZE {
            return Err(format!("symbol {name} has more than {SIZE} values"));
        }
        let fits = match (&symbol.value, symbol.ty.base) {
            (None, _) => symbol.kind != SymbolKind::Const,
            (Some(Data::Int(list)), Base::Int) => length(symbol.ty, list.len()),
            (Some(Data::Int(_)), Base::Closure | Base::Struct(_)) => true,
            (Some(Data::Str(list)), Base::String) => length(symbol.ty, list.len()),
            (Some(Data::Float(list)), base) if base.is_float_based() => length(symbol.ty, list.len()),
            _ => false,
        };
        if !fits {
            return Err(format!("symbol {name} of type {}: its value does not fit", symbol.ty));
        }
        block(shader, &symbol.init, false, 0)?;
    }
    block(shader, &shader.code, false, 0)
}

fn length(ty: Type, values: usize) -> bool {
    let one = ty.base.components();
    values.is_multiple_of(one) && (ty.array < 0 || values <= ty.size())
}

fn known(shader: &Shader, id: SymId) -> Result<(), String> {
    if (id as usize) < shader.symbols.len() { Ok(()) } else { Err(format!("no symbol {id}")) }
}

fn int(shader: &Shader, id: SymId) -> Result<(), String> {
    known(shader, id)?;
    let symbol = shader.symbol(id);
    if symbol.ty == Type::INT {
        Ok(())
    } else {
        Err(format!("condition {} is not an int but {}", symbol.name, symbol.ty))
    }
}

fn block(shader: &Shader, nodes: &Block, in_loop: bool, depth: usize) -> Result<(), String> {
    if depth > DEPTH {
        return Err(format!("blocks are nested more than {DEPTH} deep"));
    }
    for node in nodes {
        match node {
            Node::Op(op) => operation(shader, op, in_loop)?,
            Node::If { condition, yes, no, .. } => {
                int(shader, *condition)?;
                block(shader, yes, in_loop, depth + 1)?;
                block(shader, no, in_loop, depth + 1)?;
            }
            Node::Loop { init, test, condition, body, step, .. } => {
                int(shader, *condition)?;
                block(shader, init, in_loop, depth + 1)?;
                for part in [test, body, step] {
                    block(shader, part, true, depth + 1)?;
                }
            }
            Node::Call { name, body, .. } => {
                known(shader, *name)?;
                block(shader, body, false, depth + 1)?;
            }
        }
    }
    Ok(())
}

fn operation(shader: &Shader, op: &Op, in_loop: bool) -> Result<(), String> {
    let name = op.code.name();
    if matches!(op.code, Opcode::Break | Opcode::Continue) && !in_loop {
        return Err(format!("{name} outside a loop"));
    }
    let (count, least) = (op.args.len(), op.code.least_operands());
    if count < least {
        return Err(format!("{name} has {count} operands, expected {least} or more"));
    }
    for (i, &arg) in op.args.iter().enumerate() {
        known(shader, arg)?;
        let symbol = shader.symbol(arg);
        if op.is_written(i) && symbol.kind == SymbolKind::Const {
            return Err(format!("{name} writes the constant {}", symbol.name));
        }
        if symbol.ty.struct_id().is_some() {
            return Err(format!("{name} takes the whole struct {}", symbol.name));
        }
    }
    Ok(())
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Operations in a row, with jump targets in place of blocks, as files hold them.
//! The order of blocks is OSL's.

use super::shader::{Block, Node, Op, SourcePosition, SymId};
use crate::opcode::Opcode;

/// One operation of the row.
#[derive(Clone, Debug)]
pub struct Flat {
    /// The operation; blocks are one named `if`, `for`, `while`, `dowhile` or `functioncall`.
    pub op: Op,
    /// Numbers of operations where its blocks end.
    pub jumps: Vec<usize>,
}

fn control(code: Opcode, symbol: SymId, at: SourcePosition) -> Flat {
    Flat { op: Op { code, args: vec![symbol], reads: 1, writes: 0, derivs: 0, at }, jumps: Vec::new() }
}

impl Flat {
    /// Appends a block to a row.
    pub fn append(block: &Block, row: &mut Vec<Self>) {
        for node in block {
            let start = row.len();
            match node {
                Node::Op(op) => row.push(Self { op: op.clone(), jumps: Vec::new() }),
                Node::If { condition, yes, no, at } => {
                    row.push(control(Opcode::If, *condition, *at));
                    Self::append(yes, row);
                    let otherwise = row.len();
                    Self::append(no, row);
                    row[start].jumps = vec![otherwise, row.len()];
                }
                Node::Loop { keyword, init, test, condition, body, step, at } => {
                    row.push(control(Opcode::named(keyword), *condition, *at));
                    let mut jumps = Vec::new();
                    for part in [init, test, body, step] {
                        Self::append(part, row);
                        jumps.push(row.len());
                    }
                    row[start].jumps = jumps;
                }
                Node::Call { name, body, at } => {
                    row.push(control(Opcode::FunctionCall, *name, *at));
                    Self::append(body, row);
                    row[start].jumps = vec![row.len()];
                }
            }
        }
    }

    /// The blocks of the operations from `from` up to `to`.
    ///
    /// # Errors
    /// The fault of a jump.
    pub fn nest(row: &[Self], from: usize, to: usize, depth: usize) -> Result<Block, String> {
        if depth > 1000 {
            return Err("blocks are nested more than 1000 deep".into());
        }
        let mut block = Vec::new();
        let mut i = from;
        while i < to {
            let flat = &row[i];
            let at = flat.op.at;
            let bounds = |count: usize| -> Result<Vec<usize>, String> {
                let mut last = i + 1;
                for &jump in &flat.jumps {
                    if jump < last || jump > to {
                        return Err(format!(
                            "operation {i} ({}): jump to {jump} is not in {last}..={to}",
                            flat.op.code.name()
                        ));
                    }
                    last = jump;
                }
                if flat.jumps.len() != count || flat.op.args.len() != 1 {
                    return Err(format!(
                        "operation {i} ({}) has a wrong number of jumps or arguments",
                        flat.op.code.name()
                    ));
                }
                Ok(flat.jumps.clone())
            };
            let symbol = flat.op.args.first().copied().unwrap_or(0);
            let inner = |a: usize, b: usize| Self::nest(row, a, b, depth + 1);
            let next;
            block.push(match flat.op.code {
                Opcode::If => {
                    let jumps = bounds(2)?;
                    next = jumps[1];
                    Node::If {
                        condition: symbol,
                        yes: inner(i + 1, jumps[0])?,
                        no: inner(jumps[0], jumps[1])?,
                        at,
                    }
                }
                code @ (Opcode::For | Opcode::While | Opcode::DoWhile) => {
                    let j = bounds(4)?;
                    next = j[3];
                    Node::Loop {
                        keyword: code.name(),
                        init: inner(i + 1, j[0])?,
                        test: inner(j[0], j[1])?,
                        condition: symbol,
                        body: inner(j[1], j[2])?,
                        step: inner(j[2], j[3])?,
                        at,
                    }
                }
                Opcode::FunctionCall | Opcode::FunctionCallNr => {
                    let jumps = bounds(1)?;
                    next = jumps[0];
                    Node::Call { name: symbol, body: inner(i + 1, jumps[0])?, at }
                }
                _ => {
                    next = i + 1;
                    Node::Op(flat.op.clone())
                }
            });
            i = next;
        }
        Ok(block)
    }
}

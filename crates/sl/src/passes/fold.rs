// SPDX-License-Identifier: GPL-3.0-or-later
//! Evaluates values known before a shader runs: numbers computed from constants and constant parameters, and
//! conditions on them. Products of closures with 0 and 1 and sums with nothing become copies. Then removes unused code. Constant
//! propagation and dead code elimination over symbols that are written once.
//! Invariant: the output of a shader is the same with and without it.
//! Tests: `tests/passes.rs`, and OSL's test suite, which runs through it.

use crate::exec::known_result;
use crate::hir::Data;
use crate::ir::{Block, Node, Op, Shader, SymId, Symbol, SymbolKind, Use, ops, uses};
use crate::opcode::Opcode;
use crate::types::{Base, Type};
use std::collections::{HashMap, HashSet};

/// The limit of passes, each of which visits the whole shader.
const PASSES: usize = 100;

/// Folds a shader whose parameters in `known` have the values that they have there.
pub fn fold(shader: &mut Shader, known: &HashMap<SymId, Data>) {
    for _ in 0..PASSES {
        let mut writes = vec![0_u32; shader.symbols.len()];
        uses(&shader.code, &mut |id, usage| writes[id as usize] += u32::from(usage == Use::Write));
        let (made, now) = (HashMap::new(), HashMap::new());
        let once = written_first(shader, &writes);
        let empty = HashSet::new();
        let mut folder =
            Folder { shader, known, writes: &writes, once: &once, empty, made, now, changed: false };
        let mut code = std::mem::take(&mut folder.shader.code);
        code = folder.block(code);
        let (made, mut changed) = (std::mem::take(&mut folder.made), folder.changed);
        for (id, data) in made {
            let symbol = &mut shader.symbols[id as usize];
            symbol.kind = SymbolKind::Const;
            symbol.value = Some(data);
        }
        shader.code = code;
        changed |= remove_dead(shader, &[]);
        if !changed {
            return;
        }
    }
}

struct Folder<'a> {
    shader: &'a mut Shader,
    known: &'a HashMap<SymId, Data>,
    writes: &'a [u32],
    /// Variables that are written once, before they are read.
    once: &'a [bool],
    /// Closures without components.
    empty: HashSet<SymId>,
    /// Symbols that turn out to be constants.
    made: HashMap<SymId, Data>,
    /// The current contents of the compiler's own variables, also of those that are written more than once.
    now: HashMap<SymId, Data>,
    changed: bool,
}

impl Folder<'_> {
    fn value(&self, id: SymId) -> Option<&Data> {
        let symbol = self.shader.symbol(id);
        match symbol.kind {
            SymbolKind::Const => symbol.value.as_ref(),
            SymbolKind::Param => self.known.get(&id),
            _ => self.made.get(&id).or_else(|| self.now.get(&id)),
        }
    }

    /// Drops the variables that these nodes write.
    fn forget(&mut self, nodes: &[Node]) {
        uses(nodes, &mut |id, usage| {
            if usage == Use::Write {
                self.now.remove(&id);
            }
        });
    }

    /// Nodes that run zero or more times: known values hold at their start, those at their end are unknown.
    fn inner(&mut self, block: Block) -> Block {
        let before = self.now.clone();
        let block = self.block(block);
        self.now = before;
        block
    }

    /// A condition.
    fn truth(&self, id: SymId) -> Option<bool> {
        match self.value(id)? {
            Data::Int(list) => list.first().map(|&v| v != 0),
            _ => None,
        }
    }

    fn block(&mut self, block: Block) -> Block {
        let mut out = Vec::with_capacity(block.len());
        for node in block {
            match node {
                Node::Op(op) => match self.operation(&op) {
                    Some((id, data)) if self.writes[id as usize] == 1 => {
                        self.made.insert(id, data);
                        self.changed = true;
                    }
                    Some((id, data)) => {
                        self.now.insert(id, data);
                        out.push(Node::Op(op));
                    }
                    None => {
                        let node = Node::Op(self.closure(op));
                        self.forget(std::slice::from_ref(&node));
                        out.push(node);
                    }
                },
                Node::If { condition, yes, no, at } => match self.truth(condition) {
                    Some(taken) => {
                        self.changed = true;
                        out.extend(self.block(if taken { yes } else { no }));
                    }
                    None => {
                        let node = Node::If { condition, yes: self.inner(yes), no: self.inner(no), at };
                        self.forget(std::slice::from_ref(&node));
                        out.push(node);
                    }
                },
                Node::Loop { keyword, init, test, condition, body, step, at } => {
                    let init = self.block(init);
                    // The test runs again after the body and the step.
                    for part in [&test, &body, &step] {
                        self.forget(part);
                    }
                    let test = self.block(test);
                    if keyword != "dowhile" && self.truth(condition) == Some(false) {
                        self.changed = true;
                        out.extend(init);
                        out.extend(test);
                        continue;
                    }
                    let body = self.inner(body);
                    self.forget(&body);
                    let step = self.inner(step);
                    let node = Node::Loop { keyword, init, test, condition, body, step, at };
                    self.forget(std::slice::from_ref(&node));
                    out.push(node);
                }
                Node::Call { name, body, at } => {
                    let node = Node::Call { name, body: self.inner(body), at };
                    self.forget(std::slice::from_ref(&node));
                    out.push(node);
                }
            }
        }
        out
    }

    fn is_closure(&self, id: SymId) -> bool {
        self.shader.symbol(id).ty == Type::CLOSURE
    }

    /// Whether all numbers of a value are known to be `x`.
    fn has_all(&self, id: SymId, x: f32) -> bool {
        match self.value(id) {
            Some(Data::Float(list)) => list.iter().all(|&y| y == x),
            Some(Data::Int(list)) => list.iter().all(|&y| y as f32 == x),
            _ => false,
        }
    }

    /// Whether it is a closure without components, or 0.
    fn is_empty(&self, id: SymId) -> bool {
        if self.is_closure(id) { self.empty.contains(&id) } else { self.has_all(id, 0.0) }
    }

    /// An operation on closures, or a copy in its place: products with 0 or 1, and sums with nothing.
    fn closure(&mut self, op: Op) -> Op {
        let [out, a, b] = match (op.code, &op.args[..]) {
            (Opcode::Mul | Opcode::Add, &[out, a, b]) => [out, a, b],
            (Opcode::Assign, &[out, a]) => [out, a, a],
            _ => return op,
        };
        // Others may be read before they are written, or written again.
        let is_safe = self.once[out as usize]
            || self.shader.symbol(out).kind == SymbolKind::Temp && self.writes[out as usize] == 1;
        if !self.is_closure(out) || op.writes != 1 {
            return op;
        }
        let [closures, ones] = [[a, b].map(|id| self.is_closure(id)), [a, b].map(|id| self.has_all(id, 1.0))];
        let [a_empty, b_empty] = [a, b].map(|id| self.is_empty(id));
        let from = match op.code {
            Opcode::Add if a_empty => Some(b).filter(|_| !b_empty),
            Opcode::Add if b_empty => Some(a),
            Opcode::Mul if a_empty || b_empty => None,
            Opcode::Mul if closures == [true, false] && ones[1] => Some(a),
            Opcode::Mul if closures == [false, true] && ones[0] => Some(b),
            Opcode::Assign if a_empty => None,
            _ => return op,
        };
        if from.is_none() && is_safe {
            self.empty.insert(out);
        }
        if op.code == Opcode::Assign && !closures[0] {
            return op;
        }
        self.changed = true;
        let from = from.unwrap_or_else(|| zero(self.shader));
        Op { code: Opcode::Assign, args: vec![out, from], reads: 2, writes: 1, derivs: 0, at: op.at }
    }

    /// The symbol and value that an operation always makes.
    fn operation(&self, op: &Op) -> Option<(SymId, Data)> {
        let (&out, args) = op.args.split_first()?;
        let symbol = self.shader.symbol(out);
        // A declared variable may be read before it is written.
        let is_safe = symbol.kind == SymbolKind::Temp
            || symbol.kind == SymbolKind::Local && self.once[out as usize] && !symbol.ty.is_array();
        if !is_safe || symbol.derivs && symbol.ty != Type::INT || op.writes != 1 {
            return None;
        }
        let operand = |&id: &SymId| Some((self.shader.symbol(id).ty, self.value(id)?));
        let operands: Vec<(Type, &Data)> = args.iter().map(operand).collect::<Option<_>>()?;
        Some((out, known_result(op.code, symbol.ty, &operands)?))
    }
}

/// The constant 0.
fn zero(shader: &mut Shader) -> SymId {
    let is_zero = |symbol: &Symbol| {
        symbol.kind == SymbolKind::Const
            && symbol.ty == Type::INT
            && matches!(&symbol.value, Some(Data::Int(list)) if list[..] == [0])
    };
    if let Some(known) = shader.symbols.iter().position(is_zero) {
        return known as SymId;
    }
    let name = format!("$nothing{}", shader.symbols.len());
    let value = Some(Data::Int(vec![0]));
    shader.symbols.push(Symbol { value, ..Symbol::new(name.into(), SymbolKind::Const, Type::INT) });
    (shader.symbols.len() - 1) as SymId
}

/// Which local variables are written once, outside of loops, choices and functions, and not read before: they have one value.
fn written_first(shader: &Shader, writes: &[u32]) -> Vec<bool> {
    let mut read = vec![false; shader.symbols.len()];
    for symbol in &shader.symbols {
        uses(&symbol.init, &mut |id, _| read[id as usize] = true);
    }
    let mut once = vec![false; shader.symbols.len()];
    for node in &shader.code {
        if let Node::Op(op) = node {
            for (_, &id) in op.args.iter().enumerate().filter(|(i, _)| op.is_read(*i)) {
                read[id as usize] = true;
            }
            if let Some(&out) = op.args.first().filter(|_| op.writes == 1) {
                once[out as usize] = writes[out as usize] == 1 && !read[out as usize];
            }
        } else {
            uses(std::slice::from_ref(node), &mut |id, _| read[id as usize] = true);
        }
    }
    once
}

/// Whether an operation has no effect but its results, and reports no unknown names.
pub(super) fn is_plain(shader: &Shader, op: &Op) -> bool {
    let by_name =
        !matches!(op.code, Opcode::Eq | Opcode::Neq | Opcode::Assign | Opcode::ArrayCopy | Opcode::Hash)
            && op.args.iter().any(|&id| shader.symbol(id).ty.base == Base::String);
    op.code.is_pure() && !by_name
}

/// Removes operations whose results are unused, and the operations that only feed those; returns whether
/// there were any.
fn remove_dead(shader: &mut Shader, unused: &[bool]) -> bool {
    let mut reads = vec![0_u32; shader.symbols.len()];
    uses(&shader.code, &mut |id, usage| reads[id as usize] += u32::from(usage == Use::Read));
    for symbol in &shader.symbols {
        uses(&symbol.init, &mut |id, usage| reads[id as usize] += u32::from(usage == Use::Read));
    }
    let is_own = |id: SymId| {
        matches!(shader.symbol(id).kind, SymbolKind::Temp | SymbolKind::Local)
            || unused.get(id as usize) == Some(&true)
    };
    let writes = |op: &'_ Op| -> Vec<SymId> {
        op.args.iter().enumerate().filter(|(i, _)| op.is_written(*i)).map(|(_, &id)| id).collect()
    };
    // Operations by number, in the order of the text, and by their results.
    let mut all: Vec<&Op> = Vec::new();
    let mut makers: Vec<Vec<usize>> = vec![Vec::new(); shader.symbols.len()];
    ops(&shader.code, &mut |op| {
        if is_plain(shader, op) {
            writes(op).into_iter().for_each(|id| makers[id as usize].push(all.len()));
        }
        all.push(op);
    });
    let mut dead = vec![false; all.len()];
    let mut open: Vec<SymId> = (0..reads.len() as SymId).filter(|&id| reads[id as usize] == 0).collect();
    let mut visit = |number: usize, reads: &mut [u32], open: &mut Vec<SymId>| {
        let op = all[number];
        let is_dead =
            is_plain(shader, op) && writes(op).iter().all(|&id| is_own(id) && reads[id as usize] == 0);
        if !is_dead || std::mem::replace(&mut dead[number], true) {
            return;
        }
        for (_, &id) in op.args.iter().enumerate().filter(|(i, _)| op.is_read(*i)) {
            reads[id as usize] -= 1;
            if reads[id as usize] == 0 {
                open.push(id);
            }
        }
    };
    (0..all.len()).filter(|&i| writes(all[i]).is_empty()).for_each(|i| visit(i, &mut reads, &mut open));
    while let Some(id) = open.pop() {
        for &number in &makers[id as usize] {
            visit(number, &mut reads, &mut open);
        }
    }
    let (mut number, mut removed) = (0, false);
    let mut is_dead = |_: &Op| {
        number += 1;
        dead[number - 1]
    };
    let code = sweep(&shader.code, &mut is_dead, &mut removed);
    if removed {
        shader.code = code;
    }
    removed
}

/// Removes the operations that only make outputs that are unused, by number.
pub(super) fn remove_unused(shader: &mut Shader, unused: &[bool]) {
    for _ in 0..PASSES {
        if !remove_dead(shader, unused) {
            return;
        }
    }
}

/// Calls `dead` for operations in the order of the text.
fn sweep(block: &Block, dead: &mut dyn FnMut(&Op) -> bool, removed: &mut bool) -> Block {
    let mut out = Vec::with_capacity(block.len());
    for node in block {
        match node {
            Node::Op(op) if dead(op) => *removed = true,
            Node::Op(_) => out.push(node.clone()),
            Node::If { condition, yes, no, at } => {
                let (yes, no) = (sweep(yes, dead, removed), sweep(no, dead, removed));
                if yes.is_empty() && no.is_empty() {
                    *removed = true;
                } else {
                    out.push(Node::If { condition: *condition, yes, no, at: *at });
                }
            }
            Node::Loop { keyword, init, test, condition, body, step, at } => out.push(Node::Loop {
                keyword,
                init: sweep(init, dead, removed),
                test: sweep(test, dead, removed),
                condition: *condition,
                body: sweep(body, dead, removed),
                step: sweep(step, dead, removed),
                at: *at,
            }),
            Node::Call { name, body, at } => {
                let body = sweep(body, dead, removed);
                if body.is_empty() {
                    *removed = true;
                } else {
                    out.push(Node::Call { name: *name, body, at: *at });
                }
            }
        }
    }
    out
}

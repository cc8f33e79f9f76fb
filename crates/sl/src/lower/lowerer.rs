// SPDX-License-Identifier: GPL-3.0-or-later
//! The state of lowering: symbols, blocks that are being written, constants.

use super::effects::Effects;
use crate::diagnostics::{Diagnostic, Diagnostics};
use crate::hir::{Data, Expr, FuncId, Program, VarId, VarKind};
use crate::ir::{Block, Node, Op, Shader, SourcePosition as At, SymId, Symbol, SymbolKind};
use crate::opcode::Opcode;
use crate::source::{Loc, Sources};
use crate::types::{Base, Type};
use std::collections::HashMap;
use std::sync::Arc;

/// A shader may become this many operations after inlining.
const OPS: usize = 1_000_000;

/// Blocks, statements and expressions may nest this deep after inlining, and calls count: lowering and all
/// that walk over the result recurse as often, on threads of 2 MiB.
const DEPTH: usize = 800;

/// The result of an expression: a symbol, or one for each value in a struct.
#[derive(Clone, Debug)]
pub(super) struct Value {
    pub(super) ty: Type,
    pub(super) leaves: Arc<[SymId]>,
}

impl Value {
    /// The symbol of a value that is no struct.
    pub(super) fn symbol(&self) -> SymId {
        self.leaves.first().copied().unwrap_or(0)
    }
}

/// A function that is being inlined.
pub(super) struct Inline {
    pub(super) func: FuncId,
    pub(super) result: Option<Value>,
    /// Where it is called.
    pub(super) from: Loc,
}

pub(super) struct Lowerer<'a> {
    pub(super) program: &'a Program,
    sources: &'a Sources,
    pub(super) shader: Shader,
    pub(super) blocks: Vec<Block>,
    pub(super) values: HashMap<VarId, Value>,
    constants: HashMap<String, SymId>,
    pub(super) inlines: Vec<Inline>,
    /// The old values of the targets of current assignments.
    pub(super) old: Vec<Value>,
    pub(super) effects: Effects,
    temps: usize,
    ops: usize,
    depth: usize,
    is_deep: bool,
    files: HashMap<u16, u16>,
    pub(super) diagnostics: Diagnostics,
}

impl<'a> Lowerer<'a> {
    pub(super) fn new(program: &'a Program, sources: &'a Sources) -> Self {
        let shader = Shader {
            kind: program.kind.clone(),
            name: program.name.clone(),
            meta: program.meta.clone(),
            structs: program.structs.clone(),
            ..Shader::default()
        };
        Self {
            program,
            sources,
            shader,
            blocks: vec![Vec::new()],
            values: HashMap::new(),
            constants: HashMap::new(),
            inlines: Vec::new(),
            old: Vec::new(),
            effects: Effects::default(),
            temps: 0,
            ops: 0,
            depth: 0,
            is_deep: false,
            files: HashMap::new(),
            diagnostics: Diagnostics::default(),
        }
    }

    pub(super) fn error(&mut self, loc: Loc, message: impl Into<String>) {
        self.diagnostics.push(Diagnostic::error(loc, message));
    }

    /// Whether the limit of code is reached, so that no more is made.
    pub(super) fn full(&self) -> bool {
        self.ops > OPS || self.diagnostics.errors > 0
    }

    /// Does something one level deeper; `None`, with a message, if that is too deep.
    pub(super) fn deeper<T>(&mut self, loc: Loc, inner: impl FnOnce(&mut Self) -> T) -> Option<T> {
        if self.depth >= DEPTH {
            if !self.is_deep {
                self.is_deep = true;
                let within = self.inlines.last().map(|inline| &self.program.funcs[inline.func as usize].name);
                let within = within.map_or(String::new(), |name| format!(", in '{name}'"));
                self.error(loc, format!("blocks, calls and operators are nested more than {DEPTH} deep once functions are in place{within}"));
            }
            return None;
        }
        self.depth += 1;
        let made = inner(self);
        self.depth -= 1;
        Some(made)
    }

    /// The position of an operation. In the library it is that of the call of the library.
    pub(super) fn at(&mut self, loc: Loc) -> At {
        let mut loc = loc;
        for inline in self.inlines.iter().rev() {
            if !self.sources.get(loc.file).is_some_and(|file| file.system) {
                break;
            }
            loc = inline.from;
        }
        if loc.file == u16::MAX {
            return At::default();
        }
        let next = self.shader.files.len() as u16;
        let file = *self.files.entry(loc.file).or_insert(next);
        if file == next {
            self.shader.files.push(self.sources.name(loc).into());
        }
        At { file, line: loc.line }
    }

    fn push_symbol(&mut self, symbol: Symbol) -> SymId {
        self.shader.symbols.push(symbol);
        self.shader.symbols.len() as SymId - 1
    }

    /// Makes the symbols of a variable; of a struct also one for the whole.
    pub(super) fn make(&mut self, name: &str, kind: SymbolKind, ty: Type) -> Value {
        let mut leaves = Vec::new();
        self.make_leaves(name, kind, ty, None, &mut leaves);
        Value { ty, leaves: leaves.into() }
    }

    fn make_leaves(
        &mut self,
        name: &str,
        kind: SymbolKind,
        ty: Type,
        owner: Option<(SymId, u32)>,
        leaves: &mut Vec<SymId>,
    ) {
        let mut symbol = Symbol::new(name.into(), kind, ty);
        symbol.member_of = owner;
        let id = self.push_symbol(symbol);
        let Base::Struct(number) = ty.base else {
            leaves.push(id);
            return;
        };
        let fields = self.program.structs.get(number).map(|s| s.fields.clone()).unwrap_or_default();
        for (i, field) in fields.iter().enumerate() {
            let inner = if ty.is_array() {
                field.ty.array_of(ty.array.max(1) * field.ty.array.max(1))
            } else {
                field.ty
            };
            self.make_leaves(&format!("{name}.{}", field.name), kind, inner, Some((id, i as u32)), leaves);
        }
    }

    /// How many symbols a value of this type takes.
    pub(super) fn count(&self, ty: Type) -> usize {
        match ty.struct_id().and_then(|id| self.program.structs.get(id)) {
            Some(s) => s.fields.iter().map(|f| self.count(f.ty)).sum(),
            None => 1,
        }
    }

    pub(super) fn temp(&mut self, ty: Type) -> Value {
        self.temps += 1;
        self.make(&format!("$tmp{}", self.temps), SymbolKind::Temp, ty)
    }

    /// The symbols of a variable, made when it is first met.
    pub(super) fn var(&mut self, id: VarId) -> Value {
        if let Some(value) = self.values.get(&id) {
            return value.clone();
        }
        let var = &self.program.vars[id as usize];
        let kind = match var.kind {
            VarKind::Global => SymbolKind::Global,
            VarKind::Param => SymbolKind::Param,
            VarKind::Output => SymbolKind::OutputParam,
            VarKind::Local => SymbolKind::Local,
        };
        let (name, ty) = (var.name.clone(), var.ty);
        let value = self.make(&name, kind, ty);
        self.values.insert(id, value.clone());
        value
    }

    pub(super) fn constant(&mut self, ty: Type, data: Data) -> Value {
        let key = match &data {
            Data::Int(list) => format!("{ty:?}{list:?}"),
            Data::Float(list) => format!("{ty:?}{:?}", list.iter().map(|f| f.to_bits()).collect::<Vec<_>>()),
            Data::Str(list) => format!("{ty:?}{list:?}"),
        };
        let id = match self.constants.get(&key) {
            Some(&id) => id,
            None => {
                let name = format!("$const{}", self.constants.len() + 1);
                let mut symbol = Symbol::new(name.into(), SymbolKind::Const, ty);
                symbol.value = Some(data);
                let id = self.push_symbol(symbol);
                self.constants.insert(key, id);
                id
            }
        };
        Value { ty, leaves: [id].into() }
    }

    pub(super) fn int(&mut self, value: i32) -> SymId {
        self.constant(Type::INT, Data::Int(vec![value])).symbol()
    }

    pub(super) fn float(&mut self, value: f32) -> SymId {
        self.constant(Type::FLOAT, Data::Float(vec![value])).symbol()
    }

    pub(super) fn text(&mut self, value: &str) -> SymId {
        self.constant(Type::STRING, Data::Str(vec![value.into()])).symbol()
    }

    pub(super) fn push(&mut self, node: Node) {
        self.ops += 1;
        if self.ops == OPS {
            let loc = Loc::NONE;
            self.error(
                loc,
                format!(
                    "the shader is too large: more than {OPS} operations once its functions are in place"
                ),
            );
        }
        if let Some(block) = self.blocks.last_mut().filter(|_| self.ops <= OPS) {
            block.push(node);
        }
    }

    /// An operation that writes its first argument and reads the others.
    pub(super) fn emit(&mut self, name: &str, args: &[SymId], loc: Loc) {
        self.emit_with(name, args.to_vec(), [!1, 1, 0], loc);
    }

    /// An operation with its reads, writes and derivatives.
    pub(super) fn emit_with(
        &mut self,
        name: &str,
        args: Vec<SymId>,
        [reads, writes, derivs]: [u64; 3],
        loc: Loc,
    ) {
        let at = self.at(loc);
        let code = Opcode::named(name);
        if code == Opcode::Unknown {
            self.shader.unknown.get_or_insert_with(|| name.into());
        }
        self.push(Node::Op(Op { code, args, reads, writes, derivs, at }));
    }

    /// The code that `inner` emits, as a block of its own.
    pub(super) fn block(&mut self, inner: impl FnOnce(&mut Self)) -> Block {
        self.blocks.push(Vec::new());
        inner(self);
        self.blocks.pop().unwrap_or_default()
    }

    pub(super) fn kind(&self, id: SymId) -> SymbolKind {
        self.shader.symbol(id).kind
    }

    /// A constant number as a float.
    fn constant_number(&self, id: SymId) -> Option<f32> {
        let symbol = self.shader.symbol(id);
        match (&symbol.value, symbol.kind, symbol.ty) {
            (Some(Data::Int(list)), SymbolKind::Const, Type::INT) => list.first().map(|&v| v as f32),
            _ => None,
        }
    }

    /// The value as one of type `to`.
    pub(super) fn convert(&mut self, value: Value, to: Type, loc: Loc) -> Value {
        let from = value.ty;
        // Arrays are copied as far as both go.
        let arrays = from.is_array() && to.is_array();
        if from.equivalent(to, &self.program.structs) || arrays || to.is_unknown() {
            return Value { ty: if arrays { from } else { to }, ..value };
        }
        if to.base.is_float_based()
            && !to.is_array()
            && let Some(number) = self.constant_number(value.symbol())
        {
            let float = self.float(number);
            if to == Type::FLOAT {
                return Value { ty: to, leaves: [float].into() };
            }
            let out = self.temp(to);
            self.emit("assign", &[out.symbol(), float], loc);
            return out;
        }
        let out = self.temp(to);
        self.copy(&out, &value, loc);
        out
    }

    /// Assigns a value to symbols.
    pub(super) fn copy(&mut self, to: &Value, from: &Value, loc: Loc) {
        if to.leaves == from.leaves {
            return;
        }
        for (&a, &b) in to.leaves.iter().zip(from.leaves.iter()) {
            let array = self.shader.symbol(a).ty.is_array();
            self.emit(if array { "arraycopy" } else { "assign" }, &[a, b], loc);
        }
    }

    pub(super) fn condition(&mut self, e: &Expr) -> SymId {
        let value = self.expr(e, None);
        self.truth(&value, false, e.loc)
    }

    /// An int: whether the value is not zero, not empty.
    pub(super) fn truth(&mut self, value: &Value, always: bool, loc: Loc) -> SymId {
        if value.ty == Type::INT && !always {
            return value.symbol();
        }
        let zero = match value.ty.base {
            Base::String => self.text(""),
            Base::Int | Base::Closure => self.int(0),
            _ => self.float(0.0),
        };
        let out = self.temp(Type::INT);
        self.emit("neq", &[out.symbol(), value.symbol(), zero], loc);
        out.symbol()
    }
}

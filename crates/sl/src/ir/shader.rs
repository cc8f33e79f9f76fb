// SPDX-License-Identifier: GPL-3.0-or-later
//! A compiled shader.

use crate::hir::{Data, Meta};
use crate::opcode::Opcode;
use crate::types::{Base, Structs, Type};
use std::sync::Arc;

/// Number of a symbol in its shader.
pub type SymId = u32;
/// Operations in order.
pub type Block = Vec<Node>;

/// The kind of a symbol.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SymbolKind {
    /// An input.
    Param,
    /// An output, which may be given a first value.
    OutputParam,
    /// A variable.
    Local,
    /// The result of an expression.
    Temp,
    /// Input from the renderer, and `Ci`.
    Global,
    /// A value of the text.
    Const,
}

impl SymbolKind {
    /// The word in `.oso`.
    #[must_use]
    pub const fn keyword(self) -> &'static str {
        match self {
            Self::Param => "param",
            Self::OutputParam => "oparam",
            Self::Local => "local",
            Self::Temp => "temp",
            Self::Global => "global",
            Self::Const => "const",
        }
    }

    /// The inverse of [`keyword`](Self::keyword).
    #[must_use]
    pub fn from_keyword(keyword: &str) -> Option<Self> {
        [Self::Param, Self::OutputParam, Self::Local, Self::Temp, Self::Global, Self::Const]
            .into_iter()
            .find(|kind| kind.keyword() == keyword)
    }

    /// An input or output.
    #[must_use]
    pub const fn is_param(self) -> bool {
        matches!(self, Self::Param | Self::OutputParam)
    }
}

/// A typed symbol for a value. Structs have one symbol for each member, named `struct.member`, and one
/// without a value for the whole.
#[derive(Clone, Debug)]
pub struct Symbol {
    /// Its name, unique in the shader.
    pub name: Arc<str>,
    /// Its kind.
    pub kind: SymbolKind,
    /// Its type.
    pub ty: Type,
    /// A constant's value, a parameter's default as far as it is known from the text. Others have none.
    pub value: Option<Data>,
    /// Operations that make a parameter's default.
    pub init: Block,
    /// Metadata.
    pub meta: Vec<Meta>,
    /// Whether it carries derivatives.
    pub derivs: bool,
    /// The struct it is a member of, and the member's number.
    pub member_of: Option<(SymId, u32)>,
}

impl Symbol {
    /// A symbol without a value.
    #[must_use]
    pub fn new(name: Arc<str>, kind: SymbolKind, ty: Type) -> Self {
        Self {
            name,
            kind,
            ty,
            value: None,
            init: Vec::new(),
            meta: Vec::new(),
            derivs: false,
            member_of: None,
        }
    }

    /// The value of a metadatum that is an integer.
    #[must_use]
    pub fn flag(&self, name: &str) -> Option<i32> {
        self.meta.iter().find(|m| &*m.name == name && m.ty == Type::INT).and_then(|m| match &m.value {
            Data::Int(list) => list.first().copied(),
            _ => None,
        })
    }
}

/// A line of the source text.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SourcePosition {
    /// Number in [`Shader::files`].
    pub file: u16,
    /// Line, from 1; 0 is not known.
    pub line: u32,
}

/// An operation. If it has a result, that is its first argument.
#[derive(Clone, Debug)]
pub struct Op {
    /// Which.
    pub code: Opcode,
    /// Its operands.
    pub args: Vec<SymId>,
    /// Arguments that are read, by bits; from the 65th on all are.
    pub reads: u64,
    /// Arguments that are written.
    pub writes: u64,
    /// Arguments whose derivatives are taken.
    pub derivs: u64,
    /// Where it comes from.
    pub at: SourcePosition,
}

/// An operation or a block of them.
#[derive(Clone, Debug)]
pub enum Node {
    /// One operation; `break`, `continue`, `return` and `exit` among them.
    Op(Op),
    /// A choice by an int.
    If {
        /// The condition.
        condition: SymId,
        /// If it is not 0.
        yes: Block,
        /// If it is 0.
        no: Block,
        /// Where.
        at: SourcePosition,
    },
    /// A loop.
    Loop {
        /// `for`, `while` or `dowhile`.
        keyword: &'static str,
        /// Done once.
        init: Block,
        /// Makes the condition; after `init`, or after the body in `dowhile`.
        test: Block,
        /// The condition.
        condition: SymId,
        /// The body of each iteration.
        body: Block,
        /// Run after each iteration.
        step: Block,
        /// Where.
        at: SourcePosition,
    },
    /// A function's body; `return` leaves it.
    Call {
        /// The constant that holds the function's name.
        name: SymId,
        /// The body.
        body: Block,
        /// Where.
        at: SourcePosition,
    },
}

/// A compiled shader.
#[derive(Clone, Debug, Default)]
pub struct Shader {
    /// `surface`, `displacement`, `volume`, `shader`, `light`, `camera`, `environment` or `pixel`.
    pub kind: Arc<str>,
    /// Its name.
    pub name: Arc<str>,
    /// Its metadata.
    pub meta: Vec<Meta>,
    /// All structs.
    pub structs: Structs,
    /// All symbols; parameters in order.
    pub symbols: Vec<Symbol>,
    /// Its code.
    pub code: Block,
    /// Names of source files.
    pub files: Vec<Arc<str>>,
    /// The name of the first operation that is unknown.
    pub unknown: Option<Arc<str>>,
}

impl Shader {
    /// A symbol.
    #[must_use]
    pub fn symbol(&self, id: SymId) -> &Symbol {
        &self.symbols[id as usize]
    }

    /// The symbol of a name.
    #[must_use]
    pub fn find(&self, name: &str) -> Option<SymId> {
        self.symbols.iter().position(|s| &*s.name == name).map(|i| i as SymId)
    }

    /// The parameters.
    pub fn params(&self) -> impl Iterator<Item = (SymId, &Symbol)> {
        self.symbols.iter().enumerate().filter(|(_, s)| s.kind.is_param()).map(|(i, s)| (i as SymId, s))
    }

    /// The symbols that make up a struct's value, or the symbol itself.
    #[must_use]
    pub fn leaves(&self, id: SymId) -> Vec<SymId> {
        if !matches!(self.symbol(id).ty.base, Base::Struct(_)) {
            return vec![id];
        }
        let prefix = format!("{}.", self.symbol(id).name);
        (0..self.symbols.len() as SymId)
            .filter(|&i| self.symbol(i).name.starts_with(&prefix) && self.symbol(i).ty.struct_id().is_none())
            .collect()
    }
}

impl Op {
    /// Whether argument `i` is read.
    #[must_use]
    pub const fn is_read(&self, i: usize) -> bool {
        i >= 64 || self.reads & (1 << i) != 0
    }

    /// Whether argument `i` is written.
    #[must_use]
    pub const fn is_written(&self, i: usize) -> bool {
        i < 64 && self.writes & (1 << i) != 0
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! The checked program as a tree: every name resolved, every expression with its type, every call with its
//! function.

use crate::ast::{Binary, Unary};
use crate::source::Loc;
use crate::types::{Structs, Type};
use std::sync::Arc;

/// Number of a variable.
pub type VarId = u32;
/// Number of a function.
pub type FuncId = u32;

/// The kind of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VarKind {
    /// Given by the renderer.
    Global,
    /// A shader's parameter.
    Param,
    /// A shader's output parameter.
    Output,
    /// All others.
    Local,
}

/// A value that is known from the text.
#[derive(Clone, Debug, PartialEq)]
pub enum Data {
    /// Integers.
    Int(Vec<i32>),
    /// Floats, of triples and matrices as well.
    Float(Vec<f32>),
    /// Texts.
    Str(Vec<Arc<str>>),
}

impl Data {
    /// How many values it holds.
    #[must_use]
    pub fn count(&self) -> usize {
        match self {
            Self::Int(list) => list.len(),
            Self::Float(list) => list.len(),
            Self::Str(list) => list.len(),
        }
    }
}

/// One metadatum.
#[derive(Clone, Debug, PartialEq)]
pub struct Meta {
    /// Its type.
    pub ty: Type,
    /// Its name.
    pub name: Arc<str>,
    /// Its value.
    pub value: Data,
}

/// A variable.
#[derive(Clone, Debug)]
pub struct Var {
    /// Its name; of locals of inner scopes with the scope's number, so that names are unique.
    pub name: Arc<str>,
    /// Its type.
    pub ty: Type,
    /// Its kind.
    pub kind: VarKind,
    /// Its initial value.
    pub init: Option<Expr>,
    /// Metadata.
    pub meta: Vec<Meta>,
    /// Where it is declared.
    pub loc: Loc,
}

/// A function of the source text.
#[derive(Clone, Debug)]
pub struct Func {
    /// Its name.
    pub name: Arc<str>,
    /// Its return type.
    pub returns: Type,
    /// Its parameters, and whether each is written to.
    pub formals: Vec<(VarId, bool)>,
    /// Its body; `None` if only declared.
    pub body: Option<Vec<Stmt>>,
}

/// The whole program.
#[derive(Clone, Debug, Default)]
pub struct Program {
    /// All structs.
    pub structs: Structs,
    /// All variables.
    pub vars: Vec<Var>,
    /// All functions of the text.
    pub funcs: Vec<Func>,
    /// `surface`, `displacement`, `volume` or `shader`.
    pub kind: Arc<str>,
    /// The shader's name.
    pub name: Arc<str>,
    /// The shader's metadata.
    pub meta: Vec<Meta>,
    /// The shader's parameters in order.
    pub params: Vec<VarId>,
    /// The body of the shader.
    pub body: Vec<Stmt>,
}

/// An expression.
#[derive(Clone, Debug)]
pub struct Expr {
    /// Its kind.
    pub kind: ExprKind,
    /// Its type.
    pub ty: Type,
    /// Where it is.
    pub loc: Loc,
}

impl Expr {
    /// The variable that it names, or names a part of.
    #[must_use]
    pub fn root(&self) -> Option<VarId> {
        match &self.kind {
            ExprKind::Var(id) => Some(*id),
            ExprKind::Field(base, _) | ExprKind::Index(base, _) => base.root(),
            _ => None,
        }
    }
}

/// A call of a function of the library.
#[derive(Clone, Debug)]
pub struct Builtin {
    /// The operation.
    pub name: Arc<str>,
    /// Its arguments.
    pub args: Vec<Expr>,
    /// The type that each argument is converted to; unknown where any type is valid.
    pub formals: Vec<Type>,
    /// Which arguments it writes; bit 0 is the first.
    pub writes: u64,
    /// Which arguments it reads.
    pub reads: u64,
    /// Of which arguments it takes derivatives.
    pub derivs: u64,
}

/// Kinds of expressions.
#[derive(Clone, Debug)]
pub enum ExprKind {
    /// A number.
    Int(i32),
    /// A number.
    Float(f32),
    /// A text.
    Str(Arc<str>),
    /// A variable.
    Var(VarId),
    /// The number of the member of a struct.
    Field(Box<Expr>, u32),
    /// An element of an array, a component of a triple or matrix, or of such an element.
    Index(Box<Expr>, Vec<Expr>),
    /// An operator.
    Unary(Unary, Box<Expr>),
    /// An operator.
    Binary(Binary, Box<Expr>, Box<Expr>),
    /// A choice.
    Ternary(Box<[Expr; 3]>),
    /// Target and value.
    Assign(Box<Expr>, Box<Expr>),
    /// The value of the assignment's target before the assignment.
    Old,
    /// `++a` or `--a`
    Before(bool, Box<Expr>),
    /// `a++` or `a--`
    After(bool, Box<Expr>),
    /// All in order; the last is the value.
    Comma(Vec<Expr>),
    /// Conversion to the expression's type.
    Cast(Box<Expr>),
    /// A triple, matrix, float or int made of parts.
    Construct(Vec<Expr>),
    /// A struct made of its members; may be fewer.
    StructList(Vec<Expr>),
    /// An array made of its elements; may be fewer.
    ArrayList(Vec<Expr>),
    /// A function of the text.
    Call(FuncId, Vec<Expr>),
    /// A function of the library.
    Builtin(Box<Builtin>),
    /// Wrong; a message has been given.
    Error,
}

/// A statement.
#[derive(Clone, Debug)]
pub struct Stmt {
    /// Its kind.
    pub kind: StmtKind,
    /// Where it starts.
    pub loc: Loc,
}

/// Kinds of statements.
#[derive(Clone, Debug)]
pub enum StmtKind {
    /// Several.
    Block(Vec<Stmt>),
    /// A choice.
    If(Expr, Vec<Stmt>, Vec<Stmt>),
    /// A loop.
    Loop {
        /// `for`, `while` or `dowhile`.
        keyword: &'static str,
        /// Done once, before.
        init: Vec<Stmt>,
        /// Whether to go on.
        condition: Expr,
        /// Run after each iteration.
        step: Option<Expr>,
        /// The body of each iteration.
        body: Vec<Stmt>,
    },
    /// Leaves the loop.
    Break,
    /// Goes to the loop's next iteration.
    Continue,
    /// Leaves the function.
    Return(Option<Expr>),
    /// Gives variables their first value.
    Declare(Vec<VarId>),
    /// For its side effects.
    Expr(Expr),
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! The syntax tree: names are not resolved yet, types not checked. The grammar is OSL's.

use crate::source::Loc;
use crate::types::Base;
use std::sync::Arc;

/// Operators between two values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Binary {
    /// `*`
    Mul,
    /// `/`
    Div,
    /// `+`
    Add,
    /// `-`
    Sub,
    /// `%`
    Mod,
    /// `==`
    Eq,
    /// `!=`
    Neq,
    /// `>`
    Gt,
    /// `>=`
    Ge,
    /// `<`
    Lt,
    /// `<=`
    Le,
    /// `&`
    BitAnd,
    /// `|`
    BitOr,
    /// `^`
    Xor,
    /// `&&`
    And,
    /// `||`
    Or,
    /// `<<`
    Shl,
    /// `>>`
    Shr,
}

/// Sign, operation name in `.oso` files and operator functions, and how tightly it binds.
const BINARY: [(Binary, &str, &str, u8); 18] = [
    (Binary::Mul, "*", "mul", 10),
    (Binary::Div, "/", "div", 10),
    (Binary::Add, "+", "add", 9),
    (Binary::Sub, "-", "sub", 9),
    (Binary::Mod, "%", "mod", 10),
    (Binary::Eq, "==", "eq", 6),
    (Binary::Neq, "!=", "neq", 6),
    (Binary::Gt, ">", "gt", 7),
    (Binary::Ge, ">=", "ge", 7),
    (Binary::Lt, "<", "lt", 7),
    (Binary::Le, "<=", "le", 7),
    (Binary::BitAnd, "&", "bitand", 5),
    (Binary::BitOr, "|", "bitor", 3),
    (Binary::Xor, "^", "xor", 4),
    (Binary::And, "&&", "and", 2),
    (Binary::Or, "||", "or", 1),
    (Binary::Shl, "<<", "shl", 8),
    (Binary::Shr, ">>", "shr", 8),
];

impl Binary {
    /// The operator and how tightly it binds, by its sign.
    #[must_use]
    pub fn from_sign(sign: &str) -> Option<(Self, u8)> {
        BINARY.iter().find(|row| row.1 == sign).map(|row| (row.0, row.3))
    }

    fn row(self) -> (&'static str, &'static str) {
        BINARY.iter().find(|row| row.0 == self).map_or(("", ""), |row| (row.1, row.2))
    }

    /// As written.
    #[must_use]
    pub fn sign(self) -> &'static str {
        self.row().0
    }

    /// The operation's name.
    #[must_use]
    pub fn keyword(self) -> &'static str {
        self.row().1
    }
}

/// Operators before one value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unary {
    /// `-`
    Neg,
    /// `!`
    Not,
    /// `~`
    Compl,
}

impl Unary {
    /// As written.
    #[must_use]
    pub const fn sign(self) -> &'static str {
        match self {
            Self::Neg => "-",
            Self::Not => "!",
            Self::Compl => "~",
        }
    }

    /// The operation's name.
    #[must_use]
    pub const fn keyword(self) -> &'static str {
        match self {
            Self::Neg => "neg",
            Self::Not => "not",
            Self::Compl => "compl",
        }
    }
}

/// A type as written.
#[derive(Clone, Debug, PartialEq)]
pub enum TypeName {
    /// A word of the language.
    Simple(Base),
    /// `closure` before a type.
    Closure,
    /// A struct's name.
    Named(Arc<str>),
}

/// A type and its position.
#[derive(Clone, Debug)]
pub struct TypeRef {
    /// The type.
    pub keyword: TypeName,
    /// Where.
    pub loc: Loc,
}

/// An expression.
#[derive(Clone, Debug)]
pub struct Expr {
    /// Its kind.
    pub kind: ExprKind,
    /// Where its operator, or its first token, is.
    pub loc: Loc,
    /// How deep it is nested; bounded, so that walks over it can call themselves.
    pub depth: u16,
}

/// Kinds of expressions.
#[derive(Clone, Debug)]
pub enum ExprKind {
    /// An integer.
    Int(i32),
    /// A float.
    Float(f32),
    /// A text.
    Str(Arc<str>),
    /// A variable.
    Name(Arc<str>),
    /// `a[i]`, `a[i][j]`, `a[i][j][k]`
    Index(Box<Expr>, Vec<Expr>),
    /// `a.b`
    Field(Box<Expr>, Arc<str>),
    /// An operator before a value.
    Unary(Unary, Box<Expr>),
    /// An operator between values.
    Binary(Binary, Box<Expr>, Box<Expr>),
    /// `a ? b : c`
    Ternary(Box<[Expr; 3]>),
    /// `a = b`, `a += b`
    Assign(Option<Binary>, Box<Expr>, Box<Expr>),
    /// `++a`, or `--a` if false.
    Before(bool, Box<Expr>),
    /// `a++`, or `a--` if false.
    After(bool, Box<Expr>),
    /// `a, b`, and whether it is in parentheses.
    Comma(Vec<Expr>, bool),
    /// `f(a, b)`
    Call(Arc<str>, Vec<Expr>),
    /// `color(a, b, c)`
    Construct(Base, Vec<Expr>),
    /// `(color) a`
    Cast(Base, Box<Expr>),
    /// `{ a, b }`
    Braces(Vec<Expr>),
}

/// A variable in a declaration.
#[derive(Clone, Debug)]
pub struct Declarator {
    /// Its name.
    pub name: Arc<str>,
    /// Where the name is.
    pub loc: Loc,
    /// Length in brackets; -1 for empty ones.
    pub array: Option<i32>,
    /// Its initial value.
    pub init: Option<Expr>,
}

/// One `type name = value` in double brackets.
#[derive(Clone, Debug)]
pub struct Metadatum {
    /// Its type.
    pub base: Base,
    /// Name, length and value.
    pub declarator: Declarator,
}

/// A parameter of a function or shader.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// Whether it is written to.
    pub output: bool,
    /// Its type.
    pub ty: TypeRef,
    /// Name, length and default.
    pub declarator: Declarator,
    /// Its metadata.
    pub metadata: Vec<Metadatum>,
}

/// A function.
#[derive(Clone, Debug)]
pub struct Function {
    /// Its return type.
    pub returns: TypeRef,
    /// Its name.
    pub name: Arc<str>,
    /// Where the name is.
    pub loc: Loc,
    /// Its parameters.
    pub parameters: Vec<Parameter>,
    /// Its metadata.
    pub metadata: Vec<Metadatum>,
    /// Its body; `None` for a mere declaration.
    pub body: Option<Vec<Stmt>>,
}

/// A struct.
#[derive(Clone, Debug)]
pub struct StructDecl {
    /// Its name.
    pub name: Arc<str>,
    /// Where the name is.
    pub loc: Loc,
    /// Its members, each with its type.
    pub fields: Vec<(TypeRef, Declarator)>,
}

/// A shader.
#[derive(Clone, Debug)]
pub struct Shader {
    /// `surface`, `displacement`, `volume` or `shader`.
    pub kind: Arc<str>,
    /// As a function of that name without a result.
    pub function: Function,
}

/// An item of a file.
#[derive(Clone, Debug)]
pub enum Item {
    /// A function.
    Function(Function),
    /// A struct.
    Struct(StructDecl),
    /// A shader.
    Shader(Shader),
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
    /// `{ ... }`
    Block(Vec<Stmt>),
    /// `if (a) b else c`
    If(Expr, Box<Stmt>, Option<Box<Stmt>>),
    /// `while (a) b`
    While(Expr, Box<Stmt>),
    /// `do a while (b);`
    DoWhile(Box<Stmt>, Expr),
    /// `for (a; b; c) d`
    For(Box<Stmt>, Option<Expr>, Option<Expr>, Box<Stmt>),
    /// `break;`
    Break,
    /// `continue;`
    Continue,
    /// `return a;`
    Return(Option<Expr>),
    /// `type a = b, c;`
    Declare(TypeRef, Vec<Declarator>),
    /// A function inside a function.
    Function(Function),
    /// An expression for its side effects.
    Expr(Expr),
    /// `;`
    Empty,
}

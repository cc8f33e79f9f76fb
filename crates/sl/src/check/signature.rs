// SPDX-License-Identifier: GPL-3.0-or-later
//! Parameters and result of a function. The one-letter codes are OSL's.

use crate::hir::FuncId;
use crate::source::Loc;
use crate::types::{Base, Structs, Type};
use std::sync::Arc;

/// The type of one parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Formal {
    /// Of this type, or convertible to it.
    Is(Type),
    /// Anything but an array.
    Any,
    /// An array of anything.
    AnyArray,
    /// All arguments that are left.
    Rest,
    /// Names and values, alternating.
    Pairs,
}

/// A function that can be called.
#[derive(Clone, Debug)]
pub(super) struct Signature {
    pub(super) name: Arc<str>,
    pub(super) returns: Type,
    pub(super) formals: Vec<Formal>,
    /// Where it is declared; none for the table's.
    pub(super) loc: Option<Loc>,
    /// Number of the scope it was declared in.
    pub(super) scope: u32,
    /// The function of the text, if it is not the library's.
    pub(super) user: Option<FuncId>,
    /// Whether there is a body, or the library has one.
    pub(super) defined: bool,
    /// Which formals are written, by the declaration.
    pub(super) outputs: u64,
    pub(super) printf: bool,
    pub(super) texture: bool,
    /// How many `return` statements it has.
    pub(super) returned: usize,
}

impl Signature {
    /// From OSL's codes, as `fsf.`: the result first.
    pub(super) fn from_codes(name: &str, codes: &str) -> Self {
        let mut rest = codes;
        let returns = type_of(&mut rest);
        let mut formals = Vec::new();
        while !rest.is_empty() {
            formals.push(formal_of(&mut rest));
        }
        Self {
            name: name.into(),
            returns,
            formals,
            loc: None,
            scope: 0,
            user: None,
            defined: true,
            outputs: 0,
            printf: false,
            texture: false,
            returned: 0,
        }
    }

    /// The arguments' types as a list for messages.
    pub(super) fn list(&self, structs: &Structs) -> String {
        let names: Vec<String> = self.formals.iter().map(|f| f.display(structs)).collect();
        names.join(", ")
    }
}

impl Formal {
    fn display(self, structs: &Structs) -> String {
        match self {
            Self::Is(ty) => ty.display(structs),
            Self::Any => "<any>".into(),
            Self::AnyArray => "<any>[]".into(),
            Self::Rest | Self::Pairs => "...".into(),
        }
    }
}

fn formal_of(rest: &mut &str) -> Formal {
    for (code, formal) in
        [("?[]", Formal::AnyArray), ("?", Formal::Any), ("*", Formal::Rest), (".", Formal::Pairs)]
    {
        if let Some(after) = rest.strip_prefix(code) {
            *rest = after;
            return formal;
        }
    }
    Formal::Is(type_of(rest))
}

/// The type of the first code, which is taken off.
pub(super) fn type_of(rest: &mut &str) -> Type {
    let mut chars = rest.chars();
    let base = chars.next().map_or(Base::Unknown, Base::of_letter);
    *rest = chars.as_str();
    if let Some(after) = rest.strip_prefix("[]") {
        *rest = after;
        return Type::of(base).array_of(-1);
    }
    Type::of(base)
}

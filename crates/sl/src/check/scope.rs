// SPDX-License-Identifier: GPL-3.0-or-later
//! Names and the blocks in which they hold.
//! That a shader's own variables share a scope with the library's functions is OSL's rule.

use crate::hir::VarId;
use std::collections::HashMap;
use std::sync::Arc;

/// The meaning of a name.
#[derive(Clone, Debug)]
pub(super) enum Named {
    /// A variable.
    Var(VarId),
    /// Functions, by the numbers of their signatures, in reverse order of trying.
    Funcs(Vec<u32>),
    /// A struct.
    Struct(u16),
}

/// All names that hold where the checker is.
#[derive(Clone, Debug, Default)]
pub(super) struct Scopes {
    open: Vec<(u32, HashMap<Arc<str>, Named>)>,
    next: u32,
}

impl Scopes {
    /// Opens a scope.
    pub(super) fn push(&mut self) {
        self.open.push((self.next, HashMap::new()));
        self.next += 1;
    }

    /// Closes the innermost scope.
    pub(super) fn pop(&mut self) {
        self.open.pop();
    }

    /// The innermost scope's number; 0 is the file's.
    pub(super) fn number(&self) -> u32 {
        self.open.last().map_or(0, |s| s.0)
    }

    /// The meaning of a name here.
    pub(super) fn find(&self, name: &str) -> Option<&Named> {
        self.open.iter().rev().find_map(|scope| scope.1.get(name))
    }

    /// The meaning of a name that was declared in the innermost scope.
    pub(super) fn clash(&self, name: &str) -> Option<&Named> {
        self.open.last().and_then(|scope| scope.1.get(name))
    }

    /// Adds a function to those of its name in the innermost scope; they replace another meaning.
    pub(super) fn add_function(&mut self, name: Arc<str>, number: u32) {
        let Some((_, scope)) = self.open.last_mut() else { return };
        match scope.get_mut(&name) {
            Some(Named::Funcs(list)) => list.push(number),
            _ => drop(scope.insert(name, Named::Funcs(vec![number]))),
        }
    }

    /// The names of all functions that hold here, or of all variables.
    pub(super) fn names(&self, functions: bool) -> impl Iterator<Item = &Arc<str>> {
        let is_meant = move |named: &Named| match named {
            Named::Funcs(_) => functions,
            Named::Var(_) => !functions,
            Named::Struct(_) => false,
        };
        let all = self.open.iter().flat_map(|(_, scope)| scope);
        all.filter(move |(_, named)| is_meant(named)).map(|(name, _)| name)
    }

    /// Gives a name its meaning from here on.
    pub(super) fn insert(&mut self, name: Arc<str>, named: Named) {
        if let Some(scope) = self.open.last_mut() {
            scope.1.insert(name, named);
        }
    }
}

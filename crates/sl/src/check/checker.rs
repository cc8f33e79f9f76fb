// SPDX-License-Identifier: GPL-3.0-or-later
//! The state of checking.
//!
//! OSL gives some messages while it reads a function and others after its end; to print in the same order, messages of a
//! function are collected in two lists, early and late.

use super::builtins::signatures;
use super::scope::{Named, Scopes};
use super::signature::Signature;
use crate::budget::Budget;
use crate::diagnostics::{Diagnostic, Diagnostics, Severity};
use crate::hir::{Expr, ExprKind, FuncId, Program, Var, VarKind};
use crate::source::{Loc, Sources};
use crate::types::Type;
use std::collections::HashSet;
use std::sync::Arc;

/// How strictly to check.
#[derive(Clone, Copy, Debug, Default)]
pub struct Options {
    /// Warnings count as errors.
    pub warnings_are_errors: bool,
    /// Whether extensions to OSL are unknown.
    pub strict: bool,
}

/// Wrong names for which the nearest known one is searched.
const GUESSES: usize = 20;
/// Overloads times calls.
const COMPARISONS: u64 = 3_000_000;
/// Declarations times earlier ones of their names.
const DECLARATIONS: u64 = 100_000_000;
/// Initialiser lists are tried against every overload; this many tries are enough for any program.
const TRIES: usize = 100_000;

#[derive(Debug, Default)]
pub(super) struct Frame {
    pub(super) early: Diagnostics,
    pub(super) late: Diagnostics,
    /// The return type of the function; `None` in a shader's body.
    pub(super) returns: Option<(Type, Arc<str>)>,
    pub(super) returned: usize,
    pub(super) loops: usize,
}

/// The state.
#[derive(Debug)]
pub(super) struct Checker<'a> {
    pub(super) program: Program,
    pub(super) scopes: Scopes,
    pub(super) signatures: Vec<Signature>,
    pub(super) frames: Vec<Frame>,
    pub(super) readonly: HashSet<u32>,
    pub(super) sources: &'a Sources,
    pub(super) formals_of_shader: bool,
    quiet: &'a HashSet<(u16, u32)>,
    pub(super) options: Options,
    /// While above 0 messages are swallowed.
    pub(super) mute: usize,
    /// While above 0 all messages are early.
    pub(super) all_early: usize,
    /// Calls of functions that had no body yet: the function and the place.
    pub(super) bodiless: Vec<(FuncId, Loc)>,
    tries: usize,
    guesses: usize,
    /// Comparisons of functions with earlier ones of their names.
    pub(super) declarations: Budget,
    /// Comparisons of calls with functions of their names.
    pub(super) comparisons: Budget,
    pub(super) done: Diagnostics,
}

const GLOBALS: [(&str, Type, bool); 13] = [
    ("P", Type::POINT, false),
    ("I", Type::VECTOR, false),
    ("N", Type::NORMAL, false),
    ("Ng", Type::NORMAL, true),
    ("u", Type::FLOAT, true),
    ("v", Type::FLOAT, true),
    ("dPdu", Type::VECTOR, true),
    ("dPdv", Type::VECTOR, true),
    ("Ps", Type::POINT, true),
    ("Ci", Type::CLOSURE, false),
    ("time", Type::FLOAT, true),
    ("dtime", Type::FLOAT, true),
    ("dPdtime", Type::VECTOR, true),
];

/// Additional globals of the shader types that OSL lacks, and whether they are read-only.
const GLOBALS_OF_KINDS: [(&str, Type, bool, &[&str]); 9] = [
    ("L", Type::VECTOR, false, &["light"]),
    ("Cl", Type::COLOR, false, &["light"]),
    ("lightdist", Type::FLOAT, false, &["light"]),
    ("lightpdf", Type::FLOAT, false, &["light"]),
    ("xi", Type::FLOAT.array_of(2), true, &["light", "camera"]),
    ("raster", Type::POINT, true, &["camera", "pixel"]),
    ("tmin", Type::FLOAT, false, &["camera"]),
    ("tmax", Type::FLOAT, false, &["camera"]),
    ("weight", Type::COLOR, false, &["camera"]),
];

/// Declarations before a text.
#[derive(Clone, Debug, Default)]
pub struct Known {
    program: Program,
    scopes: Scopes,
    signatures: Vec<Signature>,
    readonly: HashSet<u32>,
}

impl Checker<'_> {
    /// The declarations so far.
    pub(super) fn known(self) -> Known {
        let Self { program, scopes, signatures, readonly, .. } = self;
        Known { program, scopes, signatures, readonly }
    }
}

impl<'a> Checker<'a> {
    /// After known declarations.
    pub(super) fn after(
        known: Known,
        sources: &'a Sources,
        quiet: &'a HashSet<(u16, u32)>,
        options: Options,
    ) -> Self {
        let Known { program, scopes, signatures, readonly } = known;
        Self {
            program,
            scopes,
            signatures,
            frames: Vec::new(),
            readonly,
            sources,
            formals_of_shader: false,
            quiet,
            options,
            mute: 0,
            all_early: 0,
            bodiless: Vec::new(),
            tries: 0,
            guesses: 0,
            comparisons: Budget::new(
                COMPARISONS,
                ["functions of a name are compared with calls more than", "times"],
            ),
            declarations: Budget::new(
                DECLARATIONS,
                ["functions of a name are compared with each other more than", "times"],
            ),
            done: Diagnostics::default(),
        }
    }

    pub(super) fn new(sources: &'a Sources, quiet: &'a HashSet<(u16, u32)>, options: Options) -> Self {
        let mut this = Self::after(Known::default(), sources, quiet, options);
        this.scopes.push();
        for (name, ty, readonly) in GLOBALS {
            let id = this.declare(name.into(), ty, VarKind::Global, Loc::NONE);
            if readonly {
                this.readonly.insert(id);
            }
        }
        let all: Vec<Signature> = signatures(options.strict).collect();
        for signature in all.into_iter().rev() {
            this.add_signature(signature);
        }
        this
    }

    /// Declares the additional globals of a shader type.
    pub(super) fn declare_globals_of(&mut self, kind: &str) {
        for (name, ty, readonly, kinds) in GLOBALS_OF_KINDS {
            if kinds.contains(&kind) {
                let id = self.declare(name.into(), ty, VarKind::Global, Loc::NONE);
                if readonly {
                    self.readonly.insert(id);
                }
            }
        }
    }

    /// A new variable in the innermost scope.
    pub(super) fn declare(&mut self, name: Arc<str>, ty: Type, kind: VarKind, loc: Loc) -> u32 {
        let id = self.program.vars.len() as u32;
        let unique = match self.scopes.number() {
            0 => name.clone(),
            scope => format!("___{scope}_{name}").into(),
        };
        self.program.vars.push(Var { name: unique, ty, kind, init: None, meta: Vec::new(), loc });
        self.scopes.insert(name, Named::Var(id));
        id
    }

    /// A new function in the innermost scope.
    pub(super) fn add_signature(&mut self, signature: Signature) -> u32 {
        let number = self.signatures.len() as u32;
        let name = signature.name.clone();
        self.signatures.push(signature);
        self.scopes.add_function(name, number);
        number
    }

    /// The functions of a name, in the order to try.
    pub(super) fn overloads(&self, name: &str) -> Vec<u32> {
        match self.scopes.find(name) {
            Some(Named::Funcs(list)) => list.iter().rev().copied().collect(),
            _ => Vec::new(),
        }
    }

    pub(super) fn show(&self, ty: Type) -> String {
        ty.display(&self.program.structs)
    }

    fn give(&mut self, mut diagnostic: Diagnostic, early: bool) {
        if self.mute > 0 {
            return;
        }
        if diagnostic.severity == Severity::Warning {
            if self.quiet.contains(&(diagnostic.loc.file, diagnostic.loc.line)) {
                return;
            }
            if self.options.warnings_are_errors {
                diagnostic.severity = Severity::Error;
            }
        }
        let early = early || self.all_early > 0;
        match self.frames.last_mut() {
            Some(frame) if early => frame.early.push(diagnostic),
            Some(frame) => frame.late.push(diagnostic),
            None => self.done.push(diagnostic),
        }
    }

    /// A message that OSL gives after the function's end.
    pub(super) fn error(&mut self, loc: Loc, message: String) {
        self.give(Diagnostic::error(loc, message), false);
    }

    /// The same with a remedy.
    pub(super) fn error_help(&mut self, loc: Loc, message: String, help: String) {
        self.give(Diagnostic::error(loc, message).help(help), false);
    }

    /// A message that OSL gives while it reads.
    pub(super) fn early_error(&mut self, loc: Loc, message: String) {
        self.give(Diagnostic::error(loc, message), true);
    }

    /// The same with a remedy.
    pub(super) fn early_error_help(&mut self, loc: Loc, message: String, help: Option<String>) {
        let mut diagnostic = Diagnostic::error(loc, message);
        diagnostic.help = help;
        self.give(diagnostic, true);
    }

    /// A warning, after the function's end.
    pub(super) fn warning(&mut self, loc: Loc, message: String) {
        self.give(Diagnostic::warning(loc, message), false);
    }

    /// A warning while it reads.
    pub(super) fn early_warning(&mut self, loc: Loc, message: String) {
        self.give(Diagnostic::warning(loc, message), true);
    }

    /// Counts a try of an initialiser list; false when there were too many.
    pub(super) fn may_try(&mut self, loc: Loc) -> bool {
        self.tries += 1;
        if self.tries == TRIES {
            let mute = std::mem::take(&mut self.mute);
            let message =
                "initializer lists within arguments of overloaded functions are nested too deeply".to_owned();
            self.error_help(
                loc,
                message,
                "name the types: color(...), vector(...), a struct's name(...)".to_owned(),
            );
            self.mute = mute;
        }
        self.tries <= TRIES
    }

    /// The name in scope that is most similar to a wrong one.
    pub(super) fn nearest(&mut self, wrong: &str, functions: bool) -> Option<String> {
        let distance = |a: &str, b: &str| {
            let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
            let mut row: Vec<usize> = (0..=b.len()).collect();
            for (i, x) in a.iter().enumerate() {
                let mut corner = row[0];
                row[0] = i + 1;
                for (j, y) in b.iter().enumerate() {
                    let here = (corner + usize::from(x != y)).min(row[j] + 1).min(row[j + 1] + 1);
                    corner = std::mem::replace(&mut row[j + 1], here);
                }
            }
            row[b.len()]
        };
        // All names are compared: that is done for the first mistakes only.
        self.guesses += 1;
        if wrong.len() > 60 || self.guesses > GUESSES {
            return None;
        }
        let names = self.scopes.names(functions);
        let best = names.filter(|n| n.len() < 60).map(|n| (distance(wrong, n), n)).min()?;
        (best.0 <= 1 + wrong.len() / 4).then(|| format!("did you mean '{}'?", best.1))
    }
}

/// An expression that is wrong.
pub(super) fn wrong(loc: Loc) -> Expr {
    Expr { kind: ExprKind::Error, ty: Type::UNKNOWN, loc }
}

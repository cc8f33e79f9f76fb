// SPDX-License-Identifier: GPL-3.0-or-later
//! Declarations, and the check of a whole file.
//! The rules and words are OSL's.

use super::checker::{Checker, Frame, Known, Options};
use super::literal::literal;
use super::scope::Named;
use super::signature::{Formal, Signature};
use crate::ast::{self, TypeName};
use crate::diagnostics::Diagnostics;
use crate::hir::{Func, Meta, Program, VarId, VarKind};
use crate::parse::Parsed;
use crate::source::{Loc, Sources};
use crate::types::{Base, Field, Struct, Type};
use std::collections::HashSet;
use std::path::Path;

/// Structs of one program.
const STRUCTS: usize = 10_000;
/// Values in all members of a struct.
const STRUCT_SIZE: usize = 100_000;

/// Earlier definitions that a message lists.
const MOST_LISTED: usize = 20;

/// Checks declarations of structs and functions that come before other texts, and are right.
#[must_use]
pub fn check_library(parsed: &Parsed, sources: &Sources, options: Options) -> Known {
    let mut checker = Checker::new(sources, &parsed.quiet, options);
    for item in &parsed.items {
        match item {
            ast::Item::Struct(s) => checker.structure(s),
            ast::Item::Function(f) => checker.function(f),
            ast::Item::Shader(_) => {}
        }
    }
    checker.known()
}

/// Checks a file that follows the known declarations, if any. The program is only whole if there were no
/// errors.
#[must_use]
pub fn check(
    parsed: &Parsed,
    known: Option<&Known>,
    sources: &Sources,
    options: Options,
) -> (Program, Diagnostics) {
    let mut checker = match known {
        Some(known) => Checker::after(known.clone(), sources, &parsed.quiet, options),
        None => Checker::new(sources, &parsed.quiet, options),
    };
    checker.done.append(parsed.diagnostics.clone());
    if options.warnings_are_errors {
        checker.done.errors = checker.done.list.len();
        for diagnostic in &mut checker.done.list {
            diagnostic.severity = crate::diagnostics::Severity::Error;
        }
    }
    let mut shader = None;
    let mut late = Diagnostics::default();
    for item in &parsed.items {
        match item {
            ast::Item::Struct(s) => checker.structure(s),
            ast::Item::Function(f) => checker.function(f),
            ast::Item::Shader(s) if shader.is_some() => {
                let message = "Syntax error: Only one shader is allowed per file.".to_owned();
                checker.error(s.function.loc, message);
            }
            ast::Item::Shader(s) => {
                shader = Some(());
                late = checker.shader(s);
            }
        }
    }
    let syntax = parsed.broken || checker.done.errors > 0;
    if syntax {
        // Except messages about a whole file.
    } else if shader.is_none() {
        checker.error_help(
            Loc::NONE,
            "No shader function defined".to_owned(),
            "a file holds one shader: surface name (...) { ... }".to_owned(),
        );
    } else {
        checker.done.append(late);
        checker.missing_bodies();
    }
    (checker.program, checker.done)
}

impl Checker<'_> {
    /// Moves the early messages of the innermost function to the one around it, then the late ones.
    fn leave(&mut self, keep_late: bool) -> (Frame, Diagnostics) {
        let mut frame = self.frames.pop().unwrap_or_default();
        let early = std::mem::take(&mut frame.early);
        let late = std::mem::take(&mut frame.late);
        let to = match self.frames.last_mut() {
            Some(outer) => &mut outer.early,
            None => &mut self.done,
        };
        to.append(early);
        if keep_late {
            return (frame, late);
        }
        to.append(late);
        (frame, Diagnostics::default())
    }

    pub(super) fn type_of(&mut self, ty: &ast::TypeRef) -> Type {
        match &ty.keyword {
            TypeName::Simple(base) => Type::of(*base),
            TypeName::Closure => Type::CLOSURE,
            TypeName::Named(name) => match self.scopes.find(name) {
                Some(Named::Struct(id)) => Type::of(Base::Struct(*id)),
                _ => {
                    let names: Vec<&str> = self.program.structs.0.iter().map(|s| &*s.name).collect();
                    let help = (!names.is_empty()).then(|| format!("structs are: {}", names.join(", ")));
                    self.early_error_help(ty.loc, format!("Unknown struct name: {name}"), help);
                    Type::UNKNOWN
                }
            },
        }
    }

    fn underscores(&mut self, name: &str, loc: Loc) {
        if name.starts_with("___") {
            self.early_error(loc, format!("\"{name}\" : sorry, can't start with three underscores"));
        }
    }

    fn structure(&mut self, s: &ast::StructDecl) {
        if self.scopes.clash(&s.name).is_some() {
            self.early_error(s.loc, format!("\"{}\" already declared in this scope", s.name));
        }
        self.underscores(&s.name, s.loc);
        let id = self.program.structs.0.len();
        if id >= STRUCTS {
            self.early_error(s.loc, format!("more than {STRUCTS} structs"));
            return;
        }
        self.program.structs.0.push(Struct {
            name: s.name.to_string(),
            scope: self.scopes.number(),
            fields: Vec::new(),
        });
        let mut size = 0_usize;
        let mut names = HashSet::new();
        for (ty, field) in &s.fields {
            let mut ty = self.type_of(ty);
            if ty.struct_id() == Some(id as u16) {
                self.early_error(field.loc, format!("Unknown struct name: {}", s.name));
                continue;
            }
            if let Some(length) = field.array {
                if length < 1 {
                    self.early_error(field.loc, format!("Invalid array length for {}", field.name));
                }
                ty = ty.array_of(length.max(1));
            }
            size = size.saturating_add(self.leaves(ty).saturating_mul(ty.elements().max(1)));
            if !names.insert(field.name.clone()) {
                let message = format!("Field \"{}\" already exists in struct \"{}\"", field.name, s.name);
                self.early_error(field.loc, message);
            } else if size > STRUCT_SIZE {
                self.early_error(
                    field.loc,
                    format!("struct \"{}\" has more than {STRUCT_SIZE} values", s.name),
                );
                break;
            } else {
                self.program.structs.0[id].fields.push(Field { name: field.name.to_string(), ty });
            }
        }
        // Inserted last, so that a struct cannot hold itself.
        self.scopes.insert(s.name.clone(), Named::Struct(id as u16));
    }

    /// Values in one element.
    fn leaves(&self, ty: Type) -> usize {
        match ty.struct_id().and_then(|id| self.program.structs.get(id)) {
            Some(s) => {
                s.fields.iter().map(|f| self.leaves(f.ty).saturating_mul(f.ty.elements().max(1))).sum()
            }
            None => ty.base.components().max(1),
        }
    }

    fn nested_arrays(&mut self, ty: Type, outer: bool, loc: Loc) {
        let Some(spec) = ty.struct_id().and_then(|id| self.program.structs.get(id)).cloned() else { return };
        for field in &spec.fields {
            if outer && field.ty.is_array() {
                let message =
                    format!("Nested structs with >1 levels of arrays are not allowed: {}", spec.name);
                self.early_error(loc, message);
            }
            self.nested_arrays(field.ty, outer || field.ty.is_array(), loc);
        }
    }

    /// Declares a variable and checks its initial value.
    pub(super) fn variable_declaration(&mut self, d: &ast::Declarator, ty: Type, kind: VarKind) -> VarId {
        let list = matches!(d.init.as_ref().map(|e| &e.kind), Some(ast::ExprKind::Braces(_)));
        let parameter = self.formals_of_shader;
        let mut ty = ty;
        if let Some(length) = d.array {
            if length < 1 && !parameter {
                self.early_error(d.loc, format!("Invalid array length for {}", d.name));
            }
            ty = ty.array_of(if length < 1 && !parameter { 1 } else { length });
        } else if list && !(ty.is_struct() || ty.is_triple() || ty == Type::MATRIX) {
            let message = "Can't use '= {...}' initializer except with arrays, structs, vectors, or matrix";
            self.early_error(d.loc, format!("{message} ({})", d.name));
        }
        if self.leaves(ty).saturating_mul(ty.elements().max(1)) > 1 << 24 {
            self.early_error(d.loc, format!("\"{}\" has more than 2^24 values", d.name));
            ty = ty.element();
        }
        // The first value is checked before the name holds.
        let early = list && d.init.is_some();
        self.all_early += usize::from(early);
        let init = d.init.as_ref().map(|e| self.expr(e, ty));
        self.all_early -= usize::from(early);
        self.clash(d, parameter);
        self.underscores(&d.name, d.loc);
        let id = self.declare(d.name.clone(), ty, kind, d.loc);
        self.nested_arrays(ty, ty.is_array(), d.loc);
        if let Some(init) = init {
            let fine =
                matches!(init.kind, crate::hir::ExprKind::Error) && list || self.initial(ty, d, &init, list);
            if fine {
                self.program.vars[id as usize].init = Some(init);
            }
        }
        id
    }

    fn initial(&mut self, ty: Type, d: &ast::Declarator, init: &crate::hir::Expr, list: bool) -> bool {
        if list {
            return true;
        }
        if ty.is_struct() && ty.base != init.ty.base {
            let message = format!("Cannot initialize {} {} = {}", self.show(ty), d.name, self.show(init.ty));
            self.error(d.loc, message);
            return false;
        }
        self.fits(ty, &d.name, init, d.loc)
    }

    fn clash(&mut self, d: &ast::Declarator, parameter: bool) {
        let Some(found) = self.scopes.clash(&d.name) else { return };
        let (loc, function) = match found {
            Named::Var(id) => (Some(self.program.vars[*id as usize].loc), false),
            Named::Funcs(list) => (list.last().and_then(|&n| self.signatures[n as usize].loc), true),
            Named::Struct(_) => (None, false),
        };
        let mut message = format!("\"{}\" already declared in this scope", d.name);
        if let Some(loc) = loc.filter(|&l| l != Loc::NONE) {
            let file = Path::new(self.sources.name(loc))
                .file_name()
                .map_or(String::new(), |f| f.to_string_lossy().into_owned());
            message.push_str(&format!("\n\t\tprevious declaration was at {file}:{}", loc.line));
        }
        if function && self.scopes.number() == 0 && parameter {
            self.early_warning(d.loc, message);
        } else {
            self.early_error(d.loc, message);
        }
    }

    fn metadata(&mut self, list: &[ast::Metadatum]) -> Vec<Meta> {
        let mut out = Vec::new();
        for m in list {
            let mut ty = Type::of(m.base);
            if let Some(length) = m.declarator.array {
                if length < 1 {
                    self.early_error(
                        m.declarator.loc,
                        format!("Invalid array length for {}", m.declarator.name),
                    );
                }
                ty = ty.array_of(length.max(1));
            }
            let Some(init) = &m.declarator.init else { continue };
            self.all_early += 1;
            let init = self.expr(init, ty);
            self.all_early -= 1;
            let (value, complete) = literal(ty, Some(&init));
            if complete {
                out.push(Meta { ty, name: m.declarator.name.clone(), value });
            } else {
                let message =
                    format!("Don't know how to print metadata {} ({})", m.declarator.name, self.show(ty));
                self.error_help(
                    m.declarator.loc,
                    message,
                    "metadata are numbers and texts written out".to_owned(),
                );
            }
        }
        out
    }

    /// Declares a function; checks its body.
    pub(super) fn function(&mut self, f: &ast::Function) {
        let returns = self.type_of(&f.returns);
        let outer_formals = std::mem::replace(&mut self.formals_of_shader, false);
        self.scopes.push();
        self.frames.push(Frame { returns: Some((returns, f.name.clone())), ..Frame::default() });
        let (mut formals, mut outputs) = (Vec::new(), 0_u64);
        let mut types = Vec::new();
        for (i, p) in f.parameters.iter().enumerate() {
            let mut ty = self.type_of(&p.ty);
            if let Some(length) = p.declarator.array {
                ty = ty.array_of(if length < 1 { -1 } else { length });
            }
            self.clash(&p.declarator, false);
            let id = self.declare(p.declarator.name.clone(), ty, VarKind::Local, p.declarator.loc);
            if !p.output && !ty.is_array() {
                self.readonly.insert(id);
            }
            if p.declarator.init.is_some() {
                let message =
                    format!("function parameter '{}' may not have a default initializer.", p.declarator.name);
                self.early_error(p.declarator.loc, message);
            }
            self.metadata(&p.metadata);
            formals.push((id, p.output));
            types.push(ty);
            outputs |= if p.output && i < 64 { 1 << i } else { 0 };
        }
        let body = f.body.as_ref().map(|list| self.statements(list));
        self.scopes.pop();
        let earlier = match self.scopes.find(&f.name) {
            Some(Named::Funcs(list)) => list.len(),
            _ => 0,
        };
        let was_spent = self.declarations.is_spent();
        let is_countless = was_spent || self.declarations.spend(earlier).is_none();
        if is_countless && !was_spent {
            self.early_error(f.loc, self.declarations.to_string());
        }
        let meta = self.metadata(&f.metadata);
        let flag = |name: &str| meta.iter().any(|m| &*m.name == name);
        let (frame, late) = self.leave(true);
        self.formals_of_shader = outer_formals;
        self.underscores(&f.name, f.loc);
        let unknown = types.iter().any(|t| t.is_unknown());
        let builtin = flag("builtin");
        let mut list: Vec<Formal> = types.iter().map(|&t| Formal::Is(t)).collect();
        if builtin && returns == Type::CLOSURE {
            list.push(Formal::Pairs);
        }
        let user = (!builtin).then(|| {
            let has_body = body.is_some();
            self.program.funcs.push(Func { name: f.name.clone(), returns, formals, body });
            let id = self.program.funcs.len() as u32 - 1;
            if has_body && !is_countless {
                self.define_declared(&f.name, &list, returns, id);
            }
            id
        });
        match self.scopes.clash(&f.name) {
            None | Some(Named::Funcs(_)) => {}
            Some(_) => self.early_error(f.loc, format!("\"{}\" already declared in this scope", f.name)),
        }
        if f.body.is_some() && !unknown && !is_countless {
            self.redefined(f, &list, returns);
        }
        let signature = Signature {
            name: f.name.clone(),
            returns,
            formals: list,
            loc: Some(f.loc),
            scope: self.scopes.number(),
            user,
            defined: f.body.is_some() || builtin,
            outputs,
            printf: flag("printf_args"),
            texture: flag("texture_args"),
            returned: frame.returned,
        };
        // OSL checks a body at the function's end, so after all messages above.
        match self.frames.last_mut() {
            Some(outer) => outer.early.append(late),
            None => self.done.append(late),
        }
        if !unknown {
            self.add_signature(signature);
        }
    }

    /// Calls of functions that were declared before they were defined reach the definition.
    fn define_declared(&mut self, name: &str, formals: &[Formal], returns: Type, id: u32) {
        for number in self.overloads(name) {
            let other = &mut self.signatures[number as usize];
            if !other.defined
                && other.formals == formals
                && other.returns == returns
                && let Some(declared) = other.user
            {
                let made = self.program.funcs[id as usize].clone();
                self.program.funcs[declared as usize] = made;
            }
        }
    }

    /// Reports functions that are called and have no body at the end of the file, each once. Without a result it is a warning:
    /// OSL's compiler takes them.
    fn missing_bodies(&mut self) {
        let mut reported = HashSet::new();
        for (id, loc) in std::mem::take(&mut self.bodiless) {
            let Some(Func { name, returns, body: None, .. }) = self.program.funcs.get(id as usize) else {
                continue;
            };
            if !reported.insert(id) {
                continue;
            }
            let (name, returns) = (name.clone(), *returns);
            let message = format!("function '{name}' is declared and called, but has no body");
            if returns == Type::VOID {
                self.warning(loc, message);
                continue;
            }
            let help = match returns == Type::CLOSURE {
                true => {
                    "closures of the renderer are declared with [[ int builtin = 1 ]] before the semicolon"
                }
                false => "write its body in braces in place of the semicolon",
            };
            self.error_help(loc, message, help.to_owned());
        }
    }

    fn redefined(&mut self, f: &ast::Function, formals: &[Formal], returns: Type) {
        let scope = self.scopes.number();
        let mut message = String::new();
        let mut listed = 0;
        for number in self.overloads(&f.name) {
            let other = &self.signatures[number as usize];
            if other.scope != scope || other.formals != formals || other.returns != returns || !other.defined
            {
                continue;
            }
            if message.is_empty() {
                let types: Vec<String> = formals
                    .iter()
                    .map(|f| match f {
                        Formal::Is(t) => self.show(*t),
                        _ => "...".to_owned(),
                    })
                    .collect();
                message = format!(
                    "Function '{} {} ({})' redefined in the same scope\n  Previous definitions:",
                    self.show(returns),
                    f.name,
                    types.join(", ")
                );
            }
            listed += 1;
            if listed > MOST_LISTED {
                message.push_str("\n    and more");
                break;
            }
            message.push_str("\n    ");
            match other.loc {
                Some(loc) => {
                    let file = Path::new(self.sources.name(loc))
                        .file_name()
                        .map_or(String::new(), |f| f.to_string_lossy().into_owned());
                    message.push_str(&format!("{file}:{}", loc.line));
                }
                None => message.push_str("built-in"),
            }
        }
        if !message.is_empty() {
            self.early_warning(f.loc, message);
        }
    }

    fn shader(&mut self, s: &ast::Shader) -> Diagnostics {
        let f = &s.function;
        self.frames.push(Frame::default());
        self.declare_globals_of(&s.kind);
        self.formals_of_shader = true;
        let mut missing = Vec::new();
        for p in &f.parameters {
            let ty = self.type_of(&p.ty);
            let kind = if p.output { VarKind::Output } else { VarKind::Param };
            let id = self.variable_declaration(&p.declarator, ty, kind);
            let meta = self.metadata(&p.metadata);
            self.program.vars[id as usize].meta = meta;
            self.program.params.push(id);
            if p.declarator.init.is_none() {
                missing.push((
                    p.declarator.loc,
                    format!("shader parameter '{}' requires a default initializer", p.declarator.name),
                ));
            }
            let declared = self.program.vars[id as usize].ty;
            if p.output && declared.array < 0 {
                missing.push((
                    p.declarator.loc,
                    format!("shader output parameter '{}' can't be unsized array", p.declarator.name),
                ));
            }
            if declared.is_array() && declared.struct_id().is_some() {
                self.error(p.declarator.loc, "array of struct are not allowed as parameters".to_owned());
            }
        }
        self.formals_of_shader = false;
        self.program.body = self.statements(f.body.as_deref().unwrap_or_default());
        for (loc, message) in missing {
            self.early_error(loc, message);
        }
        self.program.kind = s.kind.clone();
        self.program.name = f.name.clone();
        self.program.meta = self.metadata(&f.metadata);
        self.leave(true).1
    }
}

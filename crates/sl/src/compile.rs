// SPDX-License-Identifier: GPL-3.0-or-later
//! Source text to a compiled shader, all steps in a row.

use crate::check::{Known, Options as CheckOptions, check, check_library};
use crate::diagnostics::{Diagnostic, Diagnostics};
use crate::ir::{Shader, verify};
use crate::lower::lower;
use crate::parse::Parser;
use crate::passes::mark_derivatives;
use crate::preprocess::{Loader, Macros, Preprocessor};
use crate::source::{Loc, Sources};
use std::sync::OnceLock;

/// Declarations and functions available to every shader, before the user's text.
const STANDARD: &str = include_str!("../include/stdosl.h");
/// The name that messages show for it.
const STANDARD_NAME: &str = "stdosl.h";

/// The state that it leaves to later texts.
struct Library {
    macros: Macros,
    known: Known,
}

/// It is read and checked once in a process, and once more for strict compilation.
fn library(strict: bool) -> &'static Library {
    static LIBRARIES: [OnceLock<Library>; 2] = [const { OnceLock::new() }; 2];
    LIBRARIES[usize::from(strict)].get_or_init(|| {
        let options = Options { strict, ..Options::default() };
        let load: &Loader<'_> = &|_| None;
        let mut source = bare(&options, load);
        // As in all compilations the user's file has the first number.
        source.sources.add("", "", false);
        source.push_text(STANDARD_NAME, STANDARD, true);
        let parsed = Parser::new(&mut source, strict).file();
        let options = CheckOptions { strict, ..CheckOptions::default() };
        let known = check_library(&parsed, &source.sources, options);
        Library { macros: source.macros, known }
    })
}

/// How to compile.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// `NAME=TEXT` of macros to define.
    pub defines: Vec<String>,
    /// Macros to undefine.
    pub undefines: Vec<String>,
    /// Folders that `#include` searches.
    pub includes: Vec<String>,
    /// Warnings count as errors.
    pub warnings_are_errors: bool,
    /// Whether extensions to OSL are unknown: shader types `light`, `camera`, `environment` and `pixel`,
    /// `illuminance`, colour from `trace`, closure `radiance`.
    pub strict: bool,
}

/// The result of compiling a text.
#[derive(Debug)]
pub struct Compiled {
    /// The shader, if there were no errors.
    pub shader: Option<Shader>,
    /// The messages.
    pub diagnostics: Diagnostics,
    /// The files that were read, the compiler's own first.
    pub sources: Sources,
}

/// The tokens of a text, macros expanded, as text again; and the messages.
#[must_use]
pub fn preprocess(name: &str, text: &str, options: &Options, load: &Loader<'_>) -> (String, Compiled) {
    let mut source = start(name, text, options, load);
    let mut out = String::new();
    loop {
        let token = source.next_token();
        if token.tok == crate::token::Tok::End {
            break;
        }
        if source.sources.get(token.loc.file).is_some_and(|f| f.system) {
            continue;
        }
        out.push_str(if token.first {
            "\n"
        } else if token.space {
            " "
        } else {
            ""
        });
        out.push_str(&token.spelling());
    }
    out.push('\n');
    (out, Compiled { shader: None, diagnostics: source.diagnostics, sources: source.sources })
}

/// Before any text.
fn bare<'a>(options: &Options, load: &'a Loader<'a>) -> Preprocessor<'a> {
    let mut source = Preprocessor::new(load, options.includes.clone());
    let [major, minor, patch] = crate::VERSION_PARTS;
    for (first_token, value) in [
        ("OSL_VERSION_MAJOR", major),
        ("OSL_VERSION_MINOR", minor),
        ("OSL_VERSION_PATCH", patch),
        ("OSL_VERSION", crate::VERSION_CODE),
    ] {
        source.define(&format!("{first_token}={value}"));
    }
    if options.strict {
        source.define("__STRICT_OSL=1");
    }
    for option in &options.defines {
        source.define(option);
    }
    for option in &options.undefines {
        source.undefine(option);
    }
    source
}

/// Before the library, which comes before the text.
fn start<'a>(name: &str, text: &str, options: &Options, load: &'a Loader<'a>) -> Preprocessor<'a> {
    let mut source = bare(options, load);
    source.push_text(name, text, false);
    source.push_text(STANDARD_NAME, STANDARD, true);
    source
}

/// Before the text, after the library. Macros defined by the caller may change its meaning: then it is read
/// with the text.
fn start_after<'a>(
    name: &str,
    text: &str,
    options: &Options,
    load: &'a Loader<'a>,
) -> (Preprocessor<'a>, Option<&'static Known>) {
    if !options.defines.is_empty() || !options.undefines.is_empty() {
        return (start(name, text, options, load), None);
    }
    let library = library(options.strict);
    let mut source = Preprocessor::new(load, options.includes.clone());
    source.macros.clone_from(&library.macros);
    source.push_text(name, text, false);
    source.sources.add(STANDARD_NAME, STANDARD, true);
    (source, Some(&library.known))
}

/// Compiles a text.
#[must_use]
pub fn compile(name: &str, text: &str, options: &Options, load: &Loader<'_>) -> Compiled {
    let (mut source, known) = start_after(name, text, options, load);
    let parser = Parser::new(&mut source, options.strict);
    let mut diagnostics = std::mem::take(&mut source.diagnostics);
    let sources = source.sources;
    if diagnostics.errors > 0 {
        return Compiled { shader: None, diagnostics, sources };
    }
    let parsed = parser.file();
    let options = CheckOptions { warnings_are_errors: options.warnings_are_errors, strict: options.strict };
    let (program, found) = check(&parsed, known, &sources, options);
    diagnostics.append(found);
    if diagnostics.errors > 0 {
        return Compiled { shader: None, diagnostics, sources };
    }
    let (mut shader, found) = lower(&program, &sources);
    diagnostics.append(found);
    if let (0, Err(message)) = (diagnostics.errors, verify(&shader)) {
        diagnostics.push(Diagnostic::error(Loc::NONE, format!("the compiler made a mistake: {message}")));
    }
    mark_derivatives(&mut shader);
    let shader = (diagnostics.errors == 0).then_some(shader);
    Compiled { shader, diagnostics, sources }
}

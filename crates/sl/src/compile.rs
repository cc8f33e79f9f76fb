// SPDX-License-Identifier: GPL-3.0-or-later
//! Source text to a compiled shader, all steps in a row.
//! Source: original.

use crate::check::{Options as CheckOptions, check};
use crate::diagnostics::{Diagnostic, Diagnostics};
use crate::ir::{Shader, verify};
use crate::lower::lower;
use crate::parse::Parser;
use crate::passes::mark_derivatives;
use crate::preprocess::{Loader, Preprocessor};
use crate::source::{Loc, Sources};

/// What every shader can call: declarations and functions, before the user's text.
const STANDARD: &str = include_str!("../include/stdosl.h");

/// How to compile.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// `NAME=TEXT` of macros to define.
    pub defines: Vec<String>,
    /// Macros to forget again.
    pub undefines: Vec<String>,
    /// Folders that `#include` looks through.
    pub includes: Vec<String>,
    /// Warnings count as errors.
    pub warnings_are_errors: bool,
    /// Only what OSL has is known: no shader types `light`, `camera`, `environment` and `pixel`, no `illuminance`, no colour
    /// from `trace`, no closure `radiance`.
    pub strict: bool,
}

/// What became of a text.
#[derive(Debug)]
pub struct Compiled {
    /// The shader, if there were no errors.
    pub shader: Option<Shader>,
    /// What was found.
    pub diagnostics: Diagnostics,
    /// The files that were read, the compiler's own first.
    pub sources: Sources,
}

/// The tokens of a text, macros expanded, as text again; and what was found wrong.
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

fn start<'a>(name: &str, text: &str, options: &Options, load: &'a Loader<'a>) -> Preprocessor<'a> {
    let mut source = Preprocessor::new(load, options.includes.clone());
    let [major, minor, patch] = crate::VERSION_PARTS;
    for (word, value) in [
        ("OSL_VERSION_MAJOR", major),
        ("OSL_VERSION_MINOR", minor),
        ("OSL_VERSION_PATCH", patch),
        ("OSL_VERSION", crate::VERSION_CODE),
    ] {
        source.define(&format!("{word}={value}"));
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
    source.push_text(name, text, false);
    source.push_text("stdosl.h", STANDARD, true);
    source
}

/// Compiles a text.
#[must_use]
pub fn compile(name: &str, text: &str, options: &Options, load: &Loader<'_>) -> Compiled {
    let mut source = start(name, text, options, load);
    let parser = Parser::new(&mut source, options.strict);
    let mut diagnostics = std::mem::take(&mut source.diagnostics);
    let sources = source.sources;
    if diagnostics.errors > 0 {
        return Compiled { shader: None, diagnostics, sources };
    }
    let parsed = parser.file();
    let options = CheckOptions { warnings_are_errors: options.warnings_are_errors, strict: options.strict };
    let (program, found) = check(&parsed, &sources, options);
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

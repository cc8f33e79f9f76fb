// SPDX-License-Identifier: GPL-3.0-or-later
//! Reads the files of a script: source text, compiled shaders and groups.
//! Tests: `tests/scripts.rs`.

use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use gnurt_sl::diagnostics::{Diagnostic, Severity, Style};
use gnurt_sl::exec::unknown_operation;
use gnurt_sl::group::{Group, read_group};
use gnurt_sl::ir::{Shader, read as read_oso};
use gnurt_sl::source::Sources;
use gnurt_sl::{Options, compile};

use crate::access::Access;
use crate::library;

/// Reads files, and records their texts.
pub(crate) struct Reader<'a> {
    pub(crate) access: &'a Access,
    pub(crate) texts: RefCell<Vec<(PathBuf, String)>>,
    pub(crate) warnings: RefCell<Vec<String>>,
}

/// The compiler's message and remedy, in one line: `wood.osl:3:7: ...`.
fn headline(messages: &Diagnostic, sources: &Sources) -> String {
    let words: Vec<&str> = messages.message.split_whitespace().collect();
    let help = messages.help.as_ref().map_or_else(String::new, |help| format!("; {help}"));
    let (name, line) = (sources.name(messages.loc), messages.loc.line);
    let column = sources.line_text(messages.loc).map_or(1, |(text, first)| {
        let before = text.get(..(messages.loc.start as usize).saturating_sub(first));
        before.map_or(1, |before| before.chars().count() + 1)
    });
    let frame = if name.is_empty() { String::new() } else { format!("{name}:{line}:{column}: ") };
    format!("{frame}{}{help}", words.join(" "))
}

impl Reader<'_> {
    pub(crate) fn shader(&self, path: &Path, text: &str) -> Result<Shader, String> {
        let shown = path.display();
        let shader = if path.extension().is_some_and(|end| end == "oso") {
            read_oso(text).map_err(|why| format!("{shown}: {why}"))?
        } else {
            self.compiled(path, text)?
        };
        match unknown_operation(&shader) {
            None => Ok(shader),
            Some(op) => Err(format!("{shown}: unknown operation {op}")),
        }
    }

    fn compiled(&self, path: &Path, text: &str) -> Result<Shader, String> {
        let load = |path: &Path| {
            if let Some(text) = library::text(path) {
                return Some(text.to_owned());
            }
            let text = self.access.text(path).ok()?;
            self.texts.borrow_mut().push((path.to_owned(), text.clone()));
            Some(text)
        };
        let options = Options { includes: self.access.includes.clone(), ..Options::default() };
        let compiled = compile(&path.to_string_lossy(), text, &options, &load);
        let sources = &compiled.sources;
        let of =
            |severity: Severity| compiled.diagnostics.list.iter().filter(move |d| d.severity == severity);
        self.warnings.borrow_mut().extend(of(Severity::Warning).map(|d| headline(d, sources)));
        compiled.shader.ok_or_else(|| {
            let first = of(Severity::Error).next().map(|d| headline(d, sources));
            let drawn: String =
                of(Severity::Error).take(5).map(|d| d.render(sources, Style::Drawn)).collect();
            let first = first.unwrap_or_else(|| format!("{} does not compile", path.display()));
            // Callers with one line show the text before the blank one.
            format!("{first}\n\n{}", drawn.trim_end())
        })
    }

    pub(crate) fn group(&self, path: &Path, text: &str, folder: &Path) -> Result<Group, String> {
        let mut wrong: Vec<String> = Vec::new();
        let mut find = |name: &str| {
            let file = [name.to_owned(), format!("{name}.osl"), format!("{name}.oso")]
                .into_iter()
                .map(|name| folder.join(name))
                .find(|file| self.access.has(file));
            let made = match file {
                None => {
                    Err(format!("shader '{name}' is missing: the folder has no {name}.osl or {name}.oso"))
                }
                Some(file) => self.access.text(&file).and_then(|text| {
                    self.texts.borrow_mut().push((file.clone(), text.clone()));
                    self.shader(&file, &text)
                }),
            };
            made.map(Arc::new).map_err(|why| wrong.push(why)).ok()
        };
        let name = path.file_stem().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let mut messages = Vec::new();
        let group = read_group(&name, text, &mut find, &mut messages);
        if let Some(why) = wrong.first() {
            return Err(format!("{}: {why}", path.display()));
        }
        let group = group.map_err(|why| format!("{}: {}", path.display(), why.join("; ")))?;
        match messages.first() {
            None => Ok(group),
            Some(why) => Err(format!("{}: {why}", path.display())),
        }
    }
}

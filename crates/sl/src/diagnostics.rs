// SPDX-License-Identifier: GPL-3.0-or-later
//! Messages of the compiler: collected, then drawn for people or printed in OSL's one-line form.
//! The one-line form is OSL's.

use crate::source::{Loc, Sources};
use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// No output is written.
    Error,
    /// Output is written all the same.
    Warning,
}

/// One message.
#[derive(Clone, Debug)]
pub struct Diagnostic {
    /// How bad.
    pub severity: Severity,
    /// Where.
    pub loc: Loc,
    /// The fault, in OSL's words where OSL has words for it; may have several lines.
    pub message: String,
    /// The remedy.
    pub help: Option<String>,
}

/// The form in which messages are printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Style {
    /// File, line, column, the source line and the remedy.
    #[default]
    Drawn,
    /// `file:line: error: message`, as OSL's compiler prints it.
    Strict,
    /// One JSON object a line, for editors.
    Json,
}

/// A message of one position (file, line) is stored this often at most: a broken file must not fill the disk.
pub const LIMIT: usize = 200;

impl Diagnostic {
    /// An error.
    #[must_use]
    pub fn error(loc: Loc, message: impl Into<String>) -> Self {
        Self { severity: Severity::Error, loc, message: message.into(), help: None }
    }

    /// A warning.
    #[must_use]
    pub fn warning(loc: Loc, message: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, loc, message: message.into(), help: None }
    }

    /// With a remedy.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// The message as text that ends with a line end.
    #[must_use]
    pub fn render(&self, sources: &Sources, style: Style) -> String {
        match style {
            Style::Strict => self.strict(sources),
            Style::Json => self.json(sources),
            Style::Drawn => self.drawn(sources),
        }
    }

    const fn keyword(&self) -> &'static str {
        match self.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
        }
    }

    fn strict(&self, sources: &Sources) -> String {
        let name = sources.name(self.loc);
        let message = self.message.trim_end_matches('\n');
        if name.is_empty() {
            format!("{}: {message}\n", self.keyword())
        } else {
            format!("{name}:{}: {}: {message}\n", self.loc.line, self.keyword())
        }
    }

    fn column(&self, sources: &Sources) -> usize {
        let Some((line, first)) = sources.line_text(self.loc) else { return 0 };
        let at = (self.loc.start as usize).saturating_sub(first);
        line.get(..at).map_or(0, |before| before.chars().count()) + 1
    }

    fn json(&self, sources: &Sources) -> String {
        let text = |s: &str| {
            let mut out = String::with_capacity(s.len() + 2);
            for c in s.chars() {
                match c {
                    '"' => out.push_str("\\\""),
                    '\\' => out.push_str("\\\\"),
                    '\n' => out.push_str("\\n"),
                    '\t' => out.push_str("\\t"),
                    c if (c as u32) < 0x20 => out.push_str(&format!("\\u{:04x}", c as u32)),
                    c => out.push(c),
                }
            }
            format!("\"{out}\"")
        };
        format!(
            "{{\"severity\":\"{}\",\"file\":{},\"line\":{},\"column\":{},\"length\":{},\"message\":{},\"help\":{}}}\n",
            self.keyword(),
            text(sources.name(self.loc)),
            self.loc.line,
            self.column(sources),
            self.loc.len,
            text(self.message.trim_end_matches('\n')),
            self.help.as_deref().map_or_else(|| "null".to_owned(), text)
        )
    }

    fn drawn(&self, sources: &Sources) -> String {
        let level = match self.severity {
            Severity::Error => Level::ERROR,
            Severity::Warning => Level::WARNING,
        };
        let mut lines = self.message.trim_end_matches('\n').lines();
        let title = lines.next().unwrap_or_default();
        let notes = lines.collect::<Vec<_>>().join("\n");
        let mut group =
            level.primary_title(title).elements(std::iter::empty::<annotate_snippets::Element<'_>>());
        if let Some((line, first)) = sources.line_text(self.loc) {
            let from = (self.loc.start as usize).saturating_sub(first).min(line.len());
            let to = (from + usize::from(self.loc.len).max(1)).min(line.len());
            group = group.element(
                Snippet::source(line)
                    .line_start(self.loc.line as usize)
                    .path(sources.name(self.loc))
                    .annotation(AnnotationKind::Primary.span(from..to.max(from))),
            );
        }
        if !notes.is_empty() {
            group = group.element(Level::NOTE.message(&notes));
        }
        if let Some(help) = &self.help {
            group = group.element(Level::HELP.message(help));
        }
        format!("{}\n", Renderer::plain().render(&[group]))
    }
}

/// Messages in the order in which they are to be printed.
#[derive(Clone, Debug, Default)]
pub struct Diagnostics {
    /// The messages.
    pub list: Vec<Diagnostic>,
    /// Errors so far, dropped ones as well.
    pub errors: usize,
}

impl Diagnostics {
    /// Adds a message; past [`LIMIT`] it is only counted.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        self.errors += usize::from(diagnostic.severity == Severity::Error);
        if self.list.len() < LIMIT {
            self.list.push(diagnostic);
        }
    }

    /// Adds messages that were collected separately.
    pub fn append(&mut self, other: Self) {
        let dropped = other.errors - other.list.iter().filter(|d| d.severity == Severity::Error).count();
        for diagnostic in other.list {
            self.push(diagnostic);
        }
        self.errors += dropped;
    }
}

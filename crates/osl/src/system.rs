// SPDX-License-Identifier: GPL-3.0-or-later
//! Compiles shaders, and keeps the machine code of groups.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use gnurt_sl::diagnostics::{Diagnostic, Severity, Style};
use gnurt_sl::exec::unknown_operation;
use gnurt_sl::{Options, compile, ir};

use crate::builder::GroupBuilder;
use crate::engine::Engines;
use crate::error::Error;
use crate::shader::Shader;

/// Where shaders come from. One for a renderer; all threads may use it.
#[derive(Debug, Default)]
pub struct ShadingSystem {
    options: Options,
    engines: Engines,
}

impl ShadingSystem {
    /// With machine code where the processor has it, and no folders.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a folder that `#include` searches. Messages of shaders name a folder that does not exist.
    #[must_use]
    pub fn include(mut self, folder: impl AsRef<Path>) -> Self {
        self.options.includes.push(folder.as_ref().to_string_lossy().into_owned());
        self
    }

    /// Defines a macro, as `NAME=TEXT`.
    #[must_use]
    pub fn define(mut self, macro_and_text: impl Into<String>) -> Self {
        self.options.defines.push(macro_and_text.into());
        self
    }

    /// Interprets all groups: slower by an order of magnitude; values are the same.
    #[must_use]
    pub fn interpreted(mut self) -> Self {
        self.engines.is_interpreted = true;
        self
    }

    /// Compiles a text; `name` is the file's name in messages.
    ///
    /// # Errors
    /// [`Error::Compile`]. Types are checked once the syntax and all names are right, as in OSL's compiler: mending the first
    /// errors may bring others.
    pub fn compile(&self, name: &str, text: &str) -> Result<Shader, Error> {
        let read = |path: &Path| std::fs::read_to_string(path).ok();
        let made = compile(name, text, &self.options, &read);
        let of = |severity: Severity| -> Vec<String> {
            let all = made.diagnostics.list.iter().filter(|found| found.severity == severity);
            // OSL's compiler reports the assignment of a wrong expression once more.
            let is_echo = |found: &&Diagnostic| found.message.ends_with(" = unknown");
            let has_cause = all.clone().any(|found| !is_echo(&found));
            let all = all.filter(|found| !(has_cause && is_echo(found)));
            all.map(|found| found.render(&made.sources, Style::Drawn)).collect()
        };
        let absent = self.options.includes.iter().filter(|folder| !Path::new(folder).is_dir());
        let absent = absent.map(|folder| format!("{folder}: missing folder of include\n"));
        match made.shader {
            Some(ref shader) => {
                let warnings = of(Severity::Warning).into_iter().chain(absent).collect();
                Ok(Shader { shader: Arc::new(shader.clone()), warnings })
            }
            None => Err(Error::Compile(of(Severity::Error).into_iter().chain(absent).collect())),
        }
    }

    /// Reads and compiles a file: text (`.osl`), or the compiled form (`.oso`).
    ///
    /// # Errors
    /// [`Error::File`], [`Error::Compile`], [`Error::Compiled`].
    pub fn read(&self, path: impl AsRef<Path>) -> Result<Shader, Error> {
        let path = path.as_ref();
        let text = std::fs::read_to_string(path)
            .map_err(|error| Error::File { path: PathBuf::from(path), why: error.to_string() })?;
        let name = path.to_string_lossy();
        match path.extension().is_some_and(|extension| extension == "oso") {
            true => self.read_oso(&name, &text),
            false => self.compile(&name, &text),
        }
    }

    /// Reads a compiled shader; `name` is the file's name in messages.
    ///
    /// # Errors
    /// [`Error::Compiled`].
    pub fn read_oso(&self, name: &str, text: &str) -> Result<Shader, Error> {
        let wrong = |why: String| Error::Compiled { name: name.to_owned(), why };
        let shader = ir::read(text).map_err(wrong)?;
        match unknown_operation(&shader) {
            Some(operation) => Err(wrong(format!("unknown operation '{operation}'"))),
            None => Ok(Shader { shader: Arc::new(shader), warnings: Arc::new([]) }),
        }
    }

    /// Begins a group of this name.
    #[must_use]
    pub fn group(&self, name: &str) -> GroupBuilder {
        GroupBuilder::new(self.engines.clone(), name)
    }
}

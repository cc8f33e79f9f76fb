// SPDX-License-Identifier: GPL-3.0-or-later
//! Settings from the environment: `GNURT_THREADS`, `GNURT_ISA`, `GNURT_LOG`, `GNURT_PATH`.
//! See docs/reference/cli.md.
//! A variable that is empty counts as not set; one that an option overrides is ignored.
//! Tests: `tests/program/arguments.rs`, rows with variables.

use std::ffi::OsString;
use std::path::PathBuf;

use gnurt::simd::Level;

use crate::arguments::value;
use crate::failure::Failure;
use crate::messages::Verbosity;
use crate::nearest::unknown;

/// Environment variables.
#[derive(Debug, Default)]
pub(crate) struct Environment {
    /// `GNURT_THREADS`: as `--threads`.
    pub(crate) threads: Option<usize>,
    /// `GNURT_ISA`: as `--isa`.
    pub(crate) isa: Option<Level>,
    /// `GNURT_LOG`: as `-q` and `-v`.
    pub(crate) log: Option<Verbosity>,
    /// `GNURT_PATH`: folders to search for scene files, separated like those of `PATH`.
    pub(crate) path: Vec<PathBuf>,
}

/// Which variables options have made moot.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Overridden {
    /// `--threads` was given.
    pub(crate) threads: bool,
    /// `--isa` was given.
    pub(crate) isa: bool,
    /// `-q` or `-v` was given.
    pub(crate) log: bool,
}

/// Names for `GNURT_LOG`, from silent to talkative.
const LOG_NAMES: [(&str, Verbosity); 5] = [
    ("error", Verbosity::Quiet),
    ("warning", Verbosity::Normal),
    ("info", Verbosity::Details),
    ("debug", Verbosity::Everything),
    ("quiet", Verbosity::Quiet),
];

impl Environment {
    /// Reads the variables that matter.
    pub(crate) fn read(overridden: Overridden) -> Result<Self, Failure> {
        let read = |moot: bool, name| if moot { Ok(None) } else { text(name) };
        let parsed = |name: &str, problem: String| Failure::usage(format_args!("{name}: {problem}"));
        let threads = match read(overridden.threads, "GNURT_THREADS")? {
            Some(text) => Some(
                value::threads(&text).map_err(|why| parsed("GNURT_THREADS", format!("'{text}': {why}")))?,
            ),
            None => None,
        };
        let isa = match read(overridden.isa, "GNURT_ISA")? {
            Some(text) => Some(value::isa(&text).map_err(|why| parsed("GNURT_ISA", why))?),
            None => None,
        };
        let log = match read(overridden.log, "GNURT_LOG")? {
            Some(text) => Some(verbosity(&text).map_err(|why| parsed("GNURT_LOG", why))?),
            None => None,
        };
        Ok(Self { threads, isa, log, path: folders()? })
    }
}

/// A variable that is set, not empty, and text.
fn text(name: &str) -> Result<Option<String>, Failure> {
    let value = std::env::var_os(name).filter(|value| !value.is_empty());
    let no_text =
        |raw: OsString| Failure::usage(format_args!("{name}: '{}' is invalid UTF-8", raw.to_string_lossy()));
    value.map(|value| value.into_string().map_err(no_text)).transpose()
}

fn verbosity(name: &str) -> Result<Verbosity, String> {
    let known = LOG_NAMES.into_iter().find(|&(known, _)| known == name);
    known
        .map(|(_, verbosity)| verbosity)
        .ok_or_else(|| unknown("level", name, &LOG_NAMES.map(|(known, _)| known)))
}

fn folders() -> Result<Vec<PathBuf>, Failure> {
    let value = std::env::var_os("GNURT_PATH").unwrap_or_default();
    let folders: Vec<_> =
        std::env::split_paths(&value).filter(|folder| !folder.as_os_str().is_empty()).collect();
    match folders.iter().find(|folder| !folder.is_dir()) {
        Some(missing) => Err(Failure::usage(format_args!(
            "GNURT_PATH: '{}' is not a folder; give folders, separated by ':'",
            missing.display()
        ))),
        None => Ok(folders),
    }
}

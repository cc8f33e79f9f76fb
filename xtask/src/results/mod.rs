// SPDX-License-Identifier: GPL-3.0-or-later
//! `cargo xtask results SCENES [--only ROW,...] [--all] [--quick] [--busy]`: measures the rows of docs/explanation/results.md with
//! the release profile, and writes bench/record/results-DATE.json and the tables made from it, between that page's markers.
//! Tests: unit tests in `tables.rs` and `page.rs`.

mod machine;
mod page;
mod rows;
mod tables;

use std::path::{Path, PathBuf};

use serde_json::{Map, Value, json};

use crate::command;
use crate::failure::Failure;
use crate::workspace::Workspace;

const USAGE: &str = "results SCENES [--only ROW,...] [--all] [--quick] [--busy]; SCENES holds the folders conference, dragon, ...";

/// The requested measurements.
struct Request {
    scenes: PathBuf,
    only: Option<Vec<String>>,
    all: bool,
    quick: bool,
    busy: bool,
}

impl Request {
    fn read(arguments: &[String]) -> Result<Self, Failure> {
        let mut request = Self { scenes: PathBuf::new(), only: None, all: false, quick: false, busy: false };
        let mut rest = arguments.iter();
        while let Some(argument) = rest.next() {
            match &argument[..] {
                "--all" => request.all = true,
                "--quick" => request.quick = true,
                "--busy" => request.busy = true,
                "--only" => {
                    let list = rest.next().ok_or("--only needs names of rows, separated by commas")?;
                    request.only = Some(list.split(',').map(str::to_owned).collect());
                }
                flag if flag.starts_with('-') => return Err(format!("unknown option '{flag}'; {USAGE}")),
                path if request.scenes.as_os_str().is_empty() => {
                    request.scenes =
                        std::path::absolute(path).map_err(|error| format!("'{path}': {error}"))?;
                }
                other => return Err(format!("one folder of scenes, not also '{other}'; {USAGE}")),
            }
        }
        if request.scenes.as_os_str().is_empty() {
            return Err(USAGE.into());
        }
        for name in request.only.iter().flatten() {
            if !rows::ROWS.iter().any(|row| row.name == name) {
                let known = rows::ROWS.map(|row| row.name).join(", ");
                return Err(format!("unknown row '{name}'; there are: {known}"));
            }
        }
        Ok(request)
    }

    fn wants(&self, row: &rows::Row) -> bool {
        match &self.only {
            Some(names) => names.iter().any(|name| name == row.name),
            None => self.all || !row.long,
        }
    }
}

/// Measures, writes the JSON, then the page.
pub(crate) fn run(arguments: &[String]) -> Result<(), Failure> {
    let request = Request::read(arguments)?;
    let before = machine::load();
    if let Some(complaint) = machine::complaint(before) {
        if !request.busy {
            return Err(format!("{complaint}; --busy measures all the same"));
        }
        eprintln!("WARNING: {complaint}: these numbers are no results");
    }
    let target = Workspace::load()?.target;
    let program = ["build", "--release", "-p", "gnurt-cli", "--features", "installed,research"];
    command::run(command::cargo().args(program))?;
    let work = target.join("results");
    std::fs::create_dir_all(&work).map_err(|error| format!("'{}': {error}", work.display()))?;
    let setting = rows::Setting {
        program: target.join("release/gnurt"),
        scenes: request.scenes.clone(),
        work,
        quick: request.quick,
    };
    let mut measured = Map::new();
    for row in rows::ROWS.iter().filter(|row| request.wants(row)) {
        eprintln!("== {} ==", row.name);
        match (row.measure)(&setting) {
            Ok(value) => {
                measured.insert(row.name.to_owned(), value);
            }
            Err(reason) => eprintln!("WARNING: row '{}' is SKIPPED: {reason}", row.name),
        }
    }
    if measured.is_empty() {
        return Err("no row was measured".into());
    }
    let head = machine::describe(before)?;
    let date = head["date"].as_str().unwrap_or("unknown").to_owned();
    let document = json!({ "machine": head, "quick": request.quick, "rows": Value::Object(measured) });
    // A trial leaves the page and the records unchanged.
    let trial = request.quick || request.busy;
    let folder = if trial { setting.work } else { command::root().join("bench/record") };
    let path = folder.join(format!("results-{date}.json"));
    write(&path, &(serde_json::to_string(&document).map_err(|error| error.to_string())? + "\n"))?;
    let tables = tables::all(&document, &format!("results-{date}.json"));
    if trial {
        eprintln!("{tables}");
        eprintln!("a trial: the tables are above, the numbers in {}", path.display());
        return Ok(());
    }
    page::replace(&command::root().join("docs/explanation/results.md"), &tables)
}

fn write(path: &Path, text: &str) -> Result<(), Failure> {
    std::fs::write(path, text).map_err(|error| format!("'{}' cannot be written: {error}", path.display()))
}

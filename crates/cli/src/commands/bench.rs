// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt bench`: measures ray queries, beside Embree's where `EMBREE4_LIB` names a library of Embree 4.
//! Source: original. Proof: `tests/program/bench.rs`.

use std::path::{Path, PathBuf};

use gnurt::image;
use gnurt::simd::Level;
use gnurt_bench::rays::{News, Options, run as measure};
use gnurt_bench::{Class, EmbreeLibrary, Error, Filter, Subject, table, to_json};

use crate::arguments::{BenchArguments, BenchCommand, BenchRaysArguments, MachineArguments};
use crate::environment::Environment;
use crate::failure::{Failure, Outcome};
use crate::messages::{Messages, print};
use crate::source::Source;

/// The variable that names the rival.
const EMBREE: &str = "EMBREE4_LIB";

/// Measures what was asked for.
pub(crate) fn run(arguments: &BenchArguments, environment: &Environment, messages: Messages) -> Outcome {
    match &arguments.command {
        BenchCommand::Rays(arguments) => rays(arguments, environment, messages),
    }
}

fn rays(arguments: &BenchRaysArguments, environment: &Environment, messages: Messages) -> Outcome {
    let filter = Filter { engines: arguments.engines.clone(), modes: arguments.modes.clone() };
    filter.jobs().map_err(failure)?;
    check_output(arguments.json.as_deref())?;
    let find = |scene| Source::find(scene, environment);
    let sources: Vec<Source> = arguments.scenes.iter().map(|scene| find(scene)).collect::<Result<_, _>>()?;
    let is_wanted = filter.engines.is_empty() || filter.engines.iter().any(|engine| engine == "embree4");
    let embree = if is_wanted { rival(messages)? } else { None };
    let (threads, level) = machine(&arguments.machine, environment);
    let pool = gnurt::thread_pool(0).map_err(Failure::data)?;
    let all = || Class::ALL.to_vec();
    let options = Options {
        classes: if arguments.classes.is_empty() { all() } else { arguments.classes.clone() },
        filter,
        size: arguments.size,
        rounds: arguments.rounds,
        batch: arguments.batch,
        threads,
        level,
    };
    let mut rows = Vec::new();
    for source in sources {
        let subject = Subject::new(&source.stem(), &source.load(messages)?);
        let mut heard = Ok(());
        let mut tell = |news: News| match news {
            News::Built(what) => messages.detail(what),
            News::Differs(what) => messages.note(what),
            News::Class(rows) => {
                // The first failure counts; a reader who has left hears nothing more.
                if heard.is_ok() {
                    heard = print(table::of_class(rows));
                }
            }
        };
        rows.extend(measure(&subject, &options, embree.as_ref(), &pool, &mut tell).map_err(failure)?);
        heard?;
    }
    if let Some(file) = &arguments.json {
        write(file, to_json(&rows).to_string().as_bytes())?;
    }
    print(table::summary(&rows).trim_end())
}

/// Threads that trace, one if nobody says how many, and their instruction set.
fn machine(arguments: &MachineArguments, environment: &Environment) -> (usize, Level) {
    let threads = match arguments.threads.or(environment.threads) {
        Some(0) => gnurt::cores(),
        given => given.unwrap_or(1),
    };
    (threads, arguments.isa.or(environment.isa).unwrap_or_default())
}

/// Embree, if there is any.
fn rival(messages: Messages) -> Result<Option<EmbreeLibrary>, Failure> {
    let Some(file) = std::env::var_os(EMBREE).filter(|file| !file.is_empty()) else {
        messages.note(format_args!("embree: not found (set {EMBREE} to a library of Embree 4)"));
        return Ok(None);
    };
    let library = EmbreeLibrary::open(&PathBuf::from(file)).map_err(failure)?;
    messages.detail(format_args!("embree: version {}", library.version()));
    Ok(Some(library))
}

fn failure(error: Error) -> Failure {
    match error {
        Error::NothingToDo { .. } => Failure::usage(error),
        _ => Failure::data(error),
    }
}

fn check_output(file: Option<&Path>) -> Outcome {
    file.map_or(Ok(()), |file| image::check_writable(file).map_err(Failure::data))
}

fn write(file: &Path, bytes: &[u8]) -> Outcome {
    image::replace_file(file, bytes).map_err(Failure::data)
}

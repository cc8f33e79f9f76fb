// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt bench`: measures ray queries and builds, and Embree's for comparison where `EMBREE4_LIB` names a
//! library of Embree 4.
//! Tests: `tests/program/bench.rs`.

use std::ffi::OsString;
use std::path::PathBuf;

use gnurt_bench::rays::BenchEvent;
use gnurt_bench::{
    Class, EmbreeLibrary, Error, Filter, Subject, builds, crowd, dynamic, dynamic_plot, dynamic_row, fuzzy,
    paper, plot, rays, record, research, stadium, table, to_json, top,
};

use super::bench_files::{check_outputs, write};
use super::bench_light;
use crate::arguments::{
    BenchArguments, BenchBuildArguments, BenchCommand, BenchDynamicArguments, BenchPaperArguments,
    BenchRaysArguments, FileArguments,
};
use crate::environment::Environment;
use crate::failure::{Failure, Outcome};
use crate::messages::{Messages, print};
use crate::source::Source;
use crate::workers::machine;

/// The variable that names the library to compare with.
const EMBREE: &str = "EMBREE4_LIB";

/// Runs the requested measurement.
pub(crate) fn run(arguments: &BenchArguments, environment: &Environment, messages: Messages) -> Outcome {
    match &arguments.command {
        BenchCommand::Rays(arguments) => measure_rays(arguments, environment, messages),
        BenchCommand::Build(arguments) => measure_builds(arguments, environment, messages),
        BenchCommand::Dynamic(arguments) => measure_motion(arguments, environment, messages),
        BenchCommand::Paper(arguments) => measure_paper(arguments, environment, messages),
        BenchCommand::Light(arguments) => bench_light::run(arguments, environment, messages),
    }
}

fn measure_rays(arguments: &BenchRaysArguments, environment: &Environment, messages: Messages) -> Outcome {
    let filter = Filter { engines: arguments.engines.clone(), modes: arguments.modes.clone() };
    filter.jobs().map_err(failure)?;
    check_outputs(&[&arguments.json, &arguments.record, &arguments.svg])?;
    let sources = find(&arguments.scenes, &arguments.files, environment)?;
    let embree = embree_library(&filter, messages)?;
    // One thread by default: other processes disturb it least.
    let threads = match arguments.machine.threads.or(environment.threads) {
        Some(0) => gnurt::cores(),
        given => given.unwrap_or(1),
    };
    let options = rays::Options {
        classes: if arguments.classes.is_empty() { Class::ALL.to_vec() } else { arguments.classes.clone() },
        filter,
        size: arguments.size,
        rounds: arguments.rounds,
        batch: arguments.batch,
        threads,
        level: arguments.machine.isa.or(environment.isa).unwrap_or_default(),
        ..rays::Options::default()
    };
    let load_before = record::load();
    let pool = gnurt::thread_pool(0).map_err(Failure::data)?;
    let mut rows = Vec::new();
    for source in sources {
        let subject = Subject::new(&source.stem(), &source.load(messages)?);
        let mut printed = Ok(());
        let mut tell = |news: BenchEvent| match news {
            BenchEvent::Built(what) => messages.detail(what),
            BenchEvent::Differs(what) => messages.note(what),
            BenchEvent::Class(rows) => {
                // The first failure counts; after the reader has left, nothing more is printed.
                if printed.is_ok() {
                    printed = print(table::of_class(rows));
                }
            }
        };
        let measured = rays::run(&subject, &options, embree.as_ref(), Vec::new(), &pool, &mut tell);
        rows.extend(measured.map_err(failure)?);
        printed?;
    }
    write(arguments.json.as_deref(), || to_json(&rows).to_string())?;
    write(arguments.record.as_deref(), || {
        let version = embree.as_ref().map(EmbreeLibrary::version);
        record::to_json(&options, version, load_before, &rows).to_string()
    })?;
    write(arguments.svg.as_deref(), || plot::svg(&rows))?;
    print(table::summary(&rows).trim_end())
}

fn measure_builds(arguments: &BenchBuildArguments, environment: &Environment, messages: Messages) -> Outcome {
    let filter = Filter { engines: arguments.engines.clone(), modes: arguments.modes.clone() };
    builds::check_filter(&filter).map_err(failure)?;
    check_outputs(&[&arguments.json])?;
    let sources = find(&arguments.scenes, &arguments.files, environment)?;
    let embree = embree_library(&filter, messages)?;
    let (pool, level) = machine(&arguments.machine, environment)?;
    let options = builds::Options { filter, rounds: arguments.rounds, level };
    let mut rows = Vec::new();
    for source in sources {
        let subject = Subject::new(&source.stem(), &source.load(messages)?);
        let measured = builds::run(&subject, &options, embree.as_ref(), &pool, &mut quietly(messages));
        let measured = measured.map_err(failure)?;
        print(builds::table(&measured))?;
        rows.extend(measured);
    }
    write(arguments.json.as_deref(), || builds::to_json(&rows).to_string())
}

fn measure_motion(
    arguments: &BenchDynamicArguments,
    environment: &Environment,
    messages: Messages,
) -> Outcome {
    check_outputs(&[&arguments.json, &arguments.svg])?;
    let sources = find(&arguments.scenes, &arguments.files, environment)?;
    let embree = embree_library(&Filter::default(), messages)?;
    let (pool, level) = machine(&arguments.machine, environment)?;
    let options =
        dynamic::Options { frames: arguments.frames, rounds: arguments.rounds, size: arguments.size, level };
    let cases = &arguments.cases;
    let is_requested = |case: &str| cases.is_empty() || cases.iter().any(|requested| requested == case);
    let mut rows = Vec::new();
    if is_requested("refit") || is_requested("rebuild") {
        for source in sources {
            let subject = Subject::new(&source.stem(), &source.load(messages)?);
            let measured = dynamic::run(&subject, &options, embree.as_ref(), &pool, &mut quietly(messages));
            let mut measured = measured.map_err(failure)?;
            measured.retain(|row| is_requested(row.case));
            print(dynamic_row::table(&measured))?;
            rows.extend(measured);
        }
    }
    if is_requested("top") {
        let (count, rounds) = (arguments.instances, arguments.rounds);
        let measured = top::run(count, rounds, embree.as_ref(), &pool).map_err(failure)?;
        let measured = top::dynamic_rows(&measured, count);
        print(dynamic_row::table(&measured))?;
        rows.extend(measured);
    }
    if cases.is_empty() && !research::IS_COMPILED {
        messages
            .note(format_args!("the cases stadium and fuzzy need a program built with --features research"));
    } else {
        if is_requested("stadium") {
            let options = stadium::Options { rounds: arguments.rounds, size: arguments.size, level };
            let measured = stadium::run(&stadium::RATIOS, &options, &mut quietly(messages));
            let measured = measured.map_err(failure)?;
            print(dynamic_row::table(&measured))?;
            rows.extend(measured);
        }
        if is_requested("fuzzy") {
            let (frames, rounds, size) = (arguments.frames, arguments.rounds, arguments.size);
            let options = dynamic::Options { frames, rounds, size, level };
            let measured = fuzzy::run(fuzzy::QUADS, &options, &mut quietly(messages)).map_err(failure)?;
            print(dynamic_row::table(&measured))?;
            rows.extend(measured);
        }
    }
    for (case, poses) in [("crowd", arguments.characters), ("crowd64", 64)] {
        if is_requested(case) {
            let (characters, frames) = (arguments.characters, arguments.frames.min(10));
            let options = crowd::Options { characters, frames, size: arguments.size, level };
            let measured = crowd::run(case, poses, &options).map_err(failure)?;
            print(dynamic_row::table(&measured))?;
            rows.extend(measured);
        }
    }
    write(arguments.svg.as_deref(), || dynamic_plot::svg(&rows))?;
    write(arguments.json.as_deref(), || dynamic_row::to_json(&rows).to_string())
}

fn measure_paper(arguments: &BenchPaperArguments, environment: &Environment, messages: Messages) -> Outcome {
    check_outputs(&[&arguments.json])?;
    let sources = find(&arguments.scenes, &arguments.files, environment)?;
    let options =
        rays::Options { size: arguments.size, rounds: arguments.rounds, ..rays::Options::default() };
    let mut rows = Vec::new();
    for source in sources {
        let subject = Subject::new(&source.stem(), &source.load(messages)?);
        rows.push(paper::run(&subject, &options, &mut quietly(messages)).map_err(failure)?);
    }
    write(arguments.json.as_deref(), || paper::to_json(&rows).to_string())?;
    print(paper::tables(&rows).trim_end())
}

/// News without tables.
fn quietly(messages: Messages) -> impl FnMut(BenchEvent) {
    move |news| match news {
        BenchEvent::Built(what) => messages.detail(what),
        BenchEvent::Differs(what) => messages.note(what),
        BenchEvent::Class(_) => {}
    }
}

fn find(
    scenes: &[OsString],
    files: &FileArguments,
    environment: &Environment,
) -> Result<Vec<Source>, Failure> {
    scenes.iter().map(|scene| Source::find(scene, files, environment)).collect()
}

/// Embree, if it is requested and there is any.
fn embree_library(filter: &Filter, messages: Messages) -> Result<Option<EmbreeLibrary>, Failure> {
    if !filter.has_engine("embree4") {
        return Ok(None);
    }
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

// SPDX-License-Identifier: GPL-3.0-or-later
//! The life of the program: arguments, environment, command, exit status.
//! Invariant: in all cases, at most one `error:` line is written, and no panic's text.
//! Tests: `tests/program/interface.rs`, `tests/program/arguments.rs`.

use std::panic::{PanicHookInfo, catch_unwind};
use std::sync::{Mutex, Once, PoisonError};

use clap::FromArgMatches;
use gnurt::image::expects_panics;

use crate::arguments::{Arguments, Command, Refusal, explain, verbosity_behind_command, without_effect};
use crate::command_line::command_line;
use crate::commands;
use crate::environment::{Environment, Overridden};
use crate::failure::{Failure, Outcome};
use crate::heap::HEAP;
use crate::messages::{Messages, Verbosity, print};
use crate::osl;
use crate::workers::use_threads;

/// Runs the program and gives back its exit status.
pub(crate) fn run() -> u8 {
    announce_bugs_in_one_line();
    catch_unwind(parse_and_run).unwrap_or_else(|_| {
        // The hook has printed the message, unless a picture was being decoded elsewhere.
        let retained = KEPT.lock().unwrap_or_else(PoisonError::into_inner).take();
        print_once(&retained.unwrap_or_else(|| "internal: please report this".into()));
        1
    })
}

/// The unprinted message: a decoder's panic, which becomes an error, or another one at the same time.
static KEPT: Mutex<Option<String>> = Mutex::new(None);

fn print_once(text: &str) {
    static FIRST: Once = Once::new();
    FIRST.call_once(|| Messages::new(Verbosity::Normal).error(text));
}

fn parse_and_run() -> u8 {
    if let Some(status) = osl::run() {
        return status;
    }
    let command = Arguments::with_formats();
    let command_line = verbosity_behind_command(command_line().to_vec(), &command);
    let parsed = command.try_get_matches_from(command_line);
    let (arguments, matches) = match parsed
        .and_then(|matches| Ok((Arguments::from_arg_matches(&matches)?, matches)))
    {
        Ok(both) => both,
        Err(error) => {
            return match explain(&error) {
                Refusal::Answer(text) => conclude(print(text.trim_end()), Messages::new(Verbosity::Normal)),
                Refusal::Mistake(text) => {
                    conclude(Err(Failure::Usage(text)), Messages::new(Verbosity::Normal))
                }
            };
        }
    };
    let requested = arguments.command.verbosity_arguments().verbosity();
    let machine = arguments.command.machine();
    let overridden = Overridden {
        threads: machine.is_some_and(|machine| machine.threads.is_some()),
        isa: machine.is_some_and(|machine| machine.isa.is_some()),
        log: requested.is_some(),
    };
    let environment = match Environment::read(overridden) {
        Ok(environment) => environment,
        Err(failure) => return conclude(Err(failure), Messages::new(requested.unwrap_or_default())),
    };
    let messages = Messages::new(requested.or(environment.log).unwrap_or_default());
    use_threads(arguments.command.machine().and_then(|machine| machine.threads).or(environment.threads));
    if let Some(folder) = arguments.command.machine().and_then(|machine| machine.out_of_core.as_deref())
        && let Err(error) = HEAP.page_to(folder)
    {
        let why = gnurt::image::system_reason(&error);
        let failure = Failure::usage(format_args!(
            "--out-of-core {}: {why}; give a folder on a local disk",
            folder.display()
        ));
        return conclude(Err(failure), messages);
    }
    without_effect(&arguments.command, &matches).iter().for_each(|line| messages.warning(line));
    conclude(run_command(arguments.command, &environment, messages), messages)
}

fn run_command(command: Command, environment: &Environment, messages: Messages) -> Outcome {
    match command {
        Command::Render(mut arguments) => {
            arguments.light.file.within(arguments.frame.working_space);
            commands::render::run(&arguments, environment, messages)
        }
        Command::Join(arguments) => commands::join::run(&arguments, environment, messages),
        Command::Denoise(arguments) => commands::denoise::run(&arguments, environment, messages),
        Command::Relight(arguments) => commands::relight::run(&arguments, messages),
        Command::View(mut arguments) => {
            arguments.light.file.within(arguments.frame.working_space);
            commands::view::run(&arguments, environment, messages)
        }
        Command::Info(arguments) => commands::info::run(&arguments, environment, messages),
        Command::Diff(arguments) => commands::diff::run(&arguments, messages),
        Command::Convert(arguments) => commands::convert::run(&arguments, environment, messages),
        Command::Trace(arguments) => commands::trace::run(&arguments, environment, messages),
        Command::Bench(arguments) => commands::bench::run(&arguments, environment, messages),
        Command::Scenes(_) => commands::scenes::run(),
        Command::Manuals(arguments) => commands::manuals::run(&arguments),
    }
}

fn conclude(outcome: Outcome, messages: Messages) -> u8 {
    match outcome {
        Ok(()) => 0,
        Err(failure) => {
            if let Some(message) = failure.message() {
                messages.error(message);
            }
            failure.status()
        }
    }
}

/// A panic is a bug of this program; it is reported in one line, for panics of any threads.
fn announce_bugs_in_one_line() {
    std::panic::set_hook(Box::new(|panic| {
        let text = bug(panic);
        if expects_panics() {
            *KEPT.lock().unwrap_or_else(PoisonError::into_inner) = Some(text);
        } else {
            print_once(&text);
        }
    }));
}

/// The message of a panic.
fn bug(panic: &PanicHookInfo<'_>) -> String {
    let position = panic.location().map(|position| format!(" ({}:{})", position.file(), position.line()));
    let payload = panic.payload();
    let text = payload.downcast_ref::<&str>().copied();
    let what = text.or_else(|| payload.downcast_ref::<String>().map(|text| &text[..]));
    let what = what.unwrap_or("no reason was given");
    format!("internal: {what}{}; please report this", position.unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::panic::{set_hook, take_hook};
    use std::sync::Arc;
    use std::thread::current;

    #[test]
    fn a_bug_is_told_in_one_line() {
        let reported = Arc::new(Mutex::new(Vec::new()));
        let (before, heard) = (take_hook(), Arc::clone(&reported));
        set_hook(Box::new(move |panic| {
            if current().name() == Some("one with bugs") {
                heard.lock().expect("nobody panics with it").push(bug(panic));
            } else {
                before(panic);
            }
        }));
        let worker = std::thread::Builder::new().name("one with bugs".into());
        let worker = worker.spawn(|| {
            let _ = catch_unwind(|| panic!("{} of {}", 7, 6));
            let _ = catch_unwind(|| std::panic::panic_any(7));
        });
        worker.expect("it starts").join().expect("all were caught");
        let reported = reported.lock().expect("nobody panics with it");
        let line = &reported[0];
        assert!(
            line.starts_with("internal: 7 of 6 (") && line.contains("program.rs:"),
            "what and where: {line}"
        );
        assert!(line.ends_with("; please report this") && !line.contains('\n'), "one line: {line}");
        assert!(reported[1].contains("no reason was given"), "{reported:?}");
    }
}

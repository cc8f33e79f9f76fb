// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt relight IN GROUP=GAIN.. -o OUT`: light groups of finished pictures with other strengths and colours.
//! A film has one exposure. Tests: `tests/program/relight.rs`.

use std::path::PathBuf;

use gnurt::Numbered;
use gnurt::relight::relight;

use crate::arguments::{DisplayOptions, RelightArguments};
use crate::failure::{Failure, Outcome};
use crate::film_files::film_numbers;
use crate::messages::Messages;
use crate::output::{Output, is_same_file};
use crate::signals::{self, FirstSignal};
use crate::workers::read_picture;

/// Mixes.
pub(crate) fn run(arguments: &RelightArguments, messages: Messages) -> Outcome {
    let output = Output::named(&arguments.output)?.through(&arguments.ocio)?;
    let frames = frames(arguments, &output)?;
    for (file, output) in &frames {
        if is_same_file(file, output.path()) {
            return Err(Failure::usage(format_args!(
                "{} and {} are the same file; give another name to write to",
                file.display(),
                output.path().display()
            )));
        }
    }
    output.check()?;
    signals::listen(FirstSignal::Leaves, messages)?;
    let mut look = None;
    for (file, output) in &frames {
        let mut picture = read_picture(file).map_err(Failure::data)?;
        relight(&mut picture, &arguments.gains)
            .map_err(|why| Failure::data(format_args!("{}: {why}", file.display())))?;
        let mut light = arguments.light;
        light.file.exact();
        let shown = match look {
            Some(look) => look,
            None if output.is_for_screens() => {
                let (chosen, note) = light.display_options(&picture);
                note.iter().for_each(|note| messages.note(note));
                chosen
            }
            None => DisplayOptions { file: light.file, ..DisplayOptions::default() },
        };
        look = Some(shown);
        output.write(&picture, shown)?;
        messages.detail(format_args!("wrote {}", output.path().display()));
    }
    Ok(())
}

/// Files to read and to write: one, or those of a film.
fn frames(arguments: &RelightArguments, output: &Output) -> Result<Vec<(PathBuf, Output)>, Failure> {
    let Some(numbered) = Numbered::of(&arguments.input) else {
        return Ok(vec![(arguments.input.clone(), output.clone())]);
    };
    if output.numbered().is_none() {
        return Err(Failure::usage(format_args!(
            "--output {}: a film has more than one picture; mark the number by #, as in frame.####.png",
            output.path().display()
        )));
    }
    let numbers = film_numbers(&numbered)?;
    Ok(numbers.into_iter().map(|number| (numbered.at(number), output.at(number))).collect())
}

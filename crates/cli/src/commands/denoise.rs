// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt denoise IN -o OUT`: finished pictures with layers, of this program and of others; films by the filter over
//! frames. Everything that can be rejected is rejected before the first picture is read; a film has one exposure.
//! Tests: `tests/program/denoise.rs`.

use std::path::{Path, PathBuf};

use gnurt::denoise::film::{Film, REACH};
use gnurt::denoise::{self, Options, Used, adopt, denoise, has_motion};
use gnurt::image::Picture;
use gnurt::memory::fitting_reach;
use gnurt::{Numbered, ThreadPool};

use crate::arguments::{DenoiseArguments, DisplayOptions};
use crate::environment::Environment;
use crate::failure::{Failure, Outcome};
use crate::film_files::film_numbers;
use crate::messages::Messages;
use crate::output::{Output, is_same_file};
use crate::signals::{self, FirstSignal};
use crate::workers::{machine, read_picture};

/// What pictures of one call share.
struct Call<'a> {
    arguments: &'a DenoiseArguments,
    options: Options,
    pool: ThreadPool,
    messages: Messages,
    /// Curve and exposure, once they are chosen.
    look: Option<DisplayOptions>,
    is_reported: bool,
}

/// Denoises.
pub(crate) fn run(arguments: &DenoiseArguments, environment: &Environment, messages: Messages) -> Outcome {
    let options = arguments
        .denoiser
        .options_or_built_in(None)
        .ok_or_else(|| Failure::usage("--denoise=none leaves the noise; `gnurt convert` does that"))?;
    let output = Output::named(&arguments.output)?.through(&arguments.ocio)?;
    let frames = frames(arguments, &output)?;
    for (_, file, output) in &frames {
        if is_same_file(file, output.path()) {
            return Err(Failure::usage(format_args!(
                "{} and {} are the same file; give another name to write to",
                file.display(),
                output.path().display()
            )));
        }
    }
    denoise::check(&options).map_err(Failure::data)?;
    output.check()?;
    signals::listen(FirstSignal::Leaves, messages)?;
    let (pool, _) = machine(&arguments.machine, environment)?;
    let mut call = Call { arguments, options, pool, messages, look: None, is_reported: false };
    match Numbered::of(&arguments.input) {
        Some(_) => call.film(&frames),
        None => frames.iter().try_for_each(|(_, file, output)| {
            let mut picture = call.read(file)?;
            let used = denoise(&mut picture, &call.options, &call.pool).map_err(|error| at(file, &error))?;
            call.write(picture, output, &used)
        }),
    }
}

/// The index of each frame: a gap in the numbers is one in the indices, which begins a new shot.
fn indices(numbers: &[u32]) -> Vec<usize> {
    let steps = || numbers.windows(2).map(|pair| pair[1] - pair[0]);
    let step = steps().min().unwrap_or(1);
    let mut index = 0;
    let after = steps().map(|by| {
        index += if by == step { 1 } else { 2 };
        index
    });
    std::iter::once(0).chain(after).collect()
}

/// A frame: its index in the film, the file to read and the one to write.
type Frame = (usize, PathBuf, Output);

/// The frames of the input, in order; one if it is a picture.
fn frames(arguments: &DenoiseArguments, output: &Output) -> Result<Vec<Frame>, Failure> {
    let input = arguments.input.display();
    let Some(numbered) = Numbered::of(&arguments.input) else {
        let film = arguments.frames.map(|_| "--frames");
        if let Some(option) = film.or(arguments.denoise_window.map(|_| "--denoise-window")) {
            return Err(Failure::usage(format_args!(
                "{option}: {input} is one picture; mark the number of a film's frames by #, as in frame.####.exr"
            )));
        }
        return Ok(vec![(0, arguments.input.clone(), output.clone())]);
    };
    if output.numbered().is_none() {
        return Err(Failure::usage(format_args!(
            "--output {}: a film has more than one picture; mark the number by #, as in frame.####.png",
            output.path().display()
        )));
    }
    let numbers: Vec<u32> = match arguments.frames {
        Some(range) => range.numbers().collect(),
        None => film_numbers(&numbered)?,
    };
    let indices = indices(&numbers);
    let frame = |(i, number)| (i, numbered.at(number), output.at(number));
    Ok(indices.into_iter().zip(numbers).map(frame).collect())
}

fn at(file: &Path, error: &dyn std::fmt::Display) -> Failure {
    Failure::data(format_args!("{}: {error}", file.display()))
}

impl Call<'_> {
    /// Reads a picture and finds its layers.
    fn read(&self, file: &Path) -> Result<Picture, Failure> {
        let mut picture = read_picture(file).map_err(Failure::data)?;
        let told = adopt(&mut picture);
        if !told.is_empty() {
            self.messages.detail(format_args!("{}: {}", file.display(), told.join(", ")));
        }
        Ok(picture)
    }

    fn film(&mut self, frames: &[Frame]) -> Outcome {
        let count = frames.last().map_or(0, |(i, ..)| i + 1);
        let reach = self.arguments.denoise_window.map_or(REACH, usize::from);
        let mut film: Option<Film<(PathBuf, Output)>> = None;
        for (i, file, output) in frames {
            let mut picture = self.read(file)?;
            let film = match &mut film {
                Some(film) => film,
                none => none.insert(self.begin(file, &picture, reach, count)?),
            };
            if !film.is_single() && !has_motion(&picture) {
                return Err(at(file, &"it has no layer of motion, as the frames before it have"));
            }
            if film.is_single() {
                let used =
                    denoise(&mut picture, &self.options, &self.pool).map_err(|error| at(file, &error))?;
                self.write(picture, output, &used)?;
                continue;
            }
            let with = (file.clone(), output.clone());
            let done = film.push(*i, picture, with, &self.pool).map_err(|error| at(file, &error))?;
            self.write_all(done)?;
        }
        let Some(mut film) = film else { return Ok(()) };
        let done = film.finish(&self.pool).map_err(Failure::data)?;
        self.write_all(done)
    }

    /// The film's window: none where its frames have no motion, and as much as fits into memory.
    fn begin<T>(&self, file: &Path, first: &Picture, reach: usize, count: usize) -> Result<Film<T>, Failure> {
        let mut reach = reach;
        if reach > 0 && !has_motion(first) {
            self.messages.warning(format_args!(
                "{}: it has no layer of motion: each frame is filtered by itself",
                file.display()
            ));
            reach = 0;
        }
        let size = [first.width, first.height];
        let reach = fitting_reach(size, reach, 0, self.arguments.denoise_window.is_some())
            .map_err(|why| Failure::data(format_args!("--denoise-window {reach}: {why}")))?;
        Ok(Film::new(self.options.clone(), reach, count))
    }

    fn write_all(&mut self, done: Vec<(Picture, (PathBuf, Output), Used)>) -> Outcome {
        done.into_iter().try_for_each(|(picture, (_, output), used)| self.write(picture, &output, &used))
    }

    fn write(&mut self, mut picture: Picture, output: &Output, used: &Used) -> Outcome {
        if self.is_reported {
            self.messages.detail(used);
        } else {
            self.messages.note(used);
        }
        self.is_reported = true;
        picture.set_metadata("denoiser", used.name());
        let look = match self.look {
            Some(look) => look,
            None if output.is_for_screens() => {
                let (look, note) = self.arguments.light.display_options(&picture);
                note.iter().for_each(|note| self.messages.note(note));
                look
            }
            None => DisplayOptions { file: self.arguments.light.file, ..DisplayOptions::default() },
        };
        self.look = Some(look);
        output.write(&picture, look)?;
        self.messages.detail(format_args!(
            "wrote {}, {}x{}",
            output.path().display(),
            picture.width,
            picture.height
        ));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::indices;

    #[test]
    fn gaps_of_numbers_are_gaps_of_indices() {
        assert_eq!(indices(&[3, 5, 7]), [0, 1, 2], "every second frame");
        assert_eq!(indices(&[3, 4, 7, 8]), [0, 1, 3, 4], "two shots");
        assert_eq!(indices(&[9]), [0], "one frame");
    }
}

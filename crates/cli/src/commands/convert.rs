// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt convert IN OUT`: pictures to pictures, scenes to scenes, by extension.
//! The output is checked before the input is read. Tests: `tests/program/conversion.rs`.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use gnurt::FORMATS;
use gnurt::denoise::denoise;
use gnurt::image;

use crate::arguments::ConvertArguments;
use crate::environment::Environment;
use crate::failure::{Failure, Outcome};
use crate::messages::Messages;
use crate::output::{Output, is_same_file};
use crate::signals::{self, FirstSignal, while_writing};
use crate::source::Source;
use crate::workers::read_picture;

/// The kind of a file by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Picture,
    Scene,
}

/// Converts.
pub(crate) fn run(arguments: &ConvertArguments, environment: &Environment, messages: Messages) -> Outcome {
    let (input, output) = (Path::new(&arguments.input), &arguments.output);
    if is_same_file(input, output) {
        return Err(Failure::usage(format_args!(
            "{} and {} are the same file; give another name to write to",
            input.display(),
            output.display()
        )));
    }
    signals::listen(FirstSignal::Leaves, messages)?;
    match (kind(&arguments.input), written_kind(output)?) {
        (Kind::Picture, Kind::Picture) => convert_picture(arguments, environment, messages),
        (Kind::Scene, Kind::Scene) if arguments.denoiser.options(None).is_some() => {
            Err(Failure::usage("--denoise is for pictures; scenes have no noise"))
        }
        (Kind::Scene, Kind::Scene) => convert_scene(arguments, environment, messages),
        (Kind::Scene, Kind::Picture) => Err(Failure::usage(format_args!(
            "{} is a scene and {} a picture; `gnurt render` makes pictures of scenes",
            input.display(),
            output.display()
        ))),
        (Kind::Picture, Kind::Scene) => Err(Failure::usage(format_args!(
            "{} is a picture and {} a scene; pictures cannot be converted to scenes",
            input.display(),
            output.display()
        ))),
    }
}

/// Scenes are recognised by their names; any other file is read as a picture, whose bytes determine its
/// format.
fn kind(input: &OsStr) -> Kind {
    let is_builtin = input.to_str().is_some_and(|text| text.starts_with(gnurt::BUILTIN));
    if is_builtin || FORMATS.of(Path::new(input)).is_ok() { Kind::Scene } else { Kind::Picture }
}

fn written_kind(output: &Path) -> Result<Kind, Failure> {
    if FORMATS.of(output).is_ok() {
        return Ok(Kind::Scene);
    }
    // The message lists the formats of pictures; name those of scenes as well.
    Output::named(output).map(|_| Kind::Picture).map_err(|failure| {
        Failure::usage(format_args!(
            "{}; or {} for scenes",
            failure.message().unwrap_or_default(),
            FORMATS.written_extensions()
        ))
    })
}

fn convert_picture(arguments: &ConvertArguments, environment: &Environment, messages: Messages) -> Outcome {
    let output = Output::named(&arguments.output)?.through(&arguments.ocio)?;
    output.check()?;
    let mut picture = read_picture(Path::new(&arguments.input)).map_err(Failure::data)?;
    if let Some(how) = arguments.denoiser.options(None) {
        let pool = gnurt::thread_pool(environment.threads.unwrap_or(0)).map_err(Failure::data)?;
        let used = denoise(&mut picture, &how, &pool).map_err(|error| {
            Failure::data(format_args!("{}: {error}", Path::new(&arguments.input).display()))
        })?;
        messages.note(&used);
        picture.set_metadata("denoiser", used.name());
    }
    output.write_with(&picture, arguments.light, messages)?;
    messages.detail(format_args!("wrote {}, {}x{}", output.path().display(), picture.width, picture.height));
    Ok(())
}

fn convert_scene(arguments: &ConvertArguments, environment: &Environment, messages: Messages) -> Outcome {
    if arguments.ocio.config.is_some() {
        return Err(Failure::usage("--ocio is for pictures, not for scenes"));
    }
    let source = Source::find(&arguments.input, &arguments.files, environment)?;
    image::check_writable(&arguments.output).map_err(Failure::data)?;
    let (scene, read) = source.load_with_files(messages)?;
    spare(&FORMATS.saved_files(&scene, &arguments.output).map_err(Failure::data)?, &read)?;
    let saved = while_writing(|| FORMATS.save(&scene, &arguments.output)).map_err(Failure::data)?;
    for warning in saved.iter() {
        messages.warning(warning);
    }
    messages.detail(format_args!("wrote {}", arguments.output.display()));
    Ok(())
}

/// Writing over libraries, textures or buffers of the scene is an error.
fn spare(written: &[PathBuf], read: &[PathBuf]) -> Outcome {
    let lost = written.iter().find(|file| read.iter().any(|read| is_same_file(read, file)));
    lost.map_or(Ok(()), |file| {
        Err(Failure::usage(format_args!(
            "{}: the scene is read from this file, which would be lost; give another name to write to",
            file.display()
        )))
    })
}

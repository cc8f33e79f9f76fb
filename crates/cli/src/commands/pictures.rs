// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt view PICTURE`: finished pictures and films, their layers, and two of them compared; with `--headless` one of them as a file.
//! Pictures for screens are shown as they are; light is shown by tone curve and exposure, as `render` writes it.
//! Tests: `tests/program/finished.rs`, `tests/program/window.rs`.

use std::path::{Path, PathBuf};

use gnurt::image::{Picture, PictureFormat, ToneCurve};
use gnurt::{Numbered, ThreadPool};
use gnurt_view::{Comparison, Item, compose, items};

use crate::arguments::{DisplayOptions, ExposureChoice, WindowArguments};
use crate::environment::Environment;
use crate::failure::{Failure, Outcome};
use crate::film_files::film_numbers;
use crate::messages::Messages;
use crate::nearest::unknown;
use crate::output::Output;
use crate::workers::{machine, read_picture};

/// Shows pictures.
pub(super) fn run(arguments: &WindowArguments, environment: &Environment, messages: Messages) -> Outcome {
    if arguments.display.is_some() {
        return Err(Failure::usage("--display shows scenes; give the picture to tev itself"));
    }
    match (&arguments.output, arguments.headless) {
        (Some(_), false) => {
            return Err(Failure::usage("--output is for pictures without a window; give --headless, too"));
        }
        (None, true) => return Err(Failure::usage("--headless shows nothing without --output FILE")),
        _ => {}
    }
    let files = film(Path::new(&arguments.scene))?;
    let others = arguments.pictures.compare.as_deref().map(film).transpose()?.unwrap_or_default();
    let (pool, _) = machine(&arguments.machine, environment)?;
    let read = |path: &Path| read_picture(path).map_err(Failure::data);
    let first = read(&files[0])?;
    let item = item(&first, &files[0], arguments.pictures.layer.as_deref())?;
    let (look, note) = look(arguments, &files[0], &first, &item);
    note.iter().for_each(|note| messages.note(note));
    let Some(path) = &arguments.output else {
        return show(arguments, [files, others], first, item, look, pool, messages);
    };
    let output = Output::named(path)?;
    let second = others.first().map(|path| read(path)).transpose()?;
    output.spare(&files)?;
    output.spare(&others)?;
    output.check()?;
    let comparison = arguments.pictures.compare_as.unwrap_or_default();
    let picture = compose(&first, second.as_ref(), &item, comparison, first.width.div_ceil(2));
    output.write(&picture.map_err(Failure::data)?, look)?;
    messages.detail(format_args!("wrote {}", path.display()));
    Ok(())
}

/// The files of a film in order, or one picture.
fn film(path: &Path) -> Result<Vec<PathBuf>, Failure> {
    let Some(numbered) = Numbered::of(path) else { return Ok(vec![path.to_owned()]) };
    Ok(film_numbers(&numbered)?.into_iter().map(|number| numbered.at(number)).collect())
}

/// The part of a picture that has this name.
fn item(picture: &Picture, path: &Path, name: Option<&str>) -> Result<Item, Failure> {
    let Some(name) = name else { return Ok(Item::Color) };
    let all = items(picture);
    if let Some(found) = all.iter().find(|item| item.to_string() == name) {
        return Ok(found.clone());
    }
    let names: Vec<String> = all.iter().map(ToString::to_string).collect();
    let names: Vec<&str> = names.iter().map(|name| &name[..]).collect();
    Err(Failure::usage(format_args!("{}: {}", path.display(), unknown("layer", name, &names))))
}

/// Exposure and tone curve; colours that are no light have none.
fn look(
    arguments: &WindowArguments,
    path: &Path,
    picture: &Picture,
    item: &Item,
) -> (DisplayOptions, Option<String>) {
    let is_light = *item == Item::Color
        && PictureFormat::from_path(path).is_ok_and(|format| !format.is_for_screens)
        && arguments.pictures.compare_as != Some(Comparison::Flip);
    if is_light {
        return arguments.light.display_options(picture);
    }
    let exposure = match arguments.light.exposure {
        ExposureChoice::Stops(stops) => stops,
        ExposureChoice::Auto => 0.0,
    };
    (DisplayOptions { tone: ToneCurve::Clamp, exposure, file: arguments.light.file }, None)
}

#[cfg(feature = "window")]
fn show(
    arguments: &WindowArguments,
    [files, others]: [Vec<PathBuf>; 2],
    first: Picture,
    item: Item,
    look: DisplayOptions,
    pool: ThreadPool,
    messages: Messages,
) -> Outcome {
    use std::sync::Arc;

    use gnurt_view::{Exposure, PictureOptions, run_picture_window};

    use crate::signals::{self, FirstSignal};

    /// Of pictures that are kept.
    const MEMORY: usize = 2 << 30;

    signals::listen(FirstSignal::Leaves, messages)?;
    let options = PictureOptions {
        title: format!("{} - GNU RT", Path::new(&arguments.scene).display()),
        files,
        others,
        item,
        comparison: arguments.pictures.compare_as.unwrap_or_default(),
        exposure: Exposure { stops: look.exposure, tone: look.tone },
        fps: arguments.pictures.fps,
        folder: PathBuf::from("."),
        frames: arguments.frames.map(u64::from),
        memory: MEMORY,
    };
    let read = Box::new(|path: &Path| read_picture(path).map_err(|error| error.to_string()));
    run_picture_window(options, first, read, pool, Arc::new(super::window::Speaker { messages }))
        .map_err(Failure::data)
}

#[cfg(not(feature = "window"))]
fn show(
    _: &WindowArguments,
    _: [Vec<PathBuf>; 2],
    _: Picture,
    _: Item,
    _: DisplayOptions,
    _: ThreadPool,
    _: Messages,
) -> Outcome {
    Err(Failure::usage(
        "this program was compiled without windows; --headless --output FILE writes what one would show",
    ))
}

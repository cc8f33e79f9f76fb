// SPDX-License-Identifier: GPL-3.0-or-later
//! Options without effect: each gets a warning, so that the user does not wait for its effect; none is
//! rejected.
//! Tests: `tests/program/arguments.rs::options_without_effect_are_told`.

use std::ffi::OsStr;
use std::path::Path;

use clap::ArgMatches;
use clap::parser::ValueSource;
use gnurt::image::PictureFormat;
use gnurt::render::Integrator;

use super::Command;

/// A line for each option that the command line of `command` names and that has no effect.
pub(crate) fn without_effect(command: &Command, matches: &ArgMatches) -> Vec<String> {
    let Some((_, matches)) = matches.subcommand() else { return Vec::new() };
    let is_given = |id: &str| {
        matches.try_contains_id(id).is_ok() && matches.value_source(id) == Some(ValueSource::CommandLine)
    };
    let mut reported = Vec::new();
    let mut tell = |options: &[(&str, &str)], why: &str| {
        let given = options.iter().filter(|(id, _)| is_given(id));
        reported.extend(given.map(|(_, option)| format!("{option} has no effect {why}")));
    };
    const LOOK: [(&str, &str); 2] = [("tone", "--tone"), ("exposure", "--exposure")];
    const FILES: [(&str, &str); 2] = [("confine", "--confine"), ("texture_memory", "--texture-memory")];
    const KEEPS_LIGHT: &str = "on EXR, HDR and PFM, which keep the light as it is";
    match command {
        Command::Render(arguments) => {
            of_integrator(arguments.frame.integrator, &mut tell);
            if arguments.output.as_deref().is_some_and(keeps_light) {
                tell(&LOOK, KEEPS_LIGHT);
            }
            of_file(arguments.output.as_deref().unwrap_or(Path::new("a.png")), &mut tell);
        }
        Command::View(arguments) if PictureFormat::is_named_any(Path::new(&arguments.scene)) => {
            // Groups of options have the names of types.
            let is_option = |id: &&str| id.starts_with(|c: char| c.is_ascii_lowercase());
            let given = matches.ids().map(|id| id.as_str()).filter(is_option);
            let given = given.filter(|id| is_given(id) && !OF_PICTURES.contains(id));
            let given = given.map(|id| format!("--{}", id.replace('_', "-")));
            reported.extend(given.map(|option| format!("{option} has no effect on finished pictures")));
        }
        Command::View(arguments) => {
            of_integrator(arguments.frame.integrator, &mut tell);
            tell(&FINISHED, "on scenes");
        }
        Command::Trace(arguments) => of_integrator(arguments.frame.integrator, &mut tell),
        Command::Join(arguments) => {
            if keeps_light(&arguments.output) {
                tell(&LOOK, KEEPS_LIGHT);
            }
            of_file(&arguments.output, &mut tell);
        }
        Command::Denoise(arguments) => {
            if keeps_light(&arguments.output) {
                tell(&LOOK, KEEPS_LIGHT);
            }
            of_file(&arguments.output, &mut tell);
        }
        Command::Relight(arguments) => {
            if keeps_light(&arguments.output) {
                tell(&LOOK, KEEPS_LIGHT);
            }
            of_file(&arguments.output, &mut tell);
        }
        Command::Convert(arguments) if gnurt::FORMATS.of(&arguments.output).is_ok() => {
            tell(&LOOK, "on scenes");
            tell(&STORED, "on scenes");
        }
        Command::Convert(arguments) => {
            if keeps_light(&arguments.output) {
                tell(&LOOK, KEEPS_LIGHT);
            }
            of_file(&arguments.output, &mut tell);
            if !is_scene(&arguments.input) {
                tell(&FILES, "on pictures, which name no other files");
            }
        }
        _ => {}
    }
    reported
}

/// Options of `view` for finished pictures alone.
const FINISHED: [(&str, &str); 4] =
    [("layer", "--layer"), ("compare", "--compare"), ("compare_as", "--compare-as"), ("fps", "--fps")];

/// All options of `view` that matter to finished pictures.
const OF_PICTURES: [&str; 19] = [
    "scene",
    "headless",
    "output",
    "layer",
    "compare",
    "compare_as",
    "fps",
    "tone",
    "exposure",
    "bits",
    "compression",
    "tile_size",
    "primaries",
    "quality",
    "frames",
    "threads",
    "quiet",
    "verbose",
    "help",
];

/// Choices of how pictures are stored.
const STORED: [(&str, &str); 5] = [
    ("bits", "--bits"),
    ("compression", "--compression"),
    ("tile_size", "--tile-size"),
    ("primaries", "--primaries"),
    ("quality", "--quality"),
];

/// Choices that the format of a file does not have.
fn of_file(path: &Path, tell: &mut impl FnMut(&[(&str, &str)], &str)) {
    let Ok(format) = PictureFormat::from_path(path) else { return };
    let [bits, compression, tile_size, primaries, quality] = STORED;
    if format != PictureFormat::PNG && format != PictureFormat::EXR {
        tell(&[bits], "except on PNG and EXR");
    }
    if format != PictureFormat::EXR {
        tell(&[compression, tile_size, primaries], "except on EXR");
    }
    if format.name != "JPEG" {
        tell(&[quality], "except on JPEG");
    }
}

/// Options that an integrator ignores.
fn of_integrator(integrator: Integrator, tell: &mut impl FnMut(&[(&str, &str)], &str)) {
    let why = format!("with --integrator {integrator}");
    if !integrator.has_virtual_lights() {
        tell(&[("vpls", "--vpls"), ("interleave", "--interleave")], &why);
    }
    if integrator.has_virtual_lights() {
        tell(&[("pixel_noise", "--pixel-noise")], &why);
    }
    if integrator.without_pilot() != Integrator::Path {
        tell(&[("guide", "--guide")], &why);
        if !integrator.has_virtual_lights() {
            tell(&[("caustics", "--caustics")], &why);
        }
    }
    match integrator {
        Integrator::Whitted => tell(&[("clamp", "--clamp")], &why),
        Integrator::Eyelight | Integrator::Normals => {
            tell(&[("clamp", "--clamp"), ("max_depth", "--max-depth")], &why);
        }
        _ => {}
    }
}

/// Whether a picture of this name keeps light, for which curve and exposure are nothing.
fn keeps_light(path: &Path) -> bool {
    PictureFormat::from_path(path).is_ok_and(|format| !format.is_for_screens)
}

fn is_scene(input: &OsStr) -> bool {
    let is_builtin = input.to_str().is_some_and(|text| text.starts_with(gnurt::BUILTIN));
    is_builtin || gnurt::FORMATS.of(Path::new(input)).is_ok()
}

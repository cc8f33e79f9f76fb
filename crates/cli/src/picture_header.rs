// SPDX-License-Identifier: GPL-3.0-or-later
//! Metadata of a picture's file about its rendering. Attribute names after pbrt-v4's film, except for the
//! matrices: 16 numbers as text, row-major. PNG keeps only values that do not depend on the machine or the
//! time: equal pictures are equal files.
//! Tests: `tests/program/output.rs`.

use std::ffi::OsString;
use std::path::Path;

use gnurt::image::Picture;
use gnurt::render::{CameraMatrices, RenderOptions, RenderStats};
use gnurt::scene::Camera;

use crate::command_line::command_line;

/// Sets the inputs of the picture.
pub(crate) fn describe(picture: &mut Picture, options: &RenderOptions) {
    picture.set_metadata("seed", options.seed.to_string());
    picture.set_metadata("integrator", options.integrator.to_string());
    picture.set_metadata("filter", options.filter.to_string());
}

/// Describes how it was made, with its cost where that is known: for formats whose headers may differ from run to run.
pub(crate) fn describe_making(
    picture: &mut Picture,
    camera: &Camera,
    aspect: f32,
    stats: Option<&RenderStats>,
) {
    picture.set_metadata("commandLine", command());
    if let Some(stats) = stats {
        picture.set_metadata("samplesPerPixel", stats.spp_max.to_string());
        picture.set_metadata("renderTimeSeconds", format!("{:.3}", stats.seconds));
    }
    picture.set_metadata("depths", "depth.Z: distance along the ray; Z: along the view");
    if let Some(CameraMatrices { camera_from_world, ndc_from_world }) = CameraMatrices::new(camera, aspect) {
        picture.set_metadata("cameraFromWorld", numbers(&camera_from_world));
        if let Some(ndc_from_world) = ndc_from_world {
            picture.set_metadata("ndcFromWorld", numbers(&ndc_from_world));
        }
    }
}

/// The words of this call.
pub(crate) fn command() -> String {
    command_text(command_line().iter())
}

/// The words of a call; of paths only the last part, for a picture should not reveal its maker's folders.
fn command_text<'a>(command_line: impl Iterator<Item = &'a OsString>) -> String {
    let shorten = |argument: &OsString| {
        let text = argument.to_string_lossy().into_owned();
        let (option, value) = match text.split_once('=') {
            Some((option, value)) if option.starts_with("--") => (format!("{option}="), value),
            _ => (String::new(), &text[..]),
        };
        let last = Path::new(value).file_name().map_or(value.into(), |name| name.to_string_lossy());
        let argument = format!("{option}{last}");
        if argument.contains(char::is_whitespace) || argument.is_empty() {
            format!("'{argument}'")
        } else {
            argument
        }
    };
    command_line.map(shorten).collect::<Vec<_>>().join(" ")
}

fn numbers(matrix: &[f64; 16]) -> String {
    matrix.map(|x| x.to_string()).join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_tells_no_folders() {
        let command_line =
            ["/usr/bin/gnurt", "render", "/home/me/my scene.obj", "--heatmap=/tmp/h.png", "--eye", "1,2,3"];
        let line = command_text(command_line.map(OsString::from).iter());
        assert_eq!(line, "gnurt render 'my scene.obj' --heatmap=h.png --eye 1,2,3", "last parts only");
    }
}

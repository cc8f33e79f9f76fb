// SPDX-License-Identifier: GPL-3.0-or-later
//! What a picture's file says about its making.
//! Source: original; attribute names after pbrt-v4's film, but for the matrices: 16 numbers as text, row-major.
//! PNG keeps only what does not depend on the machine or the moment: equal pictures are equal files.
//! Proof: `tests/program/output.rs`.

use std::ffi::OsString;
use std::path::Path;

use gnurt::image::Picture;
use gnurt::render::RenderStats;
use gnurt::scene::Camera;

use crate::arguments::FrameArguments;

/// Says what the picture depends on.
pub(crate) fn describe(picture: &mut Picture, frame: &FrameArguments) {
    picture.set_metadata("seed", frame.seed.to_string());
    picture.set_metadata("integrator", frame.integrator.to_string());
    picture.set_metadata("filter", frame.filter.to_string());
}

/// Says how it came about: for formats whose headers may differ from run to run.
pub(crate) fn describe_making(picture: &mut Picture, camera: &Camera, aspect: f32, stats: &RenderStats) {
    let seconds = format!("{:.3}", stats.seconds);
    picture.set_metadata("commandLine", command_line(std::env::args_os()));
    picture.set_metadata("samplesPerPixel", stats.spp_max.to_string());
    picture.set_metadata("renderTimeSeconds", seconds);
    picture.set_metadata("depths", "depth.Z: distance along the ray; Z: along the view");
    if let Some([camera_from_world, ndc_from_world]) = matrices(camera, aspect) {
        picture.set_metadata("cameraFromWorld", numbers(&camera_from_world));
        picture.set_metadata("ndcFromWorld", numbers(&ndc_from_world));
    }
}

/// The words of the call; of paths only the last part, for a picture need not tell where its maker's files lie.
fn command_line(words: impl Iterator<Item = OsString>) -> String {
    let shorten = |word: OsString| {
        let text = word.to_string_lossy().into_owned();
        let (option, value) = match text.split_once('=') {
            Some((option, value)) if option.starts_with("--") => (format!("{option}="), value),
            _ => (String::new(), &text[..]),
        };
        let last = Path::new(value).file_name().map_or(value.into(), |name| name.to_string_lossy());
        let word = format!("{option}{last}");
        if word.contains(char::is_whitespace) || word.is_empty() { format!("'{word}'") } else { word }
    };
    words.map(shorten).collect::<Vec<_>>().join(" ")
}

/// From world space to that of the camera (x right, y up, z into the picture), and on to (0, 0) = upper left and
/// (1, 1) = lower right corner of the picture after division by the last coordinate.
fn matrices(camera: &Camera, aspect: f32) -> Option<[[f64; 16]; 2]> {
    let frame = camera.frame()?;
    let row = |axis: [f32; 3]| {
        let along: f64 = (0..3).map(|k| f64::from(axis[k]) * f64::from(camera.eye[k])).sum();
        [f64::from(axis[0]), f64::from(axis[1]), f64::from(axis[2]), -along]
    };
    let [x, y, z] = [frame.right, frame.up, frame.forward].map(row);
    let half_height = (f64::from(camera.fov_y).to_radians() / 2.0).tan();
    let half_width = half_height * f64::from(aspect);
    let across: [f64; 4] = std::array::from_fn(|i| 0.5 * (x[i] / half_width + z[i]));
    let down: [f64; 4] = std::array::from_fn(|i| 0.5 * (z[i] - y[i] / half_height));
    let join = |rows: [[f64; 4]; 4]| std::array::from_fn(|i| rows[i / 4][i % 4]);
    Some([join([x, y, z, [0.0, 0.0, 0.0, 1.0]]), join([across, down, z, z])])
}

fn numbers(matrix: &[f64; 16]) -> String {
    matrix.map(|x| x.to_string()).join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_tells_no_folders() {
        let words =
            ["/usr/bin/gnurt", "render", "/home/me/my scene.obj", "--heatmap=/tmp/h.png", "--eye", "1,2,3"];
        let line = command_line(words.iter().map(OsString::from));
        assert_eq!(line, "gnurt render 'my scene.obj' --heatmap=h.png --eye 1,2,3", "last parts only");
    }

    #[test]
    fn matrices_lead_to_the_picture() {
        let camera = Camera {
            name: String::new(),
            eye: [1.0, 2.0, 3.0],
            target: [1.0, 2.0, -7.0],
            up: [0.0, 1.0, 0.0],
            fov_y: 90.0,
        };
        let [to_camera, to_ndc] = matrices(&camera, 2.0).expect("a view");
        let apply = |m: &[f64; 16], p: [f64; 3]| -> [f64; 4] {
            std::array::from_fn(|r| {
                m[4 * r] * p[0] + m[4 * r + 1] * p[1] + m[4 * r + 2] * p[2] + m[4 * r + 3]
            })
        };
        assert_eq!(apply(&to_camera, [1.0, 2.0, -1.0]), [0.0, 0.0, 4.0, 1.0], "4 in front of the eye");
        let corner = apply(&to_ndc, [1.0 + 8.0, 2.0 - 4.0, -1.0]).map(|x| x / 4.0);
        assert!(
            (corner[0] - 1.0).abs() < 1e-6 && (corner[1] - 1.0).abs() < 1e-6,
            "the lower right corner: {corner:?}"
        );
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! The statements `Film`, `Sampler`, `Integrator` and others that say how a picture is made.
//! Source: the sections Film, Samplers and Integrators of the file-format page; a film's imaging ratio is the time that the
//! shutter is open times its ISO over 100. Tests: `tests/view.rs`.

use gnurt_scene::io::reader::quoted;
use gnurt_scene::io::{Error, Oddity, Warnings};

use crate::parameter::{Kind, Parameters};

/// The size of the picture, its part and its sensor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Film {
    /// Columns and rows.
    pub(crate) size: [u32; 2],
    /// Of its sensor.
    pub(crate) iso: f32,
    /// Millimetres.
    pub(crate) diagonal: f32,
    /// The part that is made: from left to right and from the upper edge down, in [0, 1].
    pub(crate) crop: Option<[f32; 4]>,
}

impl Default for Film {
    fn default() -> Self {
        Self { size: [1280, 720], iso: 100.0, diagonal: 35.0, crop: None }
    }
}

impl Film {
    /// The film of a class with these parameters.
    pub(crate) fn read(class: &str, parameters: &Parameters, warnings: &mut Warnings) -> Result<Self, Error> {
        let location = &parameters.location;
        if !matches!(class, "rgb" | "gbuffer" | "spectral") {
            let problem = format!("unknown film {}", quoted(class));
            return Err(location.error(problem, "valid are gbuffer, rgb and spectral"));
        }
        if class == "spectral" {
            location.warn(warnings, Oddity::StandIn, "film \"spectral\": a picture of three colours");
        }
        let side = |name: &str, default: i32| -> Result<u32, Error> {
            let given = parameters.int(name)?.unwrap_or(default);
            u32::try_from(given).ok().filter(|side| (1..=1 << 16).contains(side)).ok_or_else(|| {
                location.error(format!("\"{name}\" of a film is {given}"), "expected 1 to 65536")
            })
        };
        let standard = Self::default();
        let size = [side("xresolution", 1280)?, side("yresolution", 720)?];
        let mut crop = None;
        if let Some(&[left, right, upper, lower]) = parameters.floats("cropwindow") {
            crop = Some([left, right, upper, lower]);
        } else if let Some(&[left, right, upper, lower]) = parameters.ints("pixelbounds") {
            let [x, y] = size.map(|side| side as f32);
            crop = Some([left as f32 / x, right as f32 / x, upper as f32 / y, lower as f32 / y]);
        }
        if let Some(sensor) = parameters.text("sensor")?.filter(|sensor| *sensor != "cie1931") {
            location.warn(
                warnings,
                Oddity::StandIn,
                format!("\"sensor\" {}: the CIE's observer", quoted(sensor)),
            );
        }
        if parameters.float("whitebalance")?.is_some_and(|kelvin| kelvin != 0.0) {
            location.warn(warnings, Oddity::NotShown, "\"whitebalance\" of a film");
        }
        // Of files, and without visible effect.
        for name in ["filename", "coordinatesystem"] {
            parameters.find(name, &[Kind::Text]);
        }
        parameters.find("savefp16", &[Kind::Bool]);
        parameters.find("maxcomponentvalue", &[Kind::Float]);
        if class == "spectral" {
            parameters.ignore();
        }
        Ok(Self {
            size,
            iso: parameters.float_or("iso", standard.iso)?,
            diagonal: parameters.float_or("diagonal", standard.diagonal)?,
            crop,
        })
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Displays and views of OpenColorIO configurations, for pictures that are written for screens.
//! A [`View`] turns linear light of Rec. 709 primaries into the values that a display gets, by the `ocio` library.
//! Why a feature: docs/decisions/0050-opencolorio.md. Invariant: a configuration that makes the library panic is an error.
//! Tests: `tests/views.rs`.
#![deny(unsafe_code)]

use std::path::Path;
use std::sync::{Mutex, PoisonError};

use gnurt_image::{NotRegular, Opacity, Picture, Workers, expecting_panics, open_regular, srgb};
use ocio::apphelpers::LegacyViewingPipeline;
use ocio::config::logging::set_logging_level;
use ocio::{Config, CpuProcessor, DisplayViewTransform, LoggingLevel};

/// The beginning of the names of built-in configurations.
pub const BUILT_IN: &str = "ocio://";

/// The request to a configuration.
#[derive(Clone, Copy, Debug, Default)]
pub struct Request<'a> {
    /// A file (.ocio, .ocioz), or a built-in configuration: `ocio://default`, `ocio://cg-config-latest`.
    pub config: &'a str,
    /// `None` = the configuration's default.
    pub display: Option<&'a str>,
    /// `None` = the display's default.
    pub view: Option<&'a str>,
    /// Looks between commas instead of those of the view.
    pub looks: Option<&'a str>,
    /// The configuration's name for linear light of Rec. 709 primaries; `None` = found by names, or by the roles for
    /// interchange.
    pub source: Option<&'a str>,
}

/// Why there is no view.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The configuration cannot be read, or is wrong.
    #[error("{config}: {why}")]
    Config {
        /// Its name.
        config: String,
        /// The library's message.
        why: String,
    },
    /// A name that the configuration does not have.
    #[error("{config}: unknown {what} '{name}'; valid are: {valid}")]
    UnknownName {
        /// The configuration.
        config: String,
        /// The kind of name.
        what: &'static str,
        /// The name.
        name: String,
        /// The valid names, separated by commas.
        valid: String,
    },
    /// The configuration names no space of our light.
    #[error("{config}: no colour space is known to be linear Rec. 709; name one of: {valid}")]
    NoSource {
        /// The configuration.
        config: String,
        /// Its spaces, separated by commas.
        valid: String,
    },
}

/// A view of a display.
pub struct View {
    processor: CpuProcessor,
    /// Display, view and source.
    names: [String; 3],
}

impl std::fmt::Debug for View {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("View").field("names", &self.names).finish_non_exhaustive()
    }
}

/// Names that configurations have for linear light of Rec. 709 primaries.
const LINEAR_REC709: [&str; 8] = [
    "Linear Rec.709 (sRGB)",
    "Linear Rec.709",
    "lin_rec709_scene",
    "lin_rec709",
    "lin_srgb",
    "Utility - Linear - sRGB",
    "Utility - Linear - Rec.709",
    "Linear BT.709",
];

impl View {
    /// The requested view.
    ///
    /// # Errors
    /// [`Error`] names the configuration and the fault; for a wrong name it lists the valid ones.
    pub fn new(request: &Request) -> Result<Self, Error> {
        let wrong = |why: String| Error::Config { config: request.config.into(), why };
        if !request.config.starts_with(BUILT_IN) {
            // The library would wait for the writer of a pipe.
            open_regular(Path::new(request.config)).map_err(|fault| match fault {
                NotRegular::System(error) => wrong(format!("cannot be read: {error}")),
                NotRegular::Folder => wrong("is a folder; a configuration is a file, .ocio or .ocioz".into()),
                NotRegular::Device => {
                    wrong("is a device or pipe; a configuration is a file, .ocio or .ocioz".into())
                }
            })?;
        }
        expecting_panics(|| Self::of(request))
            .unwrap_or_else(|| Err(wrong("the configuration contradicts itself".into())))
    }

    fn of(request: &Request) -> Result<Self, Error> {
        let wrong =
            |error: ocio::Error| Error::Config { config: request.config.into(), why: error.message().into() };
        // Its messages would go to standard error.
        set_logging_level(LoggingLevel::None);
        let config = Config::create_from_file(request.config).map_err(wrong)?;
        config.validate().map_err(wrong)?;
        let displays: Vec<String> = (0..config.num_displays()).map(|i| config.display(i)).collect();
        let default = config.default_display();
        let display = known(request, "display", request.display.unwrap_or(&default), &displays)?;
        let views: Vec<String> = (0..config.num_views(display)).map(|i| config.view(display, i)).collect();
        let default = config.default_view(display);
        let view = known(request, "view", request.view.unwrap_or(&default), &views)?;
        let source = source(request, &config)?;
        let mut pipeline = LegacyViewingPipeline::new();
        pipeline.set_display_view_transform(Some(&DisplayViewTransform::new(&source, display, view)));
        if let Some(looks) = request.looks {
            let all: Vec<String> =
                (0..config.num_looks()).map(|i| config.look_name_by_index(i).to_owned()).collect();
            for look in looks.split(',').map(|look| look.trim().trim_start_matches(['+', '-']).trim()) {
                if !look.is_empty() {
                    known(request, "look", look, &all)?;
                }
            }
            pipeline.set_looks_override_enabled(true);
            pipeline.set_looks_override(looks);
        }
        let processor = pipeline.get_processor(&config).map_err(wrong)?.default_cpu_processor();
        Ok(Self { processor, names: [display.into(), view.into(), source] })
    }

    /// The display.
    #[must_use]
    pub fn display(&self) -> &str {
        &self.names[0]
    }

    /// The view.
    #[must_use]
    pub fn view(&self) -> &str {
        &self.names[1]
    }

    /// The configuration's name for our light.
    #[must_use]
    pub fn source(&self) -> &str {
        &self.names[2]
    }

    /// Turns linear light into values of the display, in place; opacities stay.
    pub fn apply(&self, colors: &mut [[f32; 4]]) {
        for color in &mut *colors {
            // The library's tables have no entry for NaN.
            for channel in &mut color[..3] {
                *channel = if channel.is_nan() { 0.0 } else { channel.clamp(-BRIGHTEST, BRIGHTEST) };
            }
        }
        let opacities: Vec<f32> = colors.iter().map(|color| color[3]).collect();
        self.processor.apply_pixels(colors);
        colors.iter_mut().zip(opacities).for_each(|(color, opacity)| color[3] = opacity);
    }

    /// The picture as a file for screens shows it, without layers: written with [`ToneCurve::Clamp`](gnurt_image::ToneCurve)
    /// and exposure 0, its numbers are those of the display. `exposure` is in stops.
    #[must_use]
    pub fn shown(&self, picture: &Picture, exposure: f32, workers: Workers) -> Picture {
        let gain = exposure.exp2();
        let mut colors: Vec<[f32; 4]> =
            picture.on_screen().map(|[r, g, b, a]| [r * gain, g * gain, b * gain, a]).collect();
        let parts: Vec<Mutex<&mut [[f32; 4]]>> = colors.chunks_mut(PART).map(Mutex::new).collect();
        workers(parts.len(), &|n| {
            let mut part = parts[n].lock().unwrap_or_else(PoisonError::into_inner);
            self.apply(&mut part);
            for color in part.iter_mut() {
                // Writers encode as sRGB once more.
                (0..3).for_each(|c| color[c] = srgb::decode(color[c]));
            }
        });
        drop(parts);
        let [width, height] = [picture.width, picture.height];
        let metadata = picture.metadata.clone();
        Picture { width, height, color: colors, opacity: Opacity::Straight, layers: Vec::new(), metadata }
    }
}

/// No light is brighter: the largest number of 16 bits.
const BRIGHTEST: f32 = 65504.0;
/// Pixels of a worker's part.
const PART: usize = 1 << 14;

/// The configuration's spelling of a name.
fn known<'a>(
    request: &Request,
    what: &'static str,
    name: &str,
    valid: &'a [String],
) -> Result<&'a str, Error> {
    let found = valid.iter().find(|valid| valid.eq_ignore_ascii_case(name)).map(|name| &name[..]);
    found.ok_or_else(|| Error::UnknownName {
        config: request.config.into(),
        what,
        name: name.into(),
        valid: valid.join(", "),
    })
}

/// The space of our light.
fn source(request: &Request, config: &Config) -> Result<String, Error> {
    let all = || -> Vec<String> {
        (0..config.num_color_spaces()).map(|i| config.color_space_name_by_index(i).to_owned()).collect()
    };
    if let Some(name) = request.source {
        return match config.canonical_name(name) {
            "" => known(request, "colour space", name, &all()).map(str::to_owned),
            name => Ok(name.into()),
        };
    }
    if let Some(name) = LINEAR_REC709.iter().find(|name| config.has_color_space(name)) {
        return Ok(config.canonical_name(name).into());
    }
    let built_in = Config::create_from_builtin_config("default");
    let found = built_in
        .and_then(|built_in| Config::identify_builtin_color_space(config, &built_in, LINEAR_REC709[0]));
    found.map_err(|_| Error::NoSource { config: request.config.into(), valid: all().join(", ") })
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Pictures to be written: checked before the work, written and renamed after it. See docs/reference/cli.md.
//! An unknown extension is the user's mistake, a folder that is missing or may not be written to is the
//! system's. Tests: `tests/program/arguments.rs`, `tests/program/output.rs`.

use std::path::{Path, PathBuf};

use gnurt::Numbered;
use gnurt::image::{self, ExrCompression, ExrPixels, Picture, PictureFormat, ToneCurve, WriteOptions};
use gnurt::mattes::is_matte;

use crate::arguments::{DisplayOptions, LightArguments, OcioArguments, PictureFileArguments};
use crate::failure::{Failure, Outcome};
use crate::messages::Messages;
use crate::nearest::unknown;
use crate::ocio::View;
use crate::signals::{is_leaving, while_writing};
use crate::workers::with_workers;

/// A picture file to come.
#[derive(Clone, Debug)]
pub(crate) struct Output {
    path: PathBuf,
    format: &'static PictureFormat,
    /// In place of the tone curve.
    view: Option<View>,
}

impl Output {
    /// A file of this name; its extension must be that of a format that can be written.
    pub(crate) fn named(path: &Path) -> Result<Self, Failure> {
        let format = PictureFormat::from_path(path).map_err(|_| {
            let valid = PictureFormat::written_extensions();
            let valid: Vec<&str> = valid.split(", ").collect();
            let reason = match path.extension() {
                Some(extension) => {
                    unknown("picture format", &format!(".{}", extension.to_string_lossy()), &valid)
                }
                // Also `-` and `/dev/stdout`: a picture is written whole, as a file.
                None => {
                    format!("unknown picture format: the name has no ending; valid are: {}", valid.join(", "))
                }
            };
            Failure::usage(format_args!("{}: {reason}", path.display()))
        })?;
        Ok(Self { path: path.to_owned(), format, view: None })
    }

    /// The same by a view, if one is requested.
    pub(crate) fn through(self, ocio: &OcioArguments) -> Result<Self, Failure> {
        let view = View::of(ocio)?;
        if view.is_some() && !self.is_for_screens() {
            return Err(Failure::usage(format_args!(
                "--ocio: {} keeps the light as it is; give a .png, .jpg or .webp",
                self.path.display()
            )));
        }
        Ok(Self { view, ..self })
    }

    /// Whether it can be written, as far as that can be known before.
    pub(crate) fn check(&self) -> Outcome {
        image::check_writable(&self.path).map_err(Failure::data)
    }

    /// Overwriting a file that was read to make it is an error: a texture with the name of the scene, an
    /// environment.
    pub(crate) fn spare(&self, read: &[PathBuf]) -> Outcome {
        match read.iter().any(|file| is_same_file(file, &self.path)) {
            true => Err(Failure::usage(format_args!(
                "{}: the picture is made from this file, which would be lost; give another name to write to",
                self.path.display()
            ))),
            false => Ok(()),
        }
    }

    /// Whether its format stores layers in addition to the colours.
    pub(crate) fn has_layers(&self) -> bool {
        self.format.has_layers
    }

    /// Whether its format stores opacity.
    pub(crate) fn has_opacity(&self) -> bool {
        self.format.has_opacity
    }

    /// Whether it is for screens, so that curve and exposure show in it.
    pub(crate) fn is_for_screens(&self) -> bool {
        self.format.is_for_screens
    }

    /// Writes it with the given look, or else one that is chosen from the picture, and reports it.
    pub(crate) fn write_with(&self, picture: &Picture, light: LightArguments, messages: Messages) -> Outcome {
        if !self.is_for_screens() {
            return self.write(picture, DisplayOptions { file: light.file, ..DisplayOptions::default() });
        }
        let (display_options, note) = light.display_options(picture);
        note.iter().for_each(|note| messages.note(note));
        self.write(picture, display_options)
    }

    /// Its name, if that has a placeholder for a number.
    pub(crate) fn numbered(&self) -> Option<Numbered> {
        Numbered::of(&self.path)
    }

    /// The file of a frame; the same file if its name has no placeholder for a number.
    pub(crate) fn at(&self, frame: u32) -> Self {
        let path = self.numbered().map_or_else(|| self.path.clone(), |numbered| numbered.at(frame));
        Self { path, ..self.clone() }
    }

    /// Where it will be.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Writes it, whole or not at all.
    pub(crate) fn write(&self, picture: &Picture, display_options: DisplayOptions) -> Outcome {
        match self.view.as_ref().filter(|_| self.is_for_screens()) {
            Some(view) => self
                .put(&view.shown(picture, display_options.exposure), &Self::screen_options(display_options)),
            None => self.put(picture, &Self::options(display_options)),
        }
    }

    /// The same without rounding, where the format can.
    pub(crate) fn write_exactly(&self, picture: &Picture) -> Outcome {
        self.put(picture, &WriteOptions { exr_pixels: ExrPixels::Float, ..WriteOptions::default() })
    }

    /// The number of rows of which bands have a multiple.
    pub(crate) fn band_unit(&self, file: PictureFileArguments) -> Result<u32, Failure> {
        image::band_unit(
            self.format,
            &Self::band_options(DisplayOptions { file, ..DisplayOptions::default() }),
        )
        .map_err(|error| Failure::usage(format_args!("--band-rows: {error}")))
    }

    /// Writes it in bands of this number of rows, each made by a call; returns whether it is there.
    pub(crate) fn write_bands(
        &self,
        size: [u32; 2],
        rows: u32,
        display_options: DisplayOptions,
        make: &mut dyn FnMut([u32; 2]) -> Option<Picture>,
    ) -> Result<bool, Failure> {
        let options = Self::band_options(display_options);
        let view = self.view.as_ref().filter(|_| self.is_for_screens());
        let mut make = |rows| {
            let band = make(rows)?;
            Some(match view {
                Some(view) => view.shown(&band, display_options.exposure),
                None => band,
            })
        };
        let options = if view.is_some() { Self::screen_options(display_options) } else { options };
        let write = |workers: image::Workers| {
            image::write_bands(&self.path, size, rows, &options, workers, &mut make, || !is_leaving())
        };
        with_workers(write).map_err(Failure::data)
    }

    /// Neither curve nor exposure.
    fn screen_options(display_options: DisplayOptions) -> WriteOptions {
        WriteOptions { tone: ToneCurve::Clamp, exposure: 0.0, ..Self::options(display_options) }
    }

    /// What fits all values is not known before they are there: floats.
    fn band_options(display_options: DisplayOptions) -> WriteOptions {
        let mut options = Self::options(display_options);
        if options.exr_pixels == ExrPixels::Fitting {
            options.exr_pixels = ExrPixels::Float;
        }
        options
    }

    fn options(display_options: DisplayOptions) -> WriteOptions {
        WriteOptions {
            tone: display_options.tone,
            exposure: display_options.exposure,
            ..display_options.file.options()
        }
    }

    fn put(&self, picture: &Picture, options: &WriteOptions) -> Outcome {
        let rounds = self.has_layers() && options.exr_compression == ExrCompression::Pxr24;
        if rounds && picture.layers.iter().any(|layer| is_matte(&layer.name)) {
            return Err(Failure::usage(
                "--compression pxr24 rounds the ids of Cryptomatte; give another compression",
            ));
        }
        let bytes = with_workers(|workers| image::encode_with(picture, self.format, options, workers))
            .map_err(|error| Failure::data(format_args!("{}: {error}", self.path.display())))?;
        let replaced = while_writing(|| image::replace_file_if(&self.path, &bytes, || !is_leaving()));
        replaced.map(drop).map_err(Failure::data)
    }
}

/// Whether two names mean one file, through links or not; files that do not exist are the same if their names are.
pub(crate) fn is_same_file(a: &Path, b: &Path) -> bool {
    match (std::fs::canonicalize(a), std::fs::canonicalize(b)) {
        (Ok(a), Ok(b)) => a == b || is_same_node(&a, &b),
        _ => target_folder(a) == target_folder(b),
    }
}

/// The name in the true folder.
fn target_folder(path: &Path) -> Option<PathBuf> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    Some(std::fs::canonicalize(folder).ok()?.join(path.file_name()?))
}

/// Whether two names are hard links to one file.
#[cfg(unix)]
fn is_same_node(a: &Path, b: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let node = |path: &Path| std::fs::metadata(path).ok().map(|data| (data.dev(), data.ino()));
    node(a).is_some() && node(a) == node(b)
}

#[cfg(not(unix))]
fn is_same_node(_: &Path, _: &Path) -> bool {
    false
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Where a scene comes from: a file here or in a folder of `GNURT_PATH`, or the program itself.
//! Tests: `tests/program/arguments.rs`, `tests/program/broken_scenes.rs`.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::time::Instant;

use gnurt::image::system_reason;
use gnurt::scene::{Scene, io};
use gnurt::{BUILTIN, LoadOptions, Numbered, Override, load_scene_with};

use crate::arguments::FileArguments;
use crate::environment::Environment;
use crate::failure::Failure;
use crate::messages::Messages;
use crate::nearest::unknown;
use gnurt::memory::format_bytes as bytes;

/// A scene that is there, but not yet read.
#[derive(Clone, Debug)]
pub(crate) struct Source {
    found: OsString,
    options: LoadOptions,
    /// Changes of `--set`, made here so that errors name the option.
    overrides: Vec<Override>,
    /// Where it is a sequence of files.
    numbered: Option<Numbered>,
}

impl Source {
    /// Finds the scene without reading it.
    pub(crate) fn find(
        scene: &OsStr,
        files: &FileArguments,
        environment: &Environment,
    ) -> Result<Self, Failure> {
        let (options, overrides) = (files.options()?, files.set.clone());
        if let Some(folder) = options.confine.as_deref().filter(|folder| !folder.is_dir()) {
            return Err(Failure::usage(format_args!(
                "--confine {}: the folder does not exist; give the one that files may be read from",
                folder.display()
            )));
        }
        // The names are text, so an invalid text is an unknown name.
        if let Some(name) = scene.to_string_lossy().strip_prefix(BUILTIN) {
            let names = gnurt::builtin_names();
            return match names.contains(&name) {
                true => Ok(Self { found: scene.to_owned(), options, overrides, numbered: None }),
                false => Err(Failure::usage(unknown("built-in scene", name, &names))),
            };
        }
        let path = Path::new(scene);
        let elsewhere = environment.path.iter().map(|folder| folder.join(path));
        let candidates = std::iter::once(path.to_owned()).chain(elsewhere);
        // A name with a leading `/`, `.` or `..` is a path; others are searched.
        let has_transform = path.is_absolute() || path.starts_with(".") || path.starts_with("..");
        let found = candidates.take(if has_transform { 1 } else { usize::MAX }).find(|path| path.exists());
        match found {
            Some(path) => Ok(Self { found: path.into_os_string(), options, overrides, numbered: None }),
            None => match Numbered::of(path) {
                Some(numbered) => Self::sequence(numbered, options, overrides),
                None => Err(missing(path, environment)),
            },
        }
    }

    /// A sequence of files, of which there must be one.
    fn sequence(numbered: Numbered, options: LoadOptions, overrides: Vec<Override>) -> Result<Self, Failure> {
        let pattern = numbered.pattern();
        let first = numbered.first().map_err(|error| {
            Failure::data(format_args!("{}: {}; check the path", pattern.display(), system_reason(&error)))
        })?;
        let none = || {
            let example = numbered.at(1);
            let name = example.file_name().unwrap_or_default().to_string_lossy();
            Failure::data(format_args!(
                "{}: no file of this sequence, such as {name}; check the path",
                pattern.display()
            ))
        };
        first.ok_or_else(none)?;
        Ok(Self { found: pattern.as_os_str().to_owned(), options, overrides, numbered: Some(numbered) })
    }

    /// Its files, where it is a sequence of them.
    pub(crate) fn numbered(&self) -> Option<&Numbered> {
        self.numbered.as_ref()
    }

    /// One file of the sequence; the scene itself where it is none.
    pub(crate) fn at(&self, number: u32) -> Self {
        let Some(numbered) = &self.numbered else { return self.clone() };
        Self { found: numbered.at(number).into_os_string(), numbered: None, ..self.clone() }
    }

    /// The scene at another moment, in seconds, where its format is read at one.
    pub(crate) fn at_moment(&self, seconds: f64) -> Self {
        let options = LoadOptions { at: Some(seconds), ..self.options.clone() };
        Self { options, ..self.clone() }
    }

    /// Warns of textures that were lost while they were on the disk.
    pub(crate) fn warn_lost(&self, messages: Messages) {
        let failed = self.options.tiles.as_ref().map_or(0, |tiles| tiles.counts().failed);
        if failed > 0 {
            messages.warning(format_args!(
                "--texture-memory: {failed} tiles of textures could not be read from the temporary file; they are white"
            ));
        }
    }

    fn stem_or(&self, otherwise: &'static str) -> &OsStr {
        let builtin = self.found.to_str().and_then(|text| text.strip_prefix(BUILTIN)).map(OsStr::new);
        builtin.or_else(|| Path::new(&self.found).file_stem()).unwrap_or(OsStr::new(otherwise))
    }

    /// Its name alone, without folder and extension.
    #[cfg(any(feature = "bench", feature = "window"))]
    pub(crate) fn stem(&self) -> String {
        self.stem_or("scene").to_string_lossy().into_owned()
    }

    /// The default name of a picture, or of all pictures of a sequence.
    pub(crate) fn picture_name(&self, is_sequence: bool) -> PathBuf {
        let mut name = self.stem_or("picture").to_owned();
        let has_number = Numbered::of(Path::new(&name)).is_some();
        name.push(if is_sequence && !has_number { ".####.png" } else { ".png" });
        name.into()
    }

    /// As messages and headers name it.
    pub(crate) fn name(&self) -> String {
        Path::new(&self.found).display().to_string()
    }

    /// Reads it; oddities are reported as warnings.
    pub(crate) fn load(&self, messages: Messages) -> Result<Scene, Failure> {
        Ok(self.load_with_files(messages)?.0)
    }

    /// As [`load`](Self::load), and returns the files that it was read from.
    pub(crate) fn load_with_files(&self, messages: Messages) -> Result<(Scene, Vec<PathBuf>), Failure> {
        let begin = Instant::now();
        let mut loaded = load_scene_with(&self.found, &self.options).map_err(|error| match error.kind {
            io::ErrorKind::UnknownName => Failure::usage(error),
            _ => Failure::data(error),
        })?;
        for change in &self.overrides {
            change.apply(&mut loaded.scene).map_err(|why| Failure::usage(format_args!("--set: {why}")))?;
        }
        for warning in loaded.warnings.iter() {
            messages.warning(warning);
        }
        let held: usize = loaded.scene.meshes().iter().map(|mesh| mesh.memory_bytes()).sum();
        let seconds = begin.elapsed().as_secs_f64();
        messages.detail(format_args!("{}: {} of meshes in {seconds:.2} s", self.name(), bytes(held as u64)));
        Ok((loaded.scene, loaded.files))
    }
}

fn missing(path: &Path, environment: &Environment) -> Failure {
    let looked = if environment.path.is_empty() { "" } else { ", nor in the folders of GNURT_PATH" };
    let names = gnurt::builtin_names();
    let meant = path.to_str().filter(|name| names.contains(name));
    let remedy =
        meant.map_or_else(|| "check the path".to_owned(), |name| format!("did you mean '{BUILTIN}{name}'?"));
    // For a broken link, or a folder that may not be entered, the system's error is the most precise.
    let problem = match std::fs::metadata(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => system_reason(&error),
        _ => "no such file".into(),
    };
    Failure::data(format_args!("{}: {problem}{looked}; {remedy}", path.display()))
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Scene formats: a format's names, its reader and its writer, and the table of them.
//! Help texts, messages, the Python package and docs/reference/formats.md list formats from the table.
//! Invariant: the extension of a file's name selects the format. Tests: `tests/broken_files.rs`, `tests/save.rs`.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use super::error::{Error, ErrorKind, quoted};
use super::loaded::Loaded;
use super::options::LoadOptions;
use super::save::{losses, round};
use super::source::{self, Access};
use super::warnings::{Oddity, Warnings};
use crate::scene::Scene;

/// The beginning of the names of built-in scenes.
pub const BUILTIN_PREFIX: &str = "builtin:";

/// A scene format.
#[derive(Debug)]
pub struct Format {
    /// Its name in texts: `OBJ with MTL`.
    pub name: &'static str,
    /// Extensions of its files, in lower case, without the dot.
    pub extensions: &'static [&'static str],
    /// One line for the list of formats.
    pub notes: &'static str,
    /// Its reader, if there is one.
    pub read: Option<ReadScene>,
    /// Whether all of the format is read: the list of formats calls it *partly* read otherwise.
    pub read_whole: bool,
    /// Whether it defines, or its files say, which axis points upwards.
    pub says_up: bool,
    /// Its writer, if there is one.
    pub write: Option<SceneWriter>,
}

/// Reads a file into a scene.
pub type ReadScene = fn(&Path, &Access) -> Result<Loaded, Error>;

/// The writer of a format.
#[derive(Clone, Copy, Debug)]
pub struct SceneWriter {
    /// Writes a scene that passed [`Scene::check`], and warns of its losses.
    pub save: fn(&Scene, &Path, &mut Warnings) -> Result<(), Error>,
    /// The other files that `save` writes.
    pub companions: fn(&Scene, &Path) -> Vec<PathBuf>,
    /// Whether the format has materials.
    pub has_materials: bool,
    /// Whether the format has animations.
    pub has_animations: bool,
    /// Whether the format has curves and spheres.
    pub has_strands: bool,
    /// Whether it has all of a scene: the list of formats calls it *partly* written otherwise.
    pub is_whole: bool,
}

/// A table of formats.
#[derive(Clone, Copy, Debug)]
pub struct Formats {
    first: &'static [&'static Format],
    more: &'static [&'static Format],
}

impl Formats {
    /// The table of these formats.
    #[must_use]
    pub const fn new(formats: &'static [&'static Format]) -> Self {
        Self { first: formats, more: &[] }
    }

    /// This table with more formats behind its own. Only one table can be added.
    #[must_use]
    pub const fn with(self, more: &'static [&'static Format]) -> Self {
        Self { more, ..self }
    }

    /// The formats, in order.
    pub fn iter(&self) -> impl Iterator<Item = &'static Format> + use<> {
        self.first.iter().chain(self.more).copied()
    }

    /// `.obj, .ply`: the extensions of the formats that can be read.
    #[must_use]
    pub fn read_extensions(&self) -> String {
        Self::listed(self.iter().filter(|format| format.read.is_some()))
    }

    /// `.obj, .ply`: the extensions of the formats that can be written.
    #[must_use]
    pub fn written_extensions(&self) -> String {
        Self::listed(self.iter().filter(|format| format.write.is_some()))
    }

    fn listed(formats: impl Iterator<Item = &'static Format>) -> String {
        let dotted: Vec<_> = formats.flat_map(|f| f.extensions).map(|e| format!(".{e}")).collect();
        dotted.join(", ")
    }

    /// The format that the extension of `path` selects, in any case.
    ///
    /// # Errors
    /// The message lists the extensions that can be read.
    pub fn of(&self, path: &Path) -> Result<&'static Format, Error> {
        self.named(path, self.read_extensions())
    }

    fn named(&self, path: &Path, allowed: String) -> Result<&'static Format, Error> {
        let name = path.file_name().map(|name| name.to_string_lossy().to_lowercase()).unwrap_or_default();
        // `.pbrt.gz` is an extension as well.
        let has = |extension: &&&str| {
            name.strip_suffix(**extension).is_some_and(|stem| stem.len() > 1 && stem.ends_with('.'))
        };
        self.iter().find(|format| format.extensions.iter().any(|e| has(&e))).ok_or_else(|| {
            let problem = match path.extension() {
                Some(extension) => {
                    let extension = extension.to_string_lossy().to_lowercase();
                    format!("unknown scene format {}", quoted(&format!(".{extension}")))
                }
                None => "the scene format is unknown without an extension".to_owned(),
            };
            unknown(path, problem, &allowed)
        })
    }

    /// Loads a scene file by its format's reader.
    ///
    /// # Errors
    /// If the file is not there, has no known format, or its reader rejects it.
    pub fn load(&self, path: impl AsRef<Path>, options: &LoadOptions) -> Result<Loaded, Error> {
        let path = path.as_ref();
        let access = Access::new(options)?;
        let read = self.of(path).and_then(|format| {
            let problem = || format!("{} files are written, not read", format.name);
            if format.says_up && options.up.is_some() {
                let problem = format!("{} says itself which axis points upwards", format.name);
                return Err(Error::data(path, None, problem, "leave out the axis, `--up-axis`"));
            }
            format.read.ok_or_else(|| unknown(path, problem(), &self.read_extensions()))
        });
        let mut loaded = match read {
            Ok(read) => read(path, &access),
            // The message that the file is missing is more helpful.
            Err(unknown) => Err(source::open(path).err().unwrap_or(unknown)),
        }?;
        if let Some(up) = options.up {
            up.turn(&mut loaded.scene);
        }
        let has_shapes = loaded.scene.meshes().iter().any(|mesh| mesh.primitive_count() > 0);
        if !has_shapes && loaded.scene.media().is_empty() {
            loaded.warnings.note(Oddity::EmptyScene, path, None, "");
        }
        if let Some(first) = loaded.warnings.iter().next().filter(|_| options.strict) {
            return Err(first.as_error(loaded.warnings.iter().count()));
        }
        Ok(loaded)
    }

    /// Loads `builtin:NAME` or else a scene file, and makes the changes of the options.
    ///
    /// # Errors
    /// As [`load`](Self::load); unknown names of built-in scenes and of changes are [`ErrorKind::UnknownName`].
    pub fn load_source(&self, source: impl AsRef<OsStr>, options: &LoadOptions) -> Result<Loaded, Error> {
        let source = source.as_ref();
        let mut loaded = self.load_unchanged(source, options)?;
        for change in &options.overrides {
            change.apply(&mut loaded.scene).map_err(|error| Error {
                kind: ErrorKind::UnknownName,
                ..Error::data(Path::new(source), None, error.to_string(), "")
            })?;
        }
        Ok(loaded)
    }

    fn load_unchanged(&self, source: &OsStr, options: &LoadOptions) -> Result<Loaded, Error> {
        let Some(name) = source.to_str().and_then(|text| text.strip_prefix(BUILTIN_PREFIX)) else {
            return self.load(source, options);
        };
        let scene = crate::builtin::load(name).ok_or_else(|| {
            let problem = "unknown built-in scene";
            let remedy = crate::builtin::suggestion(name);
            Error { kind: ErrorKind::UnknownName, ..Error::data(Path::new(source), None, problem, remedy) }
        })?;
        Ok(Loaded { scene, ..Loaded::default() })
    }

    fn writer(&self, path: &Path) -> Result<SceneWriter, Error> {
        let format = self.named(path, self.written_extensions())?;
        let problem = || format!("{} files are read, not written", format.name);
        format.write.ok_or_else(|| unknown(path, problem(), &self.written_extensions()))
    }

    /// Writes a scene in the format of the file's name, where spheres are not known with triangles in their place. The warnings name
    /// the losses.
    ///
    /// # Errors
    /// If the format is unknown or not written, the scene is inconsistent, or a file cannot be written.
    pub fn save(&self, scene: &Scene, path: impl AsRef<Path>) -> Result<Warnings, Error> {
        let path = path.as_ref();
        let writer = self.writer(path)?;
        scene.check().map_err(|e| {
            Error::data(path, None, e.to_string(), "the scene must be in order to be written")
        })?;
        let mut warnings = Warnings::default();
        let clips = scene.animation().filter(|_| !writer.has_animations).map_or(0, |all| all.clips.len());
        warnings.note_many(Oddity::NotShown, clips as u64, path, None, "animation, written as it is shown");
        losses::of_scene(scene, path, &mut warnings);
        let as_triangles = if writer.has_strands { None } else { round::with_triangles(scene) };
        let scene = as_triangles.as_ref().unwrap_or(scene);
        if !writer.has_strands {
            losses::of_primitives(scene, path, &mut warnings);
        }
        if writer.has_materials {
            losses::of_materials(scene, path, &mut warnings);
        }
        (writer.save)(scene, path, &mut warnings)?;
        Ok(warnings)
    }

    /// The files that [`save`](Self::save) writes for this scene and path: the file itself first, then its
    /// companions.
    ///
    /// # Errors
    /// If the format is unknown or not written.
    pub fn saved_files(&self, scene: &Scene, path: impl AsRef<Path>) -> Result<Vec<PathBuf>, Error> {
        let path = path.as_ref();
        let mut files = vec![path.to_owned()];
        files.extend((self.writer(path)?.companions)(scene, path));
        Ok(files)
    }
}

/// The error of a format that is unknown or has no reader or writer; `allowed` are extensions between commas.
fn unknown(path: &Path, problem: String, allowed: &str) -> Error {
    let remedy = match allowed.rsplit_once(", ") {
        Some((others, last)) => format!("valid are {others} and {last}"),
        None => format!("valid is {allowed}"),
    };
    Error { kind: ErrorKind::UnknownFormat, ..Error::data(path, None, problem, remedy) }
}

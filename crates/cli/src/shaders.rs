// SPDX-License-Identifier: GPL-3.0-or-later
//! `--shader`: classes of libOpenRT, built-in ones and those of plugins, in place of a scene's materials.
//! Source: original. Proof: `tests/program/shaders.rs`.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use gnurt::render::ShaderTable;
use gnurt::scene::{MaterialId, Scene, Surface};
use gnurt_plugins::SceneShader;

use crate::arguments::ShaderChoice;
use crate::failure::Failure;
use crate::messages::Messages;
use crate::nearest::unknown;

/// The shaders that were asked for.
#[derive(Default)]
pub(crate) struct Shaders {
    /// What a commit takes.
    pub(crate) table: ShaderTable,
    made: Vec<SceneShader>,
}

/// Shaders whose faults are told as they come.
pub(crate) struct Watched(Vec<(SceneShader, AtomicBool)>);

impl Shaders {
    /// Makes them, and puts them in the place of the scene's materials; the last one for a material counts.
    pub(crate) fn put_into(scene: &mut Scene, choices: &[ShaderChoice]) -> Result<Self, Failure> {
        let mut shaders = Self::default();
        for choice in choices {
            let ShaderChoice { material, class, file, parameters } = choice;
            let option = || format!("--shader {material}={class}");
            let chosen = chosen(scene, material)?;
            let made = SceneShader::new(class, file.as_deref(), parameters)
                .map_err(|why| Failure::data(format_args!("{}: {why}", option())))?;
            let number = shaders.table.surfaces.len() as u32;
            for id in chosen {
                scene.edit_material(id).surface = Surface::Shader(number);
            }
            shaders.table.surfaces.push(made.surface.clone());
            shaders.made.push(made);
        }
        Ok(shaders)
    }

    /// For those who ask again and again.
    pub(crate) fn watched(self) -> Watched {
        Watched(self.made.into_iter().map(|made| (made, AtomicBool::new(false))).collect())
    }

    /// Tells what they did wrong.
    pub(crate) fn tell_faults(&self, messages: Messages) {
        self.made.iter().flat_map(SceneShader::faults).for_each(|fault| messages.warning(fault));
    }
}

impl Watched {
    /// What they did wrong, of each once: as much of it as is known when it is asked for first.
    pub(crate) fn new_faults(&self) -> Vec<String> {
        let new = |(made, is_told): &(SceneShader, AtomicBool)| {
            let faults = if is_told.load(Ordering::Relaxed) { Vec::new() } else { made.faults() };
            is_told.fetch_or(!faults.is_empty(), Ordering::Relaxed);
            faults
        };
        self.0.iter().flat_map(new).collect()
    }
}

/// The files that they come from.
pub(crate) fn files(choices: &[ShaderChoice]) -> impl Iterator<Item = PathBuf> + '_ {
    let texture = |(_, value): &(String, String)| value.strip_prefix('@').map(PathBuf::from);
    choices.iter().flat_map(move |choice| {
        choice.file.iter().cloned().chain(choice.parameters.iter().filter_map(texture))
    })
}

/// What tells shaders apart from others: what was asked for, and the bytes of the files.
pub(crate) fn print(choices: &[ShaderChoice]) -> u64 {
    let mut hasher = DefaultHasher::new();
    format!("{choices:?}").hash(&mut hasher);
    // A file that is gone by now was read before: its shaders exist.
    files(choices).for_each(|file| std::fs::read(file).unwrap_or_default().hash(&mut hasher));
    hasher.finish()
}

/// What can be refused before the scene is read.
pub(crate) fn check(choices: &[ShaderChoice]) -> Result<(), Failure> {
    files(choices).try_for_each(|file| match std::fs::metadata(&file) {
        Ok(data) if data.is_file() => Ok(()),
        Ok(_) => Err(no_file(&file, "not a file")),
        Err(error) => Err(no_file(&file, gnurt::image::system_reason(&error))),
    })
}

fn no_file(file: &Path, why: impl std::fmt::Display) -> Failure {
    Failure::data(format_args!("--shader: {}: {why}; give the path of a plugin or a picture", file.display()))
}

/// The materials of this name; all for `*`.
fn chosen(scene: &Scene, name: &str) -> Result<Vec<MaterialId>, Failure> {
    let materials = scene.materials().iter().zip(0..);
    let chosen: Vec<_> = materials
        .filter(|(material, _)| name == "*" || material.name == name)
        .map(|(_, i)| MaterialId(i))
        .collect();
    if chosen.is_empty() {
        let mut names: Vec<&str> = scene.materials().iter().map(|material| &material.name[..]).collect();
        names.retain(|name| !name.is_empty());
        names.push("*");
        return Err(Failure::usage(format_args!("--shader: {}", unknown("material", name, &names))));
    }
    Ok(chosen)
}

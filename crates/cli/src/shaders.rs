// SPDX-License-Identifier: GPL-3.0-or-later
//! `--shader`: classes of libOpenRT, built-in ones and those of plugins, and files in the shading language, in place of a scene's
//! materials.
//! Source: original. Proof: `tests/program/shaders.rs`.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use gnurt::osl::{Access, Kind, Script};
use gnurt::render::ShaderTable;
use gnurt::scene::{MaterialId, Scene, ShaderFile, Surface};
use gnurt_plugins::{SceneShader, is_script};

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
    lights: Vec<Script>,
}

/// Shaders whose faults are told as they come.
pub(crate) struct Watched(Vec<(SceneShader, AtomicBool)>);

impl Shaders {
    /// Makes them, and puts them in the place of the scene's materials; the last one for a material counts.
    pub(crate) fn put_into(
        scene: &mut Scene,
        choices: &[ShaderChoice],
        messages: Messages,
    ) -> Result<Self, Failure> {
        let mut shaders = Self::default();
        shaders.put_named(scene, messages);
        for choice in choices {
            let ShaderChoice { material, class, file, parameters } = choice;
            if material.is_empty() {
                shaders.put_light(class, parameters, messages)?;
                continue;
            }
            let option = || format!("--shader {material}={class}");
            let chosen = chosen(scene, material)?;
            let made = SceneShader::new(class, file.as_deref(), parameters)
                .map_err(|why| Failure::data(format_args!("{}: {why}", option())))?;
            let number = shaders.table.surfaces.len() as u32;
            for id in chosen {
                scene.edit_material(id).surface = Surface::Shader(number);
            }
            made.warnings().iter().for_each(|warning| messages.warning(warning.trim_end()));
            shaders.table.surfaces.push(made.surface.clone());
            shaders.made.push(made);
        }
        Ok(shaders)
    }

    /// Those that the scene's file names. One that cannot be had is told, and the material stays what it is without it.
    fn put_named(&mut self, scene: &mut Scene, messages: Messages) {
        let named: Vec<(MaterialId, ShaderFile)> =
            scene.shader_files().map(|(id, file)| (id, file.clone())).collect();
        for (id, ShaderFile { file, parameters, confined_to }) in named {
            let access = Access { confined_to, ..Access::default() };
            match SceneShader::of_script(&file, &parameters, &access) {
                Ok(made) => {
                    made.warnings().iter().for_each(|warning| messages.warning(warning.trim_end()));
                    // What it is without the shader still stands for it where all is forced to be diffuse.
                    let diffuse = scene.material(id).diffuse_color();
                    let material = scene.edit_material(id);
                    material.diffuse.get_or_insert(diffuse);
                    material.surface = Surface::Shader(self.table.surfaces.len() as u32);
                    self.table.surfaces.push(made.surface.clone());
                    self.made.push(made);
                }
                Err(why) => {
                    let name = &scene.material(id).name;
                    messages.warning(format_args!("material '{name}' is shown without its shader: {why}"));
                }
            }
        }
    }

    /// A light in the shading language.
    fn put_light(
        &mut self,
        file: &str,
        parameters: &[(String, String)],
        messages: Messages,
    ) -> Result<(), Failure> {
        let wrong = |why: String| Failure::data(format_args!("--shader {file}: {why}"));
        let mut script = Script::open(Path::new(file), &Access::default()).map_err(wrong)?;
        let right = match script.kind() {
            Kind::Light => None,
            Kind::Surface => {
                Some(format!("a surface needs a material; give MATERIAL={file}, or *={file} for all"))
            }
            Kind::Environment => Some(format!("give --environment {file}")),
            Kind::Camera | Kind::Pixel => {
                let word = script.kind().word();
                Some(format!("shaders of type {word} have no option yet; programs take them by the API"))
            }
        };
        if let Some(right) = right {
            return Err(Failure::usage(format_args!("--shader {file}: {right}")));
        }
        script.warnings().iter().for_each(|warning| messages.warning(warning.trim_end()));
        parameters.iter().try_for_each(|(name, value)| script.set_text(name, value)).map_err(wrong)?;
        self.table.lights.push(script.light().map_err(wrong)?);
        self.lights.push(script);
        Ok(())
    }

    /// The files that they were made from, included ones too.
    pub(crate) fn files(&self) -> impl Iterator<Item = PathBuf> + '_ {
        let surfaces = self.made.iter().flat_map(|made| made.files().iter().cloned());
        surfaces.chain(self.lights.iter().flat_map(|script| script.files().iter().cloned()))
    }

    /// For those who ask again and again.
    pub(crate) fn watched(self) -> Watched {
        Watched(self.made.into_iter().map(|made| (made, AtomicBool::new(false))).collect())
    }

    /// Tells what they did wrong.
    pub(crate) fn tell_faults(&self, messages: Messages) {
        let lights = self.lights.iter().flat_map(Script::faults);
        self.made
            .iter()
            .flat_map(SceneShader::faults)
            .chain(lights)
            .for_each(|fault| messages.warning(fault));
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
        let script = is_script(&choice.class).then(|| PathBuf::from(&choice.class));
        choice.file.iter().cloned().chain(script).chain(choice.parameters.iter().filter_map(texture))
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
    Failure::data(format_args!(
        "--shader: {}: {why}; give the path of a plugin, a shader or a picture",
        file.display()
    ))
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

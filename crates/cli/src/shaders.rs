// SPDX-License-Identifier: GPL-3.0-or-later
//! `--shader`: classes of libOpenRT, built-in ones and those of plugins, and files in the shading language,
//! which replace a scene's materials; `--pixel-shader` and `--camera FILE.osl`.
//! Tests: `tests/program/shaders.rs`.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use gnurt::image::WorkingSpace;
use gnurt::osl::{Access, CameraScript, Kind, Script, document_and_node, shaders_by_material};
use gnurt::render::ShaderTable;
use gnurt::scene::{CameraId, MaterialId, Scene, Surface};
use gnurt_plugins::{SceneShader, is_script};
use gnurt_view::{ScriptRole, Scripts, StageScript};

use crate::arguments::{FrameArguments, ShaderChoice, ViewArguments};
use crate::failure::Failure;
use crate::messages::Messages;
use crate::nearest::unknown;

/// The requested shaders.
#[derive(Default)]
pub(crate) struct Shaders {
    /// The shader table of a commit.
    pub(crate) table: ShaderTable,
    made: Vec<SceneShader>,
    /// Of lights and pixels.
    scripts: Vec<Script>,
    /// Displacement shaders, and their numbers in the table.
    displacements: Vec<(Script, usize)>,
}

/// Shaders whose faults are reported when they occur.
pub(crate) struct Watched(Vec<(SceneShader, AtomicBool)>);

impl Shaders {
    /// Makes them, and replaces the scene's materials by them; the last one for a material counts.
    pub(crate) fn put_into(
        scene: &mut Scene,
        frame: &FrameArguments,
        messages: Messages,
    ) -> Result<Self, Failure> {
        let mut shaders = Self::default();
        shaders.put_named(scene, frame.working_space, messages);
        let access = access(frame);
        if let Some(choice) = &frame.pixel_shader {
            let script = script("--pixel-shader", choice, &access, messages)?;
            let made = script.pixel().map_err(|why| wrong("--pixel-shader", choice, &why))?;
            shaders.table.pixel = Some(made);
            shaders.scripts.push(script);
        }
        for choice in each_of_document(scene, &frame.shaders, &access)? {
            let ShaderChoice { material, class, file, parameters } = &choice;
            if material.is_empty() {
                shaders.put_light(&choice, &access, messages)?;
                continue;
            }
            let option = || format!("--shader {material}={class}");
            let chosen = chosen(scene, material)?;
            let made = SceneShader::new(class, file.as_deref(), parameters, &access)
                .map_err(|why| Failure::data(format_args!("{}: {why}", option())))?;
            if let Some(displacement) = made.displacement.clone() {
                gnurt::put_displacement(scene, &mut shaders.table, &chosen, displacement);
            }
            let Some(surface) = made.surface.clone() else {
                made.warnings().iter().for_each(|warning| messages.warning(warning.trim_end()));
                let number = shaders.table.displacements.len() - 1;
                shaders.displacements.extend(made.script().cloned().map(|script| (script, number)));
                continue;
            };
            let number = shaders.table.surfaces.len() as u32;
            for id in chosen {
                scene.edit_material(id).surface = Surface::Shader(number);
            }
            made.warnings().iter().for_each(|warning| messages.warning(warning.trim_end()));
            shaders.table.surfaces.push(surface);
            shaders.made.push(made);
        }
        Ok(shaders)
    }

    /// Those that the scene's file names.
    fn put_named(&mut self, scene: &mut Scene, space: WorkingSpace, messages: Messages) {
        let named = gnurt::put_named_shaders(scene, &mut self.table, space);
        named.reported.iter().for_each(|line| messages.warning(line));
        let surfaces = self.table.surfaces.iter().cloned();
        self.made.extend(
            named
                .surfaces
                .into_iter()
                .zip(surfaces)
                .map(|(script, surface)| SceneShader::of(script, Some(surface), None)),
        );
    }

    /// A light in the shading language.
    fn put_light(
        &mut self,
        choice: &ShaderChoice,
        access: &Access,
        messages: Messages,
    ) -> Result<(), Failure> {
        let (script, file) = (script("--shader", choice, access, messages)?, &choice.class);
        let right = match script.kind() {
            Kind::Light => None,
            Kind::Surface => {
                Some(format!("a surface needs a material; give MATERIAL={file}, or *={file} for all"))
            }
            Kind::Displacement => {
                Some(format!("a displacement needs a material; give MATERIAL={file}, or *={file} for all"))
            }
            Kind::Environment => Some(format!("give --environment {file}")),
            Kind::Camera => Some(format!("give --camera {file}")),
            Kind::Pixel => Some(format!("give --pixel-shader {file}")),
        };
        if let Some(right) = right {
            return Err(Failure::usage(format_args!("--shader {file}: {right}")));
        }
        self.table.lights.push(script.light().map_err(|why| wrong("--shader", choice, &why))?);
        self.scripts.push(script);
        Ok(())
    }

    /// Those that are files in the shading language, and their positions in the shader table, for a viewer to
    /// read them again; and the others.
    pub(crate) fn into_viewed(self, camera: Option<&CameraShaderChoice>) -> (Scripts, Watched) {
        let (mut surfaces, mut others) = (Vec::new(), Vec::new());
        for (number, made) in self.made.into_iter().enumerate() {
            match made.script() {
                Some(script) => surfaces.push(StageScript::new(script.clone(), ScriptRole::Surface(number))),
                None => others.push((made, AtomicBool::new(false))),
            }
        }
        let mut lights = 0..;
        let scripts = self.scripts.into_iter().map(|script| {
            let role = match script.kind() {
                Kind::Pixel => ScriptRole::Pixel,
                _ => ScriptRole::Light(lights.next().unwrap_or_default()),
            };
            StageScript::new(script, role)
        });
        surfaces.extend(scripts);
        let displacements = self.displacements.into_iter();
        surfaces.extend(
            displacements.map(|(script, number)| StageScript::new(script, ScriptRole::Displacement(number))),
        );
        surfaces.extend(camera.map(|camera| StageScript::new(camera.script.clone(), ScriptRole::Camera)));
        let camera = camera.map(|camera| camera.camera.clone());
        (Scripts { list: surfaces, table: self.table, camera }, Watched(others))
    }

    /// Reports their faults.
    pub(crate) fn report_faults(&self, messages: Messages) {
        let displacements = self.displacements.iter().map(|(script, _)| script);
        let scripts = self.scripts.iter().chain(displacements).flat_map(Script::faults);
        self.made
            .iter()
            .flat_map(SceneShader::faults)
            .chain(scripts)
            .for_each(|fault| messages.warning(fault));
    }
}

impl Watched {
    /// Their faults, once for each shader: those known at the first call.
    pub(crate) fn new_faults(&self) -> Vec<String> {
        let new = |(made, is_reported): &(SceneShader, AtomicBool)| {
            let faults = if is_reported.load(Ordering::Relaxed) { Vec::new() } else { made.faults() };
            is_reported.fetch_or(!faults.is_empty(), Ordering::Relaxed);
            faults
        };
        self.0.iter().flat_map(new).collect()
    }
}

/// Where shaders may take files from.
fn access(frame: &FrameArguments) -> Access {
    let includes = frame.include.iter().map(|folder| folder.to_string_lossy().into_owned()).collect();
    Access { includes, space: frame.working_space, ..Access::default() }
}

/// The choices, those of documents with several materials replaced by one for each.
fn each_of_document(
    scene: &Scene,
    choices: &[ShaderChoice],
    access: &Access,
) -> Result<Vec<ShaderChoice>, Failure> {
    let mut all = Vec::new();
    for choice in choices {
        let names = scene.materials().iter().map(|material| &*material.name);
        let found = shaders_by_material(&choice.class, &choice.material, names, access).map_err(|why| {
            Failure::data(format_args!("--shader {}={}: {why}", choice.material, choice.class))
        })?;
        let of_one = |(material, class)| ShaderChoice { material, class, ..choice.clone() };
        all.extend(found.into_iter().map(of_one));
    }
    Ok(all)
}

/// A script with values, whose compiler has been listened to.
fn script(
    option: &str,
    choice: &ShaderChoice,
    access: &Access,
    messages: Messages,
) -> Result<Script, Failure> {
    let mut script =
        Script::open(Path::new(&choice.class), access).map_err(|why| wrong(option, choice, &why))?;
    let set = choice.parameters.iter().try_for_each(|(name, value)| script.set_text(name, value));
    set.map_err(|why| wrong(option, choice, &why))?;
    script.warnings().iter().for_each(|warning| messages.warning(warning.trim_end()));
    Ok(script)
}

fn wrong(option: &str, choice: &ShaderChoice, why: &str) -> Failure {
    Failure::data(format_args!("{option} {}: {why}", choice.class))
}

/// A camera's shader, and the script that it was made of.
#[derive(Clone)]
pub(crate) struct CameraShaderChoice {
    pub(crate) camera: CameraScript,
    pub(crate) script: Script,
}

/// The shader that replaces a camera: a requested one, or else the one that the scene's file names for the
/// camera; that is reported and left out where it cannot be had.
pub(crate) fn camera(
    scene: &Scene,
    number: usize,
    view: &ViewArguments,
    messages: Messages,
) -> Result<Option<CameraShaderChoice>, Failure> {
    if let Some(choice) = view.camera_shader() {
        let script = script("--camera", choice, &Access::default(), messages)?;
        let camera = script.camera_anywhere().map_err(|why| wrong("--camera", choice, &why))?;
        return Ok(Some(CameraShaderChoice { camera, script }));
    }
    match gnurt::named_camera_shader(scene, CameraId(number as u32)) {
        Ok(made) => Ok(made.map(|(script, camera)| CameraShaderChoice { camera, script })),
        Err(why) => {
            messages.warning(why);
            Ok(None)
        }
    }
}

/// All requests of the options.
fn choices<'a>(
    frame: &'a FrameArguments,
    view: &'a ViewArguments,
) -> impl Iterator<Item = (&'static str, &'a ShaderChoice)> {
    let surfaces = frame.shaders.iter().map(|choice| ("--shader", choice));
    let pixel = frame.pixel_shader.iter().map(|choice| ("--pixel-shader", choice));
    surfaces.chain(pixel).chain(view.camera_shader().into_iter().map(|choice| ("--camera", choice)))
}

/// The files that one comes from.
fn files_of(choice: &ShaderChoice) -> impl Iterator<Item = PathBuf> + '_ {
    let texture = |(_, value): &(String, String)| value.strip_prefix('@').map(PathBuf::from);
    let file = document_and_node(&choice.class).map_or(&*choice.class, |(file, _)| file);
    let script = is_script(&choice.class).then(|| PathBuf::from(file));
    choice.file.iter().cloned().chain(script).chain(choice.parameters.iter().filter_map(texture))
}

/// The files that they come from.
fn files<'a>(frame: &'a FrameArguments, view: &'a ViewArguments) -> impl Iterator<Item = PathBuf> + 'a {
    choices(frame, view).flat_map(|(_, choice)| files_of(choice))
}

/// Those of them that are not in the shading language: plugins, and pictures.
pub(crate) fn other_files<'a>(
    frame: &'a FrameArguments,
    view: &'a ViewArguments,
) -> impl Iterator<Item = PathBuf> + 'a {
    files(frame, view).filter(|file| !is_script(&file.to_string_lossy()))
}

/// The identity of shaders: the request, and the bytes of the files.
pub(crate) fn print(frame: &FrameArguments, view: &ViewArguments) -> u64 {
    let mut hasher = DefaultHasher::new();
    format!("{:?}", choices(frame, view).collect::<Vec<_>>()).hash(&mut hasher);
    // A file that is gone by now was read before: its shaders exist.
    files(frame, view).for_each(|file| std::fs::read(file).unwrap_or_default().hash(&mut hasher));
    hasher.finish()
}

/// Checks that need no scene.
pub(crate) fn check(frame: &FrameArguments, view: &ViewArguments) -> Result<(), Failure> {
    choices(frame, view).try_for_each(|(option, choice)| {
        files_of(choice).try_for_each(|file| match std::fs::metadata(&file) {
            _ if gnurt::osl::is_carried(&file) => Ok(()),
            Ok(data) if data.is_file() => Ok(()),
            Ok(_) => Err(no_file(option, &file, "not a file")),
            Err(error) => Err(no_file(option, &file, gnurt::image::system_reason(&error))),
        })
    })
}

fn no_file(option: &str, file: &Path, why: impl std::fmt::Display) -> Failure {
    Failure::data(format_args!(
        "{option}: {}: {why}; give the path of a plugin, a shader or a picture",
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

// SPDX-License-Identifier: GPL-3.0-or-later
//! Shaders of a stage from files in the shading language: read again one by one when they are saved, and
//! adjusted by controls. A later commit updates the parts that depend on a new shader; trees, textures and
//! other shaders stay. If a file does not compile, nothing changes. Tests: `tests`, and `render_thread`'s.

use std::path::PathBuf;

use gnurt::osl::{CameraScript, Parameter, ParameterValue, Script};
use gnurt::render::ShaderTable;

use crate::shader_controls::ShaderControl;

/// The purpose of a script.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScriptRole {
    /// The surface of this number in the shader table.
    Surface(usize),
    /// The displacement of this number there.
    Displacement(usize),
    /// The light of this number there.
    Light(usize),
    /// A camera shader.
    Camera,
    /// A pixel shader.
    Pixel,
}

/// A shader of a stage.
#[derive(Clone, Debug)]
pub struct StageScript {
    script: Script,
    role: ScriptRole,
    /// Its parameters when the scene was read.
    first: Vec<Parameter>,
}

impl StageScript {
    /// A script with its values, and its purpose.
    #[must_use]
    pub fn new(script: Script, role: ScriptRole) -> Self {
        Self { first: script.parameters(), script, role }
    }

    /// Stores the shader that it makes in its slot.
    fn put_into(&self, table: &mut ShaderTable, camera: &mut Option<CameraScript>) -> Result<(), String> {
        let script = &self.script;
        match self.role {
            ScriptRole::Surface(number) => set(&mut table.surfaces, number, script.surface()?),
            ScriptRole::Displacement(number) => {
                if let Some(displacement) = script.displacement()? {
                    set(&mut table.displacements, number, displacement);
                }
            }
            ScriptRole::Light(number) => set(&mut table.lights, number, script.light()?),
            ScriptRole::Camera => *camera = Some(script.camera_anywhere()?),
            ScriptRole::Pixel => table.pixel = Some(script.pixel()?),
        }
        Ok(())
    }
}

fn set<T>(list: &mut [T], number: usize, shader: T) {
    if let Some(index) = list.get_mut(number) {
        *index = shader;
    }
}

/// The shaders of a stage, and where they go.
#[derive(Clone, Default)]
pub struct Scripts {
    /// The files.
    pub list: Vec<StageScript>,
    /// The shader table of the world's commit.
    pub table: ShaderTable,
    /// The shader that replaces the camera, if one does.
    pub camera: Option<CameraScript>,
}

impl Scripts {
    /// All files that they were read from, included ones too.
    pub(crate) fn files(&self) -> Vec<PathBuf> {
        let mut files: Vec<PathBuf> =
            self.list.iter().flat_map(|script| script.script.files().iter().cloned()).collect();
        files.sort_unstable();
        files.dedup();
        files
    }

    /// The same with the shaders of `changed` files read again, and the messages about it, a line each.
    ///
    /// # Errors
    /// The compiler's message about the first that does not compile.
    pub(crate) fn again(&self, changed: &[PathBuf]) -> Result<(Self, Vec<String>), String> {
        let (mut next, mut messages) = (self.clone(), Vec::new());
        for shader in &mut next.list {
            if !shader.script.files().iter().any(|file| changed.contains(file)) {
                continue;
            }
            let is_tuned = shader.first.iter().any(|p| shader.script.is_tunable(&p.name));
            let mut script = shader.script.again()?;
            messages.push(format!("{} was read again", script.name()));
            messages.extend(script.warnings().iter().map(|warning| warning.trim_end().to_owned()));
            if is_tuned {
                script.make_tunable();
            }
            *shader = StageScript { first: script.parameters(), script, role: shader.role };
            shader.put_into(&mut next.table, &mut next.camera)?;
        }
        Ok((next, messages))
    }

    /// Gives a parameter of a script another value; returns whether the world must be committed: once for
    /// each script, and always where it emits light; all later changes reach the existing shaders.
    ///
    /// # Errors
    /// The value does not fit, or there is no such parameter.
    pub(crate) fn tune(&mut self, script: usize, name: &str, value: &ParameterValue) -> Result<bool, String> {
        let Self { list, table, camera } = self;
        let shader = list.get_mut(script).ok_or("the shader does not exist any more")?;
        if shader.script.is_tunable(name) {
            shader.script.tune(name, value)?;
            // A commit processes emissive surfaces, and moves vertices.
            let number = if let ScriptRole::Surface(number) = shader.role { number } else { usize::MAX };
            let moves = matches!(shader.role, ScriptRole::Displacement(_));
            if !moves && !table.surfaces.get(number).is_some_and(|surface| surface.emits()) {
                return Ok(false);
            }
        } else {
            shader.script.make_tunable();
            shader.script.tune(name, value)?;
        }
        shader.put_into(table, camera)?;
        Ok(true)
    }

    /// All parameters that keys can change.
    pub(crate) fn shader_controls(&self) -> Vec<ShaderControl> {
        let of = |(i, shader): (usize, &StageScript)| ShaderControl::of(i, &shader.script, &shader.first);
        self.list.iter().enumerate().flat_map(of).collect()
    }

    /// Their faults and output: each line once, while they stay.
    pub(crate) fn faults(&self) -> Vec<String> {
        self.list.iter().flat_map(|shader| shader.script.faults()).collect()
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Surface shaders for scenes that no OpenRT calls make: classes of plugins and built-in ones, files in the shading language,
//! parameters as people write them.
//! A parameter is its numbers, or one number for all of them, between commas; a text; or, for textures, `@`
//! and the name of a picture. A plugin is loaded again each time, so that a rebuilt one is used.
//! Tests: `tests`; crates/cli/tests/program/shaders.rs.

use std::collections::BTreeMap;
use std::ffi::CString;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use gnurt::image::read_texture;
use gnurt::osl::{Access, Kind as ScriptKind, Script, document_and_node};
use gnurt::shading::classes::{self, ParameterRate, ParameterType, Shader as RenderShader, Value};
use gnurt::shading::texture::TextureSampler;
use gnurt::shading::{DisplacementShader, SurfaceShader};

use crate::data_type::DataType;
use crate::description::{Kind, Parameter};
use crate::ffi_block::PluginBlock;
use crate::frame::PluginFrame;
use crate::frame_state::FrameState;
use crate::load::{load_copy, suggestion};

/// A surface shader with its parameters, or a displacement.
pub struct SceneShader {
    /// As the renderer takes it; `None` if it is a displacement only.
    pub surface: Option<Arc<dyn SurfaceShader>>,
    /// The displacement that it is or has.
    pub displacement: Option<Arc<dyn DisplacementShader>>,
    plugins: PluginFrame,
    script: Option<Script>,
}

/// Whether a class is a file in the shading language, or a document of MaterialX.
#[must_use]
pub fn is_script(class: &str) -> bool {
    [".osl", ".oso", ".oslgroup"].iter().any(|end| class.ends_with(end)) || document_and_node(class).is_some()
}

impl SceneShader {
    /// A shader of `class`, which `file` holds if it is no built-in one, with some parameters set: pairs of a name and
    /// a value. Scripts include files by `access`.
    ///
    /// # Errors
    /// One line: the class cannot be had or is of no surfaces, `prepare` fails or crashes, a parameter or value is wrong.
    pub fn new(
        class: &str,
        file: Option<&Path>,
        parameters: &[(String, String)],
        access: &Access,
    ) -> Result<Self, String> {
        match file {
            None if is_script(class) => Self::of_script(Path::new(class), parameters, access),
            Some(file) => Self::of_plugin(class, file, parameters),
            None => Self::built_in(class, parameters),
        }
    }

    /// A script, and the surface and the displacement that it has made.
    #[must_use]
    pub fn of(
        script: Script,
        surface: Option<Arc<dyn SurfaceShader>>,
        displacement: Option<Arc<dyn DisplacementShader>>,
    ) -> Self {
        Self { surface, displacement, plugins: PluginFrame::default(), script: Some(script) }
    }

    fn of_script(file: &Path, parameters: &[(String, String)], access: &Access) -> Result<Self, String> {
        let mut script = Script::open(file, access)?;
        for (name, value) in parameters {
            script.set_text(name, value)?;
        }
        let displacement = script.displacement()?;
        let is_surface = script.kind() != ScriptKind::Displacement;
        let surface = if is_surface { Some(script.surface()?) } else { None };
        Ok(Self::of(script, surface, displacement))
    }

    /// Its faults since then, a line each.
    #[must_use]
    pub fn faults(&self) -> Vec<String> {
        let mut faults = self.plugins.faults();
        faults.extend(self.script.iter().flat_map(Script::faults));
        faults
    }

    /// Warnings of a script's compiler.
    #[must_use]
    pub fn warnings(&self) -> &[String] {
        self.script.as_ref().map_or(&[], Script::warnings)
    }

    /// The script, if it is one.
    #[must_use]
    pub fn script(&self) -> Option<&Script> {
        self.script.as_ref()
    }

    /// The source files of a script, included ones too.
    #[must_use]
    pub fn files(&self) -> &[PathBuf] {
        self.script.as_ref().map_or(&[], Script::files)
    }

    fn built_in(name: &str, parameters: &[(String, String)]) -> Result<Self, String> {
        let is_surface = |class: &&classes::ShaderClass| class.kind == classes::Kind::Surface;
        let names: Vec<&str> =
            classes::ALL.iter().copied().filter(is_surface).map(|class| class.name).collect();
        let class = classes::find(name).filter(is_surface).ok_or_else(|| {
            let meant = suggestion(name, &names);
            format!(
                "unknown built-in surface class \"{name}\"; valid are: {}{meant}; one of a plugin is CLASS@FILE, one in the shading language FILE.osl",
                names.join(", ")
            )
        })?;
        let mut values = class.defaults();
        let described = Parameter::of_built_in(class);
        for (parameter, value) in parameters {
            let i = index_of(parameter, &described)?;
            let wrong = |why: String| format!("parameter '{parameter}': {why}");
            values.0[i] = match class.parameters[i].kind {
                ParameterType::Float => {
                    Value::Floats(numbers(&described[i], value, str::parse).map_err(wrong)?)
                }
                ParameterType::Int => {
                    Value::Int(numbers(&described[i], value, str::parse).map_err(wrong)?[0])
                }
                ParameterType::Texture => Value::Texture(Some(texture(value).map_err(wrong)?)),
            };
        }
        surface(class.make(&values)).map(|surface| Self {
            surface: Some(surface),
            displacement: None,
            plugins: PluginFrame::default(),
            script: None,
        })
    }

    fn of_plugin(name: &str, file: &Path, parameters: &[(String, String)]) -> Result<Self, String> {
        let class = Arc::new(load_copy(name, file).map_err(|why| why.to_string())?);
        if class.kind != Kind::Surface {
            return Err(format!("{} is of no surfaces", class.title()));
        }
        let described: Vec<Parameter> = class.parameters.iter().map(|p| p.description.clone()).collect();
        let (block, mut textures) = (PluginBlock::new(&class)?, BTreeMap::new());
        for (parameter, value) in parameters {
            let i = index_of(parameter, &described)?;
            let wrong = |why: String| format!("{}: parameter '{parameter}': {why}", class.title());
            match described[i].kind {
                DataType::Text => {
                    let text = CString::new(value.as_str());
                    block.write_text(i, &text.map_err(|_| wrong("it has a zero byte".to_owned()))?);
                }
                DataType::I32 if value.starts_with('@') => {
                    let id = textures.len() as u32 + 1;
                    textures.insert(id, texture(value).map_err(wrong)?);
                    block.write(i, &id.to_ne_bytes());
                }
                kind => {
                    let encode = |text: &str| kind.encode_text(text).ok_or(());
                    block.write(i, &numbers(&described[i], value, encode).map_err(wrong)?.concat());
                }
            }
        }
        let state = || FrameState { textures, ..FrameState::default() };
        let plugins = PluginFrame::new(std::iter::once((1, &block)), state);
        match plugins.made(1) {
            Some(made) => {
                let surface = Some(surface(made)?);
                Ok(Self { surface, displacement: None, plugins, script: None })
            }
            None => Err(plugins.problems().join("; ")),
        }
    }
}

fn surface(made: RenderShader) -> Result<Arc<dyn SurfaceShader>, String> {
    match made {
        RenderShader::Surface(surface) => Ok(surface),
        RenderShader::Environment(_)
        | RenderShader::Light(_)
        | RenderShader::Camera(_)
        | RenderShader::Pixel(_) => Err("it is of no surfaces".to_owned()),
    }
}

/// The number of the parameter of this name, if people can set it here.
fn index_of(name: &str, described: &[Parameter]) -> Result<usize, String> {
    let Some(i) = described.iter().position(|parameter| parameter.name == name) else {
        let names: Vec<&str> = described.iter().map(|parameter| &parameter.name[..]).collect();
        let list = if names.is_empty() {
            "it has none".to_owned()
        } else {
            format!("there are {}", names.join(", "))
        };
        return Err(format!("unknown parameter '{name}'; {list}{}", suggestion(name, &names)));
    };
    match described[i].rate {
        ParameterRate::Shader => Ok(i),
        ParameterRate::Vertex => {
            Err(format!("parameter '{name}' is one of vertices: the mesh has it, or none has"))
        }
        ParameterRate::Triangle => {
            Err(format!("parameter '{name}' is one of triangles: the mesh has it, or none has"))
        }
    }
}

/// The numbers of a parameter: one for each, or one for all.
fn numbers<T: Clone, E>(
    parameter: &Parameter,
    text: &str,
    parse: impl Fn(&str) -> Result<T, E>,
) -> Result<Vec<T>, String> {
    let wrong = || {
        let what = if parameter.kind.is_integer() { "whole number" } else { "number" };
        let plural = if parameter.count == 1 { "" } else { "s between commas" };
        format!("'{text}' is not {} {what}{plural}", parameter.count)
    };
    let one = |text: &str| parse(text.trim()).map_err(|_| wrong());
    let found = text.split(',').map(one).collect::<Result<Vec<T>, String>>()?;
    match &found[..] {
        [same] => Ok(vec![same.clone(); parameter.count]),
        _ if found.len() == parameter.count => Ok(found),
        _ => Err(wrong()),
    }
}

/// The texture of `@FILE`.
fn texture(value: &str) -> Result<Arc<TextureSampler>, String> {
    let file = value.strip_prefix('@').filter(|file| !file.is_empty());
    let file = file.ok_or_else(|| format!("'{value}' is not a texture; give @ and the name of a picture"))?;
    let texels = read_texture(Path::new(file)).map_err(|error| error.to_string())?;
    Ok(Arc::new(TextureSampler::new(Arc::new(texels))))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(class: &str, parameters: &[(&str, &str)]) -> String {
        let parameters: Vec<_> =
            parameters.iter().map(|(name, value)| (name.to_string(), value.to_string())).collect();
        SceneShader::new(class, None, &parameters, &Access::default()).err().expect("it is wrong")
    }

    #[test]
    fn what_is_wrong_is_said() {
        for (class, parameters, message) in [
            ("MateShader", &[][..], "did you mean \"MatteShader\"?"),
            ("PinholeCamera", &[], "unknown built-in surface class \"PinholeCamera\""),
            ("MatteShader", &[("colour", "1")], "unknown parameter 'colour'; there are"),
            ("MatteShader", &[("color", "1,2")], "'1,2' is not 3 numbers between commas"),
            ("MatteShader", &[("color", "red")], "'red' is not 3 numbers"),
            ("MatteShader", &[("texture", "wood.png")], "give @ and the name of a picture"),
            ("MatteShader", &[("texture", "@no/such.png")], "no/such.png"),
        ] {
            let found = refused(class, parameters);
            assert!(found.contains(message), "{class} {parameters:?}: {found}");
        }
    }

    #[test]
    fn files_that_are_no_plugins_are_told() {
        let folder = tempfile::Builder::new().prefix("plugins").tempdir().expect("a folder");
        let [broken, missing] = ["broken.so", "missing.so"].map(|name| folder.path().join(name));
        std::fs::write(&broken, "no library").expect("a file");
        for (file, name) in [(&broken, "broken.so"), (&missing, "missing.so")] {
            let found =
                SceneShader::new("x", Some(file), &[], &Access::default()).err().expect("it is wrong");
            assert!(found.contains(name) && !found.contains(".tmp"), "{found}");
        }
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! The shading language in a build without it: its names are known, and a request for a shader is an error that says how to get it.
//! Invariant: all names of `gnurt-sl-shading` that programs use are here with the same types, and there is never a [`Script`].
//! Tests: builds of the program without features (`cargo xtask ci`).

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use gnurt_image::{Texels, WorkingSpace};
use gnurt_shading::texture::TextureSampler;
use gnurt_shading::{
    CameraShader, DisplacementShader, EnvironmentShader, LightShader, PixelShader, SurfaceShader,
};

const ABSENT: &str = "this program was compiled without the shading language: `cargo run --release --features osl -- ...` compiles it; `cargo build --release` and `cargo xtask install` have it";

/// Where shaders may take files from.
#[derive(Clone, Debug, Default)]
pub struct Access {
    /// Only from below this folder; from anywhere if there is none.
    pub confined_to: Option<PathBuf>,
    /// Folders that `#include` searches after the shader's own.
    pub includes: Vec<String>,
    /// Source texts in memory, by their paths.
    pub texts: Arc<HashMap<PathBuf, String>>,
    /// Pictures in memory, by the names that shaders call them.
    pub pictures: Arc<HashMap<String, Arc<TextureSampler>>>,
    /// The space in which light is computed.
    pub space: WorkingSpace,
}

/// The kind of a script.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The appearance of a surface.
    Surface,
    /// The offsets of a surface's vertices.
    Displacement,
    /// A light.
    Light,
    /// A camera.
    Camera,
    /// Radiance of rays that hit nothing.
    Environment,
    /// The colour of a pixel.
    Pixel,
}

/// The value of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum ParameterValue {
    /// Numbers.
    Floats(Vec<f32>),
    /// Whole numbers.
    Ints(Vec<i32>),
    /// Texts.
    Texts(Vec<String>),
}

impl ParameterValue {
    /// Its numbers as floats; `None` of texts.
    #[must_use]
    pub fn numbers(&self) -> Option<Vec<f32>> {
        match self {
            Self::Floats(list) => Some(list.clone()),
            Self::Ints(list) => Some(list.iter().map(|&x| x as f32).collect()),
            Self::Texts(_) => None,
        }
    }
}

/// A parameter of a script.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// Its type as it is written.
    pub ty: String,
    /// Its default.
    pub default: ParameterValue,
    /// The label in user interfaces.
    pub label: String,
    /// The help text of the source.
    pub help: String,
    /// The least and the greatest value that is useful.
    pub range: Option<[f32; 2]>,
    /// The least change that is useful.
    pub step: Option<f32>,
    /// The widget in user interfaces.
    pub widget: String,
    /// The choices of `mapper` and `popup`.
    pub options: String,
    /// Whether it can be changed without compiling.
    pub is_tunable: bool,
    /// How often the mesh has one.
    pub rate: String,
    /// Whether the mesh may give it.
    pub is_of_mesh: bool,
}

/// Position and axes of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraFrame {
    /// Where it is.
    pub eye: [f32; 3],
    /// Unit, to the right.
    pub right: [f32; 3],
    /// Unit, upwards.
    pub up: [f32; 3],
    /// Unit, towards the viewer.
    pub back: [f32; 3],
    /// Pixels of the picture, across and down.
    pub pixels: [u32; 2],
}

#[derive(Clone, Debug)]
enum Never {}

/// A camera's shader without its frame: there is none.
#[derive(Clone, Debug)]
pub struct CameraScript(Never);

impl CameraScript {
    /// The camera with its frames.
    #[must_use]
    pub fn at(&self, _: &[CameraFrame]) -> Option<Arc<dyn CameraShader>> {
        match self.0 {}
    }
}

/// A compiled shader: there is none.
#[derive(Clone, Debug)]
pub struct Script(Never);

/// Methods that nothing can call.
macro_rules! never {
    ($($(#[$attribute:meta])* $name:ident($($argument:ty),*) $(-> $result:ty)?;)*) => {
        impl Script {
            $(
                $(#[$attribute])*
                pub fn $name(&self $(, _: $argument)*) $(-> $result)? {
                    match self.0 {}
                }
            )*
        }
    };
}

never! {
    /// Reads its files again.
    /// # Errors
    /// Never: there is no script.
    again() -> Result<Self, String>;
    /// Whether a parameter can be changed without compiling.
    is_tunable(&str) -> bool;
    /// Its kind.
    kind() -> Kind;
    /// Its name.
    name() -> &str;
    /// The shader's name.
    shader_name() -> &str;
    /// Its files.
    files() -> &[PathBuf];
    /// Warnings of its compiler.
    warnings() -> &[String];
    /// Faults when it ran.
    faults() -> Vec<String>;
    /// Its parameters.
    parameters() -> Vec<Parameter>;
    /// The same in another space.
    within(WorkingSpace) -> Self;
    /// As a surface.
    /// # Errors
    /// Never: there is no script.
    surface() -> Result<Arc<dyn SurfaceShader>, String>;
    /// As a displacement.
    /// # Errors
    /// Never: there is no script.
    displacement() -> Result<Option<Arc<dyn DisplacementShader>>, String>;
    /// As a light.
    /// # Errors
    /// Never: there is no script.
    light() -> Result<Arc<dyn LightShader>, String>;
    /// As a camera.
    /// # Errors
    /// Never: there is no script.
    camera_anywhere() -> Result<CameraScript, String>;
    /// As an environment.
    /// # Errors
    /// Never: there is no script.
    environment() -> Result<Arc<dyn EnvironmentShader>, String>;
    /// As the background of the scene.
    /// # Errors
    /// Never: there is no script.
    backdrop() -> Result<Option<Arc<dyn EnvironmentShader>>, String>;
    /// As a pixel shader.
    /// # Errors
    /// Never: there is no script.
    pixel() -> Result<Arc<dyn PixelShader>, String>;
}

impl Script {
    /// Reads and compiles a file.
    ///
    /// # Errors
    /// Always: the compiler is not there.
    pub fn open(path: &Path, _: &Access) -> Result<Self, String> {
        Err(format!("{}: {ABSENT}", path.display()))
    }

    /// Compiles a text.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn from_text(path: &Path, _: &str, access: &Access) -> Result<Self, String> {
        Self::open(path, access)
    }

    /// Gives a parameter a value.
    ///
    /// # Errors
    /// Never: there is no script.
    pub fn set(&mut self, _: &str, _: &ParameterValue) -> Result<(), String> {
        match self.0 {}
    }

    /// Gives a parameter a value, by text.
    ///
    /// # Errors
    /// Never: there is no script.
    pub fn set_text(&mut self, _: &str, _: &str) -> Result<(), String> {
        match self.0 {}
    }

    /// Lets parameters change without compiling.
    pub fn make_tunable(&mut self) {
        match self.0 {}
    }

    /// Changes a parameter without compiling.
    ///
    /// # Errors
    /// Never: there is no script.
    pub fn tune(&mut self, _: &str, _: &ParameterValue) -> Result<(), String> {
        match self.0 {}
    }
}

/// Whether a name is that of a shader of the library, and of no file.
#[must_use]
pub fn is_carried(path: &Path) -> bool {
    path.parent().is_some_and(|folder| folder == Path::new("builtin")) && !path.exists()
}

/// The file of a MaterialX document's name, and the node after it.
#[must_use]
pub fn document_and_node(name: &str) -> Option<(&str, Option<&str>)> {
    const END: &str = ".mtlx";
    if name.ends_with(END) {
        return Some((name, None));
    }
    let at = name.find(".mtlx:")? + END.len();
    let node = &name[at + 1..];
    (!node.is_empty()).then_some((&name[..at], Some(node)))
}

/// The materials that a document's shaders are for: the one that was asked for.
///
/// # Errors
/// Never.
pub fn shaders_by_material<'a>(
    shader: &str,
    material: &str,
    _: impl Iterator<Item = &'a str>,
    _: &Access,
) -> Result<Vec<(String, String)>, String> {
    Ok(vec![(material.to_owned(), shader.to_owned())])
}

/// The sampler of a picture in memory.
#[must_use]
pub fn sampler(texels: Arc<Texels>) -> TextureSampler {
    TextureSampler::new(texels)
}

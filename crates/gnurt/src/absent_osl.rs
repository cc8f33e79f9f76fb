// SPDX-License-Identifier: GPL-3.0-or-later
//! The shading language in a build without it: its names are known, and a request for a shader is an error that says how to get it.
//! Invariant: all names of `gnurt-sl-shading` that programs use are here with the same types, and there is never a [`Script`].
//! Tests: `tests`, and `cargo xtask ci`, which compiles the program without features.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use gnurt_image::WorkingSpace;
use gnurt_shading::script::{self, built_in_name};
pub use gnurt_shading::script::{CameraFrame, Kind, Parameter, ParameterValue, document_and_node, sampler};
use gnurt_shading::{
    CameraShader, DisplacementShader, EnvironmentShader, LightShader, PixelShader, SurfaceShader,
};

/// Where shaders may take files from.
pub type Access = script::Access;

/// The error of a request for the language; `arguments` are those of the program after its options, or an ellipsis.
#[must_use]
pub fn absent(arguments: &str) -> String {
    format!(
        "this program was compiled without the shading language: `cargo run --release --features osl -- {arguments}` \
         compiles it; `cargo build --release` and `cargo xtask install` have it"
    )
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
        Err(format!("{}: {}", path.display(), absent("...")))
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

/// Whether a name is that of a built-in shader, and of no file.
#[must_use]
pub fn is_carried(path: &Path) -> bool {
    built_in_name(path).is_some()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_request_is_an_error_with_a_remedy() {
        let access = Access::default();
        for path in ["builtin/wood.osl", "no/such.osl", "a.mtlx:gold"] {
            let opened = Script::open(path.as_ref(), &access).err();
            assert_eq!(opened, Script::from_text(path.as_ref(), "surface s () {}", &access).err(), "{path}");
            let why = opened.expect("there is no script");
            assert!(why.starts_with(path) && why.contains("--features osl -- ..."), "{why}");
            assert_eq!(why.lines().count(), 1, "{why}");
        }
        assert!(
            is_carried("builtin/wood.osl".as_ref()),
            "the name of a shader of the library is no missing file"
        );
        assert!(!is_carried("no/such.osl".as_ref()), "other files are missing");
    }

    #[test]
    fn materials_keep_their_shader() {
        let names = ["gold", "silver"].into_iter();
        let pairs = shaders_by_material("a.mtlx", "*", names, &Access::default());
        assert_eq!(pairs, Ok(vec![("*".to_owned(), "a.mtlx".to_owned())]), "as a file of one shader");
    }
}

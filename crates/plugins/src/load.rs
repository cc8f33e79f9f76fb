// SPDX-License-Identifier: GPL-3.0-or-later
//! From a class's name and a file to a checked class, or to a message about the fault.
//! Invariant: an accepted class has every guarantee of [`PluginClass`].
//! Tests: bindings/openrt/tests/plugins.rs: a plugin for each rule that it breaks.

use std::fmt::{Display, Formatter};
use std::path::Path;
use std::sync::Arc;

use gnurt::shading::classes::ParameterRate;

use crate::class::{Calls, PluginClass, PluginParameter};
use crate::data_type::DataType;
use crate::description::{Kind, Parameter};
use crate::ffi_library::{Library, ModuleReply, RawClass, RawParameter, classes, parameters};
use crate::ffi_rts::{Class, Module, RTS_ABI};
use crate::search::{PATH_VARIABLE, find};

/// Why a class cannot be had: a line for people.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LoadError {
    /// Something is not there.
    Missing(String),
    /// Something does not fit.
    Unfit(String),
}

impl std::error::Error for LoadError {}

impl Display for LoadError {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let (Self::Missing(text) | Self::Unfit(text)) = self;
        f.write_str(text)
    }
}

/// Limit of blocks and parameters: a plugin that requests more is broken.
const MAX_BLOCK: u32 = 1 << 24;
const MAX_ALIGN: u32 = 4096;
const MAX_PARAMETERS: u32 = 1 << 16;
/// Numbers of a parameter that varies.
const MAX_VARYING: u32 = 16;

/// Loads class `name` from `file`, which is searched.
pub fn load(name: &str, file: &str) -> Result<PluginClass, LoadError> {
    let folders = std::env::var(PATH_VARIABLE).unwrap_or_default();
    load_by(name, file, || find(file, &folders, Library::open))
}

/// Loads class `name` from the current library at `path`, regardless of earlier loads from there. It loads a
/// copy, because the system's loader returns an already loaded library of a name, and a mapped file must not
/// change.
///
/// The copy is in the folder of temporary files, or next to the library if no code may be loaded from there.
/// If neither is possible, the library itself is loaded; then a rebuilt library is not noticed.
pub(crate) fn load_copy(name: &str, path: &Path) -> Result<PluginClass, LoadError> {
    let beside = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let folders = [&std::env::temp_dir(), beside];
    load_by(name, &path.display().to_string(), || open_copy(path, &folders))
}

/// Opens a copy of a library in the first of these folders that allows that, or else the library itself.
fn open_copy(path: &Path, folders: &[&Path]) -> Result<Library, String> {
    let copy_in = |folder: &&Path| -> Option<Library> {
        let new = tempfile::Builder::new().prefix(".gnurt-").suffix(".so").tempfile_in(folder);
        let copy = new.ok()?.into_temp_path();
        std::fs::copy(path, &copy).ok()?;
        // Once the loader has it, its name may go.
        Library::open(&copy).ok()
    };
    folders
        .iter()
        .find_map(copy_in)
        .map_or_else(
            // A bare name is one that the loader would search elsewhere.
            || Library::open(&Path::new(".").join(path)),
            Ok,
        )
        .map_err(|why| format!("cannot load library \"{}\": {why}", path.display()))
}

/// Loads class `name` from the library that `open` gives; messages call it `file`.
fn load_by(
    name: &str,
    file: &str,
    open: impl FnOnce() -> Result<Library, String>,
) -> Result<PluginClass, LoadError> {
    let library = open().map_err(|why| LoadError::Missing(format!("{}: {why}", title(name))))?;
    let in_file = |text: String| format!("{}: library \"{file}\": {text}", title(name));
    let module = match library.module().map_err(|why| LoadError::Missing(in_file(why)))? {
        ModuleReply::Offers(module) => module,
        ModuleReply::Throws => {
            return Err(LoadError::Unfit(in_file("an exception left its rts_module".to_owned())));
        }
        ModuleReply::Refuses => {
            let text = format!("it does not work with version {} of the shader interface", version(RTS_ABI));
            return Err(LoadError::Unfit(in_file(text)));
        }
    };
    class_of(&module, name, file, &Arc::new(library))
}

/// The class of this name among those of a module, if it keeps the rules.
pub(crate) fn class_of(
    module: &Module,
    name: &str,
    file: &str,
    library: &Arc<Library>,
) -> Result<PluginClass, LoadError> {
    let in_file = |text: String| format!("{}: library \"{file}\": {text}", title(name));
    if module.abi >> 16 != RTS_ABI >> 16 {
        let (theirs, ours) = (version(module.abi), version(RTS_ABI));
        let text = format!("it is for version {theirs} of the shader interface, this libOpenRT has {ours}");
        return Err(LoadError::Unfit(in_file(text)));
    }
    if (module.struct_size as usize) < size_of_val(module) {
        let text = format!("RTSmodule has struct_size {}, not {}", module.struct_size, size_of_val(module));
        return Err(LoadError::Unfit(in_file(text)));
    }
    let classes = classes(module);
    let Some(found) = classes.iter().find(|class| class.name == name) else {
        return Err(LoadError::Missing(in_file(no_class(name, &classes))));
    };
    checked(found, file, library.clone()).map_err(|why| LoadError::Unfit(in_file(why)))
}

/// The name of a requested class in messages.
fn title(name: &str) -> String {
    format!("shader class \"{name}\"")
}

fn version(abi: u32) -> String {
    format!("{}.{}", abi >> 16, abi & 0xFFFF)
}

/// There is no class of this name: which there are, and which may be meant.
fn no_class(name: &str, classes: &[RawClass]) -> String {
    if classes.is_empty() {
        return "it has no classes".to_owned();
    }
    let names: Vec<&str> = classes.iter().map(|class| &class.name[..]).collect();
    format!("it has no such class; there are {}{}", names.join(", "), suggestion(name, &names))
}

/// "did you mean ...?" if a name is near.
#[must_use]
pub fn suggestion(name: &str, names: &[&str]) -> String {
    let near = names
        .iter()
        .map(|known| (strsim::damerau_levenshtein(&name.to_lowercase(), &known.to_lowercase()), known));
    match near.min() {
        Some((distance, known)) if distance <= name.len().max(known.len()) / 3 => {
            format!("; did you mean \"{known}\"?")
        }
        _ => String::new(),
    }
}

/// The class, if it keeps the rules.
fn checked(raw: &RawClass, file: &str, library: Arc<Library>) -> Result<PluginClass, String> {
    let class = &raw.class;
    let kind = checked_header(class)?;
    let mut checked = PluginClass {
        name: raw.name.clone(),
        file: file.to_owned(),
        kind,
        shader_size: class.shader_size as usize,
        shader_align: class.shader_align.max(16) as usize,
        parameters: Vec::new(),
        calls: Calls {
            init: class.init,
            fini: class.fini,
            prepare: class.prepare,
            shade: class.shade,
            transmit: class.transmit,
            miss: class.miss,
            illuminate: class.illuminate,
            camera: class.camera,
            camera_lens: class.camera_lens,
        },
        library,
    };
    for (i, p) in parameters(class).into_iter().enumerate() {
        let parameter = checked_parameter(class, kind, p).map_err(|why| format!("parameter {i}: {why}"))?;
        if checked.parameters.iter().any(|p| p.description.name == parameter.description.name) {
            return Err(format!("parameter {i}: there are two \"{}\"", parameter.description.name));
        }
        checked.parameters.push(parameter);
    }
    Ok(checked)
}

/// The part of a class before its parameters.
fn checked_header(class: &Class) -> Result<Kind, String> {
    if (class.struct_size as usize) < Class::LEAST {
        return Err(format!("RTSclass has struct_size {}, not {}", class.struct_size, size_of::<Class>()));
    }
    let (kind, has_callback, callback) = match class.kind {
        0x400 => (Kind::Surface, class.shade.is_some(), "shade"),
        0x401 => (Kind::Environment, class.miss.is_some(), "miss"),
        0x402 => (Kind::Light, class.illuminate.is_some(), "illuminate"),
        0x403 => (Kind::Camera, class.camera.is_some() || class.camera_lens.is_some(), "camera"),
        0x404 => {
            let text =
                "it is of kind RT_RENDERING_OBJECT, which plugins cannot be in this version of the interface";
            return Err(text.to_owned());
        }
        other => {
            return Err(format!(
                "its kind {other:#x} is invalid; valid are RT_SURFACE_SHADER to RT_CAMERA_SHADER"
            ));
        }
    };
    if !has_callback {
        return Err(format!("its callback `{callback}` is NULL, without which its kind does nothing"));
    }
    if class.flags != 0 {
        return Err(format!("its flags are {:#x}, not 0", class.flags));
    }
    let align = class.shader_align;
    if align > MAX_ALIGN || (align != 0 && !align.is_power_of_two()) {
        return Err(format!("its shader_align is {align}, not a power of two up to {MAX_ALIGN}, nor 0"));
    }
    let sizes = [class.shader_size, class.triangle_size, class.vertex_size];
    if sizes.iter().any(|&size| size > MAX_BLOCK) {
        return Err(format!("one of its blocks is too large: {sizes:?} bytes, at most {MAX_BLOCK}"));
    }
    if kind != Kind::Surface && (class.triangle_size != 0 || class.vertex_size != 0) {
        return Err("only surface classes have blocks per triangle and per vertex".to_owned());
    }
    if class.param_count > MAX_PARAMETERS || (class.param_count > 0 && class.params.is_null()) {
        return Err(format!("it declares {} parameters, but their table is missing", class.param_count));
    }
    Ok(kind)
}

fn checked_parameter(class: &Class, kind: Kind, p: RawParameter) -> Result<PluginParameter, String> {
    let name = p.name.filter(|name| !name.is_empty()).ok_or("it has no name")?;
    let fail = |text: String| Err(format!("\"{name}\": {text}"));
    let Some(data) = DataType::from_code(p.kind) else {
        return fail(format!("its type {:#x} is invalid for a parameter", p.kind));
    };
    let (rate, block) = match p.rate {
        0x500 => (ParameterRate::Shader, class.shader_size),
        0x501 => (ParameterRate::Vertex, class.vertex_size),
        0x502 => (ParameterRate::Triangle, class.triangle_size),
        other => {
            return fail(format!(
                "its rate {other:#x} is invalid; valid are RT_PER_SHADER, RT_PER_VERTEX, RT_PER_TRIANGLE"
            ));
        }
    };
    let varies = rate != ParameterRate::Shader;
    if varies && kind != Kind::Surface {
        return fail("only parameters of surfaces vary".to_owned());
    }
    if p.count == 0 || varies && p.count > MAX_VARYING || data == DataType::Text && p.count > 1 {
        return fail(format!("its count is {}", p.count));
    }
    if varies && data == DataType::Text {
        return fail("texts are per shader only".to_owned());
    }
    let end = u64::from(p.offset) + u64::from(p.count) * data.size() as u64;
    if end > u64::from(block) {
        return fail(format!("it ends at byte {end} of a block of {block}"));
    }
    let default = if varies { vec![0.0; p.count as usize] } else { Vec::new() };
    let description = Parameter { name, rate, kind: data, count: p.count as usize, default };
    Ok(PluginParameter { description, offset: p.offset as usize })
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;
    use std::process::Command;

    use super::*;

    #[test]
    fn near_names_are_suggested() {
        let names = ["sample", "mirror", "tiles"];
        assert_eq!(suggestion("smaple", &names), "; did you mean \"sample\"?", "two letters exchanged");
        assert_eq!(suggestion("Mirror", &names), "; did you mean \"mirror\"?", "another case");
        assert_eq!(suggestion("environment", &names), "", "nothing is near");
    }

    /// A plugin of the tests, in its own folder.
    fn built() -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("broken.so");
        let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../../bindings/openrt/");
        let status = Command::new("cc")
            .args(["-std=c99", "-DCASE=0", "-shared", "-fPIC", "-I"])
            .args([&format!("{root}include"), &format!("{root}tests/plugins/broken.c"), "-o"])
            .arg(&file)
            .status();
        assert!(status.is_ok_and(|status| status.success()), "the plugin is built");
        (folder, file)
    }

    #[test]
    fn folders_that_take_no_copy_are_passed_over() {
        let (folder, file) = built();
        for folders in [&[Path::new("/no/such/folder"), Path::new("/proc"), folder.path()][..], &[]] {
            assert!(open_copy(&file, folders).is_ok(), "with {folders:?}");
        }
        let left: Vec<_> = std::fs::read_dir(folder.path()).expect("it is there").collect();
        assert_eq!(left.len(), 1, "no copy is left: {left:?}");
    }

    /// In a folder that is mounted so that no code may be loaded from it, if the machine has one that we may write to.
    #[test]
    fn folders_without_leave_to_run_code_are_passed_over() {
        let (_folder, file) = built();
        let mounts = std::fs::read_to_string("/proc/mounts").unwrap_or_default();
        let mount_points = mounts.lines().filter_map(|line| {
            let mut words = line.split(' ').skip(1);
            let (candidate, _kind, options) = (words.next()?, words.next()?, words.next()?);
            options.split(',').any(|option| option == "noexec").then_some(candidate)
        });
        let writable = |candidate: &&str| tempfile::tempfile_in(candidate).is_ok();
        let Some(candidate) = mount_points.into_iter().find(writable) else {
            eprintln!("SKIPPED: no folder here is mounted noexec and may be written to");
            return;
        };
        let copy = tempfile::Builder::new().suffix(".so").tempfile_in(candidate).expect("it is writable");
        std::fs::copy(&file, copy.path()).expect("there is room");
        assert!(Library::open(copy.path()).is_err(), "{candidate} runs no code");
        assert!(open_copy(&file, &[Path::new(candidate)]).is_ok(), "the library is loaded all the same");
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Shared libraries of plugins: opening them and taking the one symbol that they export.
//! On libloading. Invariant: a library is closed when the last class of it is gone.
//! Tests: bindings/openrt/tests/plugins.rs.

use std::path::Path;

use crate::ffi_catch::{Runtime, Thrown};
use crate::ffi_rts::{Class, Module, ModuleFn, RTS_ABI, read_sized, text};

/// Name of the symbol.
const SYMBOL: &[u8] = b"rts_module\0";

/// An open library.
pub(crate) struct Library {
    library: libloading::Library,
    /// Ends exceptions that leave its functions.
    runtime: Runtime,
}

impl Library {
    /// Opens a library by its path, or by a bare name that the system's loader searches; all its symbols must
    /// be found, and none of them are visible to others.
    pub(crate) fn open(path: &Path) -> Result<Self, String> {
        // SAFETY: the library's constructors run: the program requested that.
        #[cfg(unix)]
        let opened = unsafe {
            use libloading::os::unix::{Library, RTLD_LOCAL, RTLD_NOW};
            Library::open(Some(path), RTLD_NOW | RTLD_LOCAL).map(Into::into)
        };
        // SAFETY: as above; other systems' loaders do so in any case.
        #[cfg(not(unix))]
        let opened = unsafe { libloading::Library::new(path) };
        let library = opened.map_err(|error| error.to_string())?;
        let runtime = Runtime::of(&library);
        Ok(Self { library, runtime })
    }

    /// The program itself, instead of a library.
    #[cfg(all(unix, any(test, fuzzing)))]
    pub(crate) fn this_program() -> Self {
        let library = libloading::os::unix::Library::this().into();
        let runtime = Runtime::default();
        Self { library, runtime }
    }

    /// Calls a function of it. An exception that leaves the function ends here.
    pub(crate) fn call(&self, work: impl FnOnce()) -> Result<(), Thrown> {
        self.runtime.call(work)
    }

    /// Its description; an error names the version of the request.
    pub(crate) fn module(&self) -> Result<ModuleReply, String> {
        // SAFETY: rts.h defines the type of the function of this name.
        let function = unsafe { self.library.get::<ModuleFn>(SYMBOL) }
            .map_err(|error| format!("it exports no function rts_module: {error}"))?;
        let mut module = std::ptr::null();
        // SAFETY: as rts.h says, it takes the host's version and returns NULL or a module.
        if self.call(|| module = unsafe { function(RTS_ABI) }).is_err() {
            return Ok(ModuleReply::Throws);
        }
        if module.is_null() {
            return Ok(ModuleReply::Refuses);
        }
        // SAFETY: it is not null, so it points to as many bytes as it says.
        Ok(ModuleReply::Offers(unsafe { read_sized(module) }))
    }
}

/// The result of rts_module.
pub(crate) enum ModuleReply {
    /// NULL: it cannot serve our version.
    Refuses,
    /// An exception left it.
    Throws,
    /// A module.
    Offers(Module),
}

/// A class as the plugin has it, and its name.
pub(crate) struct RawClass {
    pub(crate) name: String,
    pub(crate) class: Class,
}

/// The classes of a module that have a name; the others cannot be loaded.
pub(crate) fn classes(module: &Module) -> Vec<RawClass> {
    if module.classes.is_null() {
        return Vec::new();
    }
    let mut found = Vec::new();
    for i in 0..module.class_count as usize {
        // SAFETY: the module states that there are `class_count` pointers.
        let class = unsafe { module.classes.add(i).read_unaligned() };
        if class.is_null() {
            continue;
        }
        // SAFETY: it is not null, so it points to as many bytes as it says.
        let class: Class = unsafe { read_sized(class) };
        // SAFETY: a name that is not null is a text, as rts.h says.
        if let Some(name) = unsafe { text(class.name) } {
            found.push(RawClass { name: name.to_string_lossy().into_owned(), class });
        }
    }
    found
}

/// A parameter as the plugin describes it.
pub(crate) struct RawParameter {
    /// `None`: NULL.
    pub(crate) name: Option<String>,
    pub(crate) kind: u32,
    pub(crate) count: u32,
    pub(crate) rate: u32,
    pub(crate) offset: u32,
}

/// The parameters of a class; none if the pointer is null.
pub(crate) fn parameters(class: &Class) -> Vec<RawParameter> {
    if class.params.is_null() {
        return Vec::new();
    }
    let parameter = |i: u32| {
        // SAFETY: the class states that there are `param_count` of them.
        let p = unsafe { class.params.add(i as usize).read_unaligned() };
        // SAFETY: a name that is not null is a text, as rts.h says.
        let name = unsafe { text(p.name) }.map(|name| name.to_string_lossy().into_owned());
        RawParameter { name, kind: p.kind, count: p.count, rate: p.rate, offset: p.offset }
    };
    (0..class.param_count).map(parameter).collect()
}

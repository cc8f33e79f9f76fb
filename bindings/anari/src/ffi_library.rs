// SPDX-License-Identifier: GPL-3.0-or-later
//! The library's entry, and the library as ANARI's loader knows it.
//! Loaders before version 0.15 expect another table of functions. The exports of its file identify one: `anariLoadLibrary` without
//! `anariNewInitializedDevice`. Programs that have the loader within them export neither and get the newer table.
//! Tests: tests/introspection.rs.

use std::ffi::{c_char, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::ffi_abi::{Address, Library, LibraryTable, OldLibraryTable, ParameterValue, Strings, TableHead};
use crate::ffi_device::{self, text};
use crate::ffi_introspection::extensions;

static TABLE: LibraryTable = LibraryTable {
    head: TableHead { offset: 0, type_info: 0 },
    destroy,
    delete,
    new_device,
    new_initialized_device,
    device_extensions,
    device_subtypes,
    load_module,
    unload_module: load_module,
};

static OLD_TABLE: OldLibraryTable = OldLibraryTable {
    head: TableHead { offset: 0, type_info: 0 },
    destroy,
    delete,
    new_device,
    device_extensions,
    device_subtypes,
    load_module,
    unload_module: load_module,
};

/// Whether the function that called our entry is in a file of an old loader.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
fn caller_is_old() -> bool {
    use std::ffi::CStr;
    /// The file that has an address, by where it begins and its name.
    fn file(address: *const c_void) -> Option<(*mut c_void, *const c_char)> {
        // SAFETY: all zero is a value of it, and dladdr fills it.
        let mut info: libc::Dl_info = unsafe { std::mem::zeroed() };
        // SAFETY: any address may be asked about.
        let found = unsafe { libc::dladdr(address, &raw mut info) };
        (found != 0).then_some((info.dli_fbase, info.dli_fname))
    }
    let Some((own, _)) = file(caller_is_old as *const c_void) else { return false };
    let mut frames = [std::ptr::null_mut::<c_void>(); 32];
    // SAFETY: the length passed is that of `frames`.
    let count = unsafe { libc::backtrace(frames.as_mut_ptr(), frames.len() as i32) };
    let foreign =
        frames.iter().take(count.max(0) as usize).filter_map(|&frame| file(frame)).find(|it| it.0 != own);
    let Some((_, name)) = foreign.filter(|(_, name)| !name.is_null()) else { return false };
    // SAFETY: the name is that of a file that is loaded; this call loads nothing.
    let loaded = unsafe { libc::dlopen(name, libc::RTLD_LAZY | libc::RTLD_NOLOAD) };
    if loaded.is_null() {
        return false;
    }
    let has = |symbol: &CStr| {
        // SAFETY: the handle is good until it is closed below.
        let found = unsafe { libc::dlsym(loaded, symbol.as_ptr()) };
        // Of its own, not of one that it depends on.
        !found.is_null() && file(found).is_some_and(|it| foreign.is_some_and(|caller| caller.0 == it.0))
    };
    let is_old = has(c"anariLoadLibrary") && !has(c"anariNewInitializedDevice");
    // SAFETY: opened above.
    unsafe { libc::dlclose(loaded) };
    is_old
}

#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
fn caller_is_old() -> bool {
    false
}

/// The entry: a new library, which ANARI's loader calls with its handle and the program's function for messages.
///
/// # Safety
/// `status_function` is null or an `ANARIStatusCallback`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn anari_library_gnurt_new_library(
    handle: *mut c_void,
    status_function: usize,
    status_user: *const c_void,
) -> *mut Library {
    let is_old = catch_unwind(caller_is_old).unwrap_or(false);
    let table = if is_old { (&raw const OLD_TABLE).cast::<u8>() } else { (&raw const TABLE).cast::<u8>() };
    let table = table.wrapping_add(size_of::<TableHead>()).cast_mut().cast();
    Box::into_raw(Box::new(Library { table, handle, status_function, status_user }))
}

unsafe extern "C" fn destroy(_: *mut Library) {}

unsafe extern "C" fn delete(this: *mut Library) {
    if !this.is_null() {
        // SAFETY: the loader gives up a library that the entry has made.
        drop(unsafe { Box::from_raw(this) });
    }
}

unsafe extern "C" fn new_device(this: *mut Library, _subtype: *const c_char) -> Address {
    // SAFETY: the loader gives one of our libraries.
    let Some(library) = (unsafe { this.as_ref() }) else { return std::ptr::null_mut() };
    let make = || ffi_device::new(library.status_function, library.status_user) as usize;
    catch_unwind(AssertUnwindSafe(make)).unwrap_or(0) as Address
}

unsafe extern "C" fn new_initialized_device(
    this: *mut Library,
    subtype: *const c_char,
    parameters: *const ParameterValue,
) -> Address {
    // SAFETY: the loader gives one of our libraries.
    let device = unsafe { new_device(this, subtype) };
    let mut next = parameters;
    // SAFETY: the list ends with a parameter without a name; values are as the program promises.
    unsafe {
        while !device.is_null() && !next.is_null() && !(*next).name.is_null() {
            ffi_device::initialize(device, &text((*next).name), (*next).kind, (*next).value);
            next = next.add(1);
        }
        ffi_device::commit(device);
    }
    device
}

unsafe extern "C" fn device_extensions(_: *mut Library, _: *const c_char) -> Strings {
    catch_unwind(extensions).unwrap_or(0) as Strings
}

unsafe extern "C" fn device_subtypes(_: *mut Library) -> Strings {
    /// Two names of one device: programs ask for `default` by default.
    struct Names([*const c_char; 3]);
    // SAFETY: they are never written.
    unsafe impl Sync for Names {}
    static NAMES: Names = Names([c"default".as_ptr(), c"gnurt".as_ptr(), std::ptr::null()]);
    NAMES.0.as_ptr()
}

unsafe extern "C" fn load_module(_: *mut Library, _: *const c_char) {}

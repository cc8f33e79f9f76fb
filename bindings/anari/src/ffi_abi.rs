// SPDX-License-Identifier: GPL-3.0-or-later
//! Layouts of libraries and devices as ANARI's loader knows them: a table of functions, and the fields after it.
//! Source: the public headers `anari/backend/{LibraryImpl,DeviceImpl}.h` of the ANARI SDK 0.14 to 0.17, whose facts are restated. Both
//! are C++ classes with virtual functions, in the order of the C++ ABI of Unix systems. The object begins with the address of its table.
//! The table follows an offset of 0 and a type (none here: callers never read it).
//! Differs between versions: tables of libraries before 0.15 lack `newInitializedDevice`. Tests: tests/introspection.rs.

use std::ffi::{c_char, c_int, c_void};

use crate::ffi_array::MemoryDeleter;
use crate::types::DataType;

/// Any address.
pub(crate) type Address = *mut c_void;
/// A list of strings, ended by null.
pub(crate) type Strings = *const *const c_char;

/// The fields before the functions of a table.
#[repr(C)]
pub(crate) struct TableHead {
    pub(crate) offset: isize,
    pub(crate) type_info: usize,
}

/// Functions of a library.
#[repr(C)]
pub(crate) struct LibraryTable {
    pub(crate) head: TableHead,
    pub(crate) destroy: unsafe extern "C" fn(*mut Library),
    pub(crate) delete: unsafe extern "C" fn(*mut Library),
    pub(crate) new_device: unsafe extern "C" fn(*mut Library, *const c_char) -> Address,
    pub(crate) new_initialized_device:
        unsafe extern "C" fn(*mut Library, *const c_char, *const ParameterValue) -> Address,
    pub(crate) device_extensions: unsafe extern "C" fn(*mut Library, *const c_char) -> Strings,
    pub(crate) device_subtypes: unsafe extern "C" fn(*mut Library) -> Strings,
    pub(crate) load_module: unsafe extern "C" fn(*mut Library, *const c_char),
    pub(crate) unload_module: unsafe extern "C" fn(*mut Library, *const c_char),
}

/// The same before version 0.15.
#[repr(C)]
pub(crate) struct OldLibraryTable {
    pub(crate) head: TableHead,
    pub(crate) destroy: unsafe extern "C" fn(*mut Library),
    pub(crate) delete: unsafe extern "C" fn(*mut Library),
    pub(crate) new_device: unsafe extern "C" fn(*mut Library, *const c_char) -> Address,
    pub(crate) device_extensions: unsafe extern "C" fn(*mut Library, *const c_char) -> Strings,
    pub(crate) device_subtypes: unsafe extern "C" fn(*mut Library) -> Strings,
    pub(crate) load_module: unsafe extern "C" fn(*mut Library, *const c_char),
    pub(crate) unload_module: unsafe extern "C" fn(*mut Library, *const c_char),
}

/// A library.
#[repr(C)]
pub struct Library {
    pub(crate) table: Address,
    /// That of the system's loader.
    pub(crate) handle: Address,
    pub(crate) status_function: usize,
    pub(crate) status_user: *const c_void,
}

/// `ANARIParameterValue`.
#[repr(C)]
pub(crate) struct ParameterValue {
    pub(crate) name: *const c_char,
    pub(crate) kind: DataType,
    pub(crate) value: *const c_void,
}

/// `ANARIParameter`.
#[repr(C)]
pub(crate) struct ParameterName {
    pub(crate) name: *const c_char,
    pub(crate) kind: DataType,
}

/// A device as the loader sees it; ours go on behind.
#[repr(C)]
pub(crate) struct DeviceHead {
    pub(crate) table: *const c_void,
    pub(crate) status_function: usize,
    pub(crate) status_user: *const c_void,
}

type This = *mut DeviceHead;
type New = unsafe extern "C" fn(This) -> Address;
type NewOf = unsafe extern "C" fn(This, *const c_char) -> Address;
type OfObject = unsafe extern "C" fn(This, Address);

/// Functions of a device, in order.
#[repr(C)]
pub(crate) struct DeviceTable {
    pub(crate) head: TableHead,
    pub(crate) new_array_1d: unsafe extern "C" fn(
        This,
        *const c_void,
        Option<MemoryDeleter>,
        *const c_void,
        DataType,
        u64,
    ) -> Address,
    pub(crate) new_array_2d: unsafe extern "C" fn(
        This,
        *const c_void,
        Option<MemoryDeleter>,
        *const c_void,
        DataType,
        u64,
        u64,
    ) -> Address,
    pub(crate) new_array_3d: unsafe extern "C" fn(
        This,
        *const c_void,
        Option<MemoryDeleter>,
        *const c_void,
        DataType,
        u64,
        u64,
        u64,
    ) -> Address,
    pub(crate) new_geometry: NewOf,
    pub(crate) new_material: NewOf,
    pub(crate) new_sampler: NewOf,
    pub(crate) new_surface: New,
    pub(crate) new_spatial_field: NewOf,
    pub(crate) new_volume: NewOf,
    pub(crate) new_light: NewOf,
    pub(crate) new_group: New,
    pub(crate) new_instance: NewOf,
    pub(crate) new_world: New,
    pub(crate) new_camera: NewOf,
    pub(crate) new_renderer: NewOf,
    pub(crate) new_frame: New,
    pub(crate) set_parameter: unsafe extern "C" fn(This, Address, *const c_char, DataType, *const c_void),
    pub(crate) unset_parameter: unsafe extern "C" fn(This, Address, *const c_char),
    pub(crate) unset_all_parameters: OfObject,
    pub(crate) map_parameter_array_1d:
        unsafe extern "C" fn(This, Address, *const c_char, DataType, u64, *mut u64) -> Address,
    pub(crate) map_parameter_array_2d:
        unsafe extern "C" fn(This, Address, *const c_char, DataType, u64, u64, *mut u64) -> Address,
    pub(crate) map_parameter_array_3d:
        unsafe extern "C" fn(This, Address, *const c_char, DataType, u64, u64, u64, *mut u64) -> Address,
    pub(crate) unmap_parameter_array: unsafe extern "C" fn(This, Address, *const c_char),
    pub(crate) commit_parameters: OfObject,
    pub(crate) release: OfObject,
    pub(crate) retain: OfObject,
    pub(crate) map_array: unsafe extern "C" fn(This, Address) -> Address,
    pub(crate) unmap_array: OfObject,
    pub(crate) get_property:
        unsafe extern "C" fn(This, Address, *const c_char, DataType, *mut c_void, u64, u32) -> c_int,
    pub(crate) object_subtypes: unsafe extern "C" fn(This, DataType) -> Strings,
    pub(crate) object_info:
        unsafe extern "C" fn(This, DataType, *const c_char, *const c_char, DataType) -> *const c_void,
    pub(crate) parameter_info: unsafe extern "C" fn(
        This,
        DataType,
        *const c_char,
        *const c_char,
        DataType,
        *const c_char,
        DataType,
    ) -> *const c_void,
    pub(crate) map_frame: unsafe extern "C" fn(
        This,
        Address,
        *const c_char,
        *mut u32,
        *mut u32,
        *mut DataType,
    ) -> *const c_void,
    pub(crate) unmap_frame: unsafe extern "C" fn(This, Address, *const c_char),
    pub(crate) render_frame: OfObject,
    pub(crate) frame_ready: unsafe extern "C" fn(This, Address, u32) -> c_int,
    pub(crate) discard_frame: OfObject,
    pub(crate) new_object: unsafe extern "C" fn(This, *const c_char, *const c_char) -> Address,
    pub(crate) proc_address: unsafe extern "C" fn(This, *const c_char) -> Address,
    pub(crate) destroy: unsafe extern "C" fn(This),
    pub(crate) delete: unsafe extern "C" fn(This),
}

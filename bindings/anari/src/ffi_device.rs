// SPDX-License-Identifier: GPL-3.0-or-later
//! Devices of the program: their table of functions, their life, and each function's use of pointers.
//! No panic crosses to the program. Tests: tests/{lifetimes,wrong,introspection}.rs.

use std::ffi::{CStr, c_char, c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::device::Device;
use crate::ffi_abi::{Address, DeviceHead, DeviceTable, Strings, TableHead};
use crate::ffi_array::{Array, Given, MemoryDeleter};
use crate::ffi_frame;
use crate::ffi_introspection as introspection;
use crate::ffi_properties::property;
use crate::ffi_status::{Code, Reporter, Severity};
use crate::frame::Frame;
use crate::object::{Object, Value};
use crate::types::{self, DataType};

type This = *mut DeviceHead;

/// A device of the program.
#[repr(C)]
struct DeviceBox {
    head: DeviceHead,
    /// How often the program holds it.
    count: AtomicUsize,
    device: Option<Arc<Device>>,
}

static TABLE: DeviceTable = DeviceTable {
    head: TableHead { offset: 0, type_info: 0 },
    new_array_1d,
    new_array_2d,
    new_array_3d,
    new_geometry,
    new_material,
    new_sampler,
    new_surface,
    new_spatial_field,
    new_volume,
    new_light,
    new_group,
    new_instance,
    new_world,
    new_camera,
    new_renderer,
    new_frame,
    set_parameter,
    unset_parameter,
    unset_all_parameters,
    map_parameter_array_1d,
    map_parameter_array_2d,
    map_parameter_array_3d,
    unmap_parameter_array,
    commit_parameters,
    release,
    retain,
    map_array,
    unmap_array,
    get_property,
    object_subtypes,
    object_info,
    parameter_info,
    map_frame,
    unmap_frame,
    render_frame,
    frame_ready,
    discard_frame,
    new_object,
    proc_address,
    destroy: delete,
    delete,
};

/// A new device, held once; its messages go to this function at first, given by its address.
pub(crate) fn new(function: usize, user: *const c_void) -> Address {
    let table = (&raw const TABLE).cast::<u8>();
    let table = table.wrapping_add(size_of::<TableHead>()).cast::<c_void>();
    let head = DeviceHead { table, status_function: function, status_user: user };
    let made = Box::into_raw(Box::new(DeviceBox { head, count: AtomicUsize::new(1), device: None }));
    let reporter = Reporter::new(made as usize, None, user);
    reporter.listen(function, user as usize);
    let device = Arc::new(Device::new(made as usize, reporter, [function, user as usize]));
    // SAFETY: the box was made just now, and no other thread has its address.
    unsafe { (*made).device = Some(device) };
    made.cast()
}

/// The device of a call's first argument.
///
/// # Safety
/// It must be a device that [`new`] has given and that was not deleted.
unsafe fn device<'a>(this: This) -> Option<&'a Arc<Device>> {
    // SAFETY: the caller's promise; the box begins with the head.
    unsafe { this.cast::<DeviceBox>().as_ref() }?.device.as_ref()
}

/// Calls `work` with the device; a panic is reported and gives `R`'s default.
///
/// # Safety
/// As [`device`].
unsafe fn guarded<R: Default>(this: This, work: impl FnOnce(&Arc<Device>) -> R) -> R {
    // SAFETY: the caller's promise.
    let Some(device) = (unsafe { device(this) }) else { return R::default() };
    match catch_unwind(AssertUnwindSafe(|| work(device))) {
        Ok(result) => result,
        Err(_) => {
            let text = "the call failed: a fault of GNU RT";
            let tell = || device.reporter.send(None, Severity::Fatal, Code::Unknown, text);
            drop(catch_unwind(AssertUnwindSafe(tell)));
            R::default()
        }
    }
}

/// An address that is null by default.
struct Found(Address);

impl Default for Found {
    fn default() -> Self {
        Self(std::ptr::null_mut())
    }
}

/// The string at an address; empty for null.
///
/// # Safety
/// It must be null or a string that ends with a zero byte.
pub(crate) unsafe fn text(address: *const c_char) -> String {
    if address.is_null() {
        return String::new();
    }
    // SAFETY: the caller's promise.
    unsafe { CStr::from_ptr(address) }.to_string_lossy().into_owned()
}

fn handle(object: Address) -> usize {
    object as usize
}

// --- arrays ---

fn new_array(
    device: &Arc<Device>,
    kind: DataType,
    element: DataType,
    dims: [u64; 3],
    given: &Given,
) -> Found {
    match Array::new(element, dims, given) {
        Ok(array) => {
            let handle = device.add(kind, "", Box::new(array));
            if let Some(object) = device.object(handle, "new array") {
                device.resolve(&object);
            }
            Found(handle as Address)
        }
        Err(fault) => {
            device.reporter.send(None, Severity::Error, Code::Memory, &format!("new array: {fault}"));
            Found::default()
        }
    }
}

macro_rules! new_arrays {
    ($($name:ident, $kind:ident, ($($n:ident),*), $dims:expr;)*) => {$(
        unsafe extern "C" fn $name(
            this: This,
            memory: *const c_void,
            deleter: Option<MemoryDeleter>,
            user: *const c_void,
            element: DataType,
            $($n: u64),*
        ) -> Address {
            let given = Given { memory, deleter, user };
            // SAFETY: the loader gives one of our devices.
            unsafe { guarded(this, |device| new_array(device, types::$kind, element, $dims, &given)) }.0
        }
    )*};
}

new_arrays! {
    new_array_1d, ARRAY1D, (a), [a, 1, 1];
    new_array_2d, ARRAY2D, (a, b), [a, b, 1];
    new_array_3d, ARRAY3D, (a, b, c), [a, b, c];
}

unsafe extern "C" fn map_array(this: This, object: Address) -> Address {
    // SAFETY: the loader gives one of our devices.
    unsafe {
        guarded(this, |device| {
            let object = device.object(handle(object), "map array");
            Found(object.as_deref().and_then(Array::of).map_or(std::ptr::null_mut(), Array::address))
        })
    }
    .0
}

fn unmapped(device: &Device, object: &Object) {
    if let Some(array) = Array::of(object) {
        array.touch();
        device.resolve(object);
    }
}

unsafe extern "C" fn unmap_array(this: This, object: Address) {
    // SAFETY: the loader gives one of our devices.
    unsafe {
        guarded(this, |device| {
            if let Some(object) = device.object(handle(object), "unmap array") {
                unmapped(device, &object);
            }
        });
    }
}

// --- objects ---

macro_rules! new_objects {
    ($($name:ident, $kind:ident;)*) => {$(
        unsafe extern "C" fn $name(this: This) -> Address {
            // SAFETY: the loader gives one of our devices.
            unsafe { guarded(this, |device| Found(device.add(types::$kind, "", Box::new(())) as Address)) }.0
        }
    )*};
}

new_objects! {
    new_surface, SURFACE;
    new_group, GROUP;
    new_world, WORLD;
}

macro_rules! new_objects_of {
    ($($name:ident, $kind:ident;)*) => {$(
        unsafe extern "C" fn $name(this: This, subtype: *const c_char) -> Address {
            // SAFETY: the loader gives one of our devices, and the program a string.
            unsafe {
                let subtype = text(subtype);
                guarded(this, |device| Found(device.add(types::$kind, &subtype, Box::new(())) as Address)).0
            }
        }
    )*};
}

new_objects_of! {
    new_geometry, GEOMETRY;
    new_material, MATERIAL;
    new_sampler, SAMPLER;
    new_spatial_field, SPATIAL_FIELD;
    new_volume, VOLUME;
    new_light, LIGHT;
    new_instance, INSTANCE;
    new_camera, CAMERA;
    new_renderer, RENDERER;
}

unsafe extern "C" fn new_frame(this: This) -> Address {
    let frame = || Box::new(Frame::default());
    // SAFETY: the loader gives one of our devices.
    unsafe { guarded(this, |device| Found(device.add(types::FRAME, "", frame()) as Address)) }.0
}

unsafe extern "C" fn new_object(this: This, kind: *const c_char, subtype: *const c_char) -> Address {
    // SAFETY: the loader gives one of our devices, and the program strings.
    unsafe {
        let (kind, subtype) = (text(kind), text(subtype));
        guarded(this, |device| {
            device.say(Severity::Error, &format!("new object '{kind}' '{subtype}': unknown"));
        });
    }
    std::ptr::null_mut()
}

unsafe extern "C" fn proc_address(_: This, _: *const c_char) -> Address {
    std::ptr::null_mut()
}

// --- parameters ---

/// The value of a parameter as it was given; `None` and a message where it is none.
///
/// # Safety
/// `memory` holds a value of the type, or is a string or a pointer itself.
unsafe fn value(
    device: &Device,
    object: &Object,
    name: &str,
    kind: DataType,
    memory: *const c_void,
) -> Option<Value> {
    if kind == types::STRING {
        // SAFETY: the caller's promise.
        return Some(Value::Text(unsafe { text(memory.cast()) }.into()));
    }
    if kind == types::VOID_POINTER {
        return Some(Value::Plain(kind, (memory as usize).to_ne_bytes().into()));
    }
    let size = types::size(kind).filter(|_| !memory.is_null());
    let Some(size) = size else {
        let text = format!("parameter '{name}': type {}: invalid, or no value", types::name(kind));
        device.reporter.send(Some(object), Severity::Error, Code::Argument, &text);
        return None;
    };
    // SAFETY: the caller's promise.
    let bytes = unsafe { std::slice::from_raw_parts(memory.cast::<u8>(), size) };
    if types::is_object(kind) {
        let handle = usize::from_ne_bytes(bytes.try_into().ok()?);
        return device.value(object, name, handle);
    }
    Some(Value::Plain(kind, bytes.into()))
}

unsafe extern "C" fn set_parameter(
    this: This,
    object: Address,
    name: *const c_char,
    kind: DataType,
    memory: *const c_void,
) {
    // SAFETY: the loader gives one of our devices; name and value are as the program promises.
    unsafe {
        let name = text(name);
        guarded(this, |device| {
            if handle(object) == device.handle {
                if let Some(value) = value(device, &device.own, &name, kind, memory) {
                    device.set(&device.own, &name, value);
                }
                return;
            }
            let Some(object) = device.object(handle(object), "set parameter") else { return };
            if types::is_object(kind) && (memory.is_null() || memory.cast::<usize>().read_unaligned() == 0) {
                object.unstage(Some(&name));
            } else if let Some(value) = value(device, &object, &name, kind, memory) {
                device.set(&object, &name, value);
            }
        });
    }
}

/// The object of a handle, or the device's own.
fn target<R>(
    device: &Arc<Device>,
    object: Address,
    call: &str,
    work: impl FnOnce(&Object) -> R,
) -> Option<R> {
    if handle(object) == device.handle {
        return Some(work(&device.own));
    }
    device.object(handle(object), call).map(|object| work(&object))
}

unsafe extern "C" fn unset_parameter(this: This, object: Address, name: *const c_char) {
    // SAFETY: the loader gives one of our devices, and the program a string.
    unsafe {
        let name = text(name);
        guarded(this, |device| {
            target(device, object, "unset parameter", |object| object.unstage(Some(&name)));
        });
    }
}

unsafe extern "C" fn unset_all_parameters(this: This, object: Address) {
    // SAFETY: the loader gives one of our devices.
    unsafe {
        guarded(this, |device| {
            target(device, object, "unset all parameters", |object| object.unstage(None));
        });
    }
}

unsafe extern "C" fn commit_parameters(this: This, object: Address) {
    // SAFETY: the loader gives one of our devices.
    unsafe {
        guarded(this, |device| {
            if handle(object) == device.handle {
                device.commit_own();
            } else if let Some(object) = device.object(handle(object), "commit parameters") {
                device.commit(&object);
            }
        });
    }
}

fn map_parameter(
    device: &Arc<Device>,
    object: Address,
    name: &str,
    (kind, element): (DataType, DataType),
    dims: [u64; 3],
) -> Found {
    let Some(object) = device.object(handle(object), "map parameter array") else { return Found::default() };
    let given = Given { memory: std::ptr::null(), deleter: None, user: std::ptr::null() };
    let Found(array) = new_array(device, kind, element, dims, &given);
    let Some(value) = device.value(&object, name, handle(array)).filter(|_| !array.is_null()) else {
        return Found::default();
    };
    let address = match &value {
        Value::Object(array) => Array::of(array).map_or(std::ptr::null_mut(), Array::address),
        _ => std::ptr::null_mut(),
    };
    // The parameter alone holds it, whatever its type.
    object.stage(name, value);
    drop(device.release(handle(array)));
    Found(address)
}

macro_rules! map_parameters {
    ($($name:ident, $kind:ident, ($($n:ident),*), $dims:expr;)*) => {$(
        unsafe extern "C" fn $name(
            this: This,
            object: Address,
            name: *const c_char,
            element: DataType,
            $($n: u64,)*
            stride: *mut u64,
        ) -> Address {
            // SAFETY: the loader gives one of our devices; name and stride are the program's.
            unsafe {
                let name = text(name);
                if !stride.is_null() {
                    *stride = types::size(element).unwrap_or(0) as u64;
                }
                guarded(this, |device| map_parameter(device, object, &name, (types::$kind, element), $dims)).0
            }
        }
    )*};
}

map_parameters! {
    map_parameter_array_1d, ARRAY1D, (a), [a, 1, 1];
    map_parameter_array_2d, ARRAY2D, (a, b), [a, b, 1];
    map_parameter_array_3d, ARRAY3D, (a, b, c), [a, b, c];
}

unsafe extern "C" fn unmap_parameter_array(this: This, object: Address, name: *const c_char) {
    // SAFETY: the loader gives one of our devices, and the program a string.
    unsafe {
        let name = text(name);
        guarded(this, |device| {
            let object = device.object(handle(object), "unmap parameter array");
            if let Some(Value::Object(array)) = object.and_then(|object| object.staged(&name)) {
                unmapped(device, &array);
            }
        });
    }
}

// --- life ---

unsafe extern "C" fn retain(this: This, object: Address) {
    if object.cast() == this {
        // SAFETY: the loader gives one of our devices.
        if let Some(own) = unsafe { this.cast::<DeviceBox>().as_ref() } {
            own.count.fetch_add(1, Ordering::Relaxed);
        }
        return;
    }
    // SAFETY: the loader gives one of our devices.
    unsafe { guarded(this, |device| device.retain(handle(object))) };
}

unsafe extern "C" fn release(this: This, object: Address) {
    if object.is_null() {
        return;
    }
    if object.cast() == this {
        // SAFETY: the loader gives one of our devices.
        let last = unsafe { this.cast::<DeviceBox>().as_ref() }
            .is_some_and(|own| own.count.fetch_sub(1, Ordering::AcqRel) == 1);
        if last {
            // SAFETY: the count is zero, so no holder is left.
            unsafe { delete(this) };
        }
        return;
    }
    // SAFETY: the loader gives one of our devices.
    unsafe {
        guarded(this, |device| {
            let gone = device.release(handle(object));
            if let Some(frame) = gone.as_deref().and_then(Frame::of) {
                frame.discard();
            }
        });
    }
}

unsafe extern "C" fn delete(this: This) {
    if this.is_null() {
        return;
    }
    let work = || {
        // SAFETY: the program gives up a device that `new` has made.
        let mut own = unsafe { Box::from_raw(this.cast::<DeviceBox>()) };
        let Some(device) = own.device.take() else { return };
        let left = device.all();
        left.iter().filter_map(|object| Frame::of(object)).for_each(Frame::discard);
        device.wait();
        if !left.is_empty() {
            let names: Vec<String> = left.iter().take(8).map(|object| object.label()).collect();
            let text = format!("{} objects were not released: {} ...", left.len(), names.join(", "));
            device.reporter.send(None, Severity::Warning, Code::None, &text);
        }
        drop(left);
        device.forget_all();
    };
    drop(catch_unwind(AssertUnwindSafe(work)));
}

// --- properties and introspection ---

unsafe extern "C" fn get_property(
    this: This,
    object: Address,
    name: *const c_char,
    kind: DataType,
    memory: *mut c_void,
    size: u64,
    mask: u32,
) -> c_int {
    // SAFETY: the loader gives one of our devices; the program promises `size` bytes at `memory`.
    unsafe {
        let name = text(name);
        guarded(this, |device| {
            let found = target(device, object, "get property", |object| {
                property(device, object, &name, kind, mask != 0)
            });
            let Some(bytes) = found.flatten().filter(|bytes| !memory.is_null() && bytes.len() as u64 <= size)
            else {
                return 0;
            };
            std::ptr::copy_nonoverlapping(bytes.as_ptr(), memory.cast::<u8>(), bytes.len());
            1
        })
    }
}

unsafe extern "C" fn object_subtypes(_: This, kind: DataType) -> Strings {
    catch_unwind(|| introspection::subtypes(kind) as usize).unwrap_or(0) as Strings
}

unsafe extern "C" fn object_info(
    _: This,
    kind: DataType,
    subtype: *const c_char,
    property: *const c_char,
    info: DataType,
) -> *const c_void {
    // SAFETY: the program gives strings.
    let (subtype, property) = unsafe { (text(subtype), text(property)) };
    let answer = || introspection::object_info(kind, &subtype, &property, info) as usize;
    catch_unwind(AssertUnwindSafe(answer)).unwrap_or(0) as *const c_void
}

unsafe extern "C" fn parameter_info(
    _: This,
    kind: DataType,
    subtype: *const c_char,
    name: *const c_char,
    of: DataType,
    property: *const c_char,
    info: DataType,
) -> *const c_void {
    // SAFETY: the program gives strings.
    let (subtype, name, property) = unsafe { (text(subtype), text(name), text(property)) };
    let answer = || introspection::parameter_info((kind, &subtype), (&name, of), (&property, info)) as usize;
    catch_unwind(AssertUnwindSafe(answer)).unwrap_or(0) as *const c_void
}

// --- frames ---

/// Calls `work` with a frame; `default` where there is none.
///
/// # Safety
/// As [`device`].
unsafe fn with_frame<R: Default>(
    this: This,
    frame: Address,
    call: &str,
    work: impl FnOnce(&Arc<Device>, &Arc<Object>, &Frame) -> R,
) -> R {
    // SAFETY: the caller's promise.
    unsafe {
        guarded(this, |device| {
            let Some(object) = device.object(handle(frame), call) else { return R::default() };
            match Frame::of(&object) {
                Some(frame) => work(device, &object, frame),
                None => {
                    device.reporter.send(
                        Some(&object),
                        Severity::Error,
                        Code::Argument,
                        &format!("{call}: no frame"),
                    );
                    R::default()
                }
            }
        })
    }
}

unsafe extern "C" fn map_frame(
    this: This,
    frame: Address,
    channel: *const c_char,
    width: *mut u32,
    height: *mut u32,
    kind: *mut DataType,
) -> *const c_void {
    // SAFETY: the loader gives one of our devices; the program a string and places for the answers.
    unsafe {
        let channel = text(channel);
        let found = with_frame(this, frame, "map frame", |device, object, frame| {
            frame.wait();
            let output = frame.map(&channel);
            let Some((format, address)) = output.channel(&channel) else {
                frame.unmap(&channel);
                let text = format!("map frame: channel '{channel}': unknown, or not asked for");
                device.reporter.warn(object, &text);
                return None;
            };
            Some((output.size, format, address as usize))
        });
        let ([w, h], format, address) = found.unwrap_or(([0; 2], types::UNKNOWN, 0));
        for (out, value) in [(width, w), (height, h)] {
            if !out.is_null() {
                *out = value;
            }
        }
        if !kind.is_null() {
            *kind = format;
        }
        address as *const c_void
    }
}

unsafe extern "C" fn unmap_frame(this: This, frame: Address, channel: *const c_char) {
    // SAFETY: the loader gives one of our devices, and the program a string.
    unsafe {
        let channel = text(channel);
        with_frame(this, frame, "unmap frame", |_, _, frame| frame.unmap(&channel));
    }
}

unsafe extern "C" fn render_frame(this: This, frame: Address) {
    // SAFETY: the loader gives one of our devices.
    unsafe { with_frame(this, frame, "render frame", |device, object, _| ffi_frame::render(device, object)) };
}

unsafe extern "C" fn frame_ready(this: This, frame: Address, mask: u32) -> c_int {
    // SAFETY: the loader gives one of our devices.
    unsafe {
        with_frame(this, frame, "frame ready", |_, _, frame| {
            if mask != 0 {
                frame.wait();
            }
            c_int::from(frame.is_ready())
        })
    }
}

unsafe extern "C" fn discard_frame(this: This, frame: Address) {
    // SAFETY: the loader gives one of our devices.
    unsafe { with_frame(this, frame, "discard frame", |_, _, frame| frame.discard()) };
}

/// Sets a parameter of a device before the program has it.
///
/// # Safety
/// `device` is one that [`new`] has given; the value is as [`value`] wants it.
pub(crate) unsafe fn initialize(device: Address, name: &str, kind: DataType, memory: *const c_void) {
    // SAFETY: the caller's promise.
    unsafe {
        guarded(device.cast(), |device| {
            if let Some(value) = value(device, &device.own, name, kind, memory) {
                device.set(&device.own, name, value);
            }
        });
    }
}

/// Makes these parameters count.
///
/// # Safety
/// `device` is null or one that [`new`] has given.
pub(crate) unsafe fn commit(device: Address) {
    // SAFETY: the caller's promise.
    unsafe { guarded(device.cast(), |device| device.commit_own()) };
}

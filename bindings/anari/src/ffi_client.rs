// SPDX-License-Identifier: GPL-3.0-or-later
//! A program that uses the device through its table of functions alone, as ANARI's loader does: for tests.
//! Tests: tests/main.rs and all that it names.

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::sync::{Arc, Mutex};

use crate::ffi_abi::{DeviceHead, DeviceTable, Library, LibraryTable, TableHead};
use crate::ffi_library::anari_library_gnurt_new_library;
use crate::object::lock;
use crate::types::{self, DataType};

/// A message of the device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// 1 = fatal, 2 = error, 3 = warning, 4 = performance, 5 = information.
    pub severity: i32,
    /// Handle of the object that it is about.
    pub source: usize,
    /// Its words.
    pub text: String,
}

/// Messages so far.
type Messages = Arc<Mutex<Vec<Message>>>;

/// A picture's channel.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Columns and rows.
    pub size: [u32; 2],
    /// Format.
    pub kind: DataType,
    /// All values, from the lowest row on.
    pub bytes: Vec<u8>,
}

impl Channel {
    /// Its values as floats.
    #[must_use]
    pub fn floats(&self) -> Vec<f32> {
        self.bytes.chunks_exact(4).map(|b| f32::from_ne_bytes([b[0], b[1], b[2], b[3]])).collect()
    }

    /// Its values as whole numbers.
    #[must_use]
    pub fn numbers(&self) -> Vec<u32> {
        self.bytes.chunks_exact(4).map(|b| u32::from_ne_bytes([b[0], b[1], b[2], b[3]])).collect()
    }

    /// Four floats of a pixel, counted from the left and from below.
    #[must_use]
    pub fn pixel(&self, x: u32, y: u32) -> [f32; 4] {
        let first = 4 * (y * self.size[0] + x) as usize;
        let floats = self.floats();
        [floats[first], floats[first + 1], floats[first + 2], floats[first + 3]]
    }
}

/// A program with a device.
pub struct Client {
    library: *mut Library,
    device: *mut DeviceHead,
    messages: Messages,
}

// SAFETY: devices may be used by many threads at once.
unsafe impl Send for Client {}
// SAFETY: as above.
unsafe impl Sync for Client {}

unsafe extern "C-unwind" fn note(
    user: *const c_void,
    _: *mut c_void,
    source: *mut c_void,
    _: DataType,
    severity: c_int,
    _: c_int,
    text: *const c_char,
) {
    // SAFETY: the user data is the list of messages from `Client::new`; the text lives as long as this call.
    let (messages, text) = unsafe { (&*user.cast::<Mutex<Vec<Message>>>(), CStr::from_ptr(text)) };
    let text = text.to_string_lossy().into_owned();
    lock(messages).push(Message { severity, source: source as usize, text });
}

/// A counter's deleter: counts a call.
unsafe extern "C-unwind" fn count_deletion(user: *const c_void, _: *const c_void) {
    // SAFETY: the user data is a counter that outlives the array.
    unsafe { &*user.cast::<std::sync::atomic::AtomicUsize>() }
        .fetch_add(1, std::sync::atomic::Ordering::SeqCst);
}

/// A counter's callback: counts a finished frame.
unsafe extern "C-unwind" fn count_completion(user: *const c_void, _: *mut c_void, _: *mut c_void) {
    // SAFETY: the user data is a counter that outlives the frame.
    unsafe { &*user.cast::<std::sync::atomic::AtomicUsize>() }
        .fetch_add(1, std::sync::atomic::Ordering::SeqCst);
}

impl Default for Client {
    fn default() -> Self {
        Self::new()
    }
}

impl Client {
    /// A program with a new device, which notes its messages.
    #[must_use]
    pub fn new() -> Self {
        let messages = Messages::default();
        let user = Arc::as_ptr(&messages).cast::<c_void>();
        // SAFETY: the function is one for messages, and the user data lives as long as the client.
        let library = unsafe {
            anari_library_gnurt_new_library(std::ptr::null_mut(), note as *const () as usize, user)
        };
        // SAFETY: the library was made just now; its table begins behind the head.
        let device = unsafe { (Self::library_table(library).new_device)(library, c"default".as_ptr()) };
        Self { library, device: device.cast(), messages }
    }

    unsafe fn library_table<'a>(library: *mut Library) -> &'a LibraryTable {
        // SAFETY: a library of ours, of the newer table.
        unsafe { &*(*library).table.cast::<u8>().sub(size_of::<TableHead>()).cast() }
    }

    fn table(&self) -> &DeviceTable {
        // SAFETY: the device lives as long as the client.
        unsafe { &*(*self.device).table.cast::<u8>().sub(size_of::<TableHead>()).cast() }
    }

    /// The device's own handle.
    #[must_use]
    pub fn device(&self) -> usize {
        self.device as usize
    }

    /// Messages so far, which are forgotten.
    #[must_use]
    pub fn messages(&self) -> Vec<Message> {
        std::mem::take(&mut lock(&self.messages))
    }

    /// A new object.
    #[must_use]
    pub fn object(&self, kind: DataType, subtype: &str) -> usize {
        let (table, device) = (self.table(), self.device);
        let subtype = CString::new(subtype).unwrap_or_default();
        let subtype = subtype.as_ptr();
        // SAFETY: the device lives, and the subtype is a string.
        let made = unsafe {
            match kind {
                types::GEOMETRY => (table.new_geometry)(device, subtype),
                types::MATERIAL => (table.new_material)(device, subtype),
                types::SAMPLER => (table.new_sampler)(device, subtype),
                types::SPATIAL_FIELD => (table.new_spatial_field)(device, subtype),
                types::VOLUME => (table.new_volume)(device, subtype),
                types::LIGHT => (table.new_light)(device, subtype),
                types::INSTANCE => (table.new_instance)(device, subtype),
                types::CAMERA => (table.new_camera)(device, subtype),
                types::RENDERER => (table.new_renderer)(device, subtype),
                types::SURFACE => (table.new_surface)(device),
                types::GROUP => (table.new_group)(device),
                types::WORLD => (table.new_world)(device),
                types::FRAME => (table.new_frame)(device),
                _ => (table.new_object)(device, subtype, subtype),
            }
        };
        made as usize
    }

    /// An array of a copy of these bytes.
    #[must_use]
    pub fn array(&self, element: DataType, dims: &[u64], bytes: &[u8]) -> usize {
        let array = self.managed(element, dims);
        self.write(array, bytes);
        array
    }

    /// An array of floats.
    #[must_use]
    pub fn floats(&self, element: DataType, floats: &[f32]) -> usize {
        let bytes: Vec<u8> = floats.iter().flat_map(|x| x.to_ne_bytes()).collect();
        let count = bytes.len() / types::size(element).unwrap_or(4);
        self.array(element, &[count as u64], &bytes)
    }

    /// An array of whole numbers.
    #[must_use]
    pub fn numbers(&self, element: DataType, numbers: &[u32]) -> usize {
        let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_ne_bytes()).collect();
        let count = bytes.len() / types::size(element).unwrap_or(4);
        self.array(element, &[count as u64], &bytes)
    }

    /// An array of objects.
    #[must_use]
    pub fn objects(&self, element: DataType, objects: &[usize]) -> usize {
        let bytes: Vec<u8> = objects.iter().flat_map(|x| x.to_ne_bytes()).collect();
        self.array(element, &[objects.len() as u64], &bytes)
    }

    fn new_array(
        &self,
        element: DataType,
        dims: &[u64],
        memory: *const c_void,
        deletions: Option<&std::sync::atomic::AtomicUsize>,
    ) -> usize {
        let (table, device) = (self.table(), self.device);
        let user = deletions.map_or(std::ptr::null(), |counter| (&raw const *counter).cast::<c_void>());
        let deleter: Option<crate::ffi_array::MemoryDeleter> =
            if deletions.is_some() { Some(count_deletion) } else { None };
        // SAFETY: the device lives; memory is as the caller of the public functions promises.
        let made = unsafe {
            match *dims {
                [a] => (table.new_array_1d)(device, memory, deleter, user, element, a),
                [a, b] => (table.new_array_2d)(device, memory, deleter, user, element, a, b),
                [a, b, c] => (table.new_array_3d)(device, memory, deleter, user, element, a, b, c),
                _ => std::ptr::null_mut(),
            }
        };
        made as usize
    }

    /// An array of the device's own memory.
    #[must_use]
    pub fn managed(&self, element: DataType, dims: &[u64]) -> usize {
        self.new_array(element, dims, std::ptr::null(), None)
    }

    /// An array of memory with a deleter that counts its calls. Both are borrowed for as long as the client lives, or longer.
    #[must_use]
    pub fn captured<'m>(&self, memory: &'m [u8], deletions: &'m std::sync::atomic::AtomicUsize) -> usize
    where
        Self: 'm,
    {
        let count = memory.len() as u64 / 12;
        self.new_array(types::FLOAT32_VEC3, &[count], memory.as_ptr().cast(), Some(deletions))
    }

    /// Calls `work` with an array of memory that stays the program's, and releases it.
    pub fn shared_for(&self, memory: &[u8], element: DataType, work: impl FnOnce(usize)) {
        let count = memory.len() / types::size(element).unwrap_or(1);
        let array = self.new_array(element, &[count as u64], memory.as_ptr().cast(), None);
        work(array);
        self.release(array);
    }

    /// Writes an array's elements by mapping it. `bytes` must not be more than it has.
    pub fn write(&self, array: usize, bytes: &[u8]) {
        let array = array as *mut c_void;
        // SAFETY: the device lives, and the array is as large as the caller says.
        unsafe {
            let memory = (self.table().map_array)(self.device, array);
            if !memory.is_null() {
                std::ptr::copy_nonoverlapping(bytes.as_ptr(), memory.cast::<u8>(), bytes.len());
            }
            (self.table().unmap_array)(self.device, array);
        }
    }

    /// Sets a parameter to a value of these bytes.
    pub fn set(&self, object: usize, name: &str, kind: DataType, bytes: &[u8]) {
        let name = CString::new(name).unwrap_or_default();
        // SAFETY: the device lives, and the bytes are a value.
        unsafe {
            (self.table().set_parameter)(
                self.device,
                object as *mut c_void,
                name.as_ptr(),
                kind,
                bytes.as_ptr().cast(),
            )
        };
    }

    /// Sets a parameter to floats.
    pub fn set_floats(&self, object: usize, name: &str, kind: DataType, floats: &[f32]) {
        let bytes: Vec<u8> = floats.iter().flat_map(|x| x.to_ne_bytes()).collect();
        self.set(object, name, kind, &bytes);
    }

    /// Sets a parameter to a number.
    pub fn set_float(&self, object: usize, name: &str, float: f32) {
        self.set_floats(object, name, types::FLOAT32, &[float]);
    }

    /// Sets a parameter to three numbers.
    pub fn set_vec3(&self, object: usize, name: &str, v: [f32; 3]) {
        self.set_floats(object, name, types::FLOAT32_VEC3, &v);
    }

    /// Sets a parameter to a whole number.
    pub fn set_u32(&self, object: usize, name: &str, kind: DataType, number: u32) {
        self.set(object, name, kind, &number.to_ne_bytes());
    }

    /// Sets a parameter to a string.
    pub fn set_text(&self, object: usize, name: &str, text: &str) {
        let text = CString::new(text).unwrap_or_default();
        self.set(object, name, types::STRING, text.as_bytes_with_nul());
    }

    /// Sets a parameter to an object.
    pub fn set_object(&self, object: usize, name: &str, kind: DataType, value: usize) {
        self.set(object, name, kind, &value.to_ne_bytes());
    }

    /// Sets a parameter to an object that the program then lets go.
    pub fn give(&self, object: usize, name: &str, kind: DataType, value: usize) {
        self.set_object(object, name, kind, value);
        self.release(value);
    }

    /// Makes a frame count its completions.
    pub fn count_completions(&self, frame: usize, counter: &std::sync::atomic::AtomicUsize) {
        let function = count_completion as *const () as usize;
        self.set(frame, "frameCompletionCallback", types::FRAME_COMPLETION_CALLBACK, &function.to_ne_bytes());
        let name = c"frameCompletionCallbackUserData";
        let user = (&raw const *counter).cast();
        // SAFETY: the device lives; a pointer is given as it is.
        unsafe {
            (self.table().set_parameter)(
                self.device,
                frame as *mut c_void,
                name.as_ptr(),
                types::VOID_POINTER,
                user,
            )
        };
    }

    /// Takes a parameter away.
    pub fn unset(&self, object: usize, name: &str) {
        let name = CString::new(name).unwrap_or_default();
        // SAFETY: the device lives, and the name is a string.
        unsafe { (self.table().unset_parameter)(self.device, object as *mut c_void, name.as_ptr()) };
    }

    /// Takes all parameters away.
    pub fn unset_all(&self, object: usize) {
        // SAFETY: the device lives.
        unsafe { (self.table().unset_all_parameters)(self.device, object as *mut c_void) };
    }

    /// Sets a parameter to a list by mapping it.
    pub fn map_parameter(&self, object: usize, name: &str, element: DataType, bytes: &[u8]) {
        let name = CString::new(name).unwrap_or_default();
        let (object, mut stride) = (object as *mut c_void, 0);
        let count = (bytes.len() / types::size(element).unwrap_or(1)) as u64;
        // SAFETY: the device lives; the memory has room for the elements.
        unsafe {
            let table = self.table();
            let memory = (table.map_parameter_array_1d)(
                self.device,
                object,
                name.as_ptr(),
                element,
                count,
                &raw mut stride,
            );
            if !memory.is_null() {
                std::ptr::copy_nonoverlapping(bytes.as_ptr(), memory.cast::<u8>(), bytes.len());
            }
            (table.unmap_parameter_array)(self.device, object, name.as_ptr());
        }
        assert_eq!(stride, types::size(element).unwrap_or(0) as u64, "elements follow each other");
    }

    /// Makes parameters count.
    pub fn commit(&self, object: usize) {
        // SAFETY: the device lives.
        unsafe { (self.table().commit_parameters)(self.device, object as *mut c_void) };
    }

    /// Holds an object less.
    pub fn release(&self, object: usize) {
        // SAFETY: the device lives; it is not given up here.
        unsafe { (self.table().release)(self.device, object as *mut c_void) };
    }

    /// Holds an object more.
    pub fn retain(&self, object: usize) {
        // SAFETY: the device lives.
        unsafe { (self.table().retain)(self.device, object as *mut c_void) };
    }

    /// The bytes of a property; `None` where there is none.
    #[must_use]
    pub fn property(&self, object: usize, name: &str, kind: DataType) -> Option<Vec<u8>> {
        let mut bytes = vec![0_u8; 256];
        let size = types::size(kind).unwrap_or(8);
        let name = CString::new(name).unwrap_or_default();
        // SAFETY: the device lives; there is room for the value.
        let found = unsafe {
            (self.table().get_property)(
                self.device,
                object as *mut c_void,
                name.as_ptr(),
                kind,
                bytes.as_mut_ptr().cast(),
                bytes.len() as u64,
                1,
            )
        };
        bytes.truncate(size);
        (found != 0).then_some(bytes)
    }

    /// Objects that live.
    #[must_use]
    pub fn alive(&self) -> u64 {
        let bytes = self.property(self.device(), "objects", types::UINT64).unwrap_or_default();
        bytes.try_into().map_or(0, u64::from_ne_bytes)
    }

    /// Starts a rendering.
    pub fn render(&self, frame: usize) {
        // SAFETY: the device lives.
        unsafe { (self.table().render_frame)(self.device, frame as *mut c_void) };
    }

    /// Whether a rendering has ended; `wait` waits for it.
    #[must_use]
    pub fn is_ready(&self, frame: usize, wait: bool) -> bool {
        // SAFETY: the device lives.
        unsafe { (self.table().frame_ready)(self.device, frame as *mut c_void, u32::from(wait)) != 0 }
    }

    /// Stops a rendering.
    pub fn discard(&self, frame: usize) {
        // SAFETY: the device lives.
        unsafe { (self.table().discard_frame)(self.device, frame as *mut c_void) };
    }

    /// A copy of a channel; `None` where there is none.
    #[must_use]
    pub fn channel(&self, frame: usize, name: &str) -> Option<Channel> {
        let name = CString::new(name).unwrap_or_default();
        let (mut size, mut kind) = ([0_u32; 2], 0);
        let frame = frame as *mut c_void;
        // SAFETY: the device lives; the mapped memory holds all pixels until it is unmapped.
        unsafe {
            let [width, height] = &mut size;
            let memory =
                (self.table().map_frame)(self.device, frame, name.as_ptr(), width, height, &raw mut kind);
            if memory.is_null() {
                return None;
            }
            let count = size[0] as usize * size[1] as usize * types::size(kind).unwrap_or(0);
            let bytes = std::slice::from_raw_parts(memory.cast::<u8>(), count).to_vec();
            (self.table().unmap_frame)(self.device, frame, name.as_ptr());
            Some(Channel { size, kind, bytes })
        }
    }

    /// Subtypes of a kind.
    #[must_use]
    pub fn subtypes(&self, kind: DataType) -> Vec<String> {
        // SAFETY: the device lives; lists end with null.
        unsafe { strings((self.table().object_subtypes)(self.device, kind)) }
    }

    /// Extensions of the library.
    #[must_use]
    pub fn extensions(&self) -> Vec<String> {
        // SAFETY: the library lives; lists end with null.
        unsafe {
            strings((Self::library_table(self.library).device_extensions)(self.library, c"default".as_ptr()))
        }
    }

    /// Names and types of a kind's parameters.
    #[must_use]
    pub fn parameters(&self, kind: DataType, subtype: &str) -> Vec<(String, DataType)> {
        let subtype = CString::new(subtype).unwrap_or_default();
        let mut all = Vec::new();
        // SAFETY: the device lives; the list ends with a parameter without a name.
        unsafe {
            let list = (self.table().object_info)(
                self.device,
                kind,
                subtype.as_ptr(),
                c"parameter".as_ptr(),
                types::PARAMETER_LIST,
            );
            let mut next = list.cast::<crate::ffi_abi::ParameterName>();
            while !next.is_null() && !(*next).name.is_null() {
                all.push((CStr::from_ptr((*next).name).to_string_lossy().into_owned(), (*next).kind));
                next = next.add(1);
            }
        }
        all
    }

    /// Something of a parameter: the address of its first byte, or 0.
    #[must_use]
    pub fn parameter_info(
        &self,
        of: (DataType, &str),
        parameter: (&str, DataType),
        info: (&str, DataType),
    ) -> usize {
        let [subtype, name, property] =
            [of.1, parameter.0, info.0].map(|text| CString::new(text).unwrap_or_default());
        // SAFETY: the device lives, and names are strings.
        let found = unsafe {
            (self.table().parameter_info)(
                self.device,
                of.0,
                subtype.as_ptr(),
                name.as_ptr(),
                parameter.1,
                property.as_ptr(),
                info.1,
            )
        };
        found as usize
    }

    /// The strings of a parameter's values.
    #[must_use]
    pub fn parameter_words(&self, of: (DataType, &str), name: &str) -> Vec<String> {
        let list = self.parameter_info(of, (name, types::STRING), ("value", types::STRING_LIST));
        // SAFETY: lists end with null.
        unsafe { strings(list as *const *const c_char) }
    }

    /// Four bytes at an answer's address, as a float; `None` where there is no answer.
    #[must_use]
    pub fn read_float(&self, address: usize) -> Option<f32> {
        // SAFETY: answers of introspection have four bytes and more, and stay.
        (address != 0).then(|| unsafe { (address as *const f32).read() })
    }
}

/// A list of strings.
///
/// # Safety
/// It is null or ends with null.
unsafe fn strings(list: *const *const c_char) -> Vec<String> {
    let mut all = Vec::new();
    // SAFETY: the caller's promise.
    unsafe {
        let mut next = list;
        while !next.is_null() && !(*next).is_null() {
            all.push(CStr::from_ptr(*next).to_string_lossy().into_owned());
            next = next.add(1);
        }
    }
    all
}

impl Drop for Client {
    fn drop(&mut self) {
        // SAFETY: both were made by `new`, and only this client has them.
        unsafe {
            (self.table().release)(self.device, self.device.cast());
            (Self::library_table(self.library).delete)(self.library);
        }
    }
}

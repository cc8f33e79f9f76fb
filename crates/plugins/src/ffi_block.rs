// SPDX-License-Identifier: GPL-3.0-or-later
//! Blocks per shader of plugins: memory that the plugin describes, `init` and `fini`, and the copies that frames shade with.
//! Invariants: a block has the size and alignment of its class; texts that a block or a copy points to live
//! as long as it does; `fini` runs once, after the last frame that may use the data of `init`. A block is
//! private memory of this process: `prepare` is tried in a copy of the process, and the program's own
//! allocator may have memory that both share.
//! Tests: bindings/openrt/tests/plugins.rs.

use std::alloc::{GlobalAlloc, Layout, System, handle_alloc_error};
use std::collections::BTreeMap;
use std::ffi::{CStr, CString, c_void};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::class::PluginClass;
use crate::ffi_catch::Thrown;
use crate::ffi_rts::{BlockFn, Host, PrepareFn};
use crate::print_line::print_line;

/// Bytes with an alignment, all zero at first.
struct Memory {
    at: *mut u8,
    size: usize,
    layout: Layout,
}

// SAFETY: it owns its bytes; a writer has exclusive access, by `&mut` or behind a mutex.
unsafe impl Send for Memory {}
// SAFETY: as above; shared, it is only read.
unsafe impl Sync for Memory {}

impl Memory {
    fn new(size: usize, align: usize) -> Self {
        let layout = Layout::from_size_align(size.max(1), align).expect("loading checked size and alignment");
        // SAFETY: the layout has at least one byte.
        let at = unsafe { System.alloc_zeroed(layout) };
        if at.is_null() {
            handle_alloc_error(layout);
        }
        Self { at, size, layout }
    }

    fn bytes(&self) -> &[u8] {
        // SAFETY: `size` bytes at `at` are ours and have been written, with zeros at least.
        unsafe { std::slice::from_raw_parts(self.at, self.size) }
    }

    fn bytes_mut(&mut self) -> &mut [u8] {
        // SAFETY: as above, and access is exclusive.
        unsafe { std::slice::from_raw_parts_mut(self.at, self.size) }
    }
}

impl Drop for Memory {
    fn drop(&mut self) {
        // SAFETY: it was allocated with this layout.
        unsafe { System.dealloc(self.at, self.layout) };
    }
}

/// The mutable part of a block.
struct Content {
    memory: Memory,
    /// The texts that it points to, by parameter.
    texts: BTreeMap<usize, Arc<CStr>>,
    /// Rises with each write.
    version: u64,
}

/// The block of a plugin's shader.
pub struct PluginBlock {
    class: Arc<PluginClass>,
    content: Mutex<Content>,
    /// The version that `prepare` was tried with, and how it went.
    tried: Mutex<Option<(u64, Result<(), String>)>>,
}

impl PluginBlock {
    /// The block of a new shader.
    ///
    /// # Errors
    /// A line for people: an exception left `init`.
    pub fn new(class: &Arc<PluginClass>) -> Result<Arc<Self>, String> {
        let mut memory = Memory::new(class.shader_size, class.shader_align);
        if let Some(init) = class.calls.init {
            call_block(class, init, &mut memory)
                .map_err(|Thrown| format!("{}: an exception left its init", class.title()))?;
        }
        let content = Content { memory, texts: BTreeMap::new(), version: 0 };
        Ok(Arc::new(Self { class: class.clone(), content: Mutex::new(content), tried: Mutex::new(None) }))
    }

    fn content(&self) -> MutexGuard<'_, Content> {
        self.content.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Its class.
    #[must_use]
    pub fn class(&self) -> &Arc<PluginClass> {
        &self.class
    }

    /// Rises with each write.
    #[must_use]
    pub fn version(&self) -> u64 {
        self.content().version
    }

    /// Writes the bytes of parameter number `parameter`.
    pub fn write(&self, parameter: usize, bytes: &[u8]) {
        let offset = self.class.parameters[parameter].offset;
        let mut content = self.content();
        content.memory.bytes_mut()[offset..offset + bytes.len()].copy_from_slice(bytes);
        content.version += 1;
    }

    /// Makes a parameter point to a copy of `text`.
    pub fn write_text(&self, parameter: usize, text: &CStr) {
        let text: Arc<CStr> = Arc::from(CString::from(text));
        let offset = self.class.parameters[parameter].offset;
        let mut content = self.content();
        let slot = &mut content.memory.bytes_mut()[offset..offset + size_of::<*const u8>()];
        // SAFETY: the slot has room for a pointer: loading checked that. It need not be aligned. A pointer is written, not
        // its number, so that it may be followed.
        unsafe { slot.as_mut_ptr().cast::<*const std::ffi::c_char>().write_unaligned(text.as_ptr()) };
        content.texts.insert(parameter, text);
        content.version += 1;
    }

    /// The numbers of a parameter, as floats.
    #[must_use]
    pub fn numbers(&self, parameter: usize) -> Vec<f32> {
        decode(&self.class, parameter, self.content().memory.bytes())
    }

    /// A copy for a frame.
    #[must_use]
    pub fn snapshot(self: &Arc<Self>) -> Snapshot {
        let content = self.content();
        let mut memory = Memory::new(self.class.shader_size, self.class.shader_align);
        memory.bytes_mut().copy_from_slice(content.memory.bytes());
        let texts = content.texts.values().cloned().collect();
        Snapshot { memory, _texts: texts, version: content.version, block: self.clone() }
    }

    /// How trying `prepare` with this version went, if it was tried.
    #[must_use]
    pub fn outcome(&self, version: u64) -> Option<Result<(), String>> {
        let tried = self.tried.lock().unwrap_or_else(PoisonError::into_inner);
        tried.as_ref().filter(|(tried, _)| *tried == version).map(|(_, outcome)| outcome.clone())
    }

    /// Stores the outcome.
    pub fn set_result(&self, version: u64, outcome: Result<(), String>) {
        *self.tried.lock().unwrap_or_else(PoisonError::into_inner) = Some((version, outcome));
    }
}

impl Drop for PluginBlock {
    fn drop(&mut self) {
        if let Some(fini) = self.class.calls.fini {
            let content = self.content.get_mut().unwrap_or_else(PoisonError::into_inner);
            if call_block(&self.class, fini, &mut content.memory).is_err() {
                print_line(format_args!("{}: an exception left its fini", self.class.title()));
            }
        }
    }
}

fn call_block(class: &PluginClass, function: BlockFn, memory: &mut Memory) -> Result<(), Thrown> {
    // SAFETY: the block has the size and alignment that the class states, and no other user.
    class.library.call(|| unsafe { function(memory.at.cast()) })
}

fn decode(class: &PluginClass, parameter: usize, block: &[u8]) -> Vec<f32> {
    let p = &class.parameters[parameter];
    let size = p.description.kind.size();
    let bytes = &block[p.offset..p.offset + p.description.count * size];
    bytes.chunks_exact(size).map(|bytes| p.description.kind.decode(bytes) as f32).collect()
}

/// A frame's copy of a block.
pub struct Snapshot {
    memory: Memory,
    /// The texts that it points to.
    _texts: Vec<Arc<CStr>>,
    /// The block's when the copy was made.
    pub version: u64,
    /// The data of `init` lives as long as this.
    pub block: Arc<PluginBlock>,
}

impl Snapshot {
    /// Where it is.
    pub(crate) fn pointer(&self) -> *const c_void {
        self.memory.at.cast()
    }

    /// The numbers of a parameter per shader, as floats.
    #[must_use]
    pub fn numbers(&self, parameter: usize) -> Vec<f32> {
        decode(self.block.class(), parameter, self.memory.bytes())
    }

    /// Calls `prepare` on it and returns its result.
    pub(crate) fn prepare(&mut self, host: &'static Host, prepare: PrepareFn) -> Result<i32, Thrown> {
        let (block, mut status) = (self.memory.at.cast(), 0);
        // SAFETY: the copy is as large and aligned as the class states, and access is exclusive.
        self.block.class.library.call(|| status = unsafe { prepare(host, block) }).map(|()| status)
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Arrays: memory that the program shares, hands over with a deleter, or maps.
//! Shared memory is the program's until it releases the array: then remaining users get a copy. Captured memory lives as
//! long as the array, and the deleter is called when that dies.
//! Invariant: memory holds `length * size(element)` bytes. Tests: tests/lifetimes.rs.

use std::ffi::c_void;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use crate::object::{Object, lock, next_stamp};
use crate::types::{self, DataType};

/// The program's function that frees memory.
pub(crate) type MemoryDeleter = unsafe extern "C-unwind" fn(user: *const c_void, memory: *const c_void);

/// Where elements lie.
enum Memory {
    /// The program's; it frees it by itself after it released the array.
    Shared(usize),
    /// Handed over.
    Captured { memory: usize, deleter: MemoryDeleter, user: usize },
    /// Ours, in words so that all elements are aligned.
    Own(Vec<u64>),
}

/// An array's payload.
pub(crate) struct Array {
    /// Type of the elements.
    pub(crate) element: DataType,
    /// Elements along each axis; 1 beyond the last.
    pub(crate) dims: [u64; 3],
    memory: Mutex<Memory>,
    /// Elements that are objects.
    objects: Mutex<Vec<Option<Arc<Object>>>>,
    /// First element that counts and one beyond the last, of lists.
    region: Mutex<Option<[usize; 2]>>,
    stamp: AtomicU64,
}

/// Memory of the program for a new array.
pub(crate) struct Given {
    /// Null = none.
    pub(crate) memory: *const c_void,
    pub(crate) deleter: Option<MemoryDeleter>,
    pub(crate) user: *const c_void,
}

impl Array {
    /// An array of the program's memory, or of its own; an error in words where it cannot be.
    pub(crate) fn new(element: DataType, dims: [u64; 3], given: &Given) -> Result<Self, String> {
        let size = types::size(element)
            .ok_or_else(|| format!("element type {}: unknown, or without a size", types::name(element)))?;
        let count = dims.iter().try_fold(1_u64, |all, &n| all.checked_mul(n));
        let bytes = count.and_then(|count| usize::try_from(count).ok()?.checked_mul(size));
        let bytes = bytes.filter(|&bytes| isize::try_from(bytes).is_ok()).ok_or_else(|| {
            format!("size {} x {} x {} out of range: more than memory has", dims[0], dims[1], dims[2])
        })?;
        let memory = match (given.memory.is_null(), given.deleter) {
            (false, Some(deleter)) => {
                Memory::Captured { memory: given.memory as usize, deleter, user: given.user as usize }
            }
            (false, None) => Memory::Shared(given.memory as usize),
            (true, _) => Memory::Own(zeroed(bytes)?),
        };
        let stamp = AtomicU64::new(next_stamp());
        Ok(Self {
            element,
            dims,
            memory: Mutex::new(memory),
            objects: Mutex::default(),
            region: Mutex::default(),
            stamp,
        })
    }

    /// The array that an object is.
    pub(crate) fn of(object: &Object) -> Option<&Self> {
        object.payload.downcast_ref()
    }

    /// How many elements it has.
    pub(crate) fn len(&self) -> usize {
        (self.dims[0] * self.dims[1] * self.dims[2]) as usize
    }

    /// Rises when its elements may have changed.
    pub(crate) fn stamp(&self) -> u64 {
        self.stamp.load(Ordering::Acquire)
    }

    fn byte_len(&self) -> usize {
        self.len() * types::size(self.element).unwrap_or(0)
    }

    /// Where its elements lie, for the program to write.
    pub(crate) fn address(&self) -> *mut c_void {
        match &mut *lock(&self.memory) {
            Memory::Shared(memory) | Memory::Captured { memory, .. } => *memory as *mut c_void,
            Memory::Own(words) => words.as_mut_ptr().cast(),
        }
    }

    /// Says that its elements may have changed.
    pub(crate) fn touch(&self) {
        self.stamp.store(next_stamp(), Ordering::Release);
    }

    /// Makes only the elements from `first` to before `last` count; fewer where there are fewer.
    pub(crate) fn set_region(&self, region: Option<[u64; 2]>) {
        let within = |index: u64| index.min(self.len() as u64) as usize;
        let region = region.map(|[first, last]| [within(first).min(within(last)), within(last)]);
        *lock(&self.region) = region;
        self.touch();
    }

    /// Calls `read` with the bytes of the elements that count.
    pub(crate) fn with_bytes<R>(&self, read: impl FnOnce(&[u8]) -> R) -> R {
        let (region, size) = (*lock(&self.region), types::size(self.element).unwrap_or(0));
        self.with_all_bytes(|bytes| match region {
            Some([first, last]) => read(bytes.get(first * size..last * size).unwrap_or_default()),
            None => read(bytes),
        })
    }

    /// Calls `read` with all bytes.
    fn with_all_bytes<R>(&self, read: impl FnOnce(&[u8]) -> R) -> R {
        let (memory, length) = (lock(&self.memory), self.byte_len());
        let start: *const u8 = match &*memory {
            Memory::Shared(memory) | Memory::Captured { memory, .. } => *memory as *const u8,
            Memory::Own(words) => words.as_ptr().cast(),
        };
        if length == 0 || start.is_null() {
            return read(&[]);
        }
        // SAFETY: the program promises `length` bytes for as long as it holds the array or captured memory lives; own memory has
        // them. The lock keeps them in their place, and programs write only between map and unmap.
        read(unsafe { std::slice::from_raw_parts(start, length) })
    }

    /// Its elements as four floats each; `None` where they are no numbers.
    pub(crate) fn colors(&self) -> Option<Vec<[f32; 4]>> {
        let size = types::size(self.element)?;
        types::decode(self.element, &[0; 64])?;
        let value = |bytes: &[u8]| types::decode(self.element, bytes).unwrap_or_default();
        Some(self.with_bytes(|bytes| bytes.chunks_exact(size).map(value).collect()))
    }

    /// Its elements as rows of `N` floats each; `None` where they are something else.
    pub(crate) fn rows<const N: usize>(&self) -> Option<Vec<[f32; N]>> {
        if types::size(self.element)? != 4 * N || types::is_object(self.element) {
            return None;
        }
        let float = |bytes: &[u8]| f32::from_ne_bytes(bytes.try_into().unwrap_or_default());
        let row = |bytes: &[u8]| std::array::from_fn(|k| float(&bytes[4 * k..4 * k + 4]));
        Some(self.with_bytes(|bytes| bytes.chunks_exact(4 * N).map(row).collect()))
    }

    /// Its elements as rows of `N` whole numbers of 32 or 64 bits; `None` where they are something else.
    pub(crate) fn indices<const N: usize>(&self) -> Option<Vec<[u64; N]>> {
        let width = types::size(self.element)? / N;
        if width != 4 && width != 8 {
            return None;
        }
        let number = |bytes: &[u8]| match bytes.len() {
            4 => u64::from(u32::from_ne_bytes(bytes.try_into().unwrap_or_default())),
            _ => u64::from_ne_bytes(bytes.try_into().unwrap_or_default()),
        };
        let row = |bytes: &[u8]| std::array::from_fn(|k| number(&bytes[width * k..width * (k + 1)]));
        Some(self.with_bytes(|bytes| bytes.chunks_exact(width * N).map(row).collect()))
    }

    /// Finds the objects that its elements are; `find` gives them by handle. Says how many are unknown.
    pub(crate) fn resolve(&self, find: impl Fn(usize) -> Option<Arc<Object>>) -> usize {
        if !types::is_object(self.element) {
            return 0;
        }
        let handles: Vec<usize> = self.with_all_bytes(|bytes| {
            let handle = |bytes: &[u8]| usize::from_ne_bytes(bytes.try_into().unwrap_or_default());
            bytes.chunks_exact(size_of::<usize>()).map(handle).collect()
        });
        let fits = |object: &Arc<Object>| self.element == types::OBJECT || object.kind == self.element;
        let found: Vec<_> = handles.iter().map(|&handle| find(handle).filter(fits)).collect();
        let unknown = found.iter().zip(&handles).filter(|(it, handle)| it.is_none() && **handle != 0).count();
        let old = std::mem::replace(&mut *lock(&self.objects), found);
        drop(old);
        unknown
    }

    /// The objects that its elements are, without those that are missing.
    pub(crate) fn objects(&self) -> Vec<Arc<Object>> {
        let (objects, region) = (lock(&self.objects), *lock(&self.region));
        let counting = match region {
            Some([first, last]) => objects.get(first..last).unwrap_or_default(),
            None => &objects[..],
        };
        counting.iter().flatten().cloned().collect()
    }

    /// Copies shared memory: the program frees it from now on.
    pub(crate) fn privatize(&self) {
        let is_shared = matches!(*lock(&self.memory), Memory::Shared(_));
        if !is_shared {
            return;
        }
        let copy = self.with_all_bytes(|bytes| {
            let word = |chunk: &[u8]| {
                let mut word = [0; 8];
                word[..chunk.len()].copy_from_slice(chunk);
                u64::from_ne_bytes(word)
            };
            bytes.chunks(8).map(word).collect()
        });
        *lock(&self.memory) = Memory::Own(copy);
    }
}

/// Words for so many bytes, all zero; an error where there is no memory.
fn zeroed(bytes: usize) -> Result<Vec<u64>, String> {
    let words = bytes.div_ceil(8);
    let mut memory = Vec::new();
    memory.try_reserve_exact(words).map_err(|_| format!("{bytes} bytes: out of memory"))?;
    memory.resize(words, 0);
    Ok(memory)
}

impl Drop for Array {
    fn drop(&mut self) {
        let memory = std::mem::replace(&mut *lock(&self.memory), Memory::Own(Vec::new()));
        if let Memory::Captured { memory, deleter, user } = memory {
            // SAFETY: the program gave the function together with the memory; it is called once, after the last reader.
            let free = || unsafe { deleter(user as *const c_void, memory as *const c_void) };
            drop(std::panic::catch_unwind(std::panic::AssertUnwindSafe(free)));
        }
    }
}

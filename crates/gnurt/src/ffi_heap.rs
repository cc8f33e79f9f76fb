// SPDX-License-Identifier: GPL-3.0-or-later
//! A heap whose large arrays may be in a file, for scenes larger than memory: the system reads needed pages,
//! and writes and evicts others when memory runs short.
//! Source: mmap(2), fallocate(2). One sparse file is mapped as a whole; an array takes a range of it, and gives its blocks back with it.
//! Invariant: ranges in use never overlap; free ones hold no blocks and read as zero. Tests: `tests` below;
//! crates/cli/tests/program/out_of_core.rs.

use std::alloc::{GlobalAlloc, Layout, System};
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// Arrays from this size on go to the file.
const LARGE: usize = 16 << 10;
/// Ranges begin and end at multiples of this.
const PAGE: usize = 4 << 10;
/// Lengths of the file that are tried, in bytes; blocks are taken only as arrays are.
#[cfg(target_os = "linux")]
const LENGTHS: [u64; 4] = [1 << 42, 1 << 38, 1 << 34, 1 << 30];

/// A global allocator: the system's, until [`page_to`](Self::page_to) puts large arrays into a file.
///
/// ```
/// #[global_allocator]
/// static HEAP: gnurt::memory::FileHeap = gnurt::memory::FileHeap::new();
///
/// # if cfg!(target_os = "linux") {
/// HEAP.page_to(&std::env::temp_dir())?;
/// let large = vec![1_u8; 1 << 20];
/// assert_eq!(HEAP.bytes_in_file(), large.len());
/// # }
/// # Ok::<(), std::io::Error>(())
/// ```
#[derive(Debug, Default)]
pub struct FileHeap {
    /// The address of the mapping; 0 = none.
    base: AtomicUsize,
    length: AtomicUsize,
    /// The process that may take ranges: a child process shares the file with its parent, and takes none.
    owner: AtomicUsize,
    in_use: AtomicUsize,
    area: Mutex<Option<Area>>,
}

/// The file, and its unused ranges.
#[derive(Debug)]
struct Area {
    file: File,
    /// Where each begins, and its length.
    free: BTreeMap<usize, usize>,
    /// The same: length and begin.
    by_length: BTreeSet<(usize, usize)>,
}

impl FileHeap {
    /// The system's allocator.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            base: AtomicUsize::new(0),
            length: AtomicUsize::new(0),
            owner: AtomicUsize::new(0),
            in_use: AtomicUsize::new(0),
            area: Mutex::new(None),
        }
    }

    /// From now on arrays of 16 KiB and more are in an unnamed file in `folder`, which disappears with the
    /// process. If the disk is full, they are in memory as before.
    ///
    /// # Errors
    /// The folder has no sparse files that can free blocks; or this is not Linux; or it has been called
    /// before.
    pub fn page_to(&self, folder: &Path) -> io::Result<()> {
        let mut area = self.area.lock().unwrap_or_else(PoisonError::into_inner);
        if area.is_some() {
            return Err(io::Error::other("large arrays are in a file already"));
        }
        let (file, base, length) = mapped(folder)?;
        let mut new = Area { file, free: BTreeMap::new(), by_length: BTreeSet::new() };
        new.add(0, length);
        *area = Some(new);
        self.owner.store(std::process::id() as usize, Ordering::Relaxed);
        self.length.store(length, Ordering::Relaxed);
        self.base.store(base, Ordering::Release);
        Ok(())
    }

    /// Bytes of arrays in the file.
    #[must_use]
    pub fn bytes_in_file(&self) -> usize {
        self.in_use.load(Ordering::Relaxed)
    }

    /// A range of the file; `None` if the array belongs elsewhere, or the disk is full.
    fn take(&self, layout: Layout) -> Option<*mut u8> {
        let base = self.base.load(Ordering::Acquire);
        if base == 0 || layout.size() < LARGE || layout.align() > PAGE {
            return None;
        }
        let length = layout.size().checked_next_multiple_of(PAGE)?;
        if self.owner.load(Ordering::Relaxed) != std::process::id() as usize {
            return None;
        }
        let mut area = self.area.lock().unwrap_or_else(PoisonError::into_inner);
        let start = area.as_mut()?.take(length)?;
        self.in_use.fetch_add(layout.size(), Ordering::Relaxed);
        Some((base + start) as *mut u8)
    }

    /// The offset in the file of an array in it.
    fn slot_of(&self, array: *mut u8) -> Option<usize> {
        let base = self.base.load(Ordering::Acquire);
        let slot_of = (array as usize).checked_sub(base)?;
        (base != 0 && slot_of < self.length.load(Ordering::Relaxed)).then_some(slot_of)
    }

    /// Gives a range back.
    fn give(&self, slot_of: usize, layout: Layout) {
        if self.owner.load(Ordering::Relaxed) != std::process::id() as usize {
            return;
        }
        self.in_use.fetch_sub(layout.size(), Ordering::Relaxed);
        if let Some(area) = self.area.lock().unwrap_or_else(PoisonError::into_inner).as_mut() {
            area.give(slot_of, layout.size().next_multiple_of(PAGE));
        }
    }
}

impl Area {
    /// Of the ranges that fit best the first one, with blocks on the disk.
    fn take(&mut self, length: usize) -> Option<usize> {
        let &(space, start) = self.by_length.range((length, 0)..).next()?;
        give_blocks(&self.file, start, length).ok()?;
        self.remove(start, space);
        if space > length {
            self.add(start + length, space - length);
        }
        Some(start)
    }

    fn add(&mut self, start: usize, length: usize) {
        self.free.insert(start, length);
        self.by_length.insert((length, start));
    }

    fn remove(&mut self, start: usize, length: usize) {
        self.free.remove(&start);
        self.by_length.remove(&(length, start));
    }

    /// Joins a range with its free neighbours.
    fn give(&mut self, mut start: usize, mut length: usize) {
        if take_blocks(&self.file, start, length).is_err() {
            // Its contents must not count as zeros: it is never reused.
            return;
        }
        if let Some(&space) = self.free.get(&(start + length)) {
            self.remove(start + length, space);
            length += space;
        }
        if let Some((&before, &space)) = self.free.range(..start).next_back()
            && before + space == start
        {
            self.remove(before, space);
            (start, length) = (before, length + space);
        }
        self.add(start, length);
    }
}

// SAFETY: an array is either the system's, by its own allocator, or an exclusive range of the mapped file:
// `Area` hands out each range once until it returns. Ranges have the requested length, begin at multiples of
// GRAIN, and stay mapped for ever.
unsafe impl GlobalAlloc for FileHeap {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        match self.take(layout) {
            Some(array) => array,
            // SAFETY: as of the caller.
            None => unsafe { System.alloc(layout) },
        }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        match self.take(layout) {
            // Blocks come with zeros.
            Some(array) => array,
            // SAFETY: as of the caller.
            None => unsafe { System.alloc_zeroed(layout) },
        }
    }

    unsafe fn dealloc(&self, array: *mut u8, layout: Layout) {
        match self.slot_of(array) {
            Some(slot_of) => self.give(slot_of, layout),
            // SAFETY: as of the caller; the array is the system's.
            None => unsafe { System.dealloc(array, layout) },
        }
    }

    unsafe fn realloc(&self, array: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        let is_mapped = self.base.load(Ordering::Relaxed) != 0 && size >= LARGE;
        let slot_of = self.slot_of(array);
        if !is_mapped && slot_of.is_none() {
            // SAFETY: as of the caller; the array is the system's.
            return unsafe { System.realloc(array, layout, size) };
        }
        let grain = |bytes: usize| bytes.next_multiple_of(PAGE);
        if slot_of.is_some() && size >= LARGE && grain(size) == grain(layout.size()) {
            self.in_use.fetch_add(size.wrapping_sub(layout.size()), Ordering::Relaxed);
            return array;
        }
        // SAFETY: the caller's size is valid for a layout.
        let new = unsafe { self.alloc(Layout::from_size_align_unchecked(size, layout.align())) };
        if !new.is_null() {
            // SAFETY: both have at least the copied length, and they are two arrays; the old one belongs to
            // the caller.
            unsafe {
                std::ptr::copy_nonoverlapping(array, new, layout.size().min(size));
                self.dealloc(array, layout);
            }
        }
        new
    }
}

/// A sparse file without a name, where it is mapped and how long it is.
#[cfg(target_os = "linux")]
fn mapped(folder: &Path) -> io::Result<(File, usize, usize)> {
    use rustix::mm::{Advice, MapFlags, ProtFlags, madvise, mmap};
    let file = tempfile::tempfile_in(folder)?;
    let mut error = io::Error::other("no room");
    for length in LENGTHS {
        let Ok(bytes) = usize::try_from(length) else { continue };
        if let Err(why) = file.set_len(length) {
            error = why;
            continue;
        }
        give_blocks(&file, 0, PAGE)?;
        take_blocks(&file, 0, PAGE)?;
        let (access, flags) = (ProtFlags::READ | ProtFlags::WRITE, MapFlags::SHARED | MapFlags::NORESERVE);
        // SAFETY: the system chooses a free range of addresses; the file is ours only, for it has no name.
        match unsafe { mmap(std::ptr::null_mut(), bytes, access, flags, &file, 0) } {
            Ok(base) => {
                // Rays access memory at random: readahead around a page, up to MiB, would evict pages in use.
                // SAFETY: the range is the one that was mapped; advice changes nothing in it.
                let _ = unsafe { madvise(base, bytes, Advice::Random) };
                return Ok((file, base as usize, bytes));
            }
            Err(why) => error = why.into(),
        }
    }
    Err(error)
}

#[cfg(target_os = "linux")]
fn give_blocks(file: &File, start: usize, length: usize) -> io::Result<()> {
    use rustix::fs::{FallocateFlags, fallocate};
    Ok(fallocate(file, FallocateFlags::empty(), start as u64, length as u64)?)
}

#[cfg(target_os = "linux")]
fn take_blocks(file: &File, start: usize, length: usize) -> io::Result<()> {
    use rustix::fs::{FallocateFlags, fallocate};
    let flags = FallocateFlags::PUNCH_HOLE | FallocateFlags::KEEP_SIZE;
    Ok(fallocate(file, flags, start as u64, length as u64)?)
}

#[cfg(not(target_os = "linux"))]
fn mapped(_: &Path) -> io::Result<(File, usize, usize)> {
    Err(io::Error::new(io::ErrorKind::Unsupported, "scenes larger than memory need Linux"))
}

#[cfg(not(target_os = "linux"))]
fn give_blocks(_: &File, _: usize, _: usize) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

#[cfg(not(target_os = "linux"))]
fn take_blocks(_: &File, _: usize, _: usize) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    /// Bytes of an array, all the same.
    unsafe fn fill(array: *mut u8, size: usize, value: u8) {
        // SAFETY: the caller's array is that long.
        unsafe { std::ptr::write_bytes(array, value, size) };
    }

    #[test]
    fn arrays_keep_what_is_theirs_and_ranges_come_back() {
        let heap = FileHeap::new();
        heap.page_to(&std::env::temp_dir()).expect("a folder for temporary files");
        assert!(heap.page_to(&std::env::temp_dir()).is_err(), "once is enough");
        let layout = |size| Layout::from_size_align(size, 64).expect("a layout");
        let mut arrays: Vec<(*mut u8, usize, u8)> = Vec::new();
        let mut random = 1_u64;
        for step in 0..600_u32 {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let size = if random >> 62 == 0 { 1000 } else { LARGE + (random >> 40) as usize % (4 * LARGE) };
            let value = step as u8;
            // SAFETY: layouts are those that the arrays were made with, and sizes are not zero.
            unsafe {
                match random >> 60 & 3 {
                    0 if !arrays.is_empty() => {
                        let (array, size, _) = arrays.swap_remove(random as usize % arrays.len());
                        heap.dealloc(array, layout(size));
                    }
                    1 if !arrays.is_empty() => {
                        let i = random as usize % arrays.len();
                        let (array, before, old) = arrays[i];
                        let new = heap.realloc(array, layout(before), size);
                        assert!(
                            (0..before.min(size)).step_by(97).all(|k| *new.add(k) == old),
                            "it moves along"
                        );
                        fill(new, size, old);
                        arrays[i] = (new, size, old);
                    }
                    _ => {
                        let array = heap.alloc_zeroed(layout(size));
                        assert!((0..size).all(|k| *array.add(k) == 0), "zeros, also where others were");
                        fill(array, size, value);
                        arrays.push((array, size, value));
                    }
                }
                for &(array, size, value) in &arrays {
                    assert!(
                        (0..size).step_by(4001).all(|k| *array.add(k) == value),
                        "nobody else writes there"
                    );
                }
            }
        }
        let large: usize = arrays.iter().map(|&(_, size, _)| size).filter(|&size| size >= LARGE).sum();
        assert_eq!(heap.bytes_in_file(), large, "all large ones are in the file");
        for (array, size, _) in arrays {
            // SAFETY: as above.
            unsafe { heap.dealloc(array, layout(size)) };
        }
        let area = heap.area.lock().expect("nobody panics with it");
        let free = &area.as_ref().expect("a file").free;
        assert_eq!((heap.bytes_in_file(), free.len()), (0, 1), "one range again: {free:?}");
        let blocks = area
            .as_ref()
            .map(|area| std::os::unix::fs::MetadataExt::blocks(&area.file.metadata().expect("data")));
        assert!(blocks < Some(1024), "the disk has its blocks back: {blocks:?}");
    }

    #[test]
    fn folders_that_do_not_exist_are_refused() {
        assert!(FileHeap::new().page_to(Path::new("no/such/folder")).is_err());
    }
}

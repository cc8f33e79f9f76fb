// SPDX-License-Identifier: GPL-3.0-or-later
//! Memory that holds machine code: written first, then executable, never both at once.
//! Over the calls of the operating system.
//! Tests: all tests that run code in `tests/agreement.rs`.

use std::ptr::NonNull;

/// Machine code that can be called. It is not written any more.
pub(crate) struct Executable {
    start: NonNull<u8>,
    length: usize,
}

// SAFETY: the memory is only read and executed once it is made.
unsafe impl Send for Executable {}
// SAFETY: as above.
unsafe impl Sync for Executable {}

impl Executable {
    /// Where it is.
    pub(crate) fn start(&self) -> *const u8 {
        self.start.as_ptr()
    }
}

#[cfg(unix)]
impl Executable {
    /// Allocates memory for code.
    ///
    /// # Errors
    /// The system's message: there may be no memory, or executable memory may be forbidden.
    pub(crate) fn new(code: &[u8]) -> Result<Self, String> {
        let length = code.len().max(1);
        let refused = || format!("no memory for machine code: {}", std::io::Error::last_os_error());
        // SAFETY: a new private mapping touches no memory of this program.
        let start = unsafe {
            libc::mmap(
                std::ptr::null_mut(),
                length,
                libc::PROT_READ | libc::PROT_WRITE,
                libc::MAP_PRIVATE | libc::MAP_ANON,
                -1,
                0,
            )
        };
        let start = match NonNull::new(start.cast::<u8>()) {
            Some(start) if start.as_ptr() as isize != -1 => start,
            _ => return Err(refused()),
        };
        let this = Self { start, length };
        // SAFETY: the mapping has `length` bytes without other users, and may be written until `mprotect`.
        unsafe { std::ptr::copy_nonoverlapping(code.as_ptr(), start.as_ptr(), code.len()) };
        // SAFETY: it is the mapping made above.
        let done =
            unsafe { libc::mprotect(start.as_ptr().cast(), length, libc::PROT_READ | libc::PROT_EXEC) };
        if done == 0 { Ok(this) } else { Err(refused()) }
    }
}

#[cfg(unix)]
impl Drop for Executable {
    fn drop(&mut self) {
        // SAFETY: the mapping made by `new`; callers into it hold a reference to this.
        unsafe { libc::munmap(self.start.as_ptr().cast(), self.length) };
    }
}

#[cfg(windows)]
mod windows {
    use std::ffi::c_void;

    pub(super) const COMMIT: u32 = 0x3000;
    pub(super) const RELEASE: u32 = 0x8000;
    pub(super) const READ_WRITE: u32 = 0x04;
    pub(super) const EXECUTE_READ: u32 = 0x20;

    #[link(name = "kernel32")]
    unsafe extern "system" {
        pub(super) fn VirtualAlloc(at: *mut c_void, size: usize, kind: u32, protection: u32) -> *mut c_void;
        pub(super) fn VirtualProtect(at: *mut c_void, size: usize, protection: u32, before: *mut u32) -> i32;
        pub(super) fn VirtualFree(at: *mut c_void, size: usize, kind: u32) -> i32;
    }
}

#[cfg(windows)]
impl Executable {
    /// Allocates memory for code.
    ///
    /// # Errors
    /// The system's message.
    pub(crate) fn new(code: &[u8]) -> Result<Self, String> {
        let length = code.len().max(1);
        let refused = || format!("no memory for machine code: {}", std::io::Error::last_os_error());
        // SAFETY: new pages touch no memory of this program.
        let start = unsafe {
            windows::VirtualAlloc(std::ptr::null_mut(), length, windows::COMMIT, windows::READ_WRITE)
        };
        let start = NonNull::new(start.cast::<u8>()).ok_or_else(refused)?;
        let this = Self { start, length };
        // SAFETY: the pages have `length` bytes without other users, and may be written until they are
        // protected.
        unsafe { std::ptr::copy_nonoverlapping(code.as_ptr(), start.as_ptr(), code.len()) };
        let mut before = 0;
        // SAFETY: the pages made above.
        let done = unsafe {
            windows::VirtualProtect(start.as_ptr().cast(), length, windows::EXECUTE_READ, &mut before)
        };
        if done != 0 { Ok(this) } else { Err(refused()) }
    }
}

#[cfg(windows)]
impl Drop for Executable {
    fn drop(&mut self) {
        // SAFETY: the pages made by `new`; callers into them hold a reference to this.
        unsafe { windows::VirtualFree(self.start.as_ptr().cast(), 0, windows::RELEASE) };
    }
}

#[cfg(not(any(unix, windows)))]
impl Executable {
    /// There is no such memory here.
    ///
    /// # Errors
    /// Always.
    pub(crate) fn new(_: &[u8]) -> Result<Self, String> {
        Err("this system has no executable memory".into())
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Memory that holds machine code: written first, then executable, never both at once.
//! Over the calls of the operating system. CPUs of ARM fetch instructions past the cache of data: there code
//! is written back, and old instructions are dropped.
//! Source: Arm's Architecture Reference Manual for A-profile, chapter B2 (concurrent modification and
//! execution of instructions); Apple's *Porting just-in-time compilers to Apple silicon*.
//! Tests: all tests that run code in `tests/agreement.rs`.

use std::ptr::NonNull;

/// Machine code that can be called. It is not written any more.
pub(crate) struct Executable {
    start: NonNull<u8>,
    #[cfg(unix)]
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

/// What a thread does before it runs code that another one has made: instructions fetched before are dropped.
#[cfg(target_arch = "aarch64")]
pub(crate) fn see_code() {
    // SAFETY: the instruction changes no register and no memory.
    unsafe { std::arch::asm!("isb", options(nostack, preserves_flags)) };
}

/// Other CPUs see code that is written.
#[cfg(not(target_arch = "aarch64"))]
pub(crate) fn see_code() {}

/// Lets instructions be fetched from memory that was written.
#[cfg(all(target_arch = "aarch64", unix, not(target_os = "macos")))]
fn publish(start: *const u8, length: usize) {
    let sizes: u64;
    // SAFETY: the register only tells the sizes of cache lines; the systems let programs read it.
    unsafe {
        std::arch::asm!("mrs {}, ctr_el0", out(reg) sizes, options(nomem, nostack, preserves_flags));
    }
    let (first, end) = (start as usize, start as usize + length);
    let line = |log: u64| 4_usize << (log & 15);
    let (data, instructions) = (line(sizes >> 16), line(sizes));
    for at in (first / data * data..end).step_by(data) {
        // SAFETY: a line of the mapping is written back, and keeps its contents.
        unsafe { std::arch::asm!("dc cvau, {}", in(reg) at, options(nostack, preserves_flags)) };
    }
    // SAFETY: waits for the above.
    unsafe { std::arch::asm!("dsb ish", options(nostack, preserves_flags)) };
    for at in (first / instructions * instructions..end).step_by(instructions) {
        // SAFETY: a line of the cache of instructions is dropped, to be fetched again.
        unsafe { std::arch::asm!("ic ivau, {}", in(reg) at, options(nostack, preserves_flags)) };
    }
    // SAFETY: waits for the above, on all CPUs.
    unsafe { std::arch::asm!("dsb ish", "isb", options(nostack, preserves_flags)) };
}

/// x86 needs nothing for that.
#[cfg(all(not(target_arch = "aarch64"), unix))]
fn publish(_: *const u8, _: usize) {}

#[cfg(all(unix, not(all(target_arch = "aarch64", target_os = "macos"))))]
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
        if done != 0 {
            return Err(refused());
        }
        publish(start.as_ptr(), length);
        Ok(this)
    }
}

#[cfg(all(target_arch = "aarch64", target_os = "macos"))]
mod apple {
    unsafe extern "C" {
        pub(super) fn sys_icache_invalidate(start: *mut std::ffi::c_void, length: usize);
    }
}

/// Apple's CPUs have memory that a thread either writes or executes, by a switch of its own. Programs of the
/// hardened runtime need the entitlement `com.apple.security.cs.allow-jit` for it.
#[cfg(all(target_arch = "aarch64", target_os = "macos"))]
impl Executable {
    /// Allocates memory for code.
    ///
    /// # Errors
    /// The system's message: there may be no memory, or executable memory may be forbidden.
    pub(crate) fn new(code: &[u8]) -> Result<Self, String> {
        let length = code.len().max(1);
        // SAFETY: a new private mapping touches no memory of this program.
        let start = unsafe {
            libc::mmap(
                std::ptr::null_mut(),
                length,
                libc::PROT_READ | libc::PROT_WRITE | libc::PROT_EXEC,
                libc::MAP_PRIVATE | libc::MAP_ANON | libc::MAP_JIT,
                -1,
                0,
            )
        };
        let start = match NonNull::new(start.cast::<u8>()) {
            Some(start) if start.as_ptr() as isize != -1 => start,
            _ => return Err(format!("no memory for machine code: {}", std::io::Error::last_os_error())),
        };
        // SAFETY: this thread executes no code of such memory until the switch is back. The mapping has
        // `length` bytes without other users.
        unsafe {
            libc::pthread_jit_write_protect_np(0);
            std::ptr::copy_nonoverlapping(code.as_ptr(), start.as_ptr(), code.len());
            libc::pthread_jit_write_protect_np(1);
            apple::sys_icache_invalidate(start.as_ptr().cast(), length);
        }
        Ok(Self { start, length })
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
        pub(super) fn GetCurrentProcess() -> *mut c_void;
        pub(super) fn FlushInstructionCache(process: *mut c_void, at: *const c_void, size: usize) -> i32;
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
        let this = Self { start };
        // SAFETY: the pages have `length` bytes without other users, and may be written until they are
        // protected.
        unsafe { std::ptr::copy_nonoverlapping(code.as_ptr(), start.as_ptr(), code.len()) };
        let mut before = 0;
        // SAFETY: the pages made above.
        let done = unsafe {
            windows::VirtualProtect(start.as_ptr().cast(), length, windows::EXECUTE_READ, &mut before)
        };
        if done == 0 {
            return Err(refused());
        }
        // SAFETY: the pages made above, of this process.
        let done = unsafe {
            windows::FlushInstructionCache(windows::GetCurrentProcess(), start.as_ptr().cast(), length)
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

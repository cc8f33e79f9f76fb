// SPDX-License-Identifier: GPL-3.0-or-later
//! The exported functions of the window, and the program's functions that it calls.
//! Source: names after GLUT. No panic leaves: a stopped call has no effect. No lock is held while functions
//! of the program or of libOpenRT run, which calls the program's rtDebugCallback; both may call back, and
//! exceptions of C++ pass to the program's own handler. Tests: tests/window.rs.

use std::cell::Cell;
use std::ffi::{CStr, CString, c_char, c_int, c_uchar};
use std::ptr::{with_exposed_provenance, with_exposed_provenance_mut};
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use crate::guard::guard;
use crate::window::{FRAME, Format, LARGEST, Program, Renderer, Settings, Stage, Use, finish, run, swap};

const RT_RGB_8: u32 = 0x310;
const RT_NEXT_FRAME_BIT: u32 = 1;
const RT_IN_FLIGHT_BIT: u32 = 2;

// They report errors to the program, and may be left by its exceptions.
unsafe extern "C-unwind" {
    unsafe fn rtSetFrameBuffer(pixels: *mut u8, width: u32, height: u32, format: u32);
    safe fn rtFrameBufferUse(pixels: *const u8) -> u32;
    safe fn rtStartRendering();
    safe fn rtEndRendering();
}

/// The process's libOpenRT.
struct Library;

impl Renderer for Library {
    fn usage(&self, memory: usize) -> Use {
        let bits = rtFrameBufferUse(with_exposed_provenance(memory));
        Use { next: bits & RT_NEXT_FRAME_BIT != 0, in_flight: bits & RT_IN_FLIGHT_BIT != 0 }
    }

    fn aim(&self, memory: usize, [width, height]: [u32; 2]) {
        // SAFETY: the buffer holds 3 bytes for each pixel; `Stage` neither moves nor frees it while libOpenRT
        // uses it by `usage`.
        unsafe { rtSetFrameBuffer(with_exposed_provenance_mut(memory), width, height, RT_RGB_8) };
    }

    fn start(&self) {
        rtStartRendering();
    }

    fn end(&self) {
        rtEndRendering();
    }
}

type Plain = Option<unsafe extern "C-unwind" fn()>;
type Pair = Option<unsafe extern "C-unwind" fn(c_int, c_int)>;
type Keyboard = Option<unsafe extern "C-unwind" fn(c_uchar, c_int, c_int)>;
type Special = Option<unsafe extern "C-unwind" fn(c_int, c_int, c_int)>;
type Mouse = Option<unsafe extern "C-unwind" fn(c_int, c_int, c_int, c_int)>;

/// The functions that the program has given.
#[derive(Clone, Copy, Default)]
struct Callbacks {
    display: Plain,
    idle: Plain,
    reshape: Pair,
    motion: Pair,
    passive_motion: Pair,
    keyboard: Keyboard,
    special: Special,
    mouse: Mouse,
}

struct Shared {
    callbacks: Callbacks,
    stage: Stage,
    /// The last error.
    error: CString,
    begin: Instant,
    /// As of the last main loop, or of the first question before it: reading the environment at any time would race with a program
    /// that changes it.
    settings: Option<Settings>,
}

static SHARED: LazyLock<Mutex<Shared>> = LazyLock::new(|| {
    Mutex::new(Shared {
        callbacks: Callbacks::default(),
        stage: Stage::default(),
        error: CString::default(),
        begin: Instant::now(),
        settings: None,
    })
});

fn shared() -> MutexGuard<'static, Shared> {
    SHARED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Runs `f` on the shared state; a panic ends it with the default result.
fn with<T: Default>(f: impl FnOnce(&mut Shared) -> T) -> T {
    guard(|| f(&mut shared())).unwrap_or_default()
}

/// One thread at a time deals with frames.
static FRAMES: Mutex<()> = Mutex::new(());

thread_local! {
    /// Whether this thread does: called functions may call back.
    static DEALS: Cell<bool> = const { Cell::new(false) };
}

/// The right to deal with frames. It ends when it is dropped, by an exception too.
struct FrameGuard {
    _guard: MutexGuard<'static, ()>,
}

impl FrameGuard {
    /// Waits until no other thread has it. `None` if this one has.
    fn take() -> Option<Self> {
        if DEALS.get() {
            return None;
        }
        let guard = FRAMES.lock().unwrap_or_else(PoisonError::into_inner);
        DEALS.set(true);
        Some(Self { _guard: guard })
    }
}

impl Drop for FrameGuard {
    fn drop(&mut self) {
        DEALS.set(false);
    }
}

fn settings() -> Settings {
    Settings::read(|name| std::env::var_os(name))
}

/// The program, by the functions that it has given; the lock is never held while one of them runs.
struct Client;

impl Program for Client {
    fn display(&self) {
        let callback = shared().callbacks.display;
        if let Some(call) = callback {
            // SAFETY: the program passed a function of this type, as the header requires.
            unsafe { call() }
        }
    }

    fn reshape(&self, [width, height]: [u32; 2]) {
        let callback = shared().callbacks.reshape;
        if let Some(call) = callback {
            // SAFETY: as in `display`.
            unsafe { call(width as c_int, height as c_int) }
        }
    }

    fn keyboard(&self, key: u8, [x, y]: [i32; 2]) {
        let callback = shared().callbacks.keyboard;
        if let Some(call) = callback {
            // SAFETY: as in `display`.
            unsafe { call(key, x, y) }
        }
    }

    fn special(&self, key: i32, [x, y]: [i32; 2]) {
        let callback = shared().callbacks.special;
        if let Some(call) = callback {
            // SAFETY: as in `display`.
            unsafe { call(key, x, y) }
        }
    }

    fn mouse(&self, button: i32, is_up: bool, [x, y]: [i32; 2]) {
        let callback = shared().callbacks.mouse;
        if let Some(call) = callback {
            // SAFETY: as in `display`.
            unsafe { call(button, c_int::from(is_up), x, y) }
        }
    }

    fn motion(&self, [x, y]: [i32; 2], dragged: bool) {
        let Callbacks { motion, passive_motion, .. } = shared().callbacks;
        if let Some(call) = if dragged { motion } else { passive_motion } {
            // SAFETY: as in `display`.
            unsafe { call(x, y) }
        }
    }

    fn idle(&self) -> bool {
        let callback = shared().callbacks.idle;
        if let Some(call) = callback {
            // SAFETY: as in `display`.
            unsafe { call() }
        }
        callback.is_some()
    }

    fn finish(&self) {
        if let Some(_guard) = FrameGuard::take() {
            finish(self, &Library);
        }
    }

    fn stage(&self, f: &mut dyn FnMut(&mut Stage)) {
        with(|shared| f(&mut shared.stage));
    }
}

#[unsafe(no_mangle)]
unsafe extern "C-unwind" fn rtutInitWindow(width: c_int, height: c_int, title: *const c_char) {
    let size = [width, height].map(|side| u32::try_from(side).unwrap_or(0));
    if size.iter().any(|side| !(1..=LARGEST).contains(side)) {
        return;
    }
    with(|shared| {
        let title = if title.is_null() {
            String::new()
        } else {
            // SAFETY: the header requires a string that ends with a zero, or NULL.
            unsafe { CStr::from_ptr(title) }.to_string_lossy().into_owned()
        };
        let stage = &mut shared.stage;
        (stage.size, stage.title, stage.is_requested) = (size, title, true);
    });
}

#[unsafe(no_mangle)]
extern "C-unwind" fn rtutMainLoop() -> u8 {
    // Nothing here is guarded as a whole: the program's exceptions pass through to its own handler.
    Client.finish();
    let settings = guard(settings).unwrap_or_default();
    let is_requested = with(|shared| {
        shared.stage.begin();
        shared.begin = Instant::now();
        shared.settings = Some(settings.clone());
        shared.stage.is_requested
    });
    let outcome =
        if is_requested { run(&Client, &settings) } else { Err("rtutInitWindow was not called".to_owned()) };
    // A program that continues finds no frame of ours in progress.
    Client.finish();
    let is_fine = outcome.is_ok();
    with(|shared| shared.error = CString::new(outcome.err().unwrap_or_default()).unwrap_or_default());
    u8::from(is_fine)
}

#[unsafe(no_mangle)]
extern "C-unwind" fn rtutLeaveMainLoop() {
    with(|shared| shared.stage.leave());
}

#[unsafe(no_mangle)]
extern "C-unwind" fn rtutErrorString() -> *const c_char {
    // The text stays until the next main loop ends.
    guard(|| shared().error.as_ptr()).unwrap_or(c"".as_ptr())
}

#[unsafe(no_mangle)]
extern "C-unwind" fn rtutDisplayFunc(function: Plain) {
    with(|shared| shared.callbacks.display = function);
}

#[unsafe(no_mangle)]
extern "C-unwind" fn rtutIdleFunc(function: Plain) {
    with(|shared| shared.callbacks.idle = function);
}

#[unsafe(no_mangle)]
extern "C-unwind" fn rtutReshapeFunc(function: Pair) {
    with(|shared| shared.callbacks.reshape = function);
}

#[unsafe(no_mangle)]
extern "C-unwind" fn rtutKeyboardFunc(function: Keyboard) {
    with(|shared| shared.callbacks.keyboard = function);
}

#[unsafe(no_mangle)]
extern "C-unwind" fn rtutSpecialFunc(function: Special) {
    with(|shared| shared.callbacks.special = function);
}

#[unsafe(no_mangle)]
extern "C-unwind" fn rtutMouseFunc(function: Mouse) {
    with(|shared| shared.callbacks.mouse = function);
}

#[unsafe(no_mangle)]
extern "C-unwind" fn rtutMotionFunc(function: Pair) {
    with(|shared| shared.callbacks.motion = function);
}

#[unsafe(no_mangle)]
extern "C-unwind" fn rtutPassiveMotionFunc(function: Pair) {
    with(|shared| shared.callbacks.passive_motion = function);
}

#[unsafe(no_mangle)]
extern "C-unwind" fn rtutPostRedisplay() {
    with(|shared| shared.stage.redisplay());
}

#[unsafe(no_mangle)]
extern "C-unwind" fn rtutSwapBuffers() {
    // Called back from within, by rtDebugCallback, it has no effect.
    if let Some(_guard) = FrameGuard::take() {
        swap(&Client, &Library);
    }
}

#[unsafe(no_mangle)]
unsafe extern "C-unwind" fn rtutShowPixels(pixels: *const u8, width: u32, height: u32, format: u32) {
    let Some(format) = Format::from_code(format) else { return };
    let sizes = 1..=LARGEST;
    if pixels.is_null() || !sizes.contains(&width) || !sizes.contains(&height) {
        return;
    }
    with(|shared| {
        let bytes = width as usize * height as usize * format.pixel_bytes();
        // SAFETY: the header requires a frame buffer of this size and format, which is no larger than memory.
        let bytes = unsafe { std::slice::from_raw_parts(pixels, bytes) };
        shared.stage.show(bytes, [width, height], format);
    });
}

#[unsafe(no_mangle)]
extern "C-unwind" fn rtutWindowWidth() -> c_int {
    with(|shared| shared.stage.size[0] as c_int)
}

#[unsafe(no_mangle)]
extern "C-unwind" fn rtutWindowHeight() -> c_int {
    with(|shared| shared.stage.size[1] as c_int)
}

#[unsafe(no_mangle)]
extern "C-unwind" fn rtutElapsedTime() -> c_int {
    with(|shared| {
        if shared.settings.get_or_insert_with(settings).headless {
            let begun = shared.stage.pictures + u64::from(shared.stage.flight().is_some());
            return c_int::try_from(begun).unwrap_or(c_int::MAX).saturating_mul(FRAME);
        }
        c_int::try_from(shared.begin.elapsed().as_millis()).unwrap_or(c_int::MAX)
    })
}

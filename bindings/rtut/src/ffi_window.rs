// SPDX-License-Identifier: GPL-3.0-or-later
//! The exported functions of the window, and the program's functions that it calls.
//! Source: original; names after GLUT. No panic leaves: what one stops has no effect. Proof: tests/window.rs.

use std::ffi::{CStr, CString, c_char, c_int, c_uchar};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use crate::window::{FRAME, Format, LARGEST, Program, Renderer, Settings, Stage, run};

const RT_RGB_8: u32 = 0x310;

unsafe extern "C" {
    unsafe fn rtSetFrameBuffer(pixels: *mut u8, width: u32, height: u32, format: u32);
    safe fn rtStartRendering();
    safe fn rtEndRendering();
}

/// The process's libOpenRT.
struct Library;

impl Renderer for Library {
    fn start(&self, buffer: &mut [u8], [width, height]: [u32; 2]) -> bool {
        // SAFETY: the buffer holds 3 bytes for each pixel; `Stage` neither moves nor frees it before `end`.
        unsafe { rtSetFrameBuffer(buffer.as_mut_ptr(), width, height, RT_RGB_8) };
        rtStartRendering();
        true
    }

    fn end(&self) {
        rtEndRendering();
    }
}

type Plain = Option<unsafe extern "C" fn()>;
type Pair = Option<unsafe extern "C" fn(c_int, c_int)>;
type Keyboard = Option<unsafe extern "C" fn(c_uchar, c_int, c_int)>;
type Special = Option<unsafe extern "C" fn(c_int, c_int, c_int)>;
type Mouse = Option<unsafe extern "C" fn(c_int, c_int, c_int, c_int)>;

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
    /// What went wrong last.
    error: CString,
    begin: Instant,
}

static SHARED: LazyLock<Mutex<Shared>> = LazyLock::new(|| {
    let stage = Stage::new(Box::new(Library));
    Mutex::new(Shared {
        callbacks: Callbacks::default(),
        stage,
        error: CString::default(),
        begin: Instant::now(),
    })
});

fn shared() -> MutexGuard<'static, Shared> {
    SHARED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Runs `f`; a panic ends it with the default answer.
fn guard<T: Default>(f: impl FnOnce() -> T) -> T {
    catch_unwind(AssertUnwindSafe(f)).unwrap_or_default()
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
            // SAFETY: what the program gave is a function of this type, as the header asks for.
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

    fn stage(&self, with: &mut dyn FnMut(&mut Stage)) {
        with(&mut shared().stage);
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn rtutInitWindow(width: c_int, height: c_int, title: *const c_char) {
    guard(|| {
        let size = [width, height].map(|side| u32::try_from(side).unwrap_or(0));
        if size.iter().any(|side| !(1..=LARGEST).contains(side)) {
            return;
        }
        let title = if title.is_null() {
            String::new()
        } else {
            // SAFETY: the header asks for a string that ends with a zero, or NULL.
            unsafe { CStr::from_ptr(title) }.to_string_lossy().into_owned()
        };
        let stage = &mut shared().stage;
        (stage.size, stage.title, stage.is_wanted) = (size, title, true);
    });
}

#[unsafe(no_mangle)]
extern "C" fn rtutMainLoop() -> u8 {
    guard(|| {
        let settings = settings();
        let is_wanted = {
            let mut shared = shared();
            shared.stage.begin();
            shared.begin = Instant::now();
            shared.stage.is_wanted
        };
        let outcome =
            if is_wanted { run(&Client, &settings) } else { Err("rtutInitWindow was not called".to_owned()) };
        // A program that goes on finds no frame of ours under way.
        let mut shared = shared();
        shared.stage.finish();
        shared.error = CString::new(outcome.as_ref().err().cloned().unwrap_or_default()).unwrap_or_default();
        u8::from(outcome.is_ok())
    })
}

#[unsafe(no_mangle)]
extern "C" fn rtutLeaveMainLoop() {
    guard(|| shared().stage.is_leaving = true);
}

#[unsafe(no_mangle)]
extern "C" fn rtutErrorString() -> *const c_char {
    // What it points to stays until the next main loop ends.
    catch_unwind(|| shared().error.as_ptr()).unwrap_or(c"".as_ptr())
}

#[unsafe(no_mangle)]
extern "C" fn rtutDisplayFunc(function: Plain) {
    guard(|| shared().callbacks.display = function);
}

#[unsafe(no_mangle)]
extern "C" fn rtutIdleFunc(function: Plain) {
    guard(|| shared().callbacks.idle = function);
}

#[unsafe(no_mangle)]
extern "C" fn rtutReshapeFunc(function: Pair) {
    guard(|| shared().callbacks.reshape = function);
}

#[unsafe(no_mangle)]
extern "C" fn rtutKeyboardFunc(function: Keyboard) {
    guard(|| shared().callbacks.keyboard = function);
}

#[unsafe(no_mangle)]
extern "C" fn rtutSpecialFunc(function: Special) {
    guard(|| shared().callbacks.special = function);
}

#[unsafe(no_mangle)]
extern "C" fn rtutMouseFunc(function: Mouse) {
    guard(|| shared().callbacks.mouse = function);
}

#[unsafe(no_mangle)]
extern "C" fn rtutMotionFunc(function: Pair) {
    guard(|| shared().callbacks.motion = function);
}

#[unsafe(no_mangle)]
extern "C" fn rtutPassiveMotionFunc(function: Pair) {
    guard(|| shared().callbacks.passive_motion = function);
}

#[unsafe(no_mangle)]
extern "C" fn rtutPostRedisplay() {
    guard(|| shared().stage.is_stale = true);
}

#[unsafe(no_mangle)]
extern "C" fn rtutSwapBuffers() {
    guard(|| shared().stage.swap());
}

#[unsafe(no_mangle)]
unsafe extern "C" fn rtutShowPixels(pixels: *const u8, width: u32, height: u32, format: u32) {
    guard(|| {
        let Some(format) = Format::from_code(format) else { return };
        let sizes = 1..=LARGEST;
        if pixels.is_null() || !sizes.contains(&width) || !sizes.contains(&height) {
            return;
        }
        let bytes = width as usize * height as usize * format.pixel_bytes();
        // SAFETY: the header asks for a frame buffer of this size and format, which is no larger than memory.
        let bytes = unsafe { std::slice::from_raw_parts(pixels, bytes) };
        shared().stage.show(bytes, [width, height], format);
    });
}

#[unsafe(no_mangle)]
extern "C" fn rtutWindowWidth() -> c_int {
    guard(|| shared().stage.size[0] as c_int)
}

#[unsafe(no_mangle)]
extern "C" fn rtutWindowHeight() -> c_int {
    guard(|| shared().stage.size[1] as c_int)
}

#[unsafe(no_mangle)]
extern "C" fn rtutElapsedTime() -> c_int {
    guard(|| {
        let shared = shared();
        if settings().headless {
            let begun = shared.stage.pictures + u64::from(shared.stage.is_rendering());
            return c_int::try_from(begun).unwrap_or(c_int::MAX).saturating_mul(FRAME);
        }
        c_int::try_from(shared.begin.elapsed().as_millis()).unwrap_or(c_int::MAX)
    })
}

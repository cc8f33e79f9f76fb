// SPDX-License-Identifier: GPL-3.0-or-later
//! A device: settings, threads that build, and errors. The rules for recorded errors are those of Embree's
//! manual.
//! Invariant: the first error of a thread is stored until it is queried, for each device, and for calls
//! without a device.
//! Tests: `tests/c/embree.c`.

use std::cell::RefCell;
use std::collections::HashMap;
use std::ffi::{CStr, CString};
use std::io::Write;
use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU64, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};

use gnurt_accel::Level;

use crate::ffi_abi::Code;
use crate::ffi_callbacks::{Callback, ErrorFunction, MemoryFunction};
use crate::ffi_catch::Thrown;
use crate::pools::Workers;

/// An error, and its message.
#[derive(Clone, Debug)]
pub(crate) struct Problem {
    pub(crate) code: Code,
    pub(crate) message: String,
}

impl Problem {
    pub(crate) fn argument(message: impl Into<String>) -> Self {
        Self { code: Code::InvalidArgument, message: message.into() }
    }

    pub(crate) fn operation(message: impl Into<String>) -> Self {
        Self { code: Code::InvalidOperation, message: message.into() }
    }

    /// The same with the number of a geometry.
    pub(crate) fn of_geometry(self, geom_id: u32) -> Self {
        Self { message: format!("geometry {geom_id}: {}", self.message), ..self }
    }
}

impl From<Thrown> for Problem {
    fn from(thrown: Thrown) -> Self {
        Self { code: Code::Unknown, message: thrown.to_string() }
    }
}

/// The target of `RTCDevice`.
#[derive(Debug)]
pub(crate) struct Device {
    number: u64,
    /// 0 = one per processor.
    threads: usize,
    pub(crate) level: Level,
    pub(crate) is_verbose: bool,
    /// Whether spheres are hit from outside only.
    pub(crate) culls_spheres: bool,
    /// Whether round curves are, of which straight ones always are.
    pub(crate) culls_curves: bool,
    /// Whether the program uses arrays of instances, and so has memory for the numbers of instances in hits
    /// and contexts.
    pub(crate) has_arrays: AtomicBool,
    pub(crate) on_error: Mutex<Option<Callback<ErrorFunction>>>,
    pub(crate) monitor: Mutex<Option<Callback<MemoryFunction>>>,
    held: AtomicI64,
}

/// The key of errors of calls without a device.
const NO_DEVICE: u64 = 0;

/// A first error, and the last message.
#[derive(Default)]
struct ErrorState {
    first: Option<Code>,
    last: CString,
}

thread_local! {
    static ERRORS: RefCell<HashMap<u64, ErrorState>> = RefCell::default();
}

fn keep(number: u64, code: Code, message: &CStr) {
    ERRORS.with_borrow_mut(|errors| {
        let retained = errors.entry(number).or_default();
        retained.first.get_or_insert(code);
        retained.last = message.to_owned();
    });
}

/// Reports where there is no device, or none that can be found.
pub(crate) fn report_without_device(problem: &Problem) {
    keep(NO_DEVICE, problem.code, &text(&problem.message));
}

fn text(message: &str) -> CString {
    CString::new(message.replace('\0', " ")).unwrap_or_default()
}

impl Device {
    /// From settings such as `threads=4,isa=avx2`; unknown ones are ignored.
    ///
    /// # Errors
    /// An invalid number of threads.
    pub(crate) fn new(settings: &str) -> Result<Self, Problem> {
        static NEXT: AtomicU64 = AtomicU64::new(NO_DEVICE + 1);
        let mut device = Self {
            number: NEXT.fetch_add(1, Ordering::Relaxed),
            threads: 0,
            level: Level::default(),
            is_verbose: false,
            culls_spheres: is_blender(),
            culls_curves: false,
            has_arrays: AtomicBool::new(false),
            on_error: Mutex::default(),
            monitor: Mutex::default(),
            held: AtomicI64::new(0),
        };
        let more = std::env::var("GNURT_EMBREE").unwrap_or_default();
        let settings = format!("{settings},{more}");
        // Blanks may surround names and values, and separate settings where there is no comma.
        let tokens = settings.replace('=', " = ");
        let mut tokens =
            tokens.split([',', ' ', '\t', '\n', '\r']).filter(|token| !token.is_empty()).peekable();
        let mut pairs = Vec::new();
        while let Some(name) = tokens.next() {
            if tokens.next_if_eq(&"=").is_some() {
                pairs.push((name, tokens.next().unwrap_or_default()));
            }
        }
        for setting in pairs {
            match setting {
                ("threads", count) => {
                    device.threads = count.parse().map_err(|_| {
                        Problem::argument(format!("threads={count}: a number is expected, 0 for all"))
                    })?;
                }
                ("backface_culling_spheres", value) => device.culls_spheres = value != "0",
                ("backface_culling_curves", value) => device.culls_curves = value != "0",
                ("verbose", value) => device.is_verbose = value != "0",
                ("isa" | "max_isa", name) => device.level = level(name),
                _ => {}
            }
        }
        Ok(device)
    }

    /// Records a problem and reports it to the program.
    pub(crate) fn report(&self, problem: &Problem) {
        let message = text(&problem.message);
        keep(self.number, problem.code, &message);
        let on_error = *self.on_error.lock().unwrap_or_else(PoisonError::into_inner);
        match on_error {
            Some(on_error) => on_error.call(problem.code as u32, &message),
            // Without standard error there is no message.
            None if self.is_verbose => {
                let _ = writeln!(std::io::stderr(), "gnurt: {}", problem.message);
            }
            None => {}
        }
    }

    /// For a build over a number of primitives.
    pub(crate) fn workers(&self, primitives: usize) -> Workers {
        // Starting threads takes as long as building over some thousand triangles.
        if primitives < 4096 { Workers::single() } else { Workers::new(self.threads) }
    }

    /// Reports a change of memory in bytes to the monitor. The result is false if the monitor refuses it.
    pub(crate) fn report_memory(&self, bytes: i64) -> Result<bool, Thrown> {
        self.held.fetch_add(bytes, Ordering::Relaxed);
        let monitor = *self.monitor.lock().unwrap_or_else(PoisonError::into_inner);
        match monitor {
            Some(monitor) if bytes != 0 => Ok(monitor.call(bytes, bytes < 0)? || bytes < 0),
            _ => Ok(true),
        }
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // Its thread-local errors of other threads go with those threads.
        let _ = ERRORS.try_with(|errors| errors.borrow_mut().remove(&self.number));
    }
}

/// The first error of this thread since the last query; for `None` that of calls without a device.
pub(crate) fn take_error(device: Option<&Device>) -> Code {
    let number = device.map_or(NO_DEVICE, |device| device.number);
    let taken =
        ERRORS.with_borrow_mut(|errors| errors.get_mut(&number).and_then(|retained| retained.first.take()));
    taken.unwrap_or(Code::None)
}

/// Shows the last message of this thread, which stays where it is until the next error.
pub(crate) fn with_last_message<R>(device: Option<&Device>, show: impl FnOnce(Option<&CStr>) -> R) -> R {
    let number = device.map_or(NO_DEVICE, |device| device.number);
    ERRORS.with_borrow(|errors| show(errors.get(&number).map(|retained| retained.last.as_c_str())))
}

/// Whether the program is Blender, or has it as a Python module. Its own Embree is built to show spheres from
/// outside only, and programs cannot ask a device for that.
fn is_blender() -> bool {
    static FOUND: OnceLock<bool> = OnceLock::new();
    *FOUND.get_or_init(|| {
        let program = std::env::current_exe().ok();
        let is_program =
            program.and_then(|path| Some(path.file_name()?.to_str()?.starts_with("blender"))) == Some(true);
        let loaded = || std::fs::read_to_string("/proc/self/maps").unwrap_or_default();
        is_program || loaded().lines().any(|line| line.ends_with("/bpy/__init__.so"))
    })
}

/// Our level by the name of Embree's.
fn level(name: &str) -> Level {
    match name {
        "sse2" | "sse4.1" | "sse4.2" | "sse42" | "avx" => Level::Sse42,
        "avx2" => Level::Avx2,
        "avx512" | "avx512skx" => Level::Avx512,
        _ => name.parse().unwrap_or_default(),
    }
}

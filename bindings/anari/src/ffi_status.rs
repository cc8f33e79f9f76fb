// SPDX-License-Identifier: GPL-3.0-or-later
//! Status messages: each names the object and the parameter, and goes to the program's function.
//! Tests: tests/wrong.rs.

use std::ffi::{CString, c_char, c_int, c_void};
use std::sync::Mutex;

use crate::object::{Object, lock};
use crate::types::{self, DataType};

/// The program's function for messages.
pub(crate) type StatusCallback = unsafe extern "C-unwind" fn(
    user: *const c_void,
    device: *mut c_void,
    source: *mut c_void,
    source_type: DataType,
    severity: c_int,
    code: c_int,
    message: *const c_char,
);

/// How grave a message is: ANARIStatusSeverity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Severity {
    Fatal = 1,
    Error = 2,
    Warning = 3,
    Info = 5,
}

/// The kind of fault: ANARIStatusCode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Code {
    None = 0,
    Unknown = 1,
    Argument = 2,
    Operation = 3,
    Memory = 4,
}

#[derive(Clone, Copy)]
struct Listener {
    function: Option<StatusCallback>,
    user: usize,
}

/// Where messages go.
pub(crate) struct Reporter {
    device: usize,
    listener: Mutex<Listener>,
}

impl Reporter {
    /// Messages of `device` go to `function` with `user`.
    pub(crate) fn new(device: usize, function: Option<StatusCallback>, user: *const c_void) -> Self {
        Self { device, listener: Mutex::new(Listener { function, user: user as usize }) }
    }

    /// Sends messages elsewhere; a function is given as its address.
    pub(crate) fn listen(&self, function: usize, user: usize) {
        // SAFETY: the program gave the address as an ANARIStatusCallback, and `Option` of a function may be any address or 0.
        let function = unsafe { (&raw const function).cast::<Option<StatusCallback>>().read() };
        *lock(&self.listener) = Listener { function, user };
    }

    /// Sends a message about an object, or about the device.
    pub(crate) fn send(&self, about: Option<&Object>, severity: Severity, code: Code, text: &str) {
        let (source, kind) =
            about.map_or((self.device, types::DEVICE), |object| (object.handle, object.kind));
        let text = match about {
            Some(object) => format!("{}: {text}", object.label()),
            None => text.to_owned(),
        };
        // The lock is not held while the program's function runs.
        let listener = *lock(&self.listener);
        let Some(function) = listener.function else { return };
        let text = CString::new(text.replace('\0', " ")).unwrap_or_default();
        let call = || {
            // SAFETY: the program promises that its function takes these; the text lives until it returns.
            unsafe {
                function(
                    listener.user as *const c_void,
                    self.device as *mut c_void,
                    source as *mut c_void,
                    kind,
                    severity as c_int,
                    code as c_int,
                    text.as_ptr(),
                );
            }
        };
        // A panic of a Rust program's function ends here; no receiver is left for a report.
        drop(std::panic::catch_unwind(std::panic::AssertUnwindSafe(call)));
    }

    /// A warning about an object.
    pub(crate) fn warn(&self, about: &Object, text: &str) {
        self.send(Some(about), Severity::Warning, Code::Argument, text);
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! The report of a failed call to the program's author: the call, its arguments, the error (rtDebugCallback,
//! OPENRT_DEBUG).
//! Source: after OpenGL's KHR_debug. Tests: `tests`; tests/c/debug.c, tests/c_programs.rs.

use std::ffi::CStr;

use super::error::Error;

/// An argument of a call, as messages show it. `name` is that of the parameter.
pub(crate) trait Shown {
    /// The text.
    fn text(&self, name: &str) -> String;
}

/// Parameters whose numbers are constants of types.h.
const CONSTANTS: [&str; 7] = ["mode", "format", "target", "name", "value", "internal_format", "texel_type"];

macro_rules! shown_numbers {
    ($($type:ty)*) => {$(
        impl Shown for $type {
            fn text(&self, name: &str) -> String {
                if CONSTANTS.contains(&name) { format!("{self:#x}") } else { self.to_string() }
            }
        }
    )*};
}

shown_numbers! { i8 i16 i32 u8 u16 u32 }

macro_rules! shown_floats {
    ($($type:ty)*) => {$(
        impl Shown for $type {
            fn text(&self, _name: &str) -> String {
                self.to_string()
            }
        }
    )*};
}

shown_floats! { f32 f64 }

impl<T: Shown, const N: usize> Shown for Option<[T; N]> {
    fn text(&self, name: &str) -> String {
        self.as_ref().map_or_else(
            || "NULL".to_owned(),
            |numbers| format!("{{{}}}", numbers.each_ref().map(|number| number.text(name)).join(", ")),
        )
    }
}

impl Shown for Option<&CStr> {
    fn text(&self, _name: &str) -> String {
        self.map_or_else(|| "NULL".to_owned(), |text| format!("{:?}", text.to_string_lossy()))
    }
}

impl<T> Shown for *const T {
    fn text(&self, _name: &str) -> String {
        if self.is_null() { "NULL".to_owned() } else { format!("{:p}", *self) }
    }
}

impl<T> Shown for *mut T {
    fn text(&self, name: &str) -> String {
        self.cast_const().text(name)
    }
}

/// The line that OPENRT_DEBUG prints.
#[must_use]
pub(crate) fn line(error: Error, call: &str) -> String {
    format!("{call}: {}: {error}", error.name())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_are_readable() {
        assert_eq!(0x17_u32.text("mode"), "0x17", "constants are in the header in hexadecimal");
        assert_eq!(23_u32.text("id"), "23", "ids are counted");
        assert_eq!(0.5_f32.text("x"), "0.5", "numbers");
        assert_eq!(Some([1_i16, -2]).text("numbers"), "{1, -2}", "what a pointer points to");
        assert_eq!(None::<[f32; 3]>.text("numbers"), "NULL", "or that it does not");
        assert_eq!(Some(c"a \"b\"").text("name"), r#""a \"b\"""#, "texts");
        assert_eq!(std::ptr::null::<u8>().text("memory"), "NULL", "memory");
        let line = line(Error::InvalidEnum, "rtBegin(0x17)");
        assert!(line.starts_with("rtBegin(0x17): RT_INVALID_ENUM: a constant"), "{line}");
    }
}

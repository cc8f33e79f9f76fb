// SPDX-License-Identifier: GPL-3.0-or-later
//! Panics of the libraries that decode pictures: they become an error of the file.
//! Who prints panics asks [`expects_panics`] first: those of a decoder are no bugs of the program, and are told as errors.
//! Tests: `tests`.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::Error;

/// Decoders that run.
static DECODERS: AtomicUsize = AtomicUsize::new(0);

/// Whether a panic may become an error, since a picture is being decoded. For hooks of panics, which run before anybody
/// catches them: what comes from elsewhere meanwhile is to be told by who catches it.
#[must_use]
pub fn expects_panics() -> bool {
    DECODERS.load(Ordering::Relaxed) > 0
}

/// Runs a decoder; a panic of it is an error of the file.
pub(super) fn decode_guarded<T>(
    format: &'static str,
    decode: impl FnOnce() -> Result<T, Error>,
) -> Result<T, Error> {
    expecting_panics(decode).unwrap_or_else(|| Err(Error::corrupt(format, "the data contradicts itself")))
}

/// Runs a library that reads files of other kinds and may panic; `None` = it did, and the file contradicts itself.
pub fn expecting_panics<T>(work: impl FnOnce() -> T) -> Option<T> {
    DECODERS.fetch_add(1, Ordering::Relaxed);
    let done = catch_unwind(AssertUnwindSafe(work));
    DECODERS.fetch_sub(1, Ordering::Relaxed);
    done.ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panics_are_expected_while_a_decoder_runs() {
        let inner = decode_guarded("PNG", || {
            let panicked: Result<(), Error> = decode_guarded("EXR", || panic!("expected by this test"));
            assert!(expects_panics(), "the outer one still runs");
            Ok(panicked.expect_err("it panicked").to_string())
        });
        let said = inner.expect("the outer one did not panic");
        assert!(said.contains("EXR") && said.contains("contradicts itself"), "{said}");
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Panics of the libraries that decode pictures: they become an error of the file. Source: original.
//! Who prints panics asks [`expects_panics`] first: those of a decoder are no bugs of the program, and are told as errors.
//! Invariant: decoders run on the thread that calls. Proof: `tests`.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::Error;

thread_local! {
    /// Decoders that run on this thread, one within the other.
    static DECODERS: Cell<usize> = const { Cell::new(0) };
}

/// Whether a panic on this thread, now, becomes an error: a picture is being decoded. For hooks of panics, which run before
/// anybody catches them.
#[must_use]
pub fn expects_panics() -> bool {
    // A thread that ends has no decoder.
    DECODERS.try_with(|decoders| decoders.get() > 0).unwrap_or(false)
}

/// Runs a decoder; a panic of it is an error of the file.
pub(super) fn decode_guarded<T>(
    format: &'static str,
    decode: impl FnOnce() -> Result<T, Error>,
) -> Result<T, Error> {
    DECODERS.set(DECODERS.get() + 1);
    let decoded = catch_unwind(AssertUnwindSafe(decode));
    DECODERS.set(DECODERS.get() - 1);
    decoded.unwrap_or_else(|_| Err(Error::corrupt(format, "the data contradicts itself")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panics_are_expected_while_a_decoder_runs() {
        assert!(!expects_panics(), "nothing runs");
        let inner = decode_guarded("PNG", || {
            let panicked: Result<(), Error> = decode_guarded("EXR", || panic!("expected by this test"));
            assert!(expects_panics(), "the outer one still runs");
            Ok(panicked.expect_err("it panicked").to_string())
        });
        let said = inner.expect("the outer one did not panic");
        assert!(said.contains("EXR") && said.contains("contradicts itself"), "{said}");
        assert!(!expects_panics(), "all have ended");
    }
}

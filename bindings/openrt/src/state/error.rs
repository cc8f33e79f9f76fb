// SPDX-License-Identifier: GPL-3.0-or-later
//! The errors of the API, with the codes that `rtGetError` returns.
//! Invariant: a call that returns an error has changed nothing but the error flag.
//! Tests: tests/c/errors.c.

/// Why a call failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[repr(u32)]
pub(crate) enum Error {
    /// A constant that the call does not accept (IE).
    #[error("a constant is invalid for this call")]
    InvalidEnum = 0xFFFF_FE01,
    /// A pointer is null, a number out of range or an id unknown (IV).
    #[error("a pointer is null, a number out of range or an id unknown")]
    InvalidValue = 0xFFFF_FE02,
    /// The call does not fit the present state (IO).
    #[error("the call does not fit the present state")]
    InvalidOperation = 0xFFFF_FE03,
    /// A matrix stack is full.
    #[error("a matrix stack is full")]
    StackOverflow = 0xFFFF_FE04,
    /// A matrix stack has one matrix left.
    #[error("a matrix stack has one matrix left")]
    StackUnderflow = 0xFFFF_FE05,
    /// Memory, or the numbers of an id, have run out.
    #[error("memory or ids have run out")]
    OutOfMemory = 0xFFFF_FE06,
}

/// The result of most calls.
pub(crate) type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// The code of no error.
    pub(crate) const NONE_CODE: u32 = 0;

    /// Its constant's name in C.
    #[must_use]
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::InvalidEnum => "RT_INVALID_ENUM",
            Self::InvalidValue => "RT_INVALID_VALUE",
            Self::InvalidOperation => "RT_INVALID_OPERATION",
            Self::StackOverflow => "RT_STACK_OVERFLOW",
            Self::StackUnderflow => "RT_STACK_UNDERFLOW",
            Self::OutOfMemory => "RT_OUT_OF_MEMORY",
        }
    }

    /// The number that C programs see.
    #[must_use]
    pub(crate) fn code(self) -> u32 {
        self as u32
    }
}

/// The destination of numbers: a function that copies them to the program's memory.
pub(crate) type Writer<'a, T> = &'a mut dyn FnMut(&[T]);

/// The pointer's value, or the error that a null pointer gives.
pub(crate) fn not_null<T>(pointer: Option<T>) -> Result<T> {
    pointer.ok_or(Error::InvalidValue)
}

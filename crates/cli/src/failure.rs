// SPDX-License-Identifier: GPL-3.0-or-later
//! Why a command ended early, and its exit status. See docs/reference/cli.md.

use std::fmt;

/// The result of a command.
pub(crate) type Outcome = Result<(), Failure>;

/// An early end.
#[derive(Debug)]
pub(crate) enum Failure {
    /// An invalid request of the user: status 2.
    Usage(String),
    /// A file or a device did not do its part: status 1.
    Data(String),
    /// `diff` found a difference, and has reported it already: status 1.
    Differs,
    /// Standard output was closed by its reader: status 0.
    Unheard,
}

impl Failure {
    /// The user's mistake.
    pub(crate) fn usage(what: impl fmt::Display) -> Self {
        Self::Usage(what.to_string())
    }

    /// The data's or the system's.
    pub(crate) fn data(what: impl fmt::Display) -> Self {
        Self::Data(what.to_string())
    }

    /// The text after `error:`.
    pub(crate) fn message(&self) -> Option<&str> {
        match self {
            Self::Usage(message) | Self::Data(message) => Some(message),
            Self::Differs | Self::Unheard => None,
        }
    }

    /// The status that the program ends with.
    pub(crate) fn status(&self) -> u8 {
        match self {
            Self::Usage(_) => 2,
            Self::Data(_) | Self::Differs => 1,
            Self::Unheard => 0,
        }
    }
}

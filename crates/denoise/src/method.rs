// SPDX-License-Identifier: GPL-3.0-or-later
//! Which denoiser is requested, and which was used.

use std::fmt;
use std::str::FromStr;

use crate::error::Error;

/// Which denoiser is requested.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// OIDN where its library is found, else the built-in one.
    #[default]
    Auto,
    /// The built-in one: the same bits on any number of threads and any processor.
    BuiltIn,
    /// OIDN's, or an error.
    Oidn,
}

impl Method {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Auto, Self::BuiltIn, Self::Oidn];

    /// The name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::BuiltIn => "built-in",
            Self::Oidn => "oidn",
        }
    }
}

impl FromStr for Method {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self, Error> {
        let found = Self::ALL.into_iter().find(|method| method.name() == name);
        found.ok_or_else(|| Error::UnknownMethod {
            name: name.into(),
            expected: Self::ALL.map(Self::name).join(", "),
        })
    }
}

/// Which denoiser was used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Used {
    /// The built-in one. The text is the reason why it was not OIDN's, if that was searched.
    BuiltIn {
        /// The reason that OIDN was not used; `None` if it was not requested.
        without_oidn: Option<String>,
    },
    /// OIDN's.
    Oidn {
        /// As the library reports it: `2.3.3`.
        version: String,
        /// Its device, as in `OIDN_DEVICE_TYPE_CPU`: `CPU`.
        device: &'static str,
    },
}

impl Used {
    /// For a file's header: `built-in` or `oidn 2.3.3`.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Self::BuiltIn { .. } => Method::BuiltIn.name().into(),
            Self::Oidn { version, .. } => format!("{} {version}", Method::Oidn.name()),
        }
    }
}

impl fmt::Display for Used {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::BuiltIn { without_oidn: None } => write!(f, "denoised by the built-in filter"),
            Self::BuiltIn { without_oidn: Some(why) } => {
                write!(f, "denoised by the built-in filter: {why}")
            }
            Self::Oidn { version, device } => {
                write!(f, "denoised by Open Image Denoise {version} on the {device}")
            }
        }
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Choices that are read and shown by their names. Tests: `tests::names_round_trip` of `options`.

/// Makes a choice with `ALL` and `name` readable by `FromStr` and shown by `Display`; `$unknown` is the error, which lists all names of
/// `$what`.
macro_rules! by_name {
    ($choice:ident, $unknown:ident, $what:literal) => {
        impl std::fmt::Display for $choice {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.pad(self.name())
            }
        }

        impl std::str::FromStr for $choice {
            type Err = $unknown;

            fn from_str(name: &str) -> Result<Self, $unknown> {
                let found = Self::ALL.into_iter().find(|choice| choice.name() == name);
                found.ok_or_else(|| $unknown(name.to_owned()))
            }
        }

        #[doc = concat!("A name that is none of [`", stringify!($choice), "::ALL`].")]
        #[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
        #[error("unknown {what} '{0}': expected {names}", what = $what, names = $choice::ALL.map($choice::name).join(", "))]
        pub struct $unknown(pub String);
    };
}

pub(crate) use by_name;

// SPDX-License-Identifier: GPL-3.0-or-later
//! How pictures and volumes go on beyond their borders: OSL's wrap modes.
//! Source: the OSL specification, "Texture"; original. Tests: `tests/scripts/stored.rs`.

/// How a picture continues beyond its border.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wrap {
    Black,
    Clamp,
    Periodic,
    Mirror,
}

impl Wrap {
    /// None for the file's own.
    pub(crate) fn named(name: &str) -> Option<Self> {
        Some(match name {
            "black" => Self::Black,
            "clamp" => Self::Clamp,
            "periodic" => Self::Periodic,
            "mirror" => Self::Mirror,
            _ => return None,
        })
    }

    /// The file's wrap modes of both directions: `black,clamp`, or one word for both.
    pub(crate) fn of_file(text: &str) -> [Self; 2] {
        let (s, t) = text.split_once(',').unwrap_or((text, text));
        [s, t].map(|wrap_name| Self::named(wrap_name.trim()).unwrap_or(Self::Black))
    }

    /// The texel of index `i` of `n`, of which there is at least one; none where all is black.
    pub(crate) fn texel(self, i: i64, n: usize) -> Option<usize> {
        let n = n as i64;
        let inside = match self {
            Self::Black if !(0..n).contains(&i) => return None,
            Self::Black => i,
            Self::Clamp => i.clamp(0, n - 1),
            Self::Periodic => i.rem_euclid(n),
            Self::Mirror => {
                let i = i.rem_euclid(2 * n);
                if i < n { i } else { 2 * n - 1 - i }
            }
        };
        Some(inside as usize)
    }
}

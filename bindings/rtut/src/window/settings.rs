// SPDX-License-Identifier: GPL-3.0-or-later
//! Environment variables about windows, so that programs run without one, in tests and on servers.
//! Tests: `tests`.

use std::path::{Path, PathBuf};

/// Milliseconds of the clock per frame without a window: animations are the same each time.
pub(crate) const FRAME: i32 = 40;

/// `RTUT_HEADLESS`, `RTUT_FRAMES` and `RTUT_SAVE`.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Settings {
    /// No window.
    pub(crate) headless: bool,
    /// Leave after this many frames.
    pub(crate) frames: Option<u64>,
    /// Write each frame to this name with its number and `.ppm`.
    pub(crate) save: Option<PathBuf>,
}

impl Settings {
    /// From the variables, which `get` reads. Without a window and without an end there is one frame.
    pub(crate) fn read(get: impl Fn(&str) -> Option<std::ffi::OsString>) -> Self {
        let headless = get("RTUT_HEADLESS").is_some_and(|value| !value.is_empty() && value != "0");
        let frames = get("RTUT_FRAMES").and_then(|value| value.to_str()?.parse().ok());
        let save = get("RTUT_SAVE").filter(|value| !value.is_empty()).map(PathBuf::from);
        Self { headless, frames: frames.or(headless.then_some(1)), save }
    }

    /// The file of frame `number`, counted from 0, if frames are to be saved.
    pub(crate) fn file(&self, number: u64) -> Option<PathBuf> {
        let name = |save: &Path| {
            let mut name = save.as_os_str().to_owned();
            name.push(format!("{number:03}.ppm"));
            name.into()
        };
        self.save.as_deref().map(name)
    }

    /// Whether this many frames are enough.
    pub(crate) fn is_enough(&self, frames: u64) -> bool {
        self.frames.is_some_and(|most| frames >= most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(characters: &[(&str, &str)]) -> Settings {
        Settings::read(|name| characters.iter().find(|token| token.0 == name).map(|token| token.1.into()))
    }

    #[test]
    fn variables_say_how_it_runs() {
        assert_eq!(read(&[]), Settings::default(), "a window until somebody closes it");
        assert_eq!(read(&[("RTUT_HEADLESS", "1")]).frames, Some(1), "without one, an end");
        assert!(!read(&[("RTUT_HEADLESS", "0")]).headless, "not wanted");
        let settings = read(&[("RTUT_FRAMES", "3"), ("RTUT_SAVE", "a/b-")]);
        assert!(!settings.is_enough(2) && settings.is_enough(3), "three frames");
        assert_eq!(settings.file(12), Some("a/b-012.ppm".into()), "numbered");
        assert_eq!(read(&[("RTUT_FRAMES", "many")]).frames, None, "no number");
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! A rendering that another program shows while it grows.
//! A display that goes away in between stops nothing: the picture is finished all the same, with a warning.
//! Tests: `tests/program/viewing.rs`.

use std::sync::{Mutex, PoisonError};

use gnurt::image::WorkingSpace;
use gnurt::render::{Accumulation, Progress};
use gnurt_view::{TevImage, ViewError};

use crate::progress::Watcher;

/// A watcher, and perhaps a display.
pub(crate) struct Displayed<'a> {
    watcher: &'a Watcher,
    display: Mutex<Display>,
    /// That of the light.
    space: WorkingSpace,
}

enum Display {
    None,
    Tev(TevImage),
    Lost(ViewError),
}

impl<'a> Displayed<'a> {
    /// Shows the picture, whose light is computed in a space, in tev, if there is one.
    pub(crate) fn new(watcher: &'a Watcher, tev: Option<TevImage>, space: WorkingSpace) -> Self {
        Self { watcher, display: Mutex::new(tev.map_or(Display::None, Display::Tev)), space }
    }

    /// Why nothing more was shown, if that is so.
    pub(crate) fn end(self) -> Option<ViewError> {
        match self.display.into_inner().unwrap_or_else(PoisonError::into_inner) {
            Display::Lost(why) => Some(why),
            Display::None | Display::Tev(_) => None,
        }
    }
}

impl Progress for Displayed<'_> {
    fn update(&self, done: f64, samples: u64) {
        self.watcher.update(done, samples);
    }

    fn passed(&self, picture: &Accumulation) {
        let mut display = self.display.lock().unwrap_or_else(PoisonError::into_inner);
        if let Display::Tev(tev) = &mut *display {
            let mut colors = picture.colors();
            colors.convert_from(self.space);
            if let Err(why) = tev.update(&colors) {
                *display = Display::Lost(why);
            }
        }
    }

    fn should_stop(&self) -> bool {
        self.watcher.should_stop()
    }
}

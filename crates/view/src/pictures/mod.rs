// SPDX-License-Identifier: GPL-3.0-or-later
//! Display of finished pictures and films: their layers, their values under the cursor, and two of them compared.
//!
//! Flow: window events -> [`Input`](crate::Input) -> `Controls` (pure) -> frame, layer, comparison -> `Loader` (a thread that reads
//! files ahead) -> `Composed` (colours at the picture's size) -> `canvas` (pixels of the window).

mod canvas;
mod composed;
mod controls;
mod histogram;
mod hud;
mod items;
mod loader;
#[cfg(feature = "window")]
mod window;

pub use composed::{Comparison, compose};
pub use hud::PICTURE_KEYS;
pub use items::{Item, items};
pub use loader::ReadPicture;
#[cfg(feature = "window")]
pub use window::{PictureOptions, run_picture_window};

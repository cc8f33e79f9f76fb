// SPDX-License-Identifier: GPL-3.0-or-later
//! Display of pictures while they grow: a window to fly through a scene, a turntable without a window, and
//! tev.
//!
//! Flow: window events -> [`Input`] -> [`Controls`] (pure) -> request -> render thread -> bytes of the screen
//! -> window. The renderer does not depend on it; only `window` depends on displays, and display libraries
//! are opened only with a window, and compiled only with the feature `window`.
#![forbid(unsafe_code)]
#![cfg_attr(not(feature = "window"), expect(dead_code, reason = "half of it serves windows alone"))]

mod camera_options;
mod choices;
mod controls;
mod error;
#[cfg(feature = "window")]
mod events;
mod exposure;
mod eye;
mod flight;
mod headless;
mod hud;
mod input;
mod memory;
mod pace;
mod pick;
mod pictures;
mod playing;
mod recorder;
mod render_thread;
mod screen;
mod screenshot;
mod scripts;
mod shader_controls;
mod shown;
mod stage;
mod temporal_filter;
mod tev;
mod text;
mod watch;
#[cfg(feature = "window")]
mod window;

pub use camera_options::camera_options;
pub use choices::{Choices, NamedClip};
pub use controls::{Controls, Effect};
pub use error::ViewError;
pub use exposure::Exposure;
pub use flight::Flight;
pub use headless::{FrameTimes, HeadlessOptions, Rest, ShownFrame, run_headless};
pub use hud::KEYS;
pub use input::{Button, Input, Key};
pub use pick::Pick;
pub use pictures::{Comparison, Item, PICTURE_KEYS, ReadPicture, compose, items};
#[cfg(feature = "window")]
pub use pictures::{PictureOptions, run_picture_window};
pub use playing::Playing;
pub use scripts::{ScriptRole, Scripts, StageScript};
pub use shader_controls::{ShaderControl, ShaderControls};
pub use shown::Shown;
pub use stage::{Faults, Listener, Loader, Stage};
pub use tev::{TevAddress, TevImage};
#[cfg(feature = "window")]
pub use window::{WindowOptions, run_window};

// SPDX-License-Identifier: GPL-3.0-or-later
//! Messages between the window and its render thread: requests in one direction, pictures and events in the
//! other.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use gnurt::osl::ParameterValue;
use gnurt::scene::Camera;

use crate::exposure::Exposure;
use crate::eye::ViewRequest;
use crate::hud::Readings;
use crate::pace::divided;
use crate::shown::Shown;
use crate::stage::Stage;

/// The window's request.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RenderRequest {
    pub(crate) camera: Camera,
    pub(crate) shown: Shown,
    pub(crate) size: [u32; 2],
    pub(crate) exposure: Exposure,
    /// Whether the camera will probably have moved on by the next frame.
    pub(crate) moving: bool,
    pub(crate) paused: bool,
    /// Whether pictures at rest are denoised.
    pub(crate) denoised: bool,
    /// The time of the clip; `None` = the scene at rest.
    pub(crate) clip_time: Option<f64>,
    /// The clip; `None` = the stage's own.
    pub(crate) clip: Option<usize>,
}

impl RenderRequest {
    /// A preview of it, its sides divided.
    pub(super) fn view_request(&self, divisor: u32) -> ViewRequest {
        let size = divided(self.size, divisor);
        ViewRequest { camera: self.camera.clone(), shown: self.shown, size, preview: true, denoised: false }
    }

    /// Whether the display is denoised: other pictures than light have no noise.
    pub(super) fn requests_denoising(&self) -> bool {
        self.denoised && matches!(self.shown, Shown::Light(_))
    }
}

/// A picture that can be shown.
#[derive(Default)]
pub(crate) struct DisplayFrame {
    /// Rises with each picture.
    pub(crate) number: u64,
    /// Pixels of the window.
    pub(crate) size: [u32; 2],
    pub(crate) screen: Vec<u32>,
    /// Linear colours of the rendered picture, `readings.rendered` pixels; old ones if it is not `whole`.
    pub(crate) colors: Vec<[f32; 4]>,
    pub(crate) exposure: Exposure,
    pub(crate) readings: Readings,
    /// Whether each pixel of the window was rendered with samples that count.
    pub(crate) whole: bool,
    /// Which change of the view it shows.
    pub(crate) view: u64,
}

/// State shared by the window and the thread.
pub(super) struct Shared {
    pub(super) request: Mutex<Pending>,
    pub(super) bell: Condvar,
    /// The request's `view`, for readers that must not wait.
    pub(super) view: AtomicU64,
    pub(super) leaving: AtomicBool,
    pub(super) front: Mutex<DisplayFrame>,
    pub(super) stage: Mutex<Arc<Stage>>,
}

pub(super) struct Pending {
    pub(super) request: RenderRequest,
    /// Rises when another picture is needed, not only another exposure.
    pub(super) view: u64,
    pub(super) reload: bool,
    /// The file of another scene that is to be read then.
    pub(super) file: Option<PathBuf>,
    /// Files of shaders that have changed.
    pub(super) changed: Vec<PathBuf>,
    /// Values of shaders' parameters, the last one of each.
    pub(super) tuned: Vec<Tuned>,
}

/// A script's number, its parameter and the value that this is to have.
pub(crate) type Tuned = (usize, String, ParameterValue);

impl Pending {
    /// Whether shaders are to be changed.
    pub(super) fn has_edits(&self) -> bool {
        !self.changed.is_empty() || !self.tuned.is_empty()
    }
}

/// Events of the thread for the window.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum RenderEvent {
    /// There is another front.
    Picture,
    /// The scene was read again from these files, or another one was.
    Reloaded { files: Vec<PathBuf>, is_other: bool },
    /// Shaders were read again; the messages about it, a line each.
    Shaders(Vec<String>),
    /// A shader could not be read again; the one before stays.
    BadShader(String),
    /// It could not be read or rendered; the earlier one stays.
    Trouble(String),
    /// How the noise was removed, whenever the method changes.
    Denoised(String),
}

pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! The window of `gnurt view`, with the feature `window`. Tests: `tests/program/window.rs`.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use gnurt::ThreadPool;
use gnurt::display_rules::is_noisy;
use gnurt::render::Guiding;
use gnurt::simd::Level;
use gnurt_view::{Exposure, Listener, WindowOptions, run_window};

use super::frame::frame_options;
use super::stage::{prepare, show_view};
use crate::arguments::WindowArguments;
use crate::environment::Environment;
use crate::failure::{Failure, Outcome};
use crate::messages::{Messages, print};
use crate::signals::{self, FirstSignal};
use crate::source::Source;

/// Shows the scene until the window is closed.
pub(super) fn show_window(
    arguments: &WindowArguments,
    source: Source,
    pool: ThreadPool,
    level: Level,
    messages: Messages,
) -> Outcome {
    signals::listen(FirstSignal::Leaves, messages)?;
    let (stage, chosen) = prepare(&source, arguments, level, &pool, messages)?;
    let mut render = frame_options(&arguments.frame, level);
    // A pilot for each view would make it wait.
    render.integrator = render.integrator.without_pilot();
    if render.guiding == Guiding::Auto {
        render.guiding = Guiding::Off;
    }
    let (show_view, note) = show_view(arguments.light, &stage, &chosen, &render, &pool)?;
    let options = WindowOptions {
        camera: chosen.camera,
        exposure: Exposure { stops: show_view.exposure, tone: show_view.tone },
        title: format!("{} - GNU RT", source.stem()),
        frames: arguments.frames.map(u64::from),
        folder: PathBuf::from("."),
        denoiser: arguments.denoiser.options_or_built_in(None).unwrap_or_default(),
        note,
        is_denoised: arguments.denoiser.options_or_built_in(None).is_some() && is_noisy(render.integrator, 1),
        render,
    };
    let again = (Mutex::new(source), arguments.clone());
    let loader = Box::new(move |file: Option<&Path>, pool: &ThreadPool| {
        let (source, arguments) = &again;
        let known = || source.lock().unwrap_or_else(PoisonError::into_inner);
        // No lock is held while a scene is read.
        let next = match file {
            Some(file) => Source::find(file.as_os_str(), &arguments.files, &Environment::default()),
            None => Ok(known().clone()),
        };
        let read = next.and_then(|next| {
            let (stage, _) = prepare(&next, arguments, level, pool, messages)?;
            *known() = next;
            Ok(stage)
        });
        read.map_err(|failure| failure.message().unwrap_or("it cannot be read").to_owned())
    });
    run_window(options, stage, pool, loader, Arc::new(Speaker { messages })).map_err(Failure::data)
}

/// Prints the window's messages as the program's.
pub(super) struct Speaker {
    pub(super) messages: Messages,
}

impl Listener for Speaker {
    fn camera(&self, options: &str) {
        // A closed standard output is ignored.
        let _ = print(options);
    }

    fn note(&self, text: &str) {
        self.messages.note(text);
    }

    fn warning(&self, text: &str) {
        self.messages.warning(text);
    }
}

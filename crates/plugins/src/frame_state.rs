// SPDX-License-Identifier: GPL-3.0-or-later
//! The input of plugin shaders during a frame, and their faults in it.
//! Invariant: a frame reads nothing that the program may change while it is in flight.
//! Tests: bindings/openrt/tests/plugins.rs.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

use gnurt::shading::texture::TextureSampler;

/// Messages that shaders of a class may print per frame.
const MOST_MESSAGES: u32 = 100;

/// The input of plugin shaders.
#[derive(Default)]
pub struct FrameState {
    /// Textures with a picture, by the API's id.
    pub textures: BTreeMap<u32, Arc<TextureSampler>>,
    /// Ids of object and instance in the API, by the scene's number of the instance.
    pub ids: Vec<[u32; 2]>,
    /// Whether meshes have a third texture coordinate.
    pub third_texcoords: bool,
}

/// Faults of the shaders of a class in a frame.
#[derive(Default)]
pub(crate) struct Faults {
    /// Lanes that were not written, or with NaN or infinities.
    bad_lanes: AtomicU64,
    /// Calls that an exception ended.
    exceptions: AtomicU64,
    /// Rays that were not traced because the stack was too small.
    untraced: AtomicU64,
    /// Services that were called from other threads than those of callbacks.
    strays: AtomicU64,
    messages: AtomicU32,
}

impl Faults {
    /// Counts bad lanes.
    pub(crate) fn add(&self, lanes: u64) {
        if lanes > 0 {
            self.bad_lanes.fetch_add(lanes, Ordering::Relaxed);
        }
    }

    /// Whether one more message may be printed.
    pub(crate) fn may_speak(&self) -> bool {
        self.messages.fetch_add(1, Ordering::Relaxed) < MOST_MESSAGES
    }

    /// Counts a call that an exception ended.
    pub(crate) fn add_exception(&self) {
        self.exceptions.fetch_add(1, Ordering::Relaxed);
    }

    /// Counts rays that were not traced because the stack was too small.
    pub(crate) fn add_untraced(&self, rays: u64) {
        self.untraced.fetch_add(rays, Ordering::Relaxed);
    }

    /// Counts a service that was called from another thread than its callback's.
    pub(crate) fn add_stray(&self) {
        self.strays.fetch_add(1, Ordering::Relaxed);
    }

    /// The counts, a line each.
    pub(crate) fn lines(&self) -> impl Iterator<Item = String> {
        let line = |count: &AtomicU64, one: &str, many: &str, what: &str| {
            let count = count.load(Ordering::Relaxed);
            let noun = if count == 1 { one } else { many };
            (count > 0).then(|| format!("{count} {noun} {what}"))
        };
        let exceptions = line(
            &self.exceptions,
            "exception",
            "exceptions",
            "left its callbacks in this frame; points that they had not written are black",
        );
        let untraced = line(
            &self.untraced,
            "ray was",
            "rays were",
            "not traced in this frame, as too little of a thread's stack was left; they see black. Ask for less \
             with rtSetMaxRayRecursionDepth, or keep large arrays out of the stack (`scratch`)",
        );
        let strays = line(
            &self.strays,
            "service was",
            "services were",
            "called in this frame from a thread other than that of the callback, and did nothing",
        );
        let bad_lanes = line(
            &self.bad_lanes,
            "result",
            "results",
            "not written, NaN or infinite in this frame, shown black",
        );
        [exceptions, untraced, strays, bad_lanes].into_iter().flatten()
    }
}

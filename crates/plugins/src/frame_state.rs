// SPDX-License-Identifier: GPL-3.0-or-later
//! What shaders of plugins read while they shade a frame, and what they did wrong in it.
//! Source: original. Invariant: a frame reads nothing that the program may change while it is in flight.
//! Proof: bindings/openrt/tests/plugins.rs.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

use gnurt::shading::texture::TextureSampler;

/// Messages that shaders of a class may print per frame.
const MOST_MESSAGES: u32 = 100;

/// What shaders of plugins read while they shade.
#[derive(Default)]
pub struct FrameState {
    /// Textures with a picture, by the API's id.
    pub textures: BTreeMap<u32, Arc<TextureSampler>>,
    /// Ids of object and instance in the API, by the scene's number of the instance.
    pub ids: Vec<[u32; 2]>,
}

/// What the shaders of a class did wrong in a frame.
#[derive(Default)]
pub(crate) struct Faults {
    /// Lanes that were not written, or with NaN or infinities.
    bad_lanes: AtomicU64,
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

    /// Bad lanes so far.
    pub(crate) fn bad_lanes(&self) -> u64 {
        self.bad_lanes.load(Ordering::Relaxed)
    }
}

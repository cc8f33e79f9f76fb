// SPDX-License-Identifier: GPL-3.0-or-later
//! Instances of the scene that move while the shutter is open. Space: world. Tests: tests/motion.rs.

use std::sync::Arc;

use gnurt::scene::animation::Exposure;
use gnurt::scene::{Affine, CameraId, InstanceId, Scene};

use crate::motion::{Motion, Shutter, time_at};

/// Pieces of the time that the shutter is open, in which instances move straight.
const PIECES: usize = 32;

/// All that moves in a world.
pub(crate) struct Movers {
    shutter: Shutter,
    all: Vec<Mover>,
}

struct Mover {
    id: InstanceId,
    motion: Arc<Motion>,
    object_from_part: Affine,
}

impl Movers {
    /// None so far, for a shutter.
    pub(crate) fn new(shutter: Shutter) -> Self {
        Self { shutter, all: Vec::new() }
    }

    /// Adds an instance of the scene.
    pub(crate) fn add(&mut self, id: InstanceId, motion: &Arc<Motion>, object_from_part: Affine) {
        self.all.push(Mover { id, motion: motion.clone(), object_from_part });
    }

    /// Whether the world is the same for this shutter.
    pub(crate) fn fit(&self, shutter: Shutter) -> bool {
        self.all.is_empty() || self.shutter == shutter
    }

    /// Whether something moves while the shutter is open.
    pub(crate) fn move_now(&self) -> bool {
        !self.all.is_empty() && self.shutter[0] < self.shutter[1]
    }

    /// A motion at a share of the time that the shutter is open.
    pub(crate) fn at(&self, motion: &Motion, share: f32) -> Affine {
        motion.at(time_at(self.shutter, share))
    }

    /// A motion at the ends of all pieces.
    pub(crate) fn path(&self, motion: &Motion) -> impl Iterator<Item = Affine> {
        (0..=PIECES).map(|piece| self.at(motion, piece as f32 / PIECES as f32))
    }

    /// Puts all of them where they are at a share of the time that the shutter is open.
    pub(crate) fn pose(&self, scene: &mut Scene, share: f32) {
        for mover in &self.all {
            let place = self.at(&mover.motion, share) * mover.object_from_part;
            scene.edit_instance(mover.id).world_from_object = place;
        }
    }

    /// What moves while the shutter is open. A camera that moves alone is enough for rays to have times.
    pub(crate) fn exposure(&self, camera_moves: bool) -> Exposure {
        let mut exposure = Exposure::default();
        if self.move_now() {
            let keys = |mover: &Mover| {
                let places = self.path(&mover.motion).map(|place| place * mover.object_from_part);
                (mover.id, places.collect())
            };
            exposure.instances = self.all.iter().map(keys).collect();
        }
        if camera_moves {
            exposure.cameras.push((CameraId(0), Vec::new()));
        }
        exposure
    }
}

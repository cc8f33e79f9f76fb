// SPDX-License-Identifier: GPL-3.0-or-later
//! A scene as it is at one moment of an open shutter. Source: original. Space: world. Proof: `tests/surfaces/motion.rs`.

use std::sync::Arc;

use super::types::{Instance, SceneTree, Shape, Slot};
use crate::{BuildOptions, ObjectTree, Threads};

impl SceneTree {
    /// Whether something in it moves while the shutter is open.
    #[must_use]
    pub fn moves(&self) -> bool {
        (0..self.slots.len()).any(|place| {
            self.placed(place).is_some_and(|placed| {
                placed.motion().is_some()
                    || match &placed.shape {
                        Shape::Object(object) => object.moves(),
                        Shape::Scene(scene) => scene.moves(),
                    }
            })
        })
    }

    /// The scene as it is at a moment, which every question is of then. Costs a build of its top tree.
    #[must_use]
    pub fn at(&self, time: f32, threads: Threads) -> Self {
        let nothing = Arc::new(ObjectTree::build(&[], &BuildOptions::default(), Threads::Single));
        let instance = |slot: &Slot| match slot {
            Slot::Placed(placed) => {
                let columns = placed.columns(time);
                let shape = match &placed.shape {
                    Shape::Object(object) => Shape::Object(object.at(time)),
                    Shape::Scene(scene) if scene.moves() => Shape::Scene(Arc::new(scene.at(time, threads))),
                    Shape::Scene(scene) => Shape::Scene(scene.clone()),
                };
                Instance::new(shape, columns).with_mask(placed.mask)
            }
            Slot::Absent | Slot::Refused => Instance::identity(nothing.clone()),
        };
        let instances: Vec<Instance> = self.slots.iter().map(instance).collect();
        let options = BuildOptions { quality: self.top.quality(), ..BuildOptions::default() };
        Self::build(&instances, &options, threads)
    }
}

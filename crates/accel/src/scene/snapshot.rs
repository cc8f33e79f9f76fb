// SPDX-License-Identifier: GPL-3.0-or-later
//! A scene at one time of an open shutter. Space: world.
//! Invariant: shared objects are frozen once, and are shared afterwards as before.
//! Tests: `tests/surfaces/motion.rs`, `tests/nested.rs`.

use std::collections::HashMap;
use std::sync::Arc;

use super::types::{Instance, SceneTree, Shape, Slot};
use crate::{BuildOptions, ObjectTree, Threads};

impl SceneTree {
    /// Whether something in it moves while the shutter is open.
    #[must_use]
    pub fn moves(&self) -> bool {
        self.moving > 0
    }

    /// The scene at one time; all its queries refer to that time. Costs a build of its top tree, and of that
    /// of each scene in it that moves, and a pass over each object that does.
    #[must_use]
    pub fn at(&self, time: f32, threads: Threads) -> Self {
        Stopped::new(time, threads).scene(self)
    }
}

/// The frozen shapes of one time, by their originals, which the scene holds meanwhile.
struct Stopped<'a> {
    time: f32,
    threads: Threads<'a>,
    nothing: Arc<ObjectTree>,
    objects: HashMap<*const ObjectTree, Arc<ObjectTree>>,
    scenes: HashMap<*const SceneTree, Arc<SceneTree>>,
}

impl<'a> Stopped<'a> {
    fn new(time: f32, threads: Threads<'a>) -> Self {
        let nothing = Arc::new(ObjectTree::build(&[], &BuildOptions::default(), Threads::Single));
        Self { time, threads, nothing, objects: HashMap::new(), scenes: HashMap::new() }
    }

    fn scene(&mut self, scene: &SceneTree) -> SceneTree {
        let instances: Vec<Instance> = scene.slots.iter().map(|slot| self.instance(slot)).collect();
        let options = BuildOptions { quality: scene.top.quality(), ..BuildOptions::default() };
        SceneTree::build(&instances, &options, self.threads)
    }

    fn instance(&mut self, slot: &Slot) -> Instance {
        match slot {
            Slot::PlacedInstance(placed) if !placed.motion().is_none_or(|path| path.is_there(self.time)) => {
                Instance::identity(self.nothing.clone())
            }
            Slot::PlacedInstance(placed) => {
                Instance::new(self.shape(&placed.shape), placed.columns(self.time)).with_mask(placed.mask)
            }
            Slot::Absent | Slot::Refused => Instance::identity(self.nothing.clone()),
        }
    }

    fn shape(&mut self, shape: &Shape) -> Shape {
        match shape {
            Shape::Object(object) => {
                let stopped = self.objects.entry(Arc::as_ptr(object));
                Shape::Object(stopped.or_insert_with(|| object.at(self.time)).clone())
            }
            Shape::Scene(scene) if !scene.moves() => Shape::Scene(scene.clone()),
            Shape::Scene(scene) => {
                let key = Arc::as_ptr(scene);
                if let Some(stopped) = self.scenes.get(&key) {
                    return Shape::Scene(stopped.clone());
                }
                let stopped = Arc::new(self.scene(scene));
                self.scenes.insert(key, stopped.clone());
                Shape::Scene(stopped)
            }
        }
    }
}

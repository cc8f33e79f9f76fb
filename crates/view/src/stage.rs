// SPDX-License-Identifier: GPL-3.0-or-later
//! The stage of a viewer: scene, world and shaders, with the functions that load them and report faults.

use std::fmt;
use std::path::{Path, PathBuf};

use gnurt::ThreadPool;
use gnurt::osl::ParameterValue;
use gnurt::render::{CommitOptions, World};
use gnurt::scene::Scene;

use crate::scripts::Scripts;

/// A scene that can be rendered, and where it came from.
pub struct Stage {
    /// The description: names of picked objects.
    pub scene: Scene,
    /// The scene, committed.
    pub world: World,
    /// Files that it was read from: if one changes, it is read again.
    pub files: Vec<PathBuf>,
    /// The clip, if something moves: its index.
    pub clip: Option<usize>,
    /// The options of the world's commit.
    pub how: CommitOptions,
    /// Files in the shading language, which are read again one by one.
    pub scripts: Scripts,
    /// Returns new faults of other shaders, a line each.
    pub faults: Faults,
}

impl Stage {
    /// The times of the first and the last key of the clip.
    #[must_use]
    pub fn range(&self) -> Option<[f64; 2]> {
        self.scene.animation()?.clips.get(self.clip?).map(|clip| clip.range())
    }

    /// Faults of shaders of all kinds.
    #[must_use]
    pub fn all_faults(&self) -> Vec<String> {
        let mut faults = (self.faults)();
        faults.extend(self.scripts.faults());
        faults
    }

    /// Shows a time of its clip, or the scene at rest.
    ///
    /// # Errors
    /// The commit's error; the world stays unchanged.
    pub(crate) fn show(&mut self, clip_time: Option<f64>, pool: &ThreadPool) -> Result<(), String> {
        let Some(clip) = self.clip else { return Ok(()) };
        match clip_time {
            Some(seconds) => self.scene.pose(clip, seconds),
            None => self.scene.rest(),
        };
        self.commit(pool)
    }

    /// Plays another clip from now on; one that is not there changes nothing.
    pub(crate) fn choose_clip(&mut self, clip: usize) {
        if self.scene.animation().is_some_and(|animation| clip < animation.clips.len()) {
            self.scene.rest();
            self.clip = Some(clip);
        }
    }

    fn commit(&mut self, pool: &ThreadPool) -> Result<(), String> {
        let committed = self.world.commit(&self.scene, &self.scripts.table, &self.how, pool);
        committed.map(drop).map_err(|error| error.to_string())
    }

    /// Reads the shaders of `changed` files again; returns the messages about it, a line each.
    ///
    /// # Errors
    /// The compiler's message; all stays unchanged.
    pub(crate) fn read_again(
        &mut self,
        changed: &[PathBuf],
        pool: &ThreadPool,
    ) -> Result<Vec<String>, String> {
        let (next, messages) = self.scripts.again(changed)?;
        let before = std::mem::replace(&mut self.scripts, next);
        match self.commit(pool) {
            Ok(()) => Ok(messages),
            Err(why) => {
                self.scripts = before;
                Err(why)
            }
        }
    }

    /// Gives a shader's parameter another value.
    ///
    /// # Errors
    /// It does not fit.
    pub(crate) fn tune(
        &mut self,
        (script, name, value): &(usize, String, ParameterValue),
        pool: &ThreadPool,
    ) -> Result<(), String> {
        if self.scripts.tune(*script, name, value)? { self.commit(pool) } else { Ok(()) }
    }
}

#[cfg(test)]
impl Stage {
    /// A scene without a file, shown without changes.
    pub(crate) fn of(scene: Scene, pool: &ThreadPool) -> Self {
        let (table, how) = (gnurt::render::ShaderTable::default(), CommitOptions::default());
        let mut world = World::new();
        world.commit(&scene, &table, &how, pool).expect("a sound scene");
        Self {
            scene,
            world,
            files: Vec::new(),
            clip: None,
            how,
            scripts: Scripts::default(),
            faults: Box::new(Vec::new),
        }
    }
}

/// Called from time to time, from any thread.
pub type Faults = Box<dyn Fn() -> Vec<String> + Send + Sync>;

impl fmt::Debug for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Stage").field("files", &self.files).finish_non_exhaustive()
    }
}

/// Reads and commits the scene whenever a file has changed; a file that is given replaces the scene from then on. The error is one
/// line.
pub type Loader = Box<dyn Fn(Option<&Path>, &ThreadPool) -> Result<Stage, String> + Send>;

/// The receiver of messages for the user.
pub trait Listener: Send + Sync {
    /// The camera as options of the command line.
    fn camera(&self, options: &str);

    /// A requested result: a pick, a file that was written.
    fn note(&self, text: &str);

    /// A fault that changes nothing.
    fn warning(&self, text: &str);
}

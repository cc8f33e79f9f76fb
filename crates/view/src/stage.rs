// SPDX-License-Identifier: GPL-3.0-or-later
//! What is looked at, and those who bring it and hear about it. Source: original.

use std::fmt;
use std::path::PathBuf;

use gnurt::ThreadPool;
use gnurt::render::{CommitOptions, ShaderTable, World};
use gnurt::scene::Scene;

/// A scene that can be rendered, and where it came from.
pub struct Stage {
    /// The description: names of what is picked.
    pub scene: Scene,
    /// The scene, committed.
    pub world: World,
    /// Files that it was read from: if one changes, it is read again.
    pub files: Vec<PathBuf>,
    /// What is played, where something moves.
    pub clip: Option<StageClip>,
    /// Tells what shaders have done wrong since it was asked last, a line each.
    pub faults: Faults,
}

/// A clip of a stage's scene, and what commits its moments.
pub struct StageClip {
    /// Its place among the clips.
    pub number: usize,
    /// What the world was committed with.
    pub shaders: ShaderTable,
    /// Likewise.
    pub how: CommitOptions,
}

impl Stage {
    /// The moments of the first and of the last key of what is played.
    #[must_use]
    pub fn range(&self) -> Option<[f64; 2]> {
        let clip = self.clip.as_ref()?;
        self.scene.animation()?.clips.get(clip.number).map(|clip| clip.range())
    }

    /// Shows a moment of its clip, or the scene at rest.
    ///
    /// # Errors
    /// What the commit says; the world stays as it was.
    pub(crate) fn show(&mut self, moment: Option<f64>, pool: &ThreadPool) -> Result<(), String> {
        let Some(clip) = &self.clip else { return Ok(()) };
        match moment {
            Some(seconds) => self.scene.pose(clip.number, seconds),
            None => self.scene.rest(),
        };
        let committed = self.world.commit(&self.scene, &clip.shaders, &clip.how, pool);
        committed.map(drop).map_err(|error| error.to_string())
    }
}

/// Asked from time to time, from any thread.
pub type Faults = Box<dyn Fn() -> Vec<String> + Send + Sync>;

impl fmt::Debug for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Stage").field("files", &self.files).finish_non_exhaustive()
    }
}

/// Reads and commits the scene, in the beginning and whenever a file has changed; the error is one line.
pub type Loader = Box<dyn Fn(&ThreadPool) -> Result<Stage, String> + Send>;

/// Told what people should read.
pub trait Listener: Send + Sync {
    /// The camera as options of the command line.
    fn camera(&self, options: &str);

    /// Something that was asked for: a pick, a file that was written.
    fn note(&self, text: &str);

    /// Something that went wrong and leaves things as they were.
    fn warning(&self, text: &str);
}

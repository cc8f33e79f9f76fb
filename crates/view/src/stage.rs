// SPDX-License-Identifier: GPL-3.0-or-later
//! What is looked at, and those who bring it and hear about it. Source: original.

use std::fmt;
use std::path::PathBuf;

use gnurt::ThreadPool;
use gnurt::render::World;
use gnurt::scene::Scene;

/// A scene that can be rendered, and where it came from.
pub struct Stage {
    /// The description: names of what is picked.
    pub scene: Scene,
    /// The scene, committed.
    pub world: World,
    /// Files that it was read from: if one changes, it is read again.
    pub files: Vec<PathBuf>,
    /// Tells what shaders have done wrong since it was asked last, a line each.
    pub faults: Faults,
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

// SPDX-License-Identifier: GPL-3.0-or-later
//! Permissions and limits of a scene while it is loaded. Tests: `tests/confine.rs`, crates/usd/tests/composition.rs.

use std::path::PathBuf;

use gnurt_image::TileCache;

use crate::affine::Affine;
use crate::id::InstanceId;
use crate::overrides::Override;
use crate::scene::Scene;

/// Permissions and limits of a scene while it is loaded.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadOptions {
    /// The folder below which the files that the scene names (libraries, textures, buffers) must lie, links followed;
    /// `None` = anywhere. The scene's own file is the caller's choice.
    pub confine: Option<PathBuf>,
    /// The cache of files' textures, mostly on the disk; `None` = all in memory.
    pub tiles: Option<TileCache>,
    /// The moment in seconds at which a format is read that is read at a moment (USD); `None` = at rest.
    pub at: Option<f64>,
    /// Variants that take the place of those that the file chooses.
    pub variants: Vec<VariantChoice>,
    /// How often subdivision surfaces are refined; `None` = [`subdivision::LEVEL`](crate::subdivision::LEVEL).
    pub subdivision: Option<u32>,
    /// Threads that reading may use, the calling one included; 0 = one for each core. The scene does not depend on it.
    pub threads: usize,
    /// Changes by names, made once the scene is there.
    pub overrides: Vec<Override>,
    /// Whether the first warning is an error.
    pub strict: bool,
    /// The axis that points upwards in files of formats that do not say (OBJ, PLY, STL); `None` = y.
    pub up: Option<UpAxis>,
}

/// The axis of a file that points upwards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UpAxis {
    /// X.
    X,
    /// Y, as here.
    Y,
    /// Z.
    Z,
}

impl UpAxis {
    /// Turns the instances of a scene without cameras and lights, so that the axis becomes y.
    pub(super) fn turn(self, scene: &mut Scene) {
        let axes = match self {
            Self::Y => return,
            Self::Z => [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]],
            Self::X => [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
        };
        let [x, y, z] = axes;
        let world_from_file = Affine { columns: [x, y, z, [0.0; 3]] };
        for id in (0..scene.instances().len() as u32).map(InstanceId) {
            let instance = scene.edit_instance(id);
            instance.world_from_object = world_from_file * instance.world_from_object;
        }
    }
}

/// One variant of a set of variants, by names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VariantChoice {
    /// The path of what has the set: `/World/Chair`; empty where the variants are the whole file's (glTF).
    pub prim: String,
    /// The set; empty where the file has one.
    pub set: String,
    /// The variant.
    pub variant: String,
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! What a commit is given beside the scene, and what it tells.

use std::sync::Arc;

use gnurt_accel::Memory;
use gnurt_shading::{CameraShader, EnvironmentShader, LightShader, PixelShader, SurfaceShader};
use gnurt_simd::Level;

/// Shaders that the description only names by number, or does not know at all.
#[derive(Clone, Default)]
pub struct ShaderTable {
    /// What `Surface::Shader(n)` means.
    pub surfaces: Vec<Arc<dyn SurfaceShader>>,
    /// Lights beside those of the scene.
    pub lights: Vec<Arc<dyn LightShader>>,
    /// What misses see, instead of the scene's own environment.
    pub environment: Option<Arc<dyn EnvironmentShader>>,
    /// What pixels show in place of the radiance against their rays.
    pub pixel: Option<Arc<dyn PixelShader>>,
    /// The camera that goes with them; commit does not use it, callers pass it to `render`.
    pub camera: Option<Arc<dyn CameraShader>>,
}

/// How a scene becomes a world.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CommitOptions {
    /// Every material becomes an opaque Lambertian reflector of its base colour under face normals.
    pub force_diffuse: bool,
    /// CPU level of the builders.
    pub level: Level,
    /// Whether trees are to be fast or small; pictures are the same.
    pub memory: Memory,
}

/// What a commit did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CommitReport {
    /// Triangles of visible objects that were left out: NaN, infinite or without area.
    pub dropped_triangles: usize,
    /// Instances that were left out: their transform has no inverse or is not finite.
    pub dropped_instances: usize,
    /// Objects whose trees were built, in whole or in part.
    pub built_objects: usize,
    /// Objects whose trees were only fitted to vertices that have moved.
    pub refitted_objects: usize,
    /// Instances that were placed: those that were edited, and those of objects that were.
    pub placed_instances: usize,
    /// Whether the tree over all instances was brought up to date.
    pub built_top_tree: bool,
    /// Surface shaders that were made.
    pub made_shaders: usize,
    /// Whether the triangles that shine were looked for.
    pub found_lamps: bool,
    /// Whether the list of lights was made. What is costly of it is shared with the list before while that holds.
    pub made_lights: bool,
    /// Seconds that all of it took.
    pub build_seconds: f64,
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Further input of a commit in addition to the scene, and its report.

use std::sync::Arc;

use gnurt_accel::Memory;
use gnurt_image::WorkingSpace;
use gnurt_shading::{CameraShader, EnvironmentShader, LightShader, PixelShader, SurfaceShader};
use gnurt_simd::Level;

/// Shaders that the description only names by number, or not at all.
#[derive(Clone, Default)]
pub struct ShaderTable {
    /// The shaders of `Surface::Shader(n)`.
    pub surfaces: Vec<Arc<dyn SurfaceShader>>,
    /// Lights in addition to those of the scene.
    pub lights: Vec<Arc<dyn LightShader>>,
    /// The environment, in place of the scene's own.
    pub environment: Option<Arc<dyn EnvironmentShader>>,
    /// The pixel shader, which replaces the radiance along the rays.
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
    /// The space in which light is computed; scenes are described in Rec. 709.
    pub space: WorkingSpace,
}

/// The work of a commit.
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
    /// Instances that were placed: edited ones, and those of edited objects.
    pub placed_instances: usize,
    /// Whether the tree over all instances was brought up to date.
    pub built_top_tree: bool,
    /// Surface shaders that were made.
    pub made_shaders: usize,
    /// Whether the emissive triangles were searched for.
    pub found_emitters: bool,
    /// Whether the list of lights was made. Its costly parts are shared with the list before while they are
    /// valid.
    pub made_lights: bool,
    /// Seconds that all of it took.
    pub build_seconds: f64,
}

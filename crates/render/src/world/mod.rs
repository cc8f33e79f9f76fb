// SPDX-License-Identifier: GPL-3.0-or-later
//! The world: a committed scene that rays can be sent into.
//! Source: original; two levels after the paper's section 6 and [WBS03a].

use std::sync::Arc;

use gnurt_accel::{Hit, Ray};
use gnurt_scene::Scene;
use gnurt_shading::{CameraShader, EnvironmentShader, LightShader, SurfaceShader};
use gnurt_simd::Level;

use crate::error::CommitError;

/// Shaders that the description only names by number, or does not know at all.
#[derive(Clone, Default)]
pub struct ShaderTable {
    /// What `Surface::Shader(n)` means.
    pub surfaces: Vec<Arc<dyn SurfaceShader>>,
    /// Lights beside those of the scene.
    pub lights: Vec<Arc<dyn LightShader>>,
    /// What misses see, instead of the scene's own environment.
    pub environment: Option<Arc<dyn EnvironmentShader>>,
    /// The camera that goes with them; commit does not use it, callers pass it to `render`.
    pub camera: Option<Arc<dyn CameraShader>>,
}

/// How a scene becomes a world.
#[derive(Clone, Copy, Debug)]
pub struct CommitOptions {
    /// Every material becomes an opaque Lambertian reflector of its base colour under face normals.
    pub force_diffuse: bool,
    /// CPU level of the builders.
    pub level: Level,
}

impl Default for CommitOptions {
    fn default() -> Self {
        Self { force_diffuse: false, level: Level::default() }
    }
}

/// What a commit did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CommitReport {
    /// Triangles of visible objects that were left out: NaN, infinite or without area.
    pub dropped_triangles: usize,
    /// Instances that were left out: their transform has no inverse or is not finite.
    pub dropped_instances: usize,
    /// Objects whose trees were built.
    pub built_objects: usize,
    /// Seconds that all of it took.
    pub build_seconds: f64,
}

/// Sizes of a world.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WorldStats {
    /// Triangles in memory: each object counts once.
    pub triangles: usize,
    /// Triangles that rays may meet: each instance counts.
    pub instanced_triangles: usize,
    /// Objects with a tree.
    pub objects: usize,
    /// Instances that rays may meet.
    pub instances: usize,
    /// Nodes of all trees.
    pub tree_nodes: usize,
    /// Bytes of all trees.
    pub tree_bytes: usize,
    /// Bytes of the meshes' arrays.
    pub array_bytes: usize,
}

/// A committed scene. Cheap to clone: a clone is a snapshot that later commits do not touch.
#[derive(Clone, Default)]
pub struct World {}

impl World {
    /// An empty world.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Brings the world up to date with `scene`. A world follows one scene: only what its log says was edited since
    /// the last commit is built again. Bad primitives and instances are dropped and counted.
    ///
    /// # Errors
    /// [`CommitError`] if the scene names things that are not there; the world stays as it was.
    pub fn commit(
        &mut self,
        scene: &Scene,
        shaders: &ShaderTable,
        options: &CommitOptions,
        pool: &rayon::ThreadPool,
    ) -> Result<CommitReport, CommitError> {
        let _ = (scene, shaders, options, pool);
        Ok(CommitReport::default())
    }

    /// Lower and upper corner of everything that rays may meet; `None` if there is nothing.
    #[must_use]
    pub fn bounds(&self) -> Option<([f32; 3], [f32; 3])> {
        None
    }

    /// Sizes.
    #[must_use]
    pub fn stats(&self) -> WorldStats {
        WorldStats::default()
    }

    /// The closest hit of one ray.
    #[must_use]
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        let _ = ray;
        None
    }

    /// Whether one ray hits anything at all.
    #[must_use]
    pub fn occluded(&self, ray: &Ray) -> bool {
        let _ = ray;
        false
    }
}

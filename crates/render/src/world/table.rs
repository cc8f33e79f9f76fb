// SPDX-License-Identifier: GPL-3.0-or-later
//! Further input of a commit in addition to the scene, and its report.

use std::sync::Arc;

use gnurt_accel::{Memory, Quality};
use gnurt_image::WorkingSpace;
use gnurt_scene::Scene;
use gnurt_shading::{
    CameraShader, DisplacementShader, EnvironmentShader, LightShader, PixelShader, SurfaceShader,
};
use gnurt_simd::Level;

use crate::options::RenderOptions;

/// Shaders that the description only names by number, or not at all.
#[derive(Clone, Default)]
pub struct ShaderTable {
    /// The shaders of `Surface::Shader(n)`.
    pub surfaces: Vec<Arc<dyn SurfaceShader>>,
    /// The shaders of `Offset::Shader(n)`.
    pub displacements: Vec<Arc<dyn DisplacementShader>>,
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
    /// How much time the trees of meshes may take for faster rays; pictures are the same. A world that has better ones
    /// keeps them.
    pub quality: Quality,
    /// The space in which light is computed; scenes are described in Rec. 709.
    pub space: WorkingSpace,
}

/// About how many rays the paths of a sample take.
const RAYS_OF_SAMPLE: u32 = 8;

impl CommitOptions {
    /// Trees for one picture of a scene: built fast where it takes fewer rays than the scene has primitives.
    #[must_use]
    pub fn for_picture(self, scene: &Scene, picture: &RenderOptions) -> Self {
        let primitives: usize = scene.meshes().iter().map(|mesh| mesh.primitive_count()).sum();
        let [x0, y0, x1, y1] = picture.region().unwrap_or([0, 0, u32::MAX, u32::MAX]).map(u64::from);
        let of_sample = if picture.integrator.has_virtual_lights() {
            picture.vpls.max(RAYS_OF_SAMPLE)
        } else {
            RAYS_OF_SAMPLE
        };
        let samples = ((x1 - x0) * (y1 - y0)).saturating_mul(picture.spp.into());
        let is_soon_done = samples.saturating_mul(of_sample.into()) < primitives as u64;
        Self { quality: if is_soon_done { Quality::Fast } else { Quality::Medium }, ..self }
    }

    /// Whether a world of these options is one of `others`, but for better trees.
    pub(super) fn serves(&self, others: &Self) -> bool {
        let is_as_good = self.quality == others.quality || others.quality == Quality::Fast;
        is_as_good && *self == Self { quality: self.quality, ..*others }
    }
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
    /// Reports of displacement, each with the name of a mesh or a shader.
    pub warnings: Vec<String>,
    /// Seconds that all of it took.
    pub build_seconds: f64,
}

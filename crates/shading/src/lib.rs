// SPDX-License-Identifier: GPL-3.0-or-later
//! Shading in batches: the traits that shaders implement, materials, lights, textures and sampling.
//! Depends on rays and hits, but neither on trees nor on scene files.
#![forbid(unsafe_code)]

pub mod batch;
pub mod bsdf;
mod camera_projection;
pub mod classes;
mod color_map;
pub mod lanes;
pub mod lights;
pub mod materials;
pub mod mipmap;
pub mod phase;
mod point;
mod projective_camera;
pub mod real;
pub mod sampling;
mod scene_queries;
pub mod script;
pub mod shader;
mod texels;
pub mod texture;

pub use batch::{Bounces, Detail, FacingRows, RayKind, SampleKey, SurfaceBatch, Vec3s};
pub use camera_projection::CameraProjection;
pub use color_map::ColorMap;
pub use point::{Leaving, Rays, SurfacePoint};
pub use projective_camera::ProjectiveCamera;
pub use scene_queries::{CameraProperties, SceneNames};
pub use shader::{
    AttributeRequest, CameraSamples, CameraShader, DisplacementShader, EnvironmentShader, Interior,
    LightBatch, LightShader, OutputKind, PixelSamples, PixelShader, RadianceShader, RayRequest, ShaderOutput,
    SurfaceHit, SurfaceShader, Tracer,
};

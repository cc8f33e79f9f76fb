// SPDX-License-Identifier: GPL-3.0-or-later
//! Shading in batches: the traits that shaders implement, materials, lights, textures and sampling.
//! Knows rays and hits, but neither trees nor scene files.
#![forbid(unsafe_code)]

pub mod batch;
pub mod bsdf;
pub mod classes;
pub mod lanes;
pub mod lights;
mod look_camera;
pub mod materials;
pub mod mipmap;
mod point;
pub mod real;
pub mod sampling;
pub mod shader;
mod texels;
pub mod texture;

pub use batch::{Detail, FacingRows, RayKind, SampleKey, SurfaceBatch, Vec3s};
pub use look_camera::{Look, LookCamera};
pub use point::{Leaving, Rays, SurfacePoint};
pub use shader::{
    AttributeRequest, CameraSamples, CameraShader, EnvironmentShader, LightBatch, LightShader, Meeting,
    PixelSamples, PixelShader, RadianceShader, RayRequest, SurfaceShader, Tracer,
};

// SPDX-License-Identifier: GPL-3.0-or-later
//! The scene description: objects, instances, materials, lights and cameras as plain data, and the files they come from.
#![forbid(unsafe_code)]

pub mod affine;
pub mod animation;
pub mod builtin;
pub mod camera;
mod check;
pub mod detail;
pub mod displacement;
pub mod edit;
pub mod factors;
pub mod id;
pub mod io;
pub mod labels;
pub mod layer_textures;
pub mod light;
pub mod light_links;
pub mod material;
pub mod medium;
pub mod mesh;
pub mod motion;
pub mod nesting;
pub mod overrides;
pub mod primitives;
mod ray_mask;
mod scene;
mod shader_file;
#[cfg(feature = "snapshot")]
pub mod snapshot;
mod tangents;
pub mod texture;
pub mod volume_cells;
mod waste;

pub use affine::Affine;
pub use animation::Animation;
pub use camera::{Camera, Lens, Projection};
pub use check::CheckError;
pub use displacement::Displacement;
/// Subdivision surfaces: a crate of its own.
pub use gnurt_subdivision as subdivision;
pub use id::{CameraId, InstanceId, LightId, MaterialId, MediumId, MeshId, ObjectId, TextureId};
pub use labels::Labels;
pub use layer_textures::LayerTextures;
pub use light::{ConeEdge, Light};
pub use material::{Material, Surface};
pub use medium::Medium;
pub use mesh::{Attribute, Mesh, Rate, TEXCOORD_1, TEXCOORD_RQ};
pub use motion::Motion;
pub use primitives::{CurveBasis, CurveForm, Curves, Primitives};
pub use ray_mask::RayMask;
pub use scene::{Instance, Member, Object, Scene};
pub use shader_file::ShaderFile;
pub use tangents::tangents;
pub use texture::Texture;
pub use waste::has_area;

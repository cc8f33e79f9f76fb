// SPDX-License-Identifier: GPL-3.0-or-later
//! Shaders written in the shading language, as shaders of the renderer.
//!
//! A [`Script`] is a compiled shader file with values for its parameters; it makes shaders of
//! `gnurt_shading`: a surface, a light, a camera, a sky. `access` defines the readable files, `closures` the
//! closures. `parts` makes lobes of them, `world` answers a running shader's queries, `stored` reads pictures
//! for the tools. `surface`, `light`, `camera`, `sky` and `pixel` are the kinds.
#![forbid(unsafe_code)]

mod access;
mod attributes;
mod camera;
mod changes;
mod closures;
mod codes;
mod displacement;
mod emission_and_opacity;
mod faults;
mod fixed;
mod library;
mod light;
mod live;
mod lobe;
mod mtlx;
mod outputs;
mod parameter;
mod parts;
mod pixel;
mod properties;
mod reader;
mod recipe;
mod script;
mod sky;
mod stored;
mod surface;
mod surface_state;
mod texture_info;
mod textures;
mod volumes;
mod world;
mod wrap;

pub use access::Access;
pub use camera::CameraScript;
pub use codes::Codes;
pub use gnurt_shading::script::{CameraFrame, Kind, Parameter, ParameterValue, document_and_node, sampler};
pub use gnurt_sl_lib::color::ColorSystem;
pub use library::is_carried;
pub use mtlx::{materials as materials_of_document, shaders_by_material};
pub use recipe::Recipe;
pub use script::Script;
pub use stored::StoredTextures;

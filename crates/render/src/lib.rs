// SPDX-License-Identifier: GPL-3.0-or-later
//! From a scene description to a picture: worlds (committed scenes), integrators, tiles and progressive passes.
#![forbid(unsafe_code)]
#![cfg_attr(
    not(any(target_arch = "x86", target_arch = "x86_64", target_arch = "aarch64")),
    allow(dead_code, unused_imports, reason = "lanes are compiled for wide registers only")
)]

mod accumulation;
mod adaptive;
mod aov;
mod bands;
mod behind;
mod by_name;
mod camera;
mod camera_batch;
mod camera_matrices;
mod caustics_training;
mod checkpoint;
mod cone;
mod cost;
mod displacement;
mod error;
mod expressions;
mod film;
mod fingerprint;
mod first_hit;
mod frame;
mod guide;
mod guide_training;
mod held;
mod holdouts;
mod integrator_choice;
mod integrators;
mod job;
mod layers;
mod lobe_colors;
mod log;
mod many_lights;
mod mattes;
mod moments;
mod motion;
mod moving_camera;
mod options;
mod packing;
mod piece;
mod pixel_grid;
mod pixel_noise;
mod pixel_order;
mod pixel_trace;
mod pixels;
mod progress;
mod render;
mod restricted;
mod sampler;
mod seen;
mod services;
mod shader_outputs;
mod space_tree;
mod state;
mod stats;
mod tile;
mod tracer;
mod transport;
pub mod world;

pub use accumulation::{Accumulation, Progress, Silent};
pub use bands::{ColorBand, FilmBand};
pub use camera::SceneCamera;
pub use camera_matrices::CameraMatrices;
pub use error::{CheckpointError, CommitError, RenderError};
pub use expressions::{ExpressionError, GROUP_PREFIX, LightLayer, OUTPUT_PREFIX, UNGROUPED, unknown_labels};
pub use fingerprint::fingerprint;
pub use frame::Frame;
pub use many_lights::PersistentLights;
pub use mattes::{MatteKind, Mattes, matte_id, matte_names};
pub use motion::{MotionCost, MotionShare, PictureHistory};
pub use moving_camera::MovingCamera;
pub use options::{
    Caustics, Guiding, Integrator, ReconstructionFilter, RenderOptions, UnknownCaustics, UnknownGuiding,
    UnknownIntegrator,
};
pub use packing::{empty_picture, pack_piece, rendered_rects, unpack_piece};
pub use piece::{BAND_UNIT, Piece};
pub use pixel_noise::{PixelNoise, UnknownPixelNoise};
pub use pixel_trace::{PixelTrace, trace_pixel};
pub use render::{render, render_on};
pub use shader_outputs::{missing_output, shader_outputs};
pub use stats::{ChoiceStats, GuideStats, MethodStats, RenderStats};
pub use world::{CommitOptions, CommitReport, ShaderTable, World, WorldStats};

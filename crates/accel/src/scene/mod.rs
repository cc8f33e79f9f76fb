// SPDX-License-Identifier: GPL-3.0-or-later
//! Two levels and more: a top tree over instances of objects that have trees of their own, or of scenes.
//! Source: [WBS03a].

mod box64;
mod build;
mod entries;
mod error;
mod exact;
mod instance;
mod leaves;
mod normal;
mod path;
mod point;
mod properties;
mod region;
mod rotation;
mod snapshot;
mod types;
mod update;
mod walk;

pub use error::SceneError;
pub use path::MotionPath;
pub use types::{DEEPEST_SCENE, Instance, SceneTree, Shape};

// SPDX-License-Identifier: GPL-3.0-or-later
//! Measures ray queries, on the same rays in the same process as Embree where a library of it is available.
//! The classes of rays and the rules of measurement are those of docs/how-to/measure.md.
//!
//! Stages of a run: a scene becomes a [`Subject`] (one mesh, a view, a light). [`rays::run`] makes the rays
//! of each [`Class`], queries the [`Contestant`] of every [`Job`] once for its answers and compares them,
//! then times all in alternating runs and gives a [`Row`] for each. [`table`] and [`plot`] show the rows.
//! [`builds`] and [`paper`] are further measurements.
//!
//! Times are those of the thread on its processor, without other programs. Rates of several threads are those
//! with a core for each.
#![deny(unsafe_code)]

mod agreement;
pub mod blur;
pub mod blur_top;
pub mod builds;
mod clock;
mod comparison;
pub mod crowd;
pub mod dynamic;
pub mod dynamic_plot;
pub mod dynamic_row;
mod embree;
mod error;
mod event;
mod exact;
#[allow(unsafe_code, reason = "the same library's triangles with several time steps")]
mod ffi_blur;
#[allow(unsafe_code, reason = "the one door to the library of C")]
mod ffi_embree;
#[allow(unsafe_code, reason = "the same library's scenes of instances")]
mod ffi_instances;
#[allow(unsafe_code, reason = "a call of the C library's allocator")]
mod ffi_malloc;
pub mod fuzzy;
mod job;
pub mod light;
pub mod light_plot;
mod memory;
mod options;
mod own;
pub mod paper;
mod pin;
pub mod plot;
mod pools;
mod random;
mod ray_classes;
pub mod rays;
pub mod record;
pub mod research;
mod row;
mod single;
pub mod stadium;
mod subject;
pub mod table;
mod ties;
mod timing;
pub mod tiny;
pub mod top;
mod trees;
mod vector;

pub use clock::{process_seconds, thread_seconds};
pub use comparison::Contestant;
pub use embree::EmbreeLibrary;
pub use error::Error;
pub use job::{ENGINES, Filter, Job};
pub use ray_classes::Class;
pub use row::{Row, to_json};
pub use subject::Subject;
pub use timing::{Answers, Engine};

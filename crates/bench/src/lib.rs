// SPDX-License-Identifier: GPL-3.0-or-later
//! Measures ray queries, on the same rays in the same process as Embree where a library of it is at hand.
//! Source: original; the classes of rays and what must be heeded are those of docs/benchmarks.md.
//!
//! The way of a run: a scene becomes a [`Subject`] (one mesh, a view, a light); [`rays::run`] makes the rays of each
//! [`Class`], asks every [`Job`] once for its answers and compares them, then times all jobs in turns and gives a
//! [`Row`] for each; [`table`] shows the rows.
//!
//! Times are those of the thread on its processor: what other programs take does not count. Rates of several threads
//! are what they reach if each has a core to itself.
#![deny(unsafe_code)]

mod clock;
mod embree;
mod error;
#[allow(unsafe_code, reason = "the one door to the library of C")]
mod ffi_embree;
mod job;
mod own;
mod random;
mod ray_classes;
pub mod rays;
mod row;
mod subject;
pub mod table;
mod timing;
mod vector;
mod verdict;

pub use embree::EmbreeLibrary;
pub use error::Error;
pub use job::{ENGINES, Filter, Job};
pub use ray_classes::Class;
pub use row::{Row, to_json};
pub use subject::Subject;

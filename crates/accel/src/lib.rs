// SPDX-License-Identifier: GPL-3.0-or-later
//! Ray queries: rays, hits, kd-trees and two-level scenes. Knows nothing of shading, materials, files or pixels.
//! Source: see each file; the outline is the paper's section 4 (kd-tree) and 6 (two levels).
//!
//! ```
//! use std::sync::Arc;
//! use gnurt_accel::{BuildOptions, Instance, ObjectTree, Ray, SceneTree, Threads, Triangles};
//!
//! let mesh = Triangles { positions: &[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]], indices: &[[0, 1, 2]] };
//! let object = Arc::new(ObjectTree::build(&[mesh], &BuildOptions::default(), Threads::Single));
//! let scene = SceneTree::build(&[Instance::identity(object)]);
//! let hit = scene.intersect(&Ray::new([0.25, 0.5, 1.0], [0.0, 0.0, -2.0])).expect("it aims at the triangle");
//! assert_eq!((hit.t, hit.u, hit.v, hit.prim_id), (0.5, 0.25, 0.5, 0));
//! ```
#![forbid(unsafe_code)]

mod aabb;
mod batch;
mod bvh;
mod geometry;
mod hit;
mod kd;
mod nearest;
mod object;
mod options;
mod packet;
mod query;
mod ray;
mod scene;
mod stats;
mod tile;
mod triangle;

pub use aabb::Aabb;
pub use geometry::{BadPrimitives, LARGEST_COORDINATE, MOST_TRIANGLES, Triangles};
pub use gnurt_simd::Level;
pub use hit::{Hit, HitBatch, INVALID_ID};
pub use object::ObjectTree;
pub use options::{BuildOptions, Quality, Structure, Threads, TriangleTest};
pub use query::{Coherence, Counters, Query, Record};
pub use ray::{Ray, RayBatch};
pub use scene::{Instance, SceneTree};
pub use stats::TreeStats;

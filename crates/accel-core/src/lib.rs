// SPDX-License-Identifier: GPL-3.0-or-later
//! The base of ray queries: rays, hits and geometry as plain data, the traversal states that pass through
//! trees, and the arithmetic that every tree shares. `gnurt-accel` is the API for programs; trees are crates
//! of their own.
//! Source: see each file.
//!
//! From below: `float`, `bits`, `aabb`, `ray`, `hit`: numbers and plain data. `slab`, `triangle`, `blocks`: one ray against
//! planes and triangles. `tile`, `beam`, `edge_planes`, `chunks`, `tile_test`: up to 64 rays of one [`direction_class`] against boxes and
//! triangles. [`traversal`]: the state that a query passes to the kernels of a tree. `geometry`,
//! `valid_triangles`, `threads`, `control`: the input of builds, their threads and their control. `store`:
//! trees in files. `curve`: curves and their tests.
//!
//! Only [`tile_kernels`] is compiled for each level here: the rest is `#[inline(always)]` for the kernels of
//! the crates above.
#![forbid(unsafe_code)]
#![allow(
    rustdoc::broken_intra_doc_links,
    reason = "keys of docs/papers.bib stand in brackets, too; tidy checks them"
)]
#![expect(
    missing_docs,
    reason = "fields and methods whose names say all, for three crates above; programs see gnurt-accel"
)]

pub mod aabb;
pub mod affine;
pub mod bad_primitives;
pub mod beam;
pub mod bits;
pub mod blocks;
pub mod chunks;
pub mod clip;
pub mod collect;
pub mod control;
pub mod curve;
pub mod direction_class;
pub mod edge_planes;
pub mod exact;
pub mod filter_region;
pub mod float;
pub mod geometry;
pub mod grids;
pub mod hit;
pub mod motion;
pub mod moving;
pub mod nearest;
pub mod options;
pub mod patches;
pub mod point;
pub mod primitive;
pub mod query;
pub mod ray;
pub mod ray_batch;
pub mod refit;
pub mod region;
pub mod shared_list;
pub mod slab;
pub mod stats;
pub mod store;
pub mod surfaces;
pub mod threads;
pub mod tile;
pub mod tile_kernels;
pub mod tile_test;
pub mod traversal;
pub mod triangle;
pub mod user;
pub mod valid_triangles;

pub use aabb::Aabb;
pub use control::{BuildControl, BuildError};
pub use curve::{CurveBasis, CurveForm, Curves};
pub use geometry::{
    BadPrimitives, Discs, FARTHEST_PLANE, Geometry, GeometryKind, LARGEST_COORDINATE, MOST_TRIANGLES,
    MovingQuads, MovingTriangles, Quads, Spheres, Triangles,
};
pub use grids::{Grid, Grids};
pub use hit::{Hit, HitBatch, INVALID_ID, PrimitiveId};
pub use motion::KeyInterval;
pub use options::{BuildOptions, Memory, Quality, Structure, TriangleTest};
pub use point::PointHit;
pub use query::{Coherence, Counters, Query, Record};
pub use ray::{AnyRay, Ray, Ray64};
pub use ray_batch::RayBatch;
pub use refit::RefitError;
pub use shared_list::SharedList;
pub use stats::TreeStats;
pub use store::LoadError;
pub use threads::Threads;
pub use user::{UserGeometry, UserHit};

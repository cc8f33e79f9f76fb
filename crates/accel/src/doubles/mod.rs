// SPDX-License-Identifier: GPL-3.0-or-later
//! Scenes of triangles in double precision: vertices as they are given, and answers of the same precision.
//! Hits, crossings and insides are decided without rounding (\[She97\]); parameters are off by less than 1e-13 of themselves. See
//! docs/reference/doubles.md. Space: that of the queried scene. Tests: `tests/doubles.rs`.
//!
//! ```
//! use gnurt_accel::{BuildOptions, Threads, doubles::{DoubleMesh, DoubleRay, DoubleScene}};
//!
//! let positions = [[1e8, 0.0, 0.0], [1e8 + 1.0, 0.0, 0.0], [1e8, 1.0, 0.0]];
//! let mesh = DoubleMesh::new(&positions, &[[0, 1, 2]]);
//! let scene = DoubleScene::build(&[mesh], &[], &BuildOptions::default(), Threads::Single)?;
//! let ray = DoubleRay::new([1e8 + 0.25, 0.5, 1.0], [0.0, 0.0, -2.0]);
//! let hit = scene.intersect(&ray).expect("it aims at the triangle");
//! assert_eq!((hit.t, hit.u, hit.v, hit.prim_id), (0.5, 0.25, 0.5, 0));
//! # Ok::<(), gnurt_accel::doubles::DoubleError>(())
//! ```

mod lines;
mod points;
mod rays;
mod scene;
mod space;

pub use points::DoublePoint;
pub use rays::{DoubleHit, DoubleRay};
pub use scene::{DoubleError, DoubleInstance, DoubleMesh, DoubleScene};

// SPDX-License-Identifier: GPL-3.0-or-later
//! Ray queries: rays, hits, kd-trees and two-level scenes. Knows nothing of shading, materials, files or pixels.
#![forbid(unsafe_code)]

mod hit;
mod ray;

pub use hit::{Hit, HitBatch, INVALID_ID};
pub use ray::{Ray, RayBatch};

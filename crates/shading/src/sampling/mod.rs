// SPDX-License-Identifier: GPL-3.0-or-later
//! Stateless random numbers and their warps into directions, points and choices.
//! Source: see each file. Everything is a function of its arguments: no generator is carried around.

pub(crate) mod distribution;
mod grid;
mod hash;
pub mod octahedron;
mod sobol;
mod sobol_lanes;
pub(crate) mod warp;
mod warp_lanes;

pub use distribution::{Choice, Distribution};
pub use grid::{GridDistribution, GridPoint};
pub use hash::hash_combine;
pub use sobol::{Draws, purpose, sample_pair};
pub use sobol_lanes::{DrawsX16, key_values, sample_pairs};
pub use warp::{Basis, concentric_disk, cosine_hemisphere, uniform_sphere};
pub(crate) use warp_lanes::{concentric_disk_of, frame_around, sin_cos_of_fraction};
pub use warp_lanes::{cosine_hemisphere_of, triangle};

// SPDX-License-Identifier: GPL-3.0-or-later
//! Queries of trees against the oracle.
//!
//! One program for all files: each of its own takes a second to link.

mod all_hits;
mod axis_parallel;
mod batches;
mod brute_force;
mod closest_point;
mod common;
mod compact;
mod control;
mod counters;
mod curves;
mod discs;
mod doubles;
mod far_away;
mod filters;
mod fuzzy;
mod grid_meshes;
mod grids;
mod instances;
mod intervals;
mod kd_build;
mod kd_sampled;
mod keyed;
mod limits;
mod masks;
mod mixed;
mod moving;
mod moving_instances;
mod nested;
mod packets;
mod parameters;
mod pencils;
mod pieces;
mod poses;
mod refit;
mod saved;
#[path = "common/signed.rs"]
mod signed;
mod surfaces;
mod traversal;
mod watertight;

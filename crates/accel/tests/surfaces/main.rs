// SPDX-License-Identifier: GPL-3.0-or-later
//! Questions about surfaces: crossings, sides, distances, near primitives and overlaps. Source: original.

#[path = "../common/mod.rs"]
mod common;
mod crossings;
mod inside;
mod normals;
mod overlaps;
mod slices;

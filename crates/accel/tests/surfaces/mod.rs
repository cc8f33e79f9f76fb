// SPDX-License-Identifier: GPL-3.0-or-later
//! Questions about surfaces: crossings, sides, distances, near primitives and overlaps; and surfaces that move while the shutter is
//! open.

mod crossings;
mod inside;
mod million;
mod motion;
mod normals;
mod overlaps;
mod slices;

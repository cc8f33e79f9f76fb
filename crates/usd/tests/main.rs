// SPDX-License-Identifier: GPL-3.0-or-later
//! Tests of USD files.

mod arrays;
mod broken;
mod cameras;
mod composition;
mod displacement;
mod instancing;
mod lights;
mod materials;
mod meshes;
mod mtlx;
mod packages;
mod save;
mod shapes;
mod skeletons;
mod strands;
mod support;
mod transforms;
mod volumes;

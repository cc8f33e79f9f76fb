// SPDX-License-Identifier: GPL-3.0-or-later
//! Geometries as triangles: every shape becomes meshes, or one mesh that is put in many places.

mod build;
mod data;
mod faces;
mod isosurface;
mod rates;
mod segments;
mod unit;

pub(crate) use build::build;
pub(crate) use data::{Bounds, Geometry, Spot};
pub(crate) use unit::sphere;

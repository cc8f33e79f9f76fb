// SPDX-License-Identifier: GPL-3.0-or-later
//! Geometries as meshes: triangles, spheres or curves, once or in many places.

mod build;
mod data;
mod faces;
mod isosurface;
mod rates;
mod segments;
mod unit;

pub(crate) use build::build;
pub(crate) use data::{Bounds, Geometry, Spot};
pub(crate) use segments::Shapes;
pub(crate) use unit::sphere;

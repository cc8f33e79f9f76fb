// SPDX-License-Identifier: GPL-3.0-or-later
//! Point clouds that shaders search, read and write: positions with values, their tree, and their files.

mod cloud;
mod file;
mod tree;

pub use cloud::{Column, PointCloud, Values};
pub use file::{read_cloud, write_cloud};
pub use tree::Found;

// SPDX-License-Identifier: GPL-3.0-or-later
//! A primitive that may meet a region, where it is shown to questions that are decided outside of trees.

use gnurt_accel_core::exact::InstancePath;
use gnurt_accel_core::primitive::Primitive;
use gnurt_accel_core::region::{LineRegion, Region};

/// A primitive that may meet a region.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfaceInRegion<'a> {
    /// The object that it is in.
    pub(crate) slot: u32,
    /// Its number in the object. The same one may come several times.
    pub(crate) number: u32,
    pub(crate) primitive: Primitive<'a>,
    /// The object's path; `None` if it is in the space of the query.
    pub(crate) path: Option<&'a InstancePath<'a>>,
    /// The region in the object's space.
    pub(crate) region: &'a Region,
}

impl SurfaceInRegion<'_> {
    /// The line of the query, in the object's space.
    pub(crate) fn line(&self) -> Option<&LineRegion> {
        match self.region {
            Region::Line(line) => Some(line),
            Region::Box(_) => None,
        }
    }
}

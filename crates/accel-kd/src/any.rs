// SPDX-License-Identifier: GPL-3.0-or-later
//! A kd-tree, interval hierarchy or grid, behind one set of methods.
//! Invariant: lists of numbers and blocks are those of the structure itself.
//! Tests: `tests/brute_force.rs`, `tests/intervals.rs` and `tests/saved.rs` of `gnurt-accel`.

use std::io::{self, Read, Write};

use gnurt_accel_core::blocks::WIDTH;
use gnurt_accel_core::control::Watch;
use gnurt_accel_core::point::{NearestPoint, Probe};
use gnurt_accel_core::primitive::Primitive;
use gnurt_accel_core::region::RegionFilter;
use gnurt_accel_core::store::{LoadError, Reader, Writer};
use gnurt_accel_core::surfaces::Surfaces;
use gnurt_accel_core::valid_triangles::ValidTriangles;
use gnurt_accel_core::{
    Aabb, BuildError, BuildOptions, RefitError, Structure, Threads, TreeStats, TriangleTest,
};

use crate::grid::GridIndex;
use crate::index::KdIndex;
use crate::interval::IntervalIndex;

/// A structure that BVHs are compared with, over an object's triangles and halves of quads. Space: object.
#[derive(Clone, Debug, PartialEq)]
pub enum ResearchIndex {
    /// A kd-tree.
    Kd(KdIndex),
    /// A bounding interval hierarchy or B-KD tree.
    Interval(IntervalIndex),
    /// A grid.
    Grid(GridIndex),
}

impl ResearchIndex {
    /// Builds the structure of the options over triangles, of which there is at least one.
    ///
    /// # Errors
    /// If the control of `watch` stops the build.
    ///
    /// # Panics
    /// If the structure is a BVH.
    pub fn build(
        triangles: &ValidTriangles,
        options: &BuildOptions,
        threads: Threads,
        watch: &Watch,
    ) -> Result<Self, BuildError> {
        Ok(match options.structure {
            Structure::Kd => Self::Kd(KdIndex::build(triangles, options, threads, watch)?),
            Structure::Grid => Self::Grid(GridIndex::build(triangles, options, threads, watch)?),
            Structure::Bih | Structure::PlainBih | Structure::BKd => {
                Self::Interval(IntervalIndex::build(triangles, options.structure, threads, watch)?)
            }
            Structure::Bvh => panic!("a BVH is built by gnurt-accel-bvh"),
        })
    }

    /// Box around everything.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        match self {
            Self::Kd(index) => index.bounds(),
            Self::Interval(index) => index.bounds(),
            Self::Grid(index) => index.bounds(),
        }
    }

    /// Size and shape.
    #[must_use]
    pub fn stats(&self) -> TreeStats {
        match self {
            Self::Kd(index) => index.stats(),
            Self::Interval(index) => index.stats(),
            Self::Grid(index) => index.stats(),
        }
    }

    /// Improves the nearest point of the triangles in the object of this slot.
    pub fn nearest(&self, probe: &Probe, slot: u32, nearest: &mut dyn NearestPoint) {
        match self {
            Self::Kd(index) => index.nearest(probe, slot, nearest),
            Self::Interval(index) => index.nearest(probe, slot, nearest),
            Self::Grid(index) => index.nearest(probe, slot, nearest),
        }
    }

    /// Visits the triangles that may meet a region.
    pub fn filter_region(&self, region_filter: &RegionFilter, visit: &mut dyn FnMut(u32, Primitive)) {
        match self {
            Self::Kd(index) => index.filter_region(region_filter, visit),
            Self::Interval(index) => index.filter_region(region_filter, visit),
            Self::Grid(index) => index.filter_region(region_filter, visit),
        }
    }

    /// Visits the numbers in each leaf block; returns the number of blocks.
    pub fn numbers(&self, visit: &mut dyn FnMut(usize, &[u32; WIDTH])) -> usize {
        match self {
            Self::Kd(index) => index.numbers(visit),
            Self::Interval(index) => index.numbers(visit),
            Self::Grid(index) => index.numbers(visit),
        }
    }

    /// Corners of the triangle with this number in a lane of a leaf block.
    #[must_use]
    pub fn corners_at(&self, number: u32, block: usize, lane: usize) -> [[f32; 3]; 3] {
        match self {
            Self::Kd(index) => index.corners_at(number, block, lane),
            Self::Interval(index) => index.corners_at(block, lane),
            Self::Grid(index) => index.corners_at(block, lane),
        }
    }

    /// Whether the structure can be refitted: interval hierarchies can.
    #[must_use]
    pub fn knows_refits(&self) -> bool {
        matches!(self, Self::Interval(_))
    }

    /// Refits to moved triangles.
    ///
    /// # Errors
    /// [`RefitError::Structure`] of kd-trees and grids, and those of interval hierarchies.
    pub fn refit(&mut self, surfaces: &Surfaces, threads: Threads) -> Result<(), RefitError> {
        match self {
            Self::Interval(index) => index.refit(surfaces, threads),
            Self::Kd(_) | Self::Grid(_) => Err(RefitError::Structure),
        }
    }

    /// Expected cost of a ray, as a multiple of its cost at the build.
    #[must_use]
    pub fn decline(&self) -> f64 {
        match self {
            Self::Interval(index) => index.decline(),
            Self::Kd(_) | Self::Grid(_) => 1.0,
        }
    }

    /// The triangle test of a kd-tree, which can be saved.
    ///
    /// # Errors
    /// `Unsupported` of interval hierarchies and grids.
    pub fn saved_test(&self) -> io::Result<TriangleTest> {
        let refused = match self {
            Self::Kd(index) => return Ok(index.triangle_test()),
            Self::Interval(_) => {
                "interval hierarchies cannot be saved: they are there to be built and refitted"
            }
            Self::Grid(_) => "grids cannot be saved; build them again instead",
        };
        Err(io::Error::new(io::ErrorKind::Unsupported, refused))
    }

    /// Writes a kd-tree.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn save(&self, writer: &mut Writer<'_, impl Write>) -> io::Result<()> {
        match self {
            Self::Kd(index) => index.save(writer),
            Self::Interval(_) | Self::Grid(_) => self.saved_test().map(drop),
        }
    }

    /// Reads a kd-tree.
    ///
    /// # Errors
    /// If the file holds no such tree: see [`LoadError`].
    pub fn load(
        reader: &mut Reader<'_, impl Read>,
        bounds: Aabb,
        stats: TreeStats,
        triangle_test: TriangleTest,
    ) -> Result<Self, LoadError> {
        KdIndex::load(reader, bounds, stats, triangle_test).map(Self::Kd)
    }

    /// Checks a tree that was read, whose numbers must be below `count`.
    ///
    /// # Errors
    /// If it is damaged.
    pub fn check(&self, count: u32) -> Result<(), LoadError> {
        match self {
            Self::Kd(index) => index.check(count),
            Self::Interval(_) | Self::Grid(_) => Ok(()),
        }
    }
}

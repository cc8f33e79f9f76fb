// SPDX-License-Identifier: GPL-3.0-or-later
//! The list of the kinds of primitives that are not single triangles, and the index that is of one of them.
//! Tests: `tests/mixed.rs` of `gnurt-accel`.

use std::io::{self, Read, Write};

use gnurt_accel_core::geometry::GeometryKind;
use gnurt_accel_core::point::{NearestPoint, Probe};
use gnurt_accel_core::primitive::Primitive;
use gnurt_accel_core::region::RegionFilter;
use gnurt_accel_core::store::{LoadError, Reader, Writer};
use gnurt_accel_core::traversal::{RayTraversal, TileTraversal};
use gnurt_accel_core::{Aabb, BadPrimitives, BuildError, Memory, Quality, RefitError, Threads, TreeStats};
use gnurt_simd::Simd;

use crate::blocked::{BlockKind, Blocked, Inputs};
use crate::node::WIDTH;

/// Makes the index of the kinds, and runs an expression for the one that it is of.
macro_rules! kinds {
    ($($(#[$doc:meta])* $Name:ident($Block:ty),)*) => {
        /// A kind of primitives.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum BlockSort {
            $($(#[$doc])* $Name,)*
        }

        /// Primitives of one kind, and their tree.
        #[derive(Clone, Debug)]
        pub enum BlockIndex {
            $($(#[$doc])* $Name(Blocked<$Block>),)*
        }

        impl BlockSort {
            /// That of a geometry; `None` for triangles.
            #[must_use]
            pub fn of(kind: &GeometryKind) -> Option<Self> {
                $(if <$Block>::is_kind_of(kind) {
                    return Some(Self::$Name);
                })*
                None
            }

            /// Builds over geometries of this kind; untraceable primitives are counted.
            ///
            /// # Errors
            /// There are too many.
            pub fn build(
                self,
                inputs: &Inputs,
                bad: &mut BadPrimitives,
                quality: Quality,
                memory: Memory,
                threads: Threads,
            ) -> Result<BlockIndex, BuildError> {
                Ok(match self {
                    $(Self::$Name => BlockIndex::$Name(Blocked::build(inputs, bad, quality, memory, threads)?),)*
                })
            }
        }

        impl BlockIndex {
            /// Its kind.
            #[must_use]
            pub fn sort(&self) -> BlockSort {
                match self {
                    $(Self::$Name(_) => BlockSort::$Name,)*
                }
            }

            /// Whether both have the same nodes and blocks.
            #[must_use]
            pub fn same_tree(&self, other: &Self) -> bool {
                match (self, other) {
                    $((Self::$Name(a), Self::$Name(b)) => a.same_tree(b),)*
                    _ => false,
                }
            }

            /// The lists of an index of this kind in files, as they are; `None` where there is no such kind.
            ///
            /// # Errors
            /// The file ends, or has a list that cannot be.
            pub fn load(
                kind: u64,
                reader: &mut Reader<'_, impl Read>,
                bounds: Aabb,
            ) -> Option<Result<Self, LoadError>> {
                $(if let Ok([fast, compact]) = <$Block>::IN_FILES {
                    if kind == fast || kind == compact {
                        let memory = if kind == fast { Memory::Fast } else { Memory::Compact };
                        return Some(Blocked::load(reader, memory, bounds).map(Self::$Name));
                    }
                })*
                None
            }
        }

        macro_rules! each {
            ($index:expr, $blocked:ident => $body:expr) => {
                match $index {
                    $(BlockIndex::$Name($blocked) => $body,)*
                }
            };
        }
    };
}

kinds! {
    /// Spheres.
    Spheres(crate::spheres::SphereBlock),
    /// Discs.
    Discs(crate::discs::DiscBlock),
    /// Curves.
    Curves(crate::curves::CurveBlock),
    /// Grids of vertices.
    Grids(crate::grids::GridBlock),
    /// Geometry of the caller's own.
    User(crate::user::UserBlock),
}

impl BlockIndex {
    /// Box around everything.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        each!(self, index => index.bounds())
    }

    /// Size and shape.
    #[must_use]
    pub fn stats(&self) -> TreeStats {
        each!(self, index => index.stats())
    }

    /// Fits the tree to primitives that have moved.
    ///
    /// # Errors
    /// That it has to be built again. It is of no use then.
    pub fn refit(&mut self, inputs: &Inputs, threads: Threads) -> Result<(), RefitError> {
        each!(self, index => index.refit(inputs, threads))
    }

    /// Numbers of all leaf blocks, and how many there are.
    pub fn numbers(&self, visit: &mut dyn FnMut(usize, &[u32; WIDTH])) -> usize {
        each!(self, index => index.numbers(visit))
    }

    /// The primitive in a lane.
    #[must_use]
    pub fn primitive(&self, block: usize, lane: usize) -> Primitive<'_> {
        each!(self, index => index.primitive(block, lane))
    }

    /// Shows the primitives that may meet a region.
    pub fn filter_region(&self, region_filter: &RegionFilter, visit: &mut dyn FnMut(u32, Primitive)) {
        each!(self, index => index.filter_region(region_filter, visit));
    }

    /// Its kind in files.
    ///
    /// # Errors
    /// It cannot be saved.
    pub fn in_files(&self) -> io::Result<u64> {
        each!(self, index => index.in_files())
    }

    /// Writes it.
    ///
    /// # Errors
    /// Those of the target.
    pub fn save(&self, writer: &mut Writer<'_, impl Write>) -> io::Result<()> {
        each!(self, index => index.save(writer))
    }

    /// Checks all properties that a traversal relies on, for `count` primitives. Then the tree is measured.
    ///
    /// # Errors
    /// The violated property.
    pub fn check(&mut self, count: u32) -> Result<(), LoadError> {
        each!(self, index => index.check(count))
    }

    /// Offers the ray's hits; it is valid and regular, the tree not empty.
    #[inline(always)]
    pub(crate) fn search<S: Simd>(&self, simd: S, traversal: &mut RayTraversal) {
        each!(self, index => search(simd, index, traversal));
    }

    /// Improves the hits of a tile's active rays, which are valid and regular, where they gain by going in turns: curves, which
    /// are many and wait for their vertices. Whether they do.
    #[inline(always)]
    pub(crate) fn search_tile<S: Simd>(&self, simd: S, traversal: &mut TileTraversal) -> bool {
        match self {
            Self::Curves(index) => index.search_tile(simd, traversal),
            _ => false,
        }
    }

    /// Improves `nearest` by the primitives.
    #[inline(always)]
    pub(crate) fn nearest<S: Simd>(&self, simd: S, probe: &Probe, slot: u32, nearest: &mut dyn NearestPoint) {
        each!(self, index => index.nearest(simd, probe, slot, nearest));
    }
}

/// One kind by itself: all of them in one function would share its registers.
#[inline(never)]
fn search<S: Simd, B: BlockKind>(simd: S, index: &Blocked<B>, traversal: &mut RayTraversal) {
    simd.vectorize(
        #[inline(always)]
        || index.search(simd, traversal),
    );
}

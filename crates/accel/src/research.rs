// SPDX-License-Identifier: GPL-3.0-or-later
//! The structures of the feature `research`: kd-trees, interval hierarchies and grids of `gnurt-accel-kd`.
//! Without the feature there is no [`ResearchIndex`], and no code for one. Tests: `tests/brute_force.rs`.

#[cfg(feature = "research")]
pub(crate) use gnurt_accel_kd::{Kernels, ResearchIndex};

#[cfg(not(feature = "research"))]
pub(crate) use absent::{Kernels, ResearchIndex};

/// Types without values, in the place of those of `gnurt-accel-kd`.
#[cfg(not(feature = "research"))]
mod absent {
    use std::io::{self, Read, Write};

    use gnurt_accel_core::blocks::WIDTH;
    use gnurt_accel_core::direction_class::DirectionClass;
    use gnurt_accel_core::point::{NearestPoint, Probe};
    use gnurt_accel_core::primitive::Primitive;
    use gnurt_accel_core::region::RegionFilter;
    use gnurt_accel_core::store::{LoadError, Reader, Writer};
    use gnurt_accel_core::surfaces::Surfaces;
    use gnurt_accel_core::traversal::{RayTraversal, TileTraversal};
    use gnurt_accel_core::{Aabb, RefitError, Threads, TreeStats, TriangleTest};
    use gnurt_simd::Token;

    #[derive(Clone, Debug, PartialEq)]
    pub(crate) enum ResearchIndex {}

    impl ResearchIndex {
        pub(crate) fn bounds(&self) -> Aabb {
            match *self {}
        }

        pub(crate) fn stats(&self) -> TreeStats {
            match *self {}
        }

        pub(crate) fn nearest(&self, _: &Probe, _: u32, _: &mut dyn NearestPoint) {
            match *self {}
        }

        pub(crate) fn filter_region(&self, _: &RegionFilter, _: &mut dyn FnMut(u32, Primitive)) {
            match *self {}
        }

        pub(crate) fn numbers(&self, _: &mut dyn FnMut(usize, &[u32; WIDTH])) -> usize {
            match *self {}
        }

        pub(crate) fn corners_at(&self, _: u32, _: usize, _: usize) -> [[f32; 3]; 3] {
            match *self {}
        }

        pub(crate) fn knows_refits(&self) -> bool {
            match *self {}
        }

        pub(crate) fn refit(&mut self, _: &Surfaces, _: Threads) -> Result<(), RefitError> {
            match *self {}
        }

        pub(crate) fn decline(&self) -> f64 {
            match *self {}
        }

        pub(crate) fn saved_test(&self) -> io::Result<TriangleTest> {
            match *self {}
        }

        pub(crate) fn save(&self, _: &mut Writer<'_, impl Write>) -> io::Result<()> {
            match *self {}
        }

        pub(crate) fn load(
            _: &mut Reader<'_, impl Read>,
            _: Aabb,
            _: TreeStats,
            _: TriangleTest,
        ) -> Result<Self, LoadError> {
            Err(LoadError::MissingFeature("research"))
        }

        pub(crate) fn check(&self, _: u32) -> Result<(), LoadError> {
            match *self {}
        }
    }

    pub(crate) struct Kernels;

    impl Kernels {
        pub(crate) fn of(_: Token) -> Self {
            Self
        }

        pub(crate) fn ray(&self, index: &ResearchIndex, _: &mut RayTraversal) {
            match *index {}
        }

        pub(crate) fn tile(&self, index: &ResearchIndex, _: DirectionClass, _: &mut TileTraversal) -> bool {
            match *index {}
        }
    }
}

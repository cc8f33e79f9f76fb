// SPDX-License-Identifier: GPL-3.0-or-later
//! The tables of kernels of a level, together: a query passes them through scenes and objects. See decision
//! 0018. Tests: `tests/brute_force.rs`, which runs at every level.

use std::sync::OnceLock;

use gnurt_accel_core::tile_kernels::TileKernels;
use gnurt_simd::Level;

/// One table of each crate that has kernels. A new structure is a line here.
pub(crate) struct Engine {
    pub(crate) tiles: TileKernels,
    pub(crate) bvh: gnurt_accel_bvh::Kernels,
    pub(crate) research: crate::research::Kernels,
}

impl Engine {
    /// That of a level, or of the best one below it that the CPU has.
    #[inline]
    pub(crate) fn at(level: Level) -> &'static Self {
        static ENGINES: OnceLock<[Engine; Level::ALL.len()]> = OnceLock::new();
        // A single ray needs it, too: after the first time it is a load.
        &ENGINES.get_or_init(|| Level::ALL.map(Self::new))[level as usize]
    }

    fn new(level: Level) -> Self {
        let token = level.token();
        Self {
            tiles: TileKernels::of(token),
            bvh: gnurt_accel_bvh::Kernels::of(level),
            research: crate::research::Kernels::of(token),
        }
    }

    /// Whether rays go together at this level. Where lanes are too narrow, they go one by one.
    pub(crate) fn has_tiles(&self) -> bool {
        self.bvh.has_tiles()
    }
}

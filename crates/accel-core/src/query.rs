// SPDX-License-Identifier: GPL-3.0-or-later
//! Options of a batch query, and its cost.

use gnurt_simd::Level;

/// The caller's knowledge about the rays of a batch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Coherence {
    /// Neighbours in the batch have similar directions (camera rays, shadow rays to one point): traced in
    /// packets.
    Coherent,
    /// Neighbours in the batch have near origins but different directions and short extents (ambient
    /// occlusion): sorted by direction within the batch, then traced in packets.
    Fanned,
    /// Unknown: traced one by one; those with origins all over a large scene are interleaved.
    #[default]
    Incoherent,
}

/// How to trace: a ray, or a batch of them. Level and coherence change only the speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Query {
    /// Instruction set; the default is the CPU's best.
    pub level: Level,
    /// Whether packets pay.
    pub coherence: Coherence,
    /// The visible kinds: each ray's own mask counts only in its common bits with this one. All by default.
    pub mask: u32,
}

impl Default for Query {
    #[inline]
    fn default() -> Self {
        Self { level: Level::default(), coherence: Coherence::default(), mask: u32::MAX }
    }
}

/// The cost of tracing.
///
/// Sums over rays: a tile adds one for each of its rays that may meet a node or is tested against a triangle.
/// Rays of a tile go through the tree in one order, so a tile counts more than its rays would singly. Every
/// level with tiles counts the same nodes, and the same triangles except for AVX-512, where fewer are tested
/// for single rays.
/// Tests: `tests/counters.rs`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Rays of queries.
    pub rays: u64,
    /// Nodes visited, leaves too: of the top tree and of objects.
    pub nodes: u64,
    /// Ray-triangle tests.
    pub triangles: u64,
}

impl std::ops::AddAssign for Counters {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.nodes += other.nodes;
        self.triangles += other.triangles;
    }
}

/// Sums over all the batches that were traced with it, and on request the cost of each ray of the last one.
#[derive(Clone, Debug, Default)]
pub struct Record {
    /// Sums.
    pub counters: Counters,
    /// `Some`: requests nodes plus triangles of each ray of the last batch, for heat maps. Such batches are
    /// traced ray by ray.
    pub costs: Option<Vec<u32>>,
}

impl Record {
    /// A record that requests costs per ray.
    #[must_use]
    pub fn with_costs() -> Self {
        Self { counters: Counters::default(), costs: Some(Vec::new()) }
    }
}

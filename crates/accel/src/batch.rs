// SPDX-License-Identifier: GPL-3.0-or-later
//! From batches to tiles, and to results.
//!
//! A coherent batch passes these stages: `BatchRun` (`batch_run.rs`; `sorted.rs` if its rays are to be
//! sorted) loads 64 rays at a time -> [`Target::tile`] -> the scene's top tree, if any (`scene/walk.rs`).
//! Then `ObjectTree::tile` separates direction classes (`coherent.rs`) -> the table of kernels of the kd-tree
//! or the BVH (`kernels.rs` of either crate) -> its traversal (`tiles.rs`). Incoherent rays go from
//! `ObjectTree::tile` to the BVH's `single.rs`. A single ray: `Target::closest` (`query.rs`) ->
//! [`Target::ray`] -> `ObjectTree::ray` -> the table of kernels -> its `search`. One value passes all stages,
//! a `RayTraversal` or a `TileTraversal`.

use gnurt_accel_core::nearest::Kind;
use gnurt_accel_core::tile::NearestTile;
use gnurt_accel_core::traversal::TileTraversal;

use crate::answers::Answers;
use crate::batch_run::BatchRun;
use crate::engine::Engine;
use crate::pencil::Pencil;
use crate::sorted;
use crate::target::Target;
use crate::{Coherence, HitBatch, Query, RayBatch, Record};

/// A batch's closest hits.
pub(crate) fn intersect(
    target: Target,
    query: &Query,
    rays: &RayBatch,
    hits: &mut HitBatch,
    record: &mut Record,
) {
    hits.reset(rays.len());
    trace(target, query, rays, Kind::Closest, Answers::Hits(target, hits), record);
}

/// Which rays of a batch hit anything.
pub(crate) fn occluded(
    target: Target,
    query: &Query,
    rays: &RayBatch,
    occluded: &mut Vec<bool>,
    record: &mut Record,
) {
    occluded.clear();
    occluded.resize(rays.len(), false);
    trace(target, query, rays, Kind::Any, Answers::Flags(occluded), record);
}

/// Which rays of a pencil hit anything.
pub(crate) fn occluded_pencil(
    target: Target,
    query: &Query,
    pencil: &mut Pencil,
    record: &mut Record,
) -> u64 {
    let engine = Engine::at(query.level);
    let mut nearest = NearestTile::EMPTY;
    let Pencil { org, rays, t_far } = pencil;
    nearest.t = *t_far;
    rays.mask = query.mask;
    let active = engine.tiles.fill(rays, *org, &mut nearest);
    let counters = &mut record.counters;
    counters.rays += u64::from(active.count_ones());
    if active == 0 {
        return 0;
    }
    let traversal =
        &mut TileTraversal { rays, active, kind: Kind::Any, slot: 0, nearest: &mut nearest, counters };
    target.tile(engine, traversal, false);
    active & engine.tiles.hit(&nearest)
}

fn trace(
    target: Target,
    query: &Query,
    rays: &RayBatch,
    kind: Kind,
    mut answers: Answers,
    record: &mut Record,
) {
    rays.check();
    let Record { counters, costs } = record;
    let batch = BatchRun { target, engine: Engine::at(query.level), rays, kind, mask: query.mask };
    match (costs, query.coherence) {
        (Some(costs), _) => batch.singles(&mut answers, counters, costs),
        (None, Coherence::Fanned) if batch.engine.has_tiles() => {
            sorted::trace(&batch, &mut answers, counters);
        }
        (None, coherence) => batch.tiles(coherence == Coherence::Incoherent, &mut answers, counters),
    }
    counters.rays += rays.len() as u64;
}

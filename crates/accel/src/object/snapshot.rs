// SPDX-License-Identifier: GPL-3.0-or-later
//! An object at one time of an open shutter. Space: object. Tests: `tests/surfaces/motion.rs`.

use std::sync::{Arc, OnceLock};

use super::kind::Times;
use super::{Index, ObjectTree, Part};
use crate::Aabb;

impl ObjectTree {
    /// Whether there are meshes in it that move while the shutter is open.
    #[must_use]
    pub fn moves(&self) -> bool {
        self.parts.iter().any(|part| matches!(part.index, Index::Moving(_) | Index::MovingUser(_)))
    }

    /// The object at one time; all its queries refer to that time. Costs a pass over the moving parts; an
    /// object without any is returned as it is.
    #[must_use]
    pub fn at(self: &Arc<Self>, time: f32) -> Arc<Self> {
        if !self.moves() {
            return self.clone();
        }
        let part = |Part { mask, times, index }: &Part| {
            let time = times.local(time)?;
            let index = match index {
                Index::Moving(moving) => Index::Bvh(moving.at(time)),
                Index::MovingUser(moving) => Index::Blocks(moving.at(time)),
                still => still.clone(),
            };
            Some(Part { mask: *mask, times: Times::SHUTTER, index })
        };
        let parts: Vec<Part> = self.parts.iter().filter_map(part).collect();
        let bounds = parts.iter().fold(Aabb::EMPTY, |all, part| all.union(&part.index.bounds()));
        Arc::new(Self {
            bounds,
            parts,
            groups: self.groups.clone(),
            numbering: self.numbering.clone(),
            bad: self.bad,
            stats: self.stats,
            locations: OnceLock::new(),
        })
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Newton's method for the first direction of a chain, so that it ends at a lamp.
//! Source: [ZGJ20] sections 4.2 and 5 (walks with a step that shrinks where a proposal fails), [HDF15]. Differs: the unknown
//! is the first direction, and all turns but the last condition hold by following the ray; so two unknowns do for chains of
//! any length, and derivatives are those of rays.
//! Space: world; misses and steps are in radians. Tests: `tests`, crates/render/tests/caustics.rs.

use glam::{Mat2, Vec2, Vec3};
use gnurt_shading::lights::Place;

use super::trace::{MOST, Trace};

/// Chains that are followed for one walk at most.
const MOST_STEPS: u32 = 20;
/// After this many, walks that still miss by more end.
const GIVES_UP: [(u32, f32); 2] = [(3, 0.5), (6, 0.02)];
/// A chain that misses by less than this arrives with one more step, which leaves only the error of its arithmetic.
const ARRIVED: f32 = 1e-5;
/// The longest step.
const FARTHEST: f32 = 0.4;
/// Solutions closer than this are one if they meet the same primitives: by where their chains would end, and by their first
/// directions. In a focus each triangle of a caster has its own, and those on both sides of an edge are as close as can be.
/// Walks to one solution were seen to differ by 3e-5 at most, those to others on the same primitives by 1e-4 at least.
const SAME_END: f32 = 5e-5;
const SAME_START: f32 = 0.005;

/// By how much a chain misses a lamp.
#[derive(Clone, Copy, Debug)]
pub(super) struct Miss {
    /// From where it goes to where the lamp is.
    by: Vec2,
    /// The change of where it goes, per step.
    change: Mat2,
    /// How far the lamp is; infinite for lamps without a position.
    pub(super) dist: f32,
}

impl Miss {
    /// `None` where the lamp is.
    pub(super) fn of(trace: &Trace, place: Place) -> Option<Self> {
        let (towards, dist) = match place {
            Place::At(p) => {
                let dist = (p - trace.org).length();
                ((p - trace.org) / dist, dist)
            }
            Place::Towards(dir) => (dir, f32::INFINITY),
        };
        let heading = trace.heading;
        let (x, y) = heading.any_orthonormal_pair();
        let flat = |v: Vec3| Vec2::new(v.dot(x), v.dot(y));
        let mut by = flat(towards - heading);
        if towards.dot(heading) < 0.0 {
            // On the far side distances would shrink again.
            by = by.normalize_or(Vec2::X) * 1.5;
        }
        let [a, b] = [0, 1].map(|k| flat(trace.change.dir[k] + trace.change.org[k] / dist));
        let change = Mat2::from_cols(a, b);
        (by.is_finite() && change.is_finite() && dist > 0.0).then_some(Self { by, change, dist })
    }

    fn step(&self) -> Option<Vec2> {
        let step = self.change.inverse() * self.by;
        step.is_finite().then(|| step.clamp_length_max(FARTHEST))
    }
}

/// A direction from which chains are followed.
#[derive(Clone, Copy, Debug)]
struct Base {
    dir: Vec3,
    frame: [Vec3; 2],
    step: Vec2,
    size: f32,
}

impl Base {
    fn moved(&self, share: f32) -> Vec3 {
        let step = self.step * share;
        (self.dir + self.frame[0] * step.x + self.frame[1] * step.y).normalize()
    }
}

/// A walk.
#[derive(Clone, Copy, Debug)]
pub(super) struct Newton {
    base: Option<Base>,
    /// The share of the step that is taken.
    share: f32,
    steps: u32,
    /// Whether only one more step was due.
    is_last: bool,
}

/// What to do next.
#[derive(Clone, Copy, Debug)]
pub(super) enum Next {
    /// Follow a chain in this direction.
    Follow(Vec3),
    Arrived,
    Failed,
}

impl Newton {
    pub(super) fn new() -> Self {
        Self { base: None, share: 1.0, steps: 0, is_last: false }
    }

    /// A chain was followed to its end.
    pub(super) fn ended(&mut self, trace: &Trace, miss: &Miss) -> Next {
        let size = miss.by.length();
        if size < ARRIVED && self.is_last {
            return Next::Arrived;
        }
        if GIVES_UP.iter().any(|&(steps, least)| self.steps >= steps && size > least) {
            return Next::Failed;
        }
        if self.base.is_some_and(|base| size > base.size && size >= ARRIVED) {
            return self.failed();
        }
        self.is_last = size < ARRIVED;
        let Some(step) = miss.step() else { return Next::Failed };
        if self.is_last {
            self.share = 1.0;
        } else if self.base.is_some() {
            self.share = (2.0 * self.share).min(1.0);
        }
        let base = Base { dir: trace.dir, frame: trace.frame, step, size };
        self.base = Some(base);
        self.follow(&base)
    }

    /// The last chain was lost, or missed by more: a shorter step.
    pub(super) fn failed(&mut self) -> Next {
        let Some(base) = self.base else { return Next::Failed };
        self.share *= 0.5;
        self.follow(&base)
    }

    fn follow(&mut self, base: &Base) -> Next {
        self.steps += 1;
        if self.steps >= MOST_STEPS || self.share < 1.0 / 8.0 {
            return Next::Failed;
        }
        Next::Follow(base.moved(self.share))
    }
}

/// Where a walk arrived.
#[derive(Clone, Copy, Debug)]
pub(super) struct Solution {
    dir: Vec3,
    frame: [Vec3; 2],
    change: Mat2,
    met: [[u32; 3]; MOST],
}

impl Solution {
    pub(super) fn new(trace: &Trace, miss: &Miss) -> Self {
        Self { dir: trace.dir, frame: trace.frame, change: miss.change, met: trace.met }
    }

    /// Whether a chain that made the same turns is this one.
    pub(super) fn is(&self, trace: &Trace) -> bool {
        let off = trace.dir - self.dir;
        let step = Vec2::new(off.dot(self.frame[0]), off.dot(self.frame[1]));
        self.met == trace.met
            && off.length_squared() < SAME_START * SAME_START
            && (self.change * step).length() < SAME_END
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt_accel::Ray;
    use gnurt_shading::SampleKey;

    /// A chain that goes `off` the z axis, over a primitive, and by how much it misses a lamp there.
    fn chain(off: f32, prim_id: u32) -> (Trace, Miss) {
        let key = SampleKey { pixel: 0, sample: 0, branch: 0 };
        let dir = Vec3::new(off, 0.0, 1.0).normalize();
        let mut trace = Trace::new(Ray::new([0.0; 3], dir.into()), key, Vec3::ZERO, None, MOST);
        trace.met[0] = [0, 0, prim_id];
        let miss = Miss::of(&trace, Place::At(Vec3::new(0.0, 0.0, 2.0))).expect("it is not at the lamp");
        (trace, miss)
    }

    #[test]
    fn solutions_on_two_primitives_are_two() {
        let (trace, miss) = chain(0.0, 3);
        let solution = Solution::new(&trace, &miss);
        assert!(solution.is(&chain(0.0, 3).0), "the same");
        assert!(solution.is(&chain(2e-5, 3).0), "as far off as walks end");
        assert!(!solution.is(&chain(2e-4, 3).0), "farther off");
        assert!(!solution.is(&chain(0.0, 4).0), "beyond an edge");
    }

    #[test]
    fn walks_that_are_near_make_one_more_step() {
        let mut walk = Newton::new();
        let (trace, miss) = chain(0.5 * ARRIVED, 3);
        let Next::Follow(dir) = walk.ended(&trace, &miss) else { panic!("one more step") };
        assert!(dir.x.abs() < 1e-3 * ARRIVED, "it is exact here: {dir}");
        let (trace, miss) = chain(dir.x, 3);
        assert!(matches!(walk.ended(&trace, &miss), Next::Arrived));
    }
}

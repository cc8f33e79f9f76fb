// SPDX-License-Identifier: GPL-3.0-or-later
//! Walks below surfaces: their state, and their steps.
//! Source: [CKB16]; steps are drawn for one channel, by the plain densities or outwards (`half_space`), and weighted by
//! the mean density of all channels and both kinds [WND*14].
//! Numbers of the first four events are stratified over a pixel's samples.
//! `subsurface` begins and ends walks. Space: world. Tests: crates/render/tests/subsurface.rs.

use glam::Vec3;
use gnurt_accel::{HitBatch, RayBatch};
use gnurt_shading::SampleKey;
use gnurt_shading::bsdf::ClosureBatch;
use gnurt_shading::phase::Phase;

use super::flight::{Random, channel_by};
use super::half_space::HalfSpace;
use crate::world::HitLanes;

/// Scattering events of one walk, at most: further light is lost. Of a white body that is 1 %.
const MOST_EVENTS: u32 = 4096;
/// Events after which walks end by chance.
const CERTAIN_EVENTS: u32 = 16;
/// Branch of a path's key: the path from where it leaves.
const LEAVING: u32 = 9;

/// A walk.
#[derive(Clone, Copy)]
pub(super) struct Walk {
    /// The number of its path.
    pub(super) number: u32,
    /// The object that it is in.
    pub(super) leaf: u32,
    pub(super) key: SampleKey,
    pub(super) org: Vec3,
    pub(super) dir: Vec3,
    /// The part of the ray up to the next event that it has yet to go.
    pub(super) span: [f32; 2],
    pub(super) throughput: Vec3,
    pub(super) albedo: Vec3,
    pub(super) extinction: Vec3,
    pub(super) phase: Phase<f32>,
    pub(super) events: u32,
    /// Below the surface where it entered, and the share of directions and distances that are drawn as light gets out of that.
    pub(super) space: HalfSpace,
    pub(super) outward_share: f32,
    /// The densities of the direction in that half space over that of the phase function, by channel.
    pub(super) ratio: Vec3,
}

/// The walks of one step.
#[derive(Default)]
pub(crate) struct Walks {
    pub(super) list: Vec<(Walk, Random)>,
    /// By point of the last shader: the factor of paths that other lobes scatter.
    pub(crate) shares: Vec<f32>,
    pub(super) rays: RayBatch,
    pub(super) keys: Vec<SampleKey>,
    pub(super) hits: HitBatch,
    /// Whether there ever was one.
    pub(crate) has_begun: bool,
    /// Where walks left: rays from outside that end there, in place of the paths' rays.
    pub(super) leaving: Leaving,
    pub(super) white: ClosureBatch,
}

/// Rays of all paths of a step, new ones where walks left; hits of those only.
#[derive(Default)]
pub(super) struct Leaving {
    pub(super) rays: RayBatch,
    pub(super) keys: Vec<SampleKey>,
    pub(super) hits: HitBatch,
    /// The paths that left, in order of materials.
    pub(super) order: Vec<u64>,
}

impl Walks {
    /// Forgets all.
    pub(crate) fn begin(&mut self) {
        self.list.clear();
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.list.is_empty()
    }
}

impl Walk {
    /// Sum of the light of all channels.
    fn light(&self) -> f32 {
        self.throughput.element_sum()
    }

    /// The channel and the kind of densities of the next direction and distance: those of the half space, or the plain ones.
    fn choose(&self, random: &mut Random) -> (usize, bool) {
        let u = random.next();
        let leads_out = u < self.outward_share;
        let u = if leads_out {
            u / self.outward_share
        } else {
            (u - self.outward_share) / (1.0 - self.outward_share)
        };
        (channel_by(self.throughput, u), leads_out)
    }

    /// Chooses the distance to the first event.
    pub(super) fn begin(&mut self, random: &mut Random) {
        let choice = self.choose(random);
        self.set_distance(choice, random.next());
    }

    fn set_distance(&mut self, (channel, leads_out): (usize, bool), u: f32) {
        let stretch = if leads_out { self.space.stretch(self.dir)[channel] } else { 1.0 };
        let distance = -(1.0 - u).ln() / (self.extinction[channel] * stretch);
        // A ray of no length would miss a surface that is there.
        self.span = [0.0, distance.clamp(f32::MIN_POSITIVE, f32::MAX)];
    }

    /// The light after a way of `t` without an event, or, with the extinctions there, with one at its end: over the mean
    /// density of all channels and both kinds.
    fn carried(&self, t: f32, end: Option<Vec3>) -> Vec3 {
        let stretch = self.space.stretch(self.dir);
        let mut plain = (-self.extinction * t).exp();
        let mut outwards = self.ratio * (-self.extinction * stretch * t).exp();
        if let Some(extinction) = end {
            plain *= extinction;
            outwards *= extinction * stretch;
        }
        let density = self.throughput.dot(plain + (outwards - plain) * self.outward_share);
        self.throughput * plain * (self.light() / density.max(f32::MIN_POSITIVE))
    }

    /// Accounts for a way of `t` without an event.
    pub(super) fn pass(&mut self, t: f32) {
        self.throughput = self.carried(t, None);
    }

    /// Goes to the next event and is scattered there; returns whether the walk goes on.
    pub(super) fn is_scattered(&mut self, random: &mut Random) -> bool {
        let t = self.span[1];
        self.throughput = self.carried(t, Some(self.extinction)) * self.albedo;
        self.events += 1;
        if self.events >= CERTAIN_EVENTS {
            let keep = self.throughput.max_element().min(1.0);
            if random.next() >= keep {
                return false;
            }
            self.throughput /= keep;
        }
        self.org += self.dir * t;
        if !(self.events < MOST_EVENTS && self.light() > 0.0 && self.throughput.is_finite()) {
            return false;
        }
        let (choice, distance) = (self.choose(random), random.next());
        let [x, y] = [random.next(), random.next()];
        let before = self.dir;
        self.dir = match choice {
            (channel, true) => self.space.sample(channel, [x, y]),
            // One lobe: nothing to choose.
            (_, false) => Vec3::from(self.phase.sample(before.into(), [0.0, x, y]).0),
        };
        self.ratio = self.space.density(self.dir) / self.phase.value_of(before, self.dir);
        self.set_distance(choice, distance);
        true
    }
}

impl Leaving {
    pub(super) fn begin(&mut self, from: HitLanes) {
        self.rays.clone_from(from.rays);
        self.keys.clear();
        self.keys.extend_from_slice(from.keys);
        self.hits.reset(from.hits.len());
    }

    /// A walk that met its object from within at a hit: the path's ray now comes from the other side, as if it had hit that.
    pub(super) fn push(&mut self, walk: &Walk, (hits, lane): (&HitBatch, usize)) {
        let (i, t) = (walk.number as usize, hits.t[lane]);
        let org = walk.org + walk.dir * (2.0 * t);
        for k in 0..3 {
            (self.rays.org[k][i], self.rays.dir[k][i]) = (org[k], -walk.dir[k]);
        }
        let to = &mut self.hits;
        (to.t[i], to.u[i], to.v[i]) = (t, hits.u[lane], hits.v[lane]);
        (to.prim_id[i], to.geom_id[i]) = (hits.prim_id[lane], hits.geom_id[lane]);
        (to.inst_id[i], to.leaf_id[i]) = (hits.inst_id[lane], hits.leaf_id[lane]);
        self.keys[i] = walk.key.fork(LEAVING);
    }
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Eight rays that are traced together, and the best hits of each.
//! Source: the paper's section 5.1 (rays in SIMD lanes), widened from four to eight.
//! Space: as the rays that went in.
//! Invariant: lanes outside `active` hold a copy of an active lane's ray, so that no garbage meets the arithmetic.

use gnurt_simd::{Simd, f32x8, mask32x8, prelude::*, u32x8};

use crate::nearest::{Mode, Nearest};
use crate::triangle::Meeting;
use crate::{INVALID_ID, Ray, RayBatch};

/// Rays per packet.
pub(crate) const WIDTH: usize = 8;

/// Rays in lanes.
#[derive(Clone, Copy)]
pub(crate) struct RayPacket<S: Simd> {
    pub(crate) org: [f32x8<S>; 3],
    pub(crate) dir: [f32x8<S>; 3],
    pub(crate) t_near: f32x8<S>,
    pub(crate) active: mask32x8<S>,
}

/// Best hits in lanes; see [`Nearest`].
#[derive(Clone, Copy)]
pub(crate) struct NearestPacket<S: Simd> {
    pub(crate) t: f32x8<S>,
    pub(crate) u: f32x8<S>,
    pub(crate) v: f32x8<S>,
    pub(crate) number: u32x8<S>,
    pub(crate) slot: u32x8<S>,
}

/// Where lanes meet a triangle.
#[derive(Clone, Copy)]
pub(crate) struct MeetingPacket<S: Simd> {
    pub(crate) t: f32x8<S>,
    pub(crate) u: f32x8<S>,
    pub(crate) v: f32x8<S>,
    /// Lanes that do.
    pub(crate) hit: mask32x8<S>,
}

impl<S: Simd> RayPacket<S> {
    /// Rays `first..first + 8` of a batch as far as it goes, and how far each reaches. Unsound rays are not active.
    #[inline(always)]
    pub(crate) fn load(simd: S, rays: &RayBatch, first: usize) -> (Self, f32x8<S>) {
        let last = rays.len().min(first + WIDTH);
        let load = |array: &[f32], padding| gnurt_simd::load_or(simd, &array[first..last], padding);
        let org = [load(&rays.org[0], 0.0), load(&rays.org[1], 0.0), load(&rays.org[2], 0.0)];
        let dir = [load(&rays.dir[0], 0.0), load(&rays.dir[1], 0.0), load(&rays.dir[2], 0.0)];
        let (t_near, t_far) = (load(&rays.t_near, 1.0), load(&rays.t_far, 0.0));

        let active = t_near.simd_le(t_far);
        (Self { org, dir, t_near, active }.sound(simd), t_far)
    }

    /// Only rays that can hit anything stay active: [`Ray::is_sound`] in lanes.
    #[inline(always)]
    pub(crate) fn sound(mut self, simd: S) -> Self {
        let [org, dir] = [self.org, self.dir];
        let limit = f32x8::splat(simd, Ray::FARTHEST_ORIGIN);
        let near = org[0].abs().simd_le(limit) & org[1].abs().simd_le(limit) & org[2].abs().simd_le(limit);
        let most = f32x8::splat(simd, f32::MAX);
        let finite = dir[0].abs().simd_le(most) & dir[1].abs().simd_le(most) & dir[2].abs().simd_le(most);
        let zero = f32x8::splat(simd, 0.0);
        let moves = dir[0].simd_ne(zero) | dir[1].simd_ne(zero) | dir[2].simd_ne(zero);
        self.active = self.active & near & finite & moves;
        self.padded(simd)
    }

    /// The same rays, of which only those in `active` count.
    #[inline(always)]
    pub(crate) fn with_active(self, simd: S, active: mask32x8<S>) -> Self {
        Self { active, ..self }.padded(simd)
    }

    /// Copies the first active lane into all that are not.
    #[inline(always)]
    fn padded(mut self, simd: S) -> Self {
        if self.active.any_true() && !self.active.all_true() {
            let from = self.active.to_bitmask().trailing_zeros() as usize;
            for k in 0..3 {
                let (org, dir) = (gnurt_simd::lane(self.org[k], from), gnurt_simd::lane(self.dir[k], from));
                self.org[k] = self.active.select(self.org[k], f32x8::splat(simd, org));
                self.dir[k] = self.active.select(self.dir[k], f32x8::splat(simd, dir));
            }
            let t_near = gnurt_simd::lane(self.t_near, from);
            self.t_near = self.active.select(self.t_near, f32x8::splat(simd, t_near));
        }
        self
    }

    /// Lane `i` as a single ray; its far end is kept elsewhere.
    #[inline(always)]
    pub(crate) fn ray(&self, i: usize) -> Ray {
        let lane = gnurt_simd::lane;
        Ray {
            org: [lane(self.org[0], i), lane(self.org[1], i), lane(self.org[2], i)],
            t_near: lane(self.t_near, i),
            dir: [lane(self.dir[0], i), lane(self.dir[1], i), lane(self.dir[2], i)],
            t_far: f32::INFINITY,
        }
    }

    /// The largest component of each direction, without its sign.
    #[inline(always)]
    pub(crate) fn longest(&self) -> f32x8<S> {
        self.dir[0].abs().max(self.dir[1].abs()).max(self.dir[2].abs())
    }

    /// What all active lanes have in common, or `None` where they differ and have to go one by one: all lanes must go
    /// the same way along each axis and move most along the same one, by lengths that floats can divide by.
    #[inline(always)]
    pub(crate) fn heading(&self, simd: S) -> Option<Heading> {
        let active = self.active.to_bitmask();
        let uniform = |mask: mask32x8<S>| match mask.to_bitmask() & active {
            0 => Some(false),
            bits if bits == active => Some(true),
            _ => None,
        };
        let [x, y, z] = [self.dir[0].abs(), self.dir[1].abs(), self.dir[2].abs()];
        let longest = self.longest();
        let regular = longest.simd_ge(f32x8::splat(simd, Ray::SHORTEST))
            & longest.simd_le(f32x8::splat(simd, Ray::LONGEST));
        if uniform(regular) != Some(true) {
            return None;
        }
        let along_x = uniform(x.simd_ge(y) & x.simd_ge(z))?;
        let along_y = along_x || uniform(y.simd_ge(z))?;
        let longest_axis = if along_x { 0 } else { 2 - usize::from(along_y) };
        let backwards = [
            uniform(self.dir[0].is_sign_negative())?,
            uniform(self.dir[1].is_sign_negative())?,
            uniform(self.dir[2].is_sign_negative())?,
        ];
        Some(Heading { backwards, longest_axis })
    }
}

/// Where all lanes of a packet go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Heading {
    /// Towards smaller coordinates.
    pub(crate) backwards: [bool; 3],
    pub(crate) longest_axis: usize,
}

impl<S: Simd> NearestPacket<S> {
    #[inline(always)]
    pub(crate) fn none(simd: S, t_far: f32x8<S>) -> Self {
        let (zero, invalid) = (f32x8::splat(simd, 0.0), u32x8::splat(simd, INVALID_ID));
        Self { t: t_far, u: zero, v: zero, number: invalid, slot: invalid }
    }

    #[inline(always)]
    pub(crate) fn get(&self, i: usize) -> Nearest {
        Nearest {
            t: gnurt_simd::lane(self.t, i),
            u: gnurt_simd::lane(self.u, i),
            v: gnurt_simd::lane(self.v, i),
            number: self.number.as_array()[i & 7],
            slot: self.slot.as_array()[i & 7],
        }
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, i: usize, nearest: &Nearest) {
        self.t.as_mut_array()[i & 7] = nearest.t;
        self.u.as_mut_array()[i & 7] = nearest.u;
        self.v.as_mut_array()[i & 7] = nearest.v;
        self.number.as_mut_array()[i & 7] = nearest.number;
        self.slot.as_mut_array()[i & 7] = nearest.slot;
    }

    /// [`Nearest::offer`] in lanes.
    #[inline(always)]
    pub(crate) fn offer<M: Mode>(&mut self, simd: S, meeting: &MeetingPacket<S>, number: u32, slot: u32) {
        let (number, slot) = (u32x8::splat(simd, number), u32x8::splat(simd, slot));
        let (t, better) = if M::ANY {
            (f32x8::splat(simd, f32::NEG_INFINITY), meeting.hit)
        } else {
            let lower = slot.simd_lt(self.slot) | (slot.simd_eq(self.slot) & number.simd_lt(self.number));
            let closer = meeting.t.simd_lt(self.t) | (meeting.t.simd_eq(self.t) & lower);
            (meeting.t, meeting.hit & closer)
        };
        self.t = better.select(t, self.t);
        self.u = better.select(meeting.u, self.u);
        self.v = better.select(meeting.v, self.v);
        self.number = better.select(number, self.number);
        self.slot = better.select(slot, self.slot);
    }
}

impl<S: Simd> MeetingPacket<S> {
    /// Writes lane `i`.
    #[inline(always)]
    pub(crate) fn set(&mut self, i: usize, meeting: Option<Meeting>) {
        let found = meeting.unwrap_or(Meeting { t: 0.0, u: 0.0, v: 0.0 });
        self.t.as_mut_array()[i & 7] = found.t;
        self.u.as_mut_array()[i & 7] = found.u;
        self.v.as_mut_array()[i & 7] = found.v;
        self.hit.set(i & 7, meeting.is_some());
    }
}

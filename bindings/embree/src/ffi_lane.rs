// SPDX-License-Identifier: GPL-3.0-or-later
//! A ray of a packet in the program's memory, its hit, and the arguments of a query. The layouts of Embree 4.4's headers.
//! Invariant: the maker of a [`Lane`] guarantees its memory. Tests: `tests/c/embree.c`, `tests/c/frames.c`.

use std::ptr::null_mut;
use std::sync::atomic::Ordering;

use gnurt_accel::{Hit, Ray};

use crate::ffi_abi::{self as abi, Arguments, COHERENT, Context, INVALID, INVOKE_ARGUMENT_FILTER, row};
use crate::located::{Located, across};
use crate::objects::Committed;

/// Where ray `at` of a packet of `n` lies.
#[derive(Clone, Copy)]
pub(crate) struct Lane {
    first: *mut f32,
    n: u32,
    at: u32,
}

impl Lane {
    /// # Safety
    /// `rays` points to a packet of `n` rays in which `at` is one; of rays with hits, if hits will be written.
    #[inline(always)]
    pub(crate) unsafe fn new(rays: *mut f32, n: usize, at: usize) -> Self {
        // SAFETY: the first number of the lane is in the packet.
        Self { first: unsafe { rays.add(at) }, n: n as u32, at: at as u32 }
    }

    /// A lane of which there are only rows of hits.
    ///
    /// # Safety
    /// `rows` points to hits of `n` lanes in which `at` is one; only hits are read and written.
    pub(crate) unsafe fn of_hits(rows: *mut f32, n: usize, at: usize) -> Self {
        // The rows of rays would precede them; nothing is read there.
        Self { first: rows.wrapping_add(at).wrapping_sub(row::NORMAL * n), n: n as u32, at: at as u32 }
    }

    /// How many rays the packet has.
    #[inline(always)]
    pub(crate) fn n(self) -> usize {
        self.n as usize
    }

    /// Which of them it is.
    #[inline(always)]
    pub(crate) fn at(self) -> usize {
        self.at as usize
    }

    /// Where the packet begins.
    pub(crate) fn packet(self) -> *mut f32 {
        self.first.wrapping_sub(self.at())
    }

    #[inline(always)]
    pub(crate) fn get(self, row: usize) -> f32 {
        // SAFETY: rows of rays exist, as the maker of this guaranteed.
        unsafe { *self.first.wrapping_add(row * self.n()) }
    }

    #[inline(always)]
    pub(crate) fn set(self, row: usize, value: f32) {
        // SAFETY: as above; rows of hits are written where the maker of this guaranteed them.
        unsafe { *self.first.wrapping_add(row * self.n()) = value }
    }

    #[inline(always)]
    fn set_id(self, row: usize, value: u32) {
        self.set(row, f32::from_bits(value));
    }

    #[inline(always)]
    fn vector(self, row: usize) -> [f32; 3] {
        [self.get(row), self.get(row + 1), self.get(row + 2)]
    }

    #[inline(always)]
    pub(crate) fn ray(self) -> Ray {
        Ray {
            org: self.vector(row::ORG),
            t_near: self.get(row::T_NEAR),
            dir: self.vector(row::DIR),
            t_far: self.get(row::T_FAR),
            mask: self.get(row::MASK).to_bits(),
            time: self.get(row::TIME),
        }
    }

    /// The ray where it lies, of a packet of one: a copy would be read in other sizes than it was written in, and the CPU
    /// wait for that.
    ///
    /// # Safety
    /// The packet is of one ray, and that is not written while the answer lives.
    #[inline(always)]
    pub(crate) unsafe fn in_place<'a>(self) -> &'a Ray {
        // SAFETY: the ray is there, as the maker of this guaranteed, and its fields are the first ones of `RTCRay`:
        // `abi::tests::layouts_are_those_of_the_headers`.
        unsafe { &*self.first.cast_const().cast::<Ray>() }
    }

    /// The ray with the fields that only the program can fill.
    pub(crate) fn whole(self) -> abi::Ray {
        let Ray { org, t_near, dir, t_far, mask, time } = self.ray();
        let (id, flags) = (self.get(row::ID).to_bits(), self.get(row::FLAGS).to_bits());
        abi::Ray { org, t_near, dir, time, t_far, mask, id, flags }
    }

    /// Writes all of the ray.
    pub(crate) fn put_ray(self, ray: &abi::Ray) {
        (0..3).for_each(|k| self.set(row::ORG + k, ray.org[k]));
        self.set(row::T_NEAR, ray.t_near);
        (0..3).for_each(|k| self.set(row::DIR + k, ray.dir[k]));
        self.set(row::TIME, ray.time);
        self.set(row::T_FAR, ray.t_far);
        self.set_id(row::MASK, ray.mask);
        self.set_id(row::ID, ray.id);
        self.set_id(row::FLAGS, ray.flags);
    }

    /// Writes where the ray begins, and where to it goes.
    pub(crate) fn put_line(self, [org, dir]: [[f32; 3]; 2]) {
        (0..3).for_each(|k| self.set(row::ORG + k, org[k]));
        (0..3).for_each(|k| self.set(row::DIR + k, dir[k]));
    }

    /// The hit of the ray.
    pub(crate) fn hit(self) -> abi::Hit {
        let id = |row: usize| self.get(row).to_bits();
        abi::Hit {
            normal: self.vector(row::NORMAL),
            u: self.get(row::U),
            v: self.get(row::V),
            prim_id: id(row::PRIM_ID),
            geom_id: id(row::GEOM_ID),
            inst_id: id(row::INST_ID),
            inst_prim_id: id(row::INST_PRIM_ID),
        }
    }

    /// Writes the hit; `instPrimID` where the program has a field for it.
    #[inline(always)]
    pub(crate) fn put_hit(self, hit: &abi::Hit, has_arrays: bool) {
        (0..3).for_each(|k| self.set(row::NORMAL + k, hit.normal[k]));
        self.set(row::U, hit.u);
        self.set(row::V, hit.v);
        self.set_id(row::PRIM_ID, hit.prim_id);
        self.set_id(row::GEOM_ID, hit.geom_id);
        self.set_id(row::INST_ID, hit.inst_id);
        if has_arrays {
            self.set_id(row::INST_PRIM_ID, hit.inst_prim_id);
        }
    }

    /// Writes the hit and how far it is.
    #[inline(always)]
    pub(crate) fn write(self, t: f32, hit: &abi::Hit, has_arrays: bool) {
        self.set(row::T_FAR, t);
        self.put_hit(hit, has_arrays);
    }
}

/// Whether the program has a field for `instPrimID` in hits and contexts: programs that were compiled without
/// arrays of instances have none, and cannot have made one.
#[inline(always)]
pub(crate) fn has_arrays(committed: &Committed) -> bool {
    committed.device.has_arrays.load(Ordering::Relaxed)
}

/// The instance of a hit that is in none of the scene: a program that transforms rays into its own instances passes their numbers
/// in the context.
#[inline(always)]
pub(crate) fn given_instance(context: *const Context, has_arrays: bool) -> (u32, u32) {
    if context.is_null() {
        return (INVALID, INVALID);
    }
    // SAFETY: a context that is not null begins with this number; the second one is there where arrays are known.
    unsafe { ((*context).inst_id, if has_arrays { (*context).inst_prim_id } else { INVALID }) }
}

/// A hit as the program is to see it; with the corners of its triangle, where the tree tells: the arrays that it was built from
/// lie elsewhere, and reading them took a third of a camera ray's time.
#[inline(always)]
pub(crate) fn hit_for_program(
    located: &Located,
    hit: &Hit,
    ray: &Ray,
    corners: Option<[[f32; 3]; 3]>,
    context: *const Context,
    has_arrays: bool,
) -> abi::Hit {
    let (inst_id, inst_prim_id) = match located.shown_instance {
        Some(shown_instance) => (shown_instance.geom_id, shown_instance.prim_id.unwrap_or(INVALID)),
        None => given_instance(context, has_arrays),
    };
    let (prim_id, [u, v]) = located.surface.seen(hit.prim_id, [hit.u, hit.v]);
    abi::Hit {
        normal: match corners {
            Some([a, b, c]) if located.is_as_built() => across(a, b, c),
            _ => located.normal(hit, ray),
        },
        u,
        v,
        prim_id,
        geom_id: located.surface.geom_id,
        inst_id,
        inst_prim_id,
    }
}

/// The arguments of a query.
#[derive(Clone, Copy)]
pub(crate) struct QueryRay {
    pub(crate) arguments: *const Arguments,
}

impl QueryRay {
    #[inline(always)]
    pub(crate) fn get(self) -> Option<Arguments> {
        // SAFETY: the program's arguments are null or live during the call; all fields are in all versions.
        (!self.arguments.is_null()).then(|| unsafe { *self.arguments })
    }

    /// Whether a filter of the arguments is for all geometries.
    #[inline(always)]
    pub(crate) fn filters_all(self) -> bool {
        self.get().is_some_and(|a| a.flags & INVOKE_ARGUMENT_FILTER != 0 && a.filter.is_some())
    }

    /// Whether the rays of a packet are coherent.
    #[inline(always)]
    pub(crate) fn is_coherent(self) -> bool {
        self.get().is_some_and(|a| a.flags & COHERENT != 0)
    }

    #[inline(always)]
    pub(crate) fn context(self) -> *mut Context {
        self.get().map_or(null_mut(), |a| a.context)
    }
}

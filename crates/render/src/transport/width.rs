// SPDX-License-Identifier: GPL-3.0-or-later
//! The number of paths per step: sixteen where the CPU's registers are wide enough, else one. The two differ
//! in reading points, drawing random numbers and choosing lights.
//! Invariant: both give the same bits. Tests: crates/render/tests/lanes.rs.

use glam::Vec3;
use gnurt_shading::SampleKey;
use gnurt_shading::bsdf::{ClosureBatch, Prepared};
use gnurt_shading::lanes::{LANES, LanesOf};
use gnurt_shading::lights::{LightSamples, LightSet};
use gnurt_shading::real::{Real, Vector};
use gnurt_shading::sampling::{Draws, DrawsX16, key_values, purpose};
use gnurt_simd::{Simd, f32x16, prelude::*, u32x16};

use super::mis::splits;

/// How many points at once.
pub(crate) trait Width: Copy {
    type R: Real;
    type Draws: Copy;

    /// Zeros.
    fn zero(self) -> Self::R;
    /// Prepares points of a batch from `first` on, for `wo`, where the light that they scatter has the weight
    /// `light`; `prepared` is [`Prepared::none`].
    fn prepare(
        self,
        closures: &ClosureBatch,
        first: usize,
        from: (Vector<Self::R>, Vector<Self::R>),
        prepared: &mut Prepared<Self::R>,
    );
    /// The random numbers of some keys at some edges, at most one for each point.
    fn draws(self, seed: u64, keys: &[SampleKey], edges: &[u32; LANES]) -> Self::Draws;
    /// The pair for a purpose.
    fn pair(draws: Self::Draws, purpose: u32) -> [Self::R; 2];
    /// The triple for a purpose: see [`Draws::triple`].
    fn triple(draws: Self::Draws, purpose: u32) -> [Self::R; 3];
    /// Lights, of one group if it is named, for the points in the first of two masks, at the first of two vectors; they face the
    /// second, and those in the second mask face all sides.
    fn lights(
        self,
        lights: (&LightSet, Option<usize>),
        masks: [<Self::R as Real>::Mask; 2],
        at: [Vector<Self::R>; 2],
        u: [Self::R; 3],
    ) -> LightSamples<Self::R>;
}

/// Points that request a light, its group if that is named, and random numbers: two for the position, one for the choice.
pub(crate) type LightRequests<W> = (<<W as Width>::R as Real>::Mask, Option<usize>, [<W as Width>::R; 3]);

/// Calls `take` with the points in a mask, after these edges, for each light that they sample: one of each group at vertices
/// that split, one of all at others.
#[inline(always)]
pub(crate) fn for_each_light_sample<W: Width>(
    width: W,
    (lights, draws): (&LightSet, W::Draws),
    (requests, edges): (<W::R as Real>::Mask, &[u32; LANES]),
    mut take: impl FnMut(LightRequests<W>),
) {
    let mut splitting = 0;
    for i in LanesOf(W::R::bits(requests)) {
        splitting |= u64::from(splits(lights, edges[i])) << i;
    }
    let splitting = width.zero().points(splitting);
    let others = requests & !splitting;
    let alone = W::R::any(others).then_some((others, None, purpose::LIGHT_POSITION));
    let groups = if W::R::any(splitting) { lights.split_groups() } else { 0..0 };
    let groups = groups.map(|group| (splitting, Some(group), purpose::LIGHT_GROUP + group as u32));
    // One call: `take` is long, and inlined.
    for (points, group, purpose) in alone.into_iter().chain(groups) {
        take((points, group, W::triple(draws, purpose)));
    }
}

/// One.
#[derive(Clone, Copy)]
pub(crate) struct One;

/// Sixteen.
#[derive(Clone, Copy)]
pub(crate) struct Sixteen<S>(pub(crate) S);

impl Width for One {
    type R = f32;
    type Draws = Draws;

    fn zero(self) -> f32 {
        0.0
    }

    fn prepare(
        self,
        closures: &ClosureBatch,
        first: usize,
        (wo, light): (Vector<f32>, Vector<f32>),
        prepared: &mut Prepared<f32>,
    ) {
        *prepared = closures.point(first).bsdf.prepared_for(wo.into(), light.into());
    }

    fn draws(self, seed: u64, keys: &[SampleKey], edges: &[u32; LANES]) -> Draws {
        Draws::new(seed, keys[0], edges[0])
    }

    fn pair(draws: Draws, purpose: u32) -> [f32; 2] {
        draws.pair(purpose)
    }

    fn triple(draws: Draws, purpose: u32) -> [f32; 3] {
        draws.triple(purpose)
    }

    fn lights(
        self,
        (lights, group): (&LightSet, Option<usize>),
        [active, from_all_sides]: [bool; 2],
        [p, ns]: [Vector<f32>; 2],
        u: [f32; 3],
    ) -> LightSamples<f32> {
        let ns = if from_all_sides { Vec3::ZERO } else { ns.into() };
        active.then(|| lights.sample_among(group, p.into(), ns, u)).flatten().into()
    }
}

impl<S: Simd> Width for Sixteen<S> {
    type R = f32x16<S>;
    type Draws = DrawsX16<S>;

    #[inline(always)]
    fn zero(self) -> f32x16<S> {
        f32x16::splat(self.0, 0.0)
    }

    #[inline(always)]
    fn prepare(
        self,
        closures: &ClosureBatch,
        first: usize,
        from: (Vector<f32x16<S>>, Vector<f32x16<S>>),
        prepared: &mut Prepared<f32x16<S>>,
    ) {
        closures.prepare(self.0, first, from, prepared);
    }

    #[inline(always)]
    fn draws(self, seed: u64, keys: &[SampleKey], edges: &[u32; LANES]) -> DrawsX16<S> {
        DrawsX16::new(self.0, seed, key_values(self.0, keys), u32x16::from_slice(self.0, edges))
    }

    #[inline(always)]
    fn pair(draws: DrawsX16<S>, purpose: u32) -> [f32x16<S>; 2] {
        draws.pair(purpose)
    }

    #[inline(always)]
    fn triple(draws: DrawsX16<S>, purpose: u32) -> [f32x16<S>; 3] {
        draws.triple(purpose)
    }

    #[inline(always)]
    fn lights(
        self,
        (lights, group): (&LightSet, Option<usize>),
        [active, from_all_sides]: [<f32x16<S> as Real>::Mask; 2],
        at: [Vector<f32x16<S>>; 2],
        u: [f32x16<S>; 3],
    ) -> LightSamples<f32x16<S>> {
        u[0].outline(
            #[inline(always)]
            || lights.sample_x16(group, [active, from_all_sides], at, u),
        )
    }
}

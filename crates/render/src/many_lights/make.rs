// SPDX-License-Identifier: GPL-3.0-or-later
//! Makes the virtual lights of a pass, by the integrator's method. Source: see each file.
//! Invariant: a function of world, camera, options and the number of the sample, on any number of threads.
//! Tests: crates/render/tests/many_lights.rs.

use super::bound::bound_of;
use super::pass::PassLights;
use super::{bidirectional, instant, metropolis};
use crate::job::Job;
use crate::options::Integrator;
use crate::stats::RenderStats;

/// The lights of sample `sample`, made on the threads of the pool that it is called in. `None` if the integrator
/// needs none.
pub(crate) fn pass_lights(job: &Job, sample: u32) -> Option<PassLights> {
    let options = job.options;
    let bound = bound_of(job.world, options);
    let mut stats = RenderStats::default();
    let vpls = match options.integrator {
        Integrator::InstantRadiosity => instant::virtual_lights(job, sample, &mut stats),
        Integrator::BidirectionalInstantRadiosity => {
            bidirectional::virtual_lights(job, sample, bound, &mut stats)
        }
        Integrator::MetropolisInstantRadiosity => metropolis::virtual_lights(job, sample, bound, &mut stats),
        _ => return None,
    };
    Some(PassLights::of(job.world, options, vpls, stats))
}

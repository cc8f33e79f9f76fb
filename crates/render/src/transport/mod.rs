// SPDX-License-Identifier: GPL-3.0-or-later
//! Common parts of integrators that scatter light themselves: the vertices of paths, weights of samples, and
//! the steps of the path tracer, many paths at a time.
//! Source: see each file.

pub(crate) mod absorption;
mod below;
mod equiangular;
mod flight;
mod forced_collision;
mod half_space;
mod light_samples;
pub(crate) mod links;
pub(crate) mod manifold;
pub(crate) mod media;
mod medium_vertices;
pub(crate) mod mis;
mod near_lamps;
pub(crate) mod opacity;
pub(crate) mod panes;
mod paths;
mod radiance_only;
pub(crate) mod roulette;
pub(crate) mod step;
pub(crate) mod subsurface;
mod through;
mod vertex;
pub(crate) mod walks;
mod way;
pub(crate) mod width;

use glam::Vec3;
use gnurt_shading::Vec3s;

pub(crate) use light_samples::{LightQuery, Offer, query_plugin_lights, sampling_normal, shadow_ray};
pub(crate) use links::Blockers;
pub(crate) use mis::{unguided_share, weigh_environment};
pub(crate) use paths::{Path, Wavefront};
pub(crate) use through::Through;
pub(crate) use vertex::{Known, Vertex};

/// Adds light that came over `edges` edges, or that did not come (negative); no more than `clamp` in any channel if it was
/// scattered more than once. It is each contribution that is limited, as production renderers limit indirect light, not their
/// sum over a sample. Returns the light that was added.
pub(crate) fn add(radiance: &mut Vec3s, lane: u32, mut light: Vec3, edges: u32, clamp: Option<f32>) -> Vec3 {
    let size = light.abs().max_element();
    if let Some(most) = clamp.filter(|&most| edges > 2 && size > most) {
        light *= most / size;
    }
    radiance.add(lane as usize, light);
    light
}

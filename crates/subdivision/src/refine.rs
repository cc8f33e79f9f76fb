// SPDX-License-Identifier: GPL-3.0-or-later
//! Refinement, step by step, of a surface and of all values on it.
//! After the last step the positions lie on the limit surface. Cost: O(faces 4^level). Tests: `tests/subdivision.rs`.

use super::sharpness::Sharpness;
use super::stencils::Stencils;
use super::surface::{Boundary, Channel, Refined, Scheme, Surface};
use super::topology::{Faces, Topology};
use super::{catmull_clark, limit, linear, loop_scheme};

/// The greatest level up to `level` with no more than `most` triangles.
#[must_use]
pub fn affordable_level(faces: &Faces, level: u32, most: u64) -> u32 {
    // The first step makes a quadrangle of each corner, or four triangles of each triangle: less than that.
    let first = 2 * faces.corners().len() as u64;
    let triangles = |level: u32| first.saturating_mul(4_u64.saturating_pow(level.saturating_sub(1)));
    (0..=level.min(16)).rev().find(|&level| level == 0 || triangles(level) <= most).unwrap_or(0)
}

/// Refines a surface `level` times. The first channel is the positions: they end on the limit surface.
#[must_use]
pub fn refine(surface: &Surface, channels: Vec<Channel>, level: u32) -> Refined {
    let hidden = hidden_faces(surface);
    let mut refined = Refined {
        parents: (0..surface.faces.len() as u32).collect(),
        faces: surface.faces.clone(),
        creases: surface.creases.clone(),
        channels,
    };
    let mut corners = surface.corners.clone();
    for _ in 0..level {
        let topology = Topology::new(&refined.faces);
        let sharpness = Sharpness::new(&topology, surface.boundary, &refined.creases, &corners);
        for channel in &mut refined.channels {
            step_channel(surface.scheme, channel, &topology, &sharpness, &refined.faces);
        }
        refined.creases = sharpness.child_creases(&topology);
        corners = sharpness.child_corners();
        let (faces, parents) = cut(surface.scheme, &topology, &refined.faces);
        refined.parents = parents.iter().map(|&face| refined.parents[face as usize]).collect();
        refined.faces = faces;
    }
    if level > 0 && surface.scheme != Scheme::Bilinear {
        let topology = Topology::new(&refined.faces);
        let sharpness = Sharpness::new(&topology, surface.boundary, &refined.creases, &corners);
        if let Some(positions) = refined.channels.first_mut() {
            let stencils = limit::stencils(surface.scheme, &topology, &sharpness, &refined.faces);
            positions.values = stencils.apply(&positions.values, positions.width);
        }
    }
    if hidden.iter().any(|&hidden| hidden) {
        drop_faces(&mut refined, &hidden);
    }
    refined
}

/// Faces that are part of the surface and are not shown.
fn hidden_faces(surface: &Surface) -> Vec<bool> {
    if surface.boundary != Boundary::None {
        return Vec::new();
    }
    let topology = Topology::new(&surface.faces);
    let touches = |corners: &[u32]| corners.iter().any(|&vertex| topology.is_boundary(vertex as usize));
    surface.faces.iter().map(touches).collect()
}

fn drop_faces(refined: &mut Refined, hidden: &[bool]) {
    let keep: Vec<bool> = refined.parents.iter().map(|&parent| !hidden[parent as usize]).collect();
    for channel in &mut refined.channels {
        if let Some(corners) = &mut channel.corners {
            *corners = refined.faces.kept(&keep, corners);
        }
    }
    refined.faces = refined.faces.only(&keep);
    let mut kept = keep.iter();
    refined.parents.retain(|_| kept.next().copied().unwrap_or(false));
}

/// The weights of one step.
fn stencils(
    scheme: Scheme,
    is_linear: bool,
    topology: &Topology,
    sharpness: &Sharpness,
    faces: &Faces,
) -> Stencils {
    match scheme {
        Scheme::Loop if is_linear => linear::of_triangles(topology),
        Scheme::Loop => loop_scheme::stencils(topology, sharpness, faces),
        Scheme::Bilinear => linear::of_polygons(topology, faces),
        Scheme::CatmullClark if is_linear => linear::of_polygons(topology, faces),
        Scheme::CatmullClark => catmull_clark::stencils(topology, sharpness, faces),
    }
}

fn cut(scheme: Scheme, topology: &Topology, faces: &Faces) -> (Faces, Vec<u32>) {
    match scheme {
        Scheme::Loop => loop_scheme::cut(topology, faces),
        Scheme::CatmullClark | Scheme::Bilinear => catmull_clark::cut(topology, faces),
    }
}

fn step_channel(
    scheme: Scheme,
    channel: &mut Channel,
    topology: &Topology,
    sharpness: &Sharpness,
    faces: &Faces,
) {
    let Some(corners) = &channel.corners else {
        let stencils = stencils(scheme, channel.is_linear, topology, sharpness, faces);
        channel.values = stencils.apply(&channel.values, channel.width);
        return;
    };
    // Values of corners have a surface of their own, whose boundaries are the seams.
    let own_faces = faces.with_corners(corners.clone(), channel.values.len() / channel.width.max(1));
    let own = Topology::new(&own_faces);
    let seams = Sharpness::new(&own, Boundary::EdgeAndCorner, &[], &[]);
    channel.values =
        stencils(scheme, channel.is_linear, &own, &seams, &own_faces).apply(&channel.values, channel.width);
    channel.corners = Some(cut(scheme, &own, &own_faces).0.corners().to_vec());
}

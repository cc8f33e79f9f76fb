// SPDX-License-Identifier: GPL-3.0-or-later
//! Direct light on Lambertian surfaces of shader classes: normals and the sum over lights.
//! Light models of [DWBS03] (no division by pi: E times colour times cosine).
//! Space: world. Tests: tests of `diffuse` and `textured_diffuse`.

use glam::Vec3;

use crate::batch::{SurfaceBatch, Vec3s};
use crate::shader::{AttributeRequest, LightBatch, RayRequest, Tracer};

/// Name of the mesh attribute, one float per triangle, that is not 0 where the program gave normals.
pub const NORMALS_GIVEN: &str = "normals_given";

/// Requests [`NORMALS_GIVEN`] from the mesh; without the attribute no normals were given.
pub(super) fn normals_given() -> AttributeRequest {
    AttributeRequest { name: NORMALS_GIVEN.to_owned(), components: 1, default: vec![0.0] }
}

/// The normals for shading: given ones unchanged, geometric ones flipped to the side of the ray. `given` is
/// the number of [`normals_given`] among the shader's attributes.
pub(super) fn shading_normals(hits: &SurfaceBatch, given: usize) -> Vec<Vec3> {
    let given = hits.attributes.get(given);
    let normal = |i: usize| match given {
        Some(given) if given[i] != 0.0 => hits.ns.get(i),
        _ => hits.facing_ng(i),
    };
    (0..hits.len()).map(normal).collect()
}

/// Whether light has to reach a point unhindered to count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shadows {
    /// Light goes through everything.
    Ignored,
    /// A ray is sent to each light.
    Traced,
}

/// Sum over all lights of `E max(0, n·l)` for each point.
pub(super) fn direct_light(
    tracer: &mut dyn Tracer,
    hits: &SurfaceBatch,
    normals: &[Vec3],
    shadows: Shadows,
) -> Vec3s {
    let mut sum = Vec3s::splat(hits.len(), Vec3::ZERO);
    let mut light = LightBatch::default();
    let (mut request, mut transmittance) = (RayRequest::default(), Vec3s::default());
    for number in 0..tracer.light_count() {
        tracer.illuminate(number, hits, &mut light);
        let arriving = |i: usize| light.radiance.get(i) * normals[i].dot(light.dir.get(i)).max(0.0);
        let lit = (0..hits.len()).filter(|&i| arriving(i) != Vec3::ZERO);
        match shadows {
            Shadows::Ignored => lit.for_each(|i| sum.add(i, arriving(i))),
            Shadows::Traced => {
                request.clear();
                for i in lit {
                    request.push(hits.spawn_to(i, light.dir.get(i), light.dist[i]), i, hits.key[i]);
                }
                tracer.occluded(&request, &mut transmittance);
                for (lane, &parent) in request.parent.iter().enumerate() {
                    let i = parent as usize;
                    sum.add(i, arriving(i) * transmittance.get(lane));
                }
            }
        }
    }
    sum
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! Offsets of vertices: constants, textures, and shaders in batches of points.
//! Space: object. Tests: crates/render/tests/displacement.rs.

use std::sync::Arc;

use glam::Vec3;
use gnurt_accel::threads;
use gnurt_scene::displacement::{Displacement, VectorSpace};
use gnurt_scene::{Mesh, Rate};
use gnurt_shading::texture::TextureSampler;
use gnurt_shading::{AttributeRequest, Detail, DisplacementShader, SurfaceBatch, Vec3s};

/// Points of a batch.
const BATCH: usize = 512;

/// The source of a mesh's offsets, ready to be evaluated.
pub(super) enum Source {
    Constant(f32),
    Height(TextureSampler, usize),
    Vector(TextureSampler, VectorSpace),
    Shader(Arc<dyn DisplacementShader>),
}

/// The directions of a mesh's texture coordinates at its vertices: the change of positions with u and v.
struct Frame {
    along_u: Vec<Vec3>,
    along_v: Vec<Vec3>,
    /// A triangle of each vertex.
    triangles: Vec<u32>,
}

impl Frame {
    fn of(mesh: &Mesh) -> Self {
        let count = mesh.positions.len();
        let (mut along_u, mut along_v) = (vec![Vec3::ZERO; count], vec![Vec3::ZERO; count]);
        let (mut areas, mut triangles) = (vec![0.0_f32; count], vec![u32::MAX; count]);
        for (number, corners) in (0u32..).zip(&mesh.indices) {
            let at = corners.map(|i| mesh.positions.get(i as usize).map(|&p| Vec3::from(p)));
            let [Some(a), Some(b), Some(c)] = at else { continue };
            for &i in corners {
                let known = &mut triangles[i as usize];
                *known = number.min(*known);
            }
            let uv = corners.map(|i| mesh.texcoords.get(i as usize).copied());
            let [Some(ua), Some(ub), Some(uc)] = uv else { continue };
            let (du1, dv1, du2, dv2) = (ub[0] - ua[0], ub[1] - ua[1], uc[0] - ua[0], uc[1] - ua[1]);
            let area_uv = du1 * dv2 - du2 * dv1;
            let (ab, ac) = (b - a, c - a);
            let area = ab.cross(ac).length();
            let (u, v) = ((ab * dv2 - ac * dv1) / area_uv, (ac * du1 - ab * du2) / area_uv);
            if u.is_finite() && v.is_finite() && area > 0.0 {
                for &i in corners {
                    let i = i as usize;
                    along_u[i] += u * area;
                    along_v[i] += v * area;
                    areas[i] += area;
                }
            }
        }
        for (i, &area) in areas.iter().enumerate().filter(|(_, area)| **area > 0.0) {
            along_u[i] /= area;
            along_v[i] /= area;
        }
        Self { along_u, along_v, triangles }
    }

    /// Unit directions to where u and v grow, square to the normal.
    fn tangents(&self, i: usize, normal: Vec3) -> Option<[Vec3; 2]> {
        let along = (self.along_u[i] - normal * normal.dot(self.along_u[i])).try_normalize()?;
        let across = normal.cross(along);
        let side = 1.0_f32.copysign(across.dot(self.along_v[i]));
        Some([along, across * side])
    }
}

/// The offsets of a mesh's vertices; `directions` are the normals that they share with others.
pub(super) fn offsets(
    mesh: &Mesh,
    geom_id: u32,
    displacement: &Displacement,
    source: &Source,
    directions: &[Vec3],
) -> Vec<Vec3> {
    let Displacement { scale, midlevel, .. } = *displacement;
    let amount = |x: f32| (x - midlevel) * scale;
    match source {
        Source::Constant(x) => {
            let offset = |&n: &Vec3| n * amount(*x);
            directions.iter().map(offset).collect()
        }
        Source::Height(sampler, channel) => {
            let at = |i: usize| directions[i] * amount(sampler.sample(uv(mesh, sampler, i))[*channel]);
            chunked(mesh.positions.len(), at)
        }
        Source::Vector(sampler, space) => {
            let frame = (*space == VectorSpace::Tangent).then(|| Frame::of(mesh));
            let at = |i: usize| {
                let [x, y, z, _] = sampler.sample(uv(mesh, sampler, i)).map(amount);
                match &frame {
                    None => Vec3::new(x, y, z),
                    Some(frame) => {
                        let n = directions[i];
                        // Without directions of coordinates only the height is known.
                        let [along, across] = frame.tangents(i, n).unwrap_or([Vec3::ZERO; 2]);
                        along * x + across * y + n * z
                    }
                }
            };
            chunked(mesh.positions.len(), at)
        }
        Source::Shader(shader) => {
            let frame = Frame::of(mesh);
            let count = mesh.positions.len();
            let found = threads::map(true, count.div_ceil(BATCH), |batch| {
                let range = batch * BATCH..((batch + 1) * BATCH).min(count);
                let mut out = Vec3s::default();
                out.reset(range.len(), Vec3::ZERO);
                let points = points(mesh, geom_id, &frame, directions, range, shader.attributes());
                shader.displace(&points, &mut out);
                (0..out.len()).map(|i| out.get(i)).collect::<Vec<_>>()
            });
            found.into_iter().flatten().collect()
        }
    }
}

fn chunked(count: usize, at: impl Fn(usize) -> Vec3 + Sync) -> Vec<Vec3> {
    let piece = BATCH * 8;
    let found = threads::map(true, count.div_ceil(piece), |n| {
        (n * piece..((n + 1) * piece).min(count)).map(&at).collect::<Vec<_>>()
    });
    found.into_iter().flatten().collect()
}

/// The coordinates that a texture reads at a vertex.
fn uv(mesh: &Mesh, sampler: &TextureSampler, i: usize) -> [f32; 2] {
    if sampler.attribute.is_some() {
        let values = mesh.second_texcoords();
        return [0, 1].map(|k| values.get(2 * i + k).copied().unwrap_or(0.0));
    }
    mesh.texcoords.get(i).copied().unwrap_or_default()
}

/// Vertices as points for a shader.
fn points(
    mesh: &Mesh,
    geom_id: u32,
    frame: &Frame,
    directions: &[Vec3],
    range: std::ops::Range<usize>,
    requests: &[AttributeRequest],
) -> SurfaceBatch {
    let count = range.len();
    let mut points = SurfaceBatch::default();
    points.resize(count, Detail::Full);
    points.footprint = vec![0.0; count];
    points.cone_spread = vec![0.0; count];
    points.lift.reset(count, Vec3::ZERO);
    points.error.fill(0.0);
    for (lane, i) in range.clone().enumerate() {
        let n = directions[i];
        points.p.set(lane, mesh.positions[i].into());
        points.ng.set(lane, n);
        points.ns.set(lane, n);
        points.ray_dir.set(lane, -n);
        let [u, v] = mesh.texcoords.get(i).copied().unwrap_or_default();
        (points.texcoord[0][lane], points.texcoord[1][lane]) = (u, v);
        points.dp_du.set(lane, frame.along_u[i]);
        points.dp_dv.set(lane, frame.along_v[i]);
        let [r, g, b, a] = mesh.colors.get(i).copied().unwrap_or([1.0; 4]);
        points.color.set(lane, Vec3::new(r, g, b));
        points.alpha[lane] = a;
        points.prim_id[lane] = if frame.triangles[i] == u32::MAX { 0 } else { frame.triangles[i] };
        points.geom_id[lane] = geom_id;
    }
    [&mut points.t, &mut points.u, &mut points.v, &mut points.uv_per_length]
        .into_iter()
        .for_each(|row| row.fill(0.0));
    points.attributes = requests.iter().map(|request| values(mesh, frame, range.clone(), request)).collect();
    points
}

/// A requested attribute of some vertices: component k of lane i is `[k * lanes + i]`.
fn values(mesh: &Mesh, frame: &Frame, range: std::ops::Range<usize>, request: &AttributeRequest) -> Vec<f32> {
    let (count, components) = (range.len(), request.components as usize);
    let mut values = vec![0.0; count * components];
    let known = mesh.attributes.iter().find(|attribute| attribute.name == request.name);
    // The space of the shader is the object's.
    let is_matrix = request.name == AttributeRequest::WORLD_FROM_OBJECT;
    for (lane, i) in range.enumerate() {
        for k in 0..components {
            let given = known.and_then(|attribute| {
                let n = attribute.components as usize;
                let element = match attribute.rate {
                    Rate::Vertex => i,
                    Rate::Triangle => frame.triangles[i] as usize,
                };
                attribute.data.get(element.checked_mul(n)? + k).copied().filter(|_| k < n)
            });
            let identity = is_matrix.then_some(if matches!(k, 0 | 4 | 8) { 1.0 } else { 0.0 });
            let default = || request.default.get(k).copied().unwrap_or(0.0);
            values[k * count + lane] = identity.or(given).unwrap_or_else(default);
        }
    }
    values
}

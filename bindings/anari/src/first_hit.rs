// SPDX-License-Identifier: GPL-3.0-or-later
//! The first hit of a ray of the camera, for the channels beside the colour. The renderers `ao`, `eyelight` and `debug`, which
//! follow a ray through surfaces with holes and volumes. Space: world. Tests: tests/{channels,renderers}.rs.

use glam::Vec3;
use gnurt::accel::Ray;
use gnurt::render::World;
use gnurt::scene::RayMask;
use gnurt::shading::SampleKey;
use gnurt::shading::sampling::{Basis, cosine_hemisphere, purpose, sample_pair};

use crate::attribute::Point;
use crate::pixel::through_volumes;
use crate::settings::Method;
use crate::shader::mapped;
use crate::table::{At, Table, Target};
use crate::transforms::linear;

/// No number.
pub(crate) const NO_ID: u32 = u32::MAX;
const LAYERS: u32 = 64;

/// The first hit at the middle of a pixel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FirstHit {
    /// Distance from the camera; infinite where there is nothing.
    pub(crate) depth: f32,
    pub(crate) normal: Vec3,
    pub(crate) albedo: Vec3,
    pub(crate) primitive: u32,
    pub(crate) object: u32,
    pub(crate) instance: u32,
}

const NOTHING: FirstHit = FirstHit {
    depth: f32::INFINITY,
    normal: Vec3::ZERO,
    albedo: Vec3::ZERO,
    primitive: NO_ID,
    object: NO_ID,
    instance: NO_ID,
};

/// A surface that a ray meets.
struct Met<'t> {
    t: f32,
    p: Vec3,
    /// Unit, as the mesh has it.
    ng: Vec3,
    /// `None` = a lamp.
    at: Option<At<'t>>,
    ns: Vec3,
    uv: [f32; 2],
    area_light: Vec3,
}

/// The first surface of a ray.
fn meet<'t>(world: &World, table: &'t Table, ray: &Ray) -> Option<Met<'t>> {
    let hit = world.intersect(ray)?;
    let p = Vec3::from(ray.at(hit.t));
    let ng = Vec3::from(world.normal_at(&hit, p.to_array().map(f64::from))?);
    let uv = [hit.u, hit.v];
    let Target::Surface { surface, instance, part, placement } = *table.targets.get(hit.inst_id as usize)?
    else {
        let area_light = table.area_light(hit.inst_id)?.radiance(ng, -Vec3::from(ray.dir));
        return Some(Met { t: hit.t, p, ng, at: None, ns: ng, uv, area_light });
    };
    let here = &table.surfaces[surface as usize].geometry.parts[part as usize];
    let mesh = here.mesh();
    let corners = mesh.corners(hit.prim_id as usize)?;
    let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
    let smooth = corners.into_iter().zip(weights).map(|(vertex, weight)| {
        mesh.normals.get(vertex).map_or(Vec3::ZERO, |&normal| Vec3::from(normal) * weight)
    });
    let smooth: Vec3 = smooth.sum();
    let mut matrix = linear(&table.instances[instance as usize].world_from_object);
    if let Some(placed) = here.placements.as_ref().and_then(|all| all.get(placement as usize)) {
        matrix *= linear(&placed.object_from_part);
    }
    let ns = (matrix.inverse().transpose() * smooth).try_normalize().unwrap_or(ng);
    let ns = if ns.dot(ng) < 0.0 { -ns } else { ns };
    let at = table.at(hit.inst_id, hit.prim_id, uv, p, ns);
    let ns = at.as_ref().map_or(ns, |at| mapped(at, ns));
    Some(Met { t: hit.t, p, ng, at, ns, uv, area_light: Vec3::ZERO })
}

/// The first surface, lamp or volume along a ray of the camera.
pub(crate) fn first_hit(world: &World, table: &Table, ray: &Ray) -> FirstHit {
    let mut first_hit = NOTHING;
    if ray.dir == [0.0; 3] {
        return first_hit;
    }
    let mut on = ray.with_mask(RayMask::CAMERA.0);
    for _ in 0..LAYERS {
        let Some(met) = meet(world, table, &on) else { break };
        if let Some(at) = &met.at {
            if at.surface.material.coverage(at) <= 0.0 {
                on = on.beyond(met.t);
                continue;
            }
            first_hit.albedo = at.surface.material.base(at);
            let primitive = at.surface.geometry.id(at.primitive());
            (first_hit.primitive, first_hit.object, first_hit.instance) =
                (primitive, at.surface.id, at.instance.id);
        } else {
            first_hit.albedo = Vec3::ONE;
        }
        first_hit.depth = met.t;
        first_hit.normal = if met.ng.dot(Vec3::from(ray.dir)) > 0.0 { -met.ns } else { met.ns };
        break;
    }
    let (org, dir) = (Vec3::from(ray.org), Vec3::from(ray.dir));
    for volume in &table.volumes {
        if let Some([enter, _]) = volume.span(org, dir, ray.t_far.min(first_hit.depth))
            && enter < first_hit.depth
        {
            first_hit = FirstHit {
                depth: enter,
                primitive: 0,
                object: volume.id,
                instance: volume.instance,
                ..first_hit
            };
        }
    }
    first_hit
}

/// A colour for a number, far from those of its neighbours.
fn color_of(number: u32) -> Vec3 {
    if number == NO_ID {
        return Vec3::splat(0.1);
    }
    let hue = (f64::from(number) * 0.618_033_988_75).fract() as f32 * 6.0;
    let channel = |shift: f32| ((hue + shift).rem_euclid(6.0) - 3.0).abs() - 1.0;
    Vec3::new(channel(0.0), channel(4.0), channel(2.0)).clamp(Vec3::ZERO, Vec3::ONE) * 0.8 + 0.2
}

fn debug(method: &str, met: &Met, dir: Vec3) -> Vec3 {
    let of_normal = |n: Vec3| n * 0.5 + 0.5;
    let Some(at) = &met.at else { return Vec3::ONE };
    match method {
        "geometricNormal" => of_normal(met.ng),
        "albedo" => at.surface.material.base(at),
        "primitiveId" => color_of(at.surface.geometry.id(at.primitive())),
        "objectId" => color_of(at.surface.id),
        "instanceId" => color_of(at.instance.id),
        "depth" => Vec3::splat(1.0 / (1.0 + met.t)),
        "uv" => Vec3::new(met.uv[0], met.uv[1], 1.0 - met.uv[0] - met.uv[1]),
        "backFace" => {
            if met.ng.dot(dir) > 0.0 {
                Vec3::X
            } else {
                Vec3::Y
            }
        }
        _ => of_normal(met.ns),
    }
}

/// The share of directions over a point that nothing occludes within a distance.
fn openness(world: &World, met: &Met, dir: Vec3, rays: u32, distance: f32, key: SampleKey) -> f32 {
    let side = if met.ng.dot(dir) > 0.0 { -1.0 } else { 1.0 };
    let basis = Basis::around(met.ns * side);
    let ng = met.ng * side;
    let offset = 1e-4_f32.max(met.p.abs().max_element() * 1e-5).max(met.t * 1e-5);
    let open = (0..rays).filter(|&k| {
        let key = SampleKey { sample: key.sample.wrapping_mul(rays).wrapping_add(k), ..key };
        let random = sample_pair(0, key, 0, purpose::SHADER);
        let to = basis.to_world(cosine_hemisphere(random));
        // Below the facet nothing comes in.
        to.dot(ng) > 0.0 && {
            let ray = Ray::new((met.p + ng * offset).to_array(), to.to_array()).within(0.0, distance);
            !world.occluded(&ray.with_mask(RayMask::SHADOW.0))
        }
    });
    open.count() as f32 / rays as f32
}

/// Light that comes along a ray of the camera by these renderers, and the share of light from behind all that it stops.
pub(crate) fn walk(
    (world, table): (&World, &Table),
    ray: &Ray,
    method: &Method,
    ambient: Vec3,
    key: SampleKey,
    random: f32,
) -> (Vec3, f32) {
    let (mut light, mut left) = (Vec3::ZERO, 1.0_f32);
    let dir = Vec3::from(ray.dir);
    if dir == Vec3::ZERO {
        return (light, 0.0);
    }
    let mut on = ray.with_mask(RayMask::CAMERA.0);
    for layer in 0..LAYERS {
        let met = meet(world, table, &on);
        let end = met.as_ref().map_or(on.t_far, |met| met.t);
        let (own, passes) = through_volumes(table, ray, [on.t_near, end], random);
        light += own * left;
        left *= passes;
        let Some(met) = met else { break };
        let (color, stopped) = match (&met.at, method) {
            (Some(at), Method::Occlusion { rays, distance }) => {
                let stopped = at.surface.material.coverage(at);
                let open = if stopped > 0.0 {
                    openness(world, &met, dir, *rays, *distance, key.fork(layer))
                } else {
                    0.0
                };
                let glow = at.surface.material.emission(at);
                (at.surface.material.base(at) * ambient * open + glow, stopped)
            }
            (Some(at), Method::Eyelight) => {
                // Half of the light falls off with the cosine, so that surfaces seen edge-on are not black.
                let share = 0.5 + 0.5 * met.ns.dot(dir).abs();
                (at.surface.material.base(at) * share, at.surface.material.coverage(at))
            }
            (Some(at), Method::Debug(name)) => {
                (debug(name, &met, dir), f32::from(u8::from(at.surface.material.coverage(at) > 0.0)))
            }
            _ => (met.area_light, 1.0),
        };
        light += color * (left * stopped);
        left *= 1.0 - stopped;
        if left < 1e-3 {
            return (light, 1.0);
        }
        on = on.beyond(met.t);
    }
    (light, 1.0 - left)
}

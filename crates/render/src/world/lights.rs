// SPDX-License-Identifier: GPL-3.0-or-later
//! From lights and emissive triangles of the description to light shaders.
//! Source: original. All emissive triangles of all instances together are one light.
//! Proof: `crates/render/tests/lights.rs`.

use std::ops::Range;
use std::sync::Arc;

use glam::{Mat3, Vec3};
use gnurt_scene::material::TextureRef;
use gnurt_scene::{Light, Material, Scene};
use gnurt_shading::lights as shading;
use gnurt_shading::lights::EnvironmentLight;
use gnurt_shading::{EnvironmentShader, LightShader};

use super::instance::PlacedInstance;
use super::materials::{coverage, emission, sampler};
use super::{CommitOptions, ShaderTable};
use crate::error::CommitError;

type Environment = Option<Arc<dyn EnvironmentShader>>;

/// All lights of a world.
pub(super) struct Lights {
    /// As shaders ask them.
    pub(super) shaders: Vec<Arc<dyn LightShader>>,
    /// Which of `shaders` only know `illuminate`: those of the shader table.
    pub(super) plugins: Range<usize>,
    /// What misses see.
    pub(super) environment: Environment,
    /// All others, for whoever needs densities.
    pub(super) parts: shading::LightParts,
}

/// All lights of a scene and of a shader table.
pub(super) fn lights(
    scene: &Scene,
    instances: &[Option<PlacedInstance>],
    shaders: &ShaderTable,
    options: &CommitOptions,
    bounds: [Vec3; 2],
) -> Lights {
    let (triangles, triangle_ids) = triangle_lights(scene, instances, options.force_diffuse);
    let mut parts = shading::LightParts { triangles, triangle_ids, bounds, ..Default::default() };
    let mut lights: Vec<Arc<dyn LightShader>> = Vec::new();
    if let Some(triangles) = &parts.triangles {
        lights.push(triangles.clone());
    }
    lights.extend(scene.lights().iter().filter_map(|light| punctual(light, &mut parts)));
    let plugins = lights.len()..lights.len() + shaders.lights.len();
    lights.extend(shaders.lights.iter().cloned());
    if let Some(environment) = &shaders.environment {
        return Lights { shaders: lights, plugins, environment: Some(environment.clone()), parts };
    }
    let environment: Environment = match environment(scene) {
        Some(light) => {
            parts.environment = Some(light.clone());
            let (light, environment): (Arc<dyn LightShader>, Arc<dyn EnvironmentShader>) = match light {
                EnvironmentLight::Constant(constant) => (constant.clone(), constant),
                EnvironmentLight::Picture(picture) => (picture.clone(), picture),
            };
            lights.push(light);
            Some(environment)
        }
        None => None,
    };
    Lights { shaders: lights, plugins, environment, parts }
}

/// A light without extent, which is added to `parts`, too.
fn punctual(light: &Light, parts: &mut shading::LightParts) -> Option<Arc<dyn LightShader>> {
    match *light {
        Light::Point { position, intensity } => {
            let point = shading::PointLight { position: position.into(), intensity: intensity.into() };
            parts.points.push(point);
            Some(Arc::new(point))
        }
        Light::Spot { position, direction, intensity, inner_angle, outer_angle } => {
            let (position, direction) = (Vec3::from(position), Vec3::from(direction));
            let spot =
                shading::SpotLight::new(position, direction, intensity.into(), inner_angle, outer_angle)?;
            parts.spots.push(spot);
            Some(Arc::new(spot))
        }
        Light::Directional { direction, irradiance } => {
            let directional = shading::DirectionalLight::new(direction.into(), irradiance.into())?;
            parts.directionals.push(directional);
            Some(Arc::new(directional))
        }
        Light::Environment { .. } => None,
    }
}

/// The last environment of the scene.
fn environment(scene: &Scene) -> Option<EnvironmentLight> {
    let last = scene.lights().iter().rev().find_map(|light| match light {
        Light::Environment { radiance, texture, world_from_light } => {
            Some((Vec3::from(*radiance), *texture, world_from_light))
        }
        _ => None,
    });
    let (radiance, texture, world_from_light) = last.filter(|(radiance, ..)| radiance.max_element() > 0.0)?;
    let Some(texture) = texture else {
        return Some(EnvironmentLight::Constant(Arc::new(shading::ConstantEnvironment { radiance })));
    };
    let [x, y, z, _] = world_from_light.to_f32();
    let unit = |v: [f32; 3]| Vec3::from(v).normalize_or_zero();
    let rotation = Mat3::from_cols(unit(x), unit(y), unit(z));
    let sampler = sampler(scene, &TextureRef::new(texture));
    let picture = shading::PictureEnvironment::new(sampler, radiance, rotation)?;
    Some(EnvironmentLight::Picture(Arc::new(picture)))
}

/// Every triangle of a shining material, in the world; and its instance, mesh and triangle, ascending.
fn triangle_lights(
    scene: &Scene,
    instances: &[Option<PlacedInstance>],
    force_diffuse: bool,
) -> (Option<Arc<shading::TriangleLights>>, Vec<[u32; 3]>) {
    let emitter = |material: &Material| {
        let emission = emission(scene, material)?;
        let coverage = if force_diffuse { None } else { coverage(scene, &material.alpha) };
        Some(Arc::new(shading::Emitter { emission, coverage }))
    };
    let by_material: Vec<_> = scene.materials().iter().map(emitter).collect();
    let emitters: Vec<_> = by_material.iter().flatten().cloned().collect();
    // Position among the emitters of each material that shines.
    let mut next = 0..;
    let number: Vec<Option<u32>> =
        by_material.iter().map(|emitter| emitter.as_ref().and_then(|_| next.next())).collect();
    let (mut triangles, mut ids) = (Vec::new(), Vec::new());
    for (inst_id, instance) in (0..).zip(instances) {
        let Some(instance) = instance else { continue };
        for (geom_id, mesh) in (0..).zip(&instance.object.meshes) {
            let Some(emitter) = number[mesh.material.index()] else { continue };
            for prim_id in 0..mesh.indices.len() {
                if let Some(shining) = triangle(instance, mesh, prim_id, emitter) {
                    triangles.push(shining);
                    ids.push([inst_id, geom_id, prim_id as u32]);
                }
            }
        }
    }
    match shading::TriangleLights::new(triangles, emitters) {
        Some(lights) => (Some(Arc::new(lights)), ids),
        None => (None, Vec::new()),
    }
}

/// A triangle in the world; `None` if it cannot be traced, because what is not there does not shine.
fn triangle(
    instance: &PlacedInstance,
    mesh: &gnurt_scene::Mesh,
    prim_id: usize,
    emitter: u32,
) -> Option<shading::EmissiveTriangle> {
    let mut corners = mesh.indices[prim_id].map(|i| i as usize);
    if instance.mirrors {
        corners.swap(1, 2);
    }
    let position = |i: usize| mesh.positions.get(i).map(|&p| instance.point(p.into()));
    let p = [position(corners[0])?, position(corners[1])?, position(corners[2])?];
    let area = (p[1] - p[0]).cross(p[2] - p[0]).length();
    let uv = corners.map(|i| mesh.texcoords.get(i).copied().unwrap_or_default());
    let opacity = corners.map(|i| mesh.colors.get(i).map_or(1.0, |color| color[3]));
    (area > 0.0 && area.is_finite()).then_some(shading::EmissiveTriangle { p, uv, opacity, emitter })
}

/// Whether all ids of lights name something.
pub(super) fn check(scene: &Scene) -> Result<(), CommitError> {
    for (index, light) in scene.lights().iter().enumerate() {
        if let Light::Environment { texture: Some(texture), .. } = light
            && texture.index() >= scene.textures().len()
        {
            return Err(CommitError::DanglingId { what: "light", index, used: "texture", id: texture.0 });
        }
    }
    Ok(())
}
